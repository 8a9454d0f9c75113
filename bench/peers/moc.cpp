#include "peers.hpp"

#include "cull/methods.hpp"
#include "cull/occlusion_walk.hpp"

#include <MaskedOcclusionCulling.h>

#include <string>

namespace antumbra::bench {
namespace {

using Moc = ::MaskedOcclusionCulling;

struct FreeMoc {
    void operator()(Moc* moc) const { Moc::Destroy(moc); }
};

struct MocState final : ViewState::Storage {
    std::unique_ptr<Moc, FreeMoc> moc;
    std::vector<WalkEntry> stack;
};

/// Triangles of one object as its rasteriser wants them: single- and double-sided apart.
struct Mesh {
    std::vector<unsigned> single_sided, double_sided;
};

/// The same tree and walk as `masked`; what the walk reports is drawn at once, whole.
class MocCuller final : public Culler {
  public:
    MocCuller(const Scene& scene, const CullScene& boxes, Moc::Implementation set, const char* set_name, int width)
        : scene_(scene), boxes_(boxes), set_(set), width_(width), serial_(new_culler_serial()),
          name_("moc-" + std::string(set_name) + "-" + std::to_string(width)), meshes_(scene.objects().size()) {
        for (std::uint32_t o = 0; o < meshes_.size(); ++o) {
            const Object& object = scene.objects()[o];
            if (!(object.flags & kOccludes))
                continue;
            auto& list = object.flags & kDoubleSided ? meshes_[o].double_sided : meshes_[o].single_sided;
            for (std::uint32_t t = object.first_triangle; t < object.first_triangle + object.triangle_count; ++t)
                for (std::uint32_t corner : scene.triangles()[t])
                    list.push_back(corner);
        }
    }
    std::string_view name() const override { return name_; }
    Guarantee guarantee() const override { return Guarantee::approximate; }

    void cull(const View& view, ViewState& view_state, CullResult& result) const override {
        const CullScene::Data& data = boxes_.data();
        begin_result(data, result);
        auto& state = view_state.storage<MocState>(serial_);
        int height = static_cast<int>(width_ / view.aspect + 0.5) / 4 * 4;
        if (!state.moc) {
            state.moc.reset(Moc::Create(set_));
            state.moc->SetResolution(unsigned(width_), unsigned(height));
        }
        Camera camera = camera_of(view);
        state.moc->SetNearClipPlane(static_cast<float>(camera.near_plane));
        state.moc->ClearBuffer();
        Screen screen = make_screen(camera, width_, height, 1);
        Visitor visitor{*this, screen, *state.moc, result, {}};
        set_matrix(camera, visitor.matrix);
        WalkKernels kernels{box_kernel(InstructionSet::automatic), project_eight_avx512()};
        if (!kernels.project)
            kernels.project = project_eight_avx2() ? project_eight_avx2() : project_eight_scalar;
        walk_front_to_back(data, screen, kernels, state.stack, result.counters, visitor);
        finish_result(result);
    }

  private:
    struct Visitor {
        const MocCuller& culler;
        const Screen& screen;
        Moc& moc;
        CullResult& result;
        float matrix[16];

        bool hidden(const PackedPlace& place) const {
            if (place.rect().empty())
                return false;
            // It rounds outward to its own pixels: stay within ours.
            auto x = [&](double pixel) { return static_cast<float>(2 * pixel / screen.width - 1); };
            auto y = [&](double pixel) { return static_cast<float>(2 * pixel / screen.height - 1); };
            return moc.TestRect(x(place.x0 + 0.01), y(place.y0 + 0.01), x(place.x1 + 0.99), y(place.y1 + 0.99),
                                1 / place.nearness) != Moc::VISIBLE;
        }
        void object(std::uint32_t object, const PackedPlace&) {
            mark_visible(result, object);
            draw(culler.meshes_[object].single_sided, Moc::BACKFACE_CW);
            draw(culler.meshes_[object].double_sided, Moc::BACKFACE_NONE);
        }
        void draw(const std::vector<unsigned>& corners, Moc::BackfaceWinding cull) {
            if (corners.empty())
                return;
            const auto* vertices = reinterpret_cast<const float*>(culler.scene_.positions().data());
            moc.RenderTriangles(vertices, corners.data(), int(corners.size() / 3), matrix, cull, Moc::CLIP_PLANE_ALL,
                                Moc::VertexLayout(12, 4, 8));
            result.counters.polygons_drawn += corners.size() / 3;
        }
        void patch(std::uint32_t, const PackedPlace&) {}
        bool wants_patch(std::uint32_t, float) const { return false; }
    };

    /// Columns of clip = matrix * (x, y, z, 1): x and y over w in -1 .. 1, w the depth.
    static void set_matrix(const Camera& camera, float (&m)[16]) {
        const Vec3d rows[4] = {camera.right * (1 / camera.half_width), camera.up * (1 / camera.half_height), {}, camera.forward};
        for (int row = 0; row < 4; ++row) {
            for (int column = 0; column < 3; ++column)
                m[4 * column + row] = static_cast<float>(rows[row][column]);
            m[12 + row] = static_cast<float>(-dot(rows[row], camera.eye));
        }
    }

    const Scene& scene_;
    CullScene boxes_;
    Moc::Implementation set_;
    int width_;
    std::uint64_t serial_;
    std::string name_;
    std::vector<Mesh> meshes_;
};

} // namespace

std::vector<std::unique_ptr<Culler>> make_moc(const Scene& scene, const CullSceneInput& input) {
    CullSceneInput boxes = input;
    boxes.occluders = nullptr; // it knows no patches
    CullScene cull_scene = CullScene::create(boxes);
    std::vector<std::unique_ptr<Culler>> cullers;
    cullers.push_back(std::make_unique<MocCuller>(scene, cull_scene, Moc::AVX2, "avx2", 640));
    cullers.push_back(std::make_unique<MocCuller>(scene, cull_scene, Moc::AVX2, "avx2", 1280));
    cullers.push_back(std::make_unique<MocCuller>(scene, cull_scene, Moc::AVX512, "avx512", 640));
    cullers.push_back(std::make_unique<MocCuller>(scene, cull_scene, Moc::AVX512, "avx512", 1280));
    return cullers;
}

} // namespace antumbra::bench
