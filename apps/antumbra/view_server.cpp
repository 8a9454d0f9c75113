#include "view_server.hpp"

#include "import/uri.hpp"

#include <antumbra/evaluate.hpp>
#include <antumbra/export.hpp>

#include <httplib.h>

#include <algorithm>
#include <charconv>
#include <mutex>
#include <thread>

namespace antumbra::app {
namespace {

std::string file_name(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

std::string ending_of(const std::string& path) {
    std::string name = file_name(path), ending = name.substr(std::min(name.find_last_of('.'), name.size()));
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
    return ending;
}

const char* type_of(const std::string& path) {
    static constexpr std::pair<const char*, const char*> types[] = {
        {".glb", "model/gltf-binary"}, {".gltf", "model/gltf+json"}, {".png", "image/png"},
        {".jpg", "image/jpeg"},        {".jpeg", "image/jpeg"},      {".webp", "image/webp"},
        {".ktx2", "image/ktx2"},
    };
    std::string ending = ending_of(path);
    for (auto [known, type] : types)
        if (ending == known)
            return type;
    return "application/octet-stream";
}

/// Sends bytes that live as long as `owner` without copying them.
template <class Owner>
void send(httplib::Response& response, std::span<const std::byte> bytes, const char* type, Owner owner) {
    const char* data = reinterpret_cast<const char*>(bytes.data());
    if (bytes.empty()) // a provider must have something to provide
        return response.set_content("", type);
    response.set_content_provider(bytes.size(), type,
                                  [data, owner = std::move(owner)](std::size_t at, std::size_t size, httplib::DataSink& sink) {
                                      return sink.write(data + at, std::min<std::size_t>(size, 1 << 20));
                                  });
}

void send_json(httplib::Response& response, const Json& document, int status = 200) {
    response.status = status;
    response.set_content(document.dump(-1, ' ', false, Json::error_handler_t::replace), "application/json");
}

void send_error(httplib::Response& response, int status, const std::string& message) {
    send_json(response, {{"error", message}}, status);
}

Json to_json(const Vec3d& v) { return {v.x, v.y, v.z}; }

/// Names as part of an address.
std::string escaped(const std::string& name) {
    static constexpr char digits[] = "0123456789ABCDEF";
    std::string text;
    for (unsigned char c : name)
        if (std::isalnum(c) || c == '.' || c == '-' || c == '_')
            text += static_cast<char>(c);
        else
            text += {'%', digits[c >> 4], digits[c & 15]};
    return text;
}

/// The files that a glTF names, decoded. The importer has read it before, so that a broken one is none of our cares.
std::set<std::string> companions_of(const std::string& path) {
    std::set<std::string> names;
    Result<MappedFile> file = MappedFile::open(path);
    if (!file)
        return names;
    std::string_view text(reinterpret_cast<const char*>(file->bytes().data()), file->bytes().size());
    if (text.starts_with("glTF") && text.size() >= 20) {
        std::uint32_t length = 0;
        for (std::size_t k = 0; k < 4; ++k)
            length |= std::uint32_t(static_cast<unsigned char>(text[12 + k])) << 8 * k;
        text = text.substr(20, length);
    }
    Json document = Json::parse(text, nullptr, false);
    for (const char* kind : {"buffers", "images"})
        if (document.is_object() && document.contains(kind))
            for (const Json& entry : document[kind])
                if (entry.is_object() && entry.contains("uri") && entry["uri"].is_string())
                    if (auto name = percent_decoded(entry["uri"].get<std::string>()))
                        names.insert(*name);
    return names;
}

/// The page, told that a server stands behind it.
const std::string& served_page() {
    static const std::string page = [] {
        std::string text(viewer_page);
        std::size_t head = text.find("<head>");
        if (head != std::string::npos)
            text.insert(head + 6, "<meta name=\"antumbra-server\" content=\"1\">");
        return text;
    }();
    return page;
}

} // namespace

Result<std::unique_ptr<ViewedScene>> open_viewed(Scene scene, const std::string& path, const std::string& pvs_path) {
    auto viewed = std::make_unique<ViewedScene>(ViewedScene{std::move(scene), path, {}, {}, {}, pvs_path, 0});
    std::string ending = ending_of(path);
    if (ending != ".glb" && ending != ".gltf") {
        Result<std::vector<std::byte>> bytes = export_glb(viewed->scene);
        if (!bytes)
            return bytes.status();
        viewed->converted = std::move(*bytes);
    } else {
        viewed->companions = companions_of(path);
    }
    if (pvs_path.empty())
        return viewed;
    Result<PvsFile> opened = open_pvs(pvs_path, viewed->scene);
    if (!opened)
        return opened.status();
    viewed->baked.emplace(std::move(*opened));
    return viewed;
}

struct ViewServer::Parts {
    explicit Parts(const ViewedScene& what) : viewed(what) { route(); }

