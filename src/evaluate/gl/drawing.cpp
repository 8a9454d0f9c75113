#include "evaluate/gl/drawing.hpp"

#include "base/random.hpp"
#include "evaluate/gl/gl_context.hpp"
#include "evaluate/pixel_rays.hpp"

#include <array>
#include <chrono>

namespace antumbra {
namespace {

constexpr GLuint kPosition = 0, kColour = 1;
/// The near plane as a share of the distance to the farthest corner of the scene: small enough that the pictures of
/// walks do not cut into walls, large enough for a depth buffer of 32 bits.
constexpr double kNearShare = 1e-5;

const char* kVertexShader = R"(#version 330 core
uniform mat4 projection;
uniform vec3 eye;
in vec3 position;
in vec4 colour;
out vec3 from_eye;
flat out vec4 object_colour;
void main() {
    from_eye = position - eye;
    object_colour = colour;
    gl_Position = projection * vec4(from_eye, 1.0);
}
)";

// The normal of the flat triangle, from derivatives; a light at the eye and a little from above.
const char* kFragmentShader = R"(#version 330 core
uniform int items;
in vec3 from_eye;
flat in vec4 object_colour;
out vec4 result;
void main() {
    vec3 normal = normalize(cross(dFdx(from_eye), dFdy(from_eye)));
    float facing = abs(dot(normal, normalize(from_eye)));
    float light = 0.35 + 0.45 * facing + 0.2 * abs(normal.y);
    result = items != 0 ? object_colour : vec4(object_colour.rgb * light, object_colour.a);
}
)";

/// Column-major matrix from coordinates relative to the eye to clip space.
std::array<float, 16> clip_matrix(const View& view, double aspect, double near_plane, double far_plane) {
    Vec3d forward = normalized(view.target - view.eye);
    Vec3d right = normalized(cross(forward, view.up)), up = cross(right, forward);
    bool parallel = view.projection == Projection::orthographic;
    double half_height = parallel ? view.height / 2 : half_tangent(view.fov_y_deg);
    double depth = far_plane - near_plane;
    std::array<double, 16> m{};
    for (int k = 0; k < 3; ++k) {
        std::size_t column = 4 * std::size_t(k);
        m[column] = right[k] / (half_height * aspect);
        m[column + 1] = up[k] / half_height;
        m[column + 2] = forward[k] * (parallel ? 2 : far_plane + near_plane) / depth;
        m[column + 3] = parallel ? 0 : forward[k];
    }
    m[14] = parallel ? -(far_plane + near_plane) / depth : -2 * far_plane * near_plane / depth;
    m[15] = parallel ? 1 : 0;
    std::array<float, 16> result;
    for (std::size_t k = 0; k < 16; ++k)
        result[k] = float(m[k]);
    return result;
}

Result<GLuint> compile(const GlFunctions& gl, GLenum kind, const char* source) {
    GLuint shader = gl.CreateShader(kind);
    gl.ShaderSource(shader, 1, &source, nullptr);
    gl.CompileShader(shader);
    GLint good = 0;
    gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (good)
        return shader;
    char log[512] = "";
    gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
    return Status(ErrorCode::unsupported, std::string("the OpenGL driver refuses a shader: ") + log);
}

Result<GLuint> link(const GlFunctions& gl) {
    Result<GLuint> vertex = compile(gl, GL_VERTEX_SHADER, kVertexShader);
    if (!vertex)
        return vertex;
    Result<GLuint> fragment = compile(gl, GL_FRAGMENT_SHADER, kFragmentShader);
    if (!fragment)
        return fragment;
    GLuint program = gl.CreateProgram();
    for (GLuint shader : {*vertex, *fragment}) {
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader);
    }
    gl.BindAttribLocation(program, kPosition, "position");
    gl.BindAttribLocation(program, kColour, "colour");
    gl.LinkProgram(program);
    GLint good = 0;
    gl.GetProgramiv(program, GL_LINK_STATUS, &good);
    if (!good)
        return Status(ErrorCode::unsupported, "the OpenGL driver does not link a program");
    return program;
}

