#include "evaluate/gl/gl_context.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <cstdlib>
#include <dlfcn.h>
#include <vector>

namespace antumbra {
namespace {

/// A shared library that stays loaded: drivers do not survive being unloaded while their threads end.
class Library {
  public:
    explicit Library(const char* name) : handle_(::dlopen(name, RTLD_NOW | RTLD_LOCAL)) {}
    explicit operator bool() const { return handle_ != nullptr; }
    template <class Function>
    Function get(const char* name) const {
        return reinterpret_cast<Function>(::dlsym(handle_, name));
    }

  private:
    void* handle_;
};

class EglContext final : public GlContext {
  public:
    static Result<std::unique_ptr<GlContext>> create() {
        auto result = std::unique_ptr<EglContext>(new EglContext);
        if (Status status = result->open(); !status)
            return status;
        return std::unique_ptr<GlContext>(std::move(result));
    }

    ~EglContext() override {
        if (context_ != EGL_NO_CONTEXT) {
            make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
            destroy_(display_, context_);
        }
    }

  private:
    EglContext() : GlContext("EGL") {}

    Status open() {
        Library egl("libEGL.so.1");
        if (!egl)
            return {ErrorCode::unsupported, "no libEGL.so.1"};
        auto address = egl.get<PFNEGLGETPROCADDRESSPROC>("eglGetProcAddress");
        auto initialize = egl.get<PFNEGLINITIALIZEPROC>("eglInitialize");
        auto bind_api = egl.get<PFNEGLBINDAPIPROC>("eglBindAPI");
        auto create_context = egl.get<PFNEGLCREATECONTEXTPROC>("eglCreateContext");
        make_current_ = egl.get<PFNEGLMAKECURRENTPROC>("eglMakeCurrent");
        destroy_ = egl.get<PFNEGLDESTROYCONTEXTPROC>("eglDestroyContext");
        if (!address || !initialize || !bind_api || !create_context || !make_current_ || !destroy_)
            return {ErrorCode::unsupported, "libEGL.so.1 is older than EGL 1.5"};
        auto get_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(address("eglGetPlatformDisplayEXT"));
        if (!get_display)
            return {ErrorCode::unsupported, "EGL has no platform displays"};
        display_ = get_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
        if (display_ == EGL_NO_DISPLAY || !initialize(display_, nullptr, nullptr) || !bind_api(EGL_OPENGL_API))
            return {ErrorCode::unsupported, "EGL opens no display without a surface"};
        const EGLint attributes[] = {
            EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
        context_ = create_context(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
        if (context_ == EGL_NO_CONTEXT || !make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
            return {ErrorCode::unsupported, "EGL makes no OpenGL 3.3 context"};
        static PFNEGLGETPROCADDRESSPROC get_address = address;
        if (!load([](const char* name) { return reinterpret_cast<void*>(get_address(name)); }))
            return {ErrorCode::unsupported, "the OpenGL of EGL lacks functions of version 3.3"};
        return {};
    }

    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
    PFNEGLMAKECURRENTPROC make_current_ = nullptr;
    PFNEGLDESTROYCONTEXTPROC destroy_ = nullptr;
};

/// Mesa drawing into plain memory. Its few functions are declared here: its header is in no package that is needed
/// otherwise.
class OsMesaContext final : public GlContext {
  public:
    static Result<std::unique_ptr<GlContext>> create() {
        auto result = std::unique_ptr<OsMesaContext>(new OsMesaContext);
        if (Status status = result->open(); !status)
            return status;
        return std::unique_ptr<GlContext>(std::move(result));
    }

    ~OsMesaContext() override {
        if (context_)
            destroy_(context_);
    }

  private:
    OsMesaContext() : GlContext("OSMesa") {}

    Status open() {
        Library mesa("libOSMesa.so.8");
        if (!mesa)
            return {ErrorCode::unsupported, "no libOSMesa.so.8"};
        auto create_context = mesa.get<void* (*)(const int*, void*)>("OSMesaCreateContextAttribs");
        auto make_current = mesa.get<GLboolean (*)(void*, void*, GLenum, GLsizei, GLsizei)>("OSMesaMakeCurrent");
        auto address = mesa.get<void* (*)(const char*)>("OSMesaGetProcAddress");
        destroy_ = mesa.get<void (*)(void*)>("OSMesaDestroyContext");
        if (!create_context || !make_current || !address || !destroy_)
            return {ErrorCode::unsupported, "libOSMesa.so.8 is too old"};
        constexpr int kFormat = 0x22, kProfile = 0x33, kCoreProfile = 0x34, kMajor = 0x36, kMinor = 0x37;
        const int attributes[] = {kFormat, GL_RGBA, kProfile, kCoreProfile, kMajor, 3, kMinor, 3, 0};
        context_ = create_context(attributes, nullptr);
        // Everything is drawn into framebuffer objects; the context itself only wants some memory.
        memory_.resize(64);
        if (!context_ || !make_current(context_, memory_.data(), GL_UNSIGNED_BYTE, 4, 4))
            return {ErrorCode::unsupported, "OSMesa makes no OpenGL 3.3 context"};
        if (!load(address))
            return {ErrorCode::unsupported, "OSMesa lacks functions of OpenGL 3.3"};
        return {};
    }

    void* context_ = nullptr;
    void (*destroy_)(void*) = nullptr;
    std::vector<unsigned char> memory_;
};

} // namespace

bool GlContext::load(void* (*address)(const char*)) {
    bool complete = true;
#define ANTUMBRA_GL_LOAD(type, name)                                                                                   \
    functions_.name = reinterpret_cast<type>(address("gl" #name));                                                     \
    complete = complete && functions_.name;
    ANTUMBRA_GL_FUNCTIONS(ANTUMBRA_GL_LOAD)
#undef ANTUMBRA_GL_LOAD
    return complete;
}

std::string GlContext::description() const {
    std::string text;
    for (GLenum what : {GL_RENDERER, GL_VERSION}) {
        const GLubyte* part = functions_.GetString(what);
        if (part)
            text += (text.empty() ? "" : ", ") + std::string(reinterpret_cast<const char*>(part));
    }
    return text + ", through " + giver_;
}

Result<std::unique_ptr<GlContext>> GlContext::create() {
    ::setenv("LP_NUM_THREADS", "0", 0);
    auto egl = EglContext::create();
    if (egl)
        return egl;
    auto mesa = OsMesaContext::create();
    if (mesa)
        return mesa;
    return Status(ErrorCode::unsupported, "no OpenGL without a window (" + egl.status().message() + "; " +
                                              mesa.status().message() +
                                              "); install libegl1 and libgl1-mesa-dri to measure drawing");
}

} // namespace antumbra
