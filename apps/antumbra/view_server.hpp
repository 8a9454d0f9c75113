// What `antumbra view` serves: the viewer's page, the scene, the bake, and answers that need the whole toolkit.
#pragma once

#include "command.hpp"

#include <antumbra/explain.hpp>
#include <antumbra/job.hpp>
#include <antumbra/pvs.hpp>
#include <antumbra/scene.hpp>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace antumbra::app {

/// The page as one document that carries everything; made by web/viewer when the program is built.
extern const std::string_view viewer_page;

/// All of one view: what is shown, immutable once it is served.
struct ViewedScene {
    Scene scene;
    std::string path;                  ///< of the scene file
    std::vector<std::byte> converted;  ///< GLB, if the file is no glTF
    std::set<std::string> companions;  ///< other files that the glTF names, relative to its folder
    std::optional<PvsFile> baked;
    std::string pvs_path;
    unsigned threads = 0;

    bool is_gltf() const { return converted.empty(); }
};

/// Reads both files. Refuses a .pvs of another scene.
Result<std::unique_ptr<ViewedScene>> open_viewed(Scene scene, const std::string& path, const std::string& pvs_path);

/// A server on 127.0.0.1 alone. It answers whom it should: requests whose Host is another name (a page elsewhere that
/// points its own name here) are refused, and nothing but the viewed files is given out.
///
///   /                  the viewer
///   /scene/NAME        the scene; of a glTF also the files that it names, by the importer's rules
///   /pvs/NAME          the .pvs
///   /api/scene         what there is: {name, scene, pvs, byOrder, explains}
///   /api/path          a walk through the scene: {description, frames [{eye, target}]}
///   /api/explain?object=ID&eye=X,Y,Z   as `antumbra explain --json`
class ViewServer {
  public:
    explicit ViewServer(const ViewedScene& viewed);
    ~ViewServer();

    /// Takes `port`; if it is busy and `any_other`, a free one. Returns the one it got. ErrorCode::io: none.
    Result<int> bind(int port, bool any_other);
    /// Answers until `stop` becomes true; work under way is cancelled then.
    void serve(const std::atomic<bool>& stop);

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace antumbra::app