/// Objects that share a state of the pipeline.
struct Group {
    bool occludes = true, double_sided = false;
    std::vector<std::uint32_t> objects;
};

} // namespace

struct Drawing::State {
    const Scene* scene = nullptr;
    std::unique_ptr<GlContext> context;
    std::uint32_t width = 0, height = 0;
    GLuint program = 0;
    GLint projection = -1, eye = -1, items = -1;
    std::array<Group, 4> groups; ///< opaque first, so that what is behind glass shows through it

    const GlFunctions& gl() const { return context->functions(); }

    void upload() {
        GLuint array = 0, buffers[2] = {};
        gl().GenVertexArrays(1, &array);
        gl().BindVertexArray(array);
        gl().GenBuffers(2, buffers);
        auto positions = scene->positions();
        auto triangles = scene->triangles();
        gl().BindBuffer(GL_ARRAY_BUFFER, buffers[0]);
        gl().BufferData(GL_ARRAY_BUFFER, GLsizeiptr(positions.size_bytes()), positions.data(), GL_STATIC_DRAW);
        gl().VertexAttribPointer(kPosition, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl().EnableVertexAttribArray(kPosition);
        gl().BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
        gl().BufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(triangles.size_bytes()), triangles.data(), GL_STATIC_DRAW);
    }