    const ViewedScene& viewed;
    httplib::Server server;
    int port = 0;
    std::atomic<bool> stopping{false};

    std::mutex path_lock, explainer_lock;
    std::optional<Json> path;               ///< made when first asked for
    std::optional<Explainer> explainer;     ///< likewise

    Job job() const { return {viewed.threads, {}, &stopping}; }
    void route();
    bool may_answer(const httplib::Request& request) const;
    void answer_scene(const httplib::Request& request, httplib::Response& response) const;
    void answer_offer(httplib::Response& response) const;
    void answer_path(httplib::Response& response);
    void answer_explain(const httplib::Request& request, httplib::Response& response);
    std::string scene_name() const {
        return file_name(viewed.path) + (viewed.is_gltf() ? "" : ".glb");
    }
};

void ViewServer::Parts::route() {
    // The page is the only one that may use what is here, and it needs nothing from elsewhere. Isolation
    // gives it a finer clock for the times that it shows.
    server.set_default_headers({
        {"Cross-Origin-Opener-Policy", "same-origin"},
        {"Cross-Origin-Embedder-Policy", "require-corp"},
        {"Cross-Origin-Resource-Policy", "same-origin"},
        {"X-Content-Type-Options", "nosniff"},
        {"Cache-Control", "no-store"},
        {"Content-Security-Policy",
         "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; "
         "style-src 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self' data: blob:; "
         "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    });
    server.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
        if (may_answer(request))
            return httplib::Server::HandlerResponse::Unhandled;
        send_error(response, 403, "this server answers to 127.0.0.1 and localhost only");
        return httplib::Server::HandlerResponse::Handled;
    });
    server.Get("/", [](const httplib::Request&, httplib::Response& response) {
        send(response, std::as_bytes(std::span(served_page())), "text/html; charset=utf-8", nullptr);
    });
    server.Get("/api/scene", [this](const httplib::Request&, httplib::Response& response) { answer_offer(response); });
    server.Get("/api/path", [this](const httplib::Request&, httplib::Response& response) { answer_path(response); });
    server.Get("/api/explain", [this](const httplib::Request& request, httplib::Response& response) {
        answer_explain(request, response);
    });
    server.Get(R"(/scene/(.+))", [this](const httplib::Request& request, httplib::Response& response) {
        answer_scene(request, response);
    });
    server.Get(R"(/pvs/.+)", [this](const httplib::Request&, httplib::Response& response) {
        if (!viewed.baked)
            return send_error(response, 404, "no .pvs was given");
        send(response, viewed.baked->bytes(), "application/octet-stream", nullptr);
    });
}

bool ViewServer::Parts::may_answer(const httplib::Request& request) const {
    std::string host = request.get_header_value("Host"), suffix = ":" + std::to_string(port);
    return host == "127.0.0.1" + suffix || host == "localhost" + suffix;
}

void ViewServer::Parts::answer_scene(const httplib::Request& request, httplib::Response& response) const {
    std::string name = request.matches[1]; // decoded already
    if (!viewed.is_gltf()) {
        if (name != scene_name())
            return send_error(response, 404, "no such file");
        return send(response, viewed.converted, "model/gltf-binary", nullptr);
    }
    if (name != file_name(viewed.path) && !viewed.companions.contains(name))
        return send_error(response, 404, "no such file");
    Result<std::string> place = path_inside(folder_of(viewed.path), name);
    if (!place)
        return send_error(response, 404, place.status().message());
    Result<MappedFile> file = MappedFile::open(*place);
    if (!file)
        return send_error(response, 404, file.status().message());
    auto kept = std::make_shared<MappedFile>(std::move(*file));
    send(response, kept->bytes(), type_of(*place), kept);
}

void ViewServer::Parts::answer_offer(httplib::Response& response) const {
    send_json(response, {{"name", file_name(viewed.path)},
                         {"scene", "scene/" + escaped(scene_name())},
                         {"pvs", viewed.baked ? Json("pvs/" + escaped(file_name(viewed.pvs_path))) : Json(nullptr)},
                         {"byOrder", !viewed.is_gltf()},
                         {"explains", viewed.baked.has_value()}});
}

void ViewServer::Parts::answer_path(httplib::Response& response) {
    std::lock_guard guard(path_lock);
    if (!path) {
        PathOptions options;
        options.frames = 240;
        Result<FoundPath> found = find_path(viewed.scene, options, job());
        if (!found)
            return send_error(response, 500, found.status().message());
        Json frames = Json::array();
        for (const View& view : found->views)
            frames.push_back({{"eye", to_json(viewed.scene.to_world(view.eye))},
                              {"target", to_json(viewed.scene.to_world(view.target))}});
        path = Json{{"description", found->description}, {"frames", std::move(frames)}};
    }
    send_json(response, *path);
}

void ViewServer::Parts::answer_explain(const httplib::Request& request, httplib::Response& response) {
    if (!viewed.baked)
        return send_error(response, 404, "no .pvs was given");
    std::string text = request.get_param_value("object");
    std::uint32_t object = 0;
    auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), object);
    if (problem != std::errc() || end != text.data() + text.size() || object >= viewed.scene.objects().size())
        return send_error(response, 400, "object wants a number below " + std::to_string(viewed.scene.objects().size()));
    Result<Vec3d> eye = parse_vec3(request.get_param_value("eye"), "eye");
    if (!eye)
        return send_error(response, 400, eye.status().message());
    {
        std::lock_guard guard(explainer_lock);
        if (!explainer) {
            Result<Explainer> made = Explainer::create(viewed.scene, viewed.baked->pvs, job());
            if (!made)
                return send_error(response, 500, made.status().message());
            explainer.emplace(std::move(*made));
        }
    }
    Result<Explanation> explanation = explainer->explain(*eye, object, {}, job());
    if (!explanation)
        return send_error(response, 400, explanation.status().message());
    response.set_content(explain_in_json(viewed.scene, *explanation), "application/json");
}

ViewServer::ViewServer(const ViewedScene& viewed) : parts_(std::make_unique<Parts>(viewed)) {}
ViewServer::~ViewServer() = default;

Result<int> ViewServer::bind(int port, bool any_other) {
    // By default a second server may share the port of a running one, and gets half of its requests.
    parts_->server.set_socket_options([](socket_t socket) {
        int yes = 1;
        setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    if (port != 0 && parts_->server.bind_to_port("127.0.0.1", port))
        return parts_->port = port;
    if (port == 0 || any_other) {
        int got = parts_->server.bind_to_any_port("127.0.0.1");
        if (got > 0)
            return parts_->port = got;
    }
    return Status(ErrorCode::io, "port " + std::to_string(port) + " of 127.0.0.1 cannot be had (is another program using "
                                 "it?); choose another with --port, or leave it out");
}

void ViewServer::serve(const std::atomic<bool>& stop) {
    std::thread watch([&] {
        while (!stop.load() && !parts_->stopping.load())
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        parts_->stopping = true;
        parts_->server.stop();
    });
    parts_->server.listen_after_bind();
    parts_->stopping = true;
    watch.join();
}

} // namespace antumbra::app