    Status make_framebuffer() {
        GLuint buffers[2] = {}, framebuffer = 0;
        gl().GenFramebuffers(1, &framebuffer);
        gl().BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        gl().GenRenderbuffers(2, buffers);
        const GLenum formats[2] = {GL_RGBA8, GL_DEPTH_COMPONENT32F};
        const GLenum places[2] = {GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
        for (int k = 0; k < 2; ++k) {
            gl().BindRenderbuffer(GL_RENDERBUFFER, buffers[k]);
            gl().RenderbufferStorage(GL_RENDERBUFFER, formats[k], GLsizei(width), GLsizei(height));
            gl().FramebufferRenderbuffer(GL_FRAMEBUFFER, places[k], GL_RENDERBUFFER, buffers[k]);
        }
        if (gl().CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE || gl().GetError() != GL_NO_ERROR)
            return {ErrorCode::unsupported, "the OpenGL driver makes no picture of " + std::to_string(width) + " x " +
                                                std::to_string(height) + " pixels"};
        gl().Viewport(0, 0, GLsizei(width), GLsizei(height));
        return {};
    }

    void sort_into_groups() {
        for (std::size_t k = 0; k < 4; ++k) {
            groups[k].occludes = k < 2;
            groups[k].double_sided = k % 2 == 1;
        }
        for (std::uint32_t o = 0; o < scene->objects().size(); ++o) {
            const Object& object = scene->objects()[o];
            std::size_t group = (object.has(kOccludes) ? 0u : 2u) + (object.has(kDoubleSided) ? 1u : 0u);
            if (object.triangle_count > 0)
                groups[group].objects.push_back(o);
        }
    }

    void set_colour(std::uint32_t object, DrawStyle style, bool occludes) const {
        if (style == DrawStyle::items) {
            std::uint32_t number = object + 1;
            gl().VertexAttrib4f(kColour, float(number & 255) / 255, float(number >> 8 & 255) / 255,
                                float(number >> 16 & 255) / 255, 1);
            return;
        }
        Vec3f colour = object_colour(object);
        gl().VertexAttrib4f(kColour, colour.x, colour.y, colour.z, occludes ? 1.0f : 0.35f);
    }

    void draw_group(const Group& group, std::span<const std::uint64_t> wanted, DrawStyle style) const {
        auto toggle = [&](GLenum what, bool on) { on ? gl().Enable(what) : gl().Disable(what); };
        toggle(GL_CULL_FACE, !group.double_sided);
        bool blend = !group.occludes && style == DrawStyle::shaded;
        toggle(GL_BLEND, blend);
        gl().DepthMask(blend ? GL_FALSE : GL_TRUE);
        for (std::uint32_t o : group.objects) {
            if (!(wanted[o / 64] >> (o % 64) & 1))
                continue;
            const Object& object = scene->objects()[o];
            set_colour(o, style, group.occludes);
            gl().DrawElements(
                GL_TRIANGLES, GLsizei(object.triangle_count * 3), GL_UNSIGNED_INT,
                reinterpret_cast<const void*>(std::uintptr_t(object.first_triangle) * sizeof(TriangleIndices)));
        }
    }

    double farthest(const Vec3d& from) const {
        Box3d bounds = to_double(scene->local_bounds());
        double distance = 0;
        for (int k = 0; k < 8; ++k)
            distance = std::max(distance, length(bounds.corner(k) - from));
        return distance * 1.01;
    }
};

Vec3f object_colour(std::uint32_t object) {
    // Muted, so that shading stays legible: a grey of its own with a little of a hue of its own.
    Random random(0x0b3ec7, object);
    double grey = random.uniform(0.5, 0.78), hue = random.uniform(0, 3), amount = random.uniform(0.06, 0.18);
    Vec3f colour;
    for (int k = 0; k < 3; ++k) {
        double turned = hue + k;
        double distance = std::abs((turned >= 3 ? turned - 3 : turned) - 1.5); // 0..1.5 around the circle
        colour[k] = float(grey + amount * (distance / 0.75 - 1));
    }
    return colour;
}

Drawing::Drawing(std::unique_ptr<State> state) : state_(std::move(state)) {}
Drawing::~Drawing() = default;

Result<std::unique_ptr<Drawing>> Drawing::create(const Scene& scene, std::uint32_t width, std::uint32_t height) {
    auto context = GlContext::create();
    if (!context)
        return context.status();
    auto state = std::make_unique<State>();
    state->scene = &scene;
    state->context = std::move(*context);
    state->width = width;
    state->height = height;
    const GlFunctions& gl = state->gl();
    Result<GLuint> program = link(gl);
    if (!program)
        return program.status();
    state->program = *program;
    gl.UseProgram(*program);
    state->projection = gl.GetUniformLocation(*program, "projection");
    state->eye = gl.GetUniformLocation(*program, "eye");
    state->items = gl.GetUniformLocation(*program, "items");
    state->upload();
    if (Status status = state->make_framebuffer(); !status)
        return status;
    state->sort_into_groups();
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.FrontFace(GL_CCW);
    gl.CullFace(GL_BACK);
    gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    return std::unique_ptr<Drawing>(new Drawing(std::move(state)));
}

double Drawing::draw(const View& view, std::span<const std::uint64_t> objects, DrawStyle style) {
    const GlFunctions& gl = state_->gl();
    double far_plane = state_->farthest(view.eye);
    std::array<float, 16> matrix =
        clip_matrix(view, double(state_->width) / state_->height, far_plane * kNearShare, far_plane);
    gl.Finish();
    auto start = std::chrono::steady_clock::now();
    gl.UniformMatrix4fv(state_->projection, 1, GL_FALSE, matrix.data());
    gl.Uniform3f(state_->eye, float(view.eye.x), float(view.eye.y), float(view.eye.z));
    gl.Uniform1i(state_->items, style == DrawStyle::items);
    gl.DepthMask(GL_TRUE); // a clear obeys the mask
    bool items = style == DrawStyle::items;
    gl.ClearColor(items ? 0 : 0.82f, items ? 0 : 0.87f, items ? 0 : 0.92f, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    for (const Group& group : state_->groups)
        state_->draw_group(group, objects, style);
    gl.Finish();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Image Drawing::read_back() {
    const GlFunctions& gl = state_->gl();
    Image image{state_->width, state_->height, {}};
    std::size_t row = std::size_t(image.width) * 3;
    std::vector<std::uint8_t> from_below(row * image.height);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.ReadPixels(0, 0, GLsizei(image.width), GLsizei(image.height), GL_RGB, GL_UNSIGNED_BYTE, from_below.data());
    image.rgb.resize(from_below.size());
    for (std::uint32_t y = 0; y < image.height; ++y)
        std::copy_n(from_below.begin() + std::ptrdiff_t(row * (image.height - 1 - y)), row,
                    image.rgb.begin() + std::ptrdiff_t(row * y));
    return image;
}

std::string Drawing::description() const {
    return state_->context->description();
}

} // namespace antumbra
