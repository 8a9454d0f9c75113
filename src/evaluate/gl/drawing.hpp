// Draws chosen objects of a scene with OpenGL: for draw times and for pictures, never for truth.
#pragma once

#include <antumbra/cull.hpp>
#include <antumbra/scene.hpp>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace antumbra {

/// 8-bit RGB, rows from the top.
struct Image {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
    bool operator==(const Image&) const = default;
};

enum class DrawStyle : std::uint8_t {
    shaded, ///< a stable colour per object, lit by its normals; see-through objects blended
    items,  ///< the object's number + 1 as a colour, nothing blended; 0 where nothing is drawn
};

/// The stable colour of an object, each channel in 0..1: what it is drawn with before lighting.
Vec3f object_colour(std::uint32_t object);

/// Belongs to the thread that made it. Faces are culled as the scene says (Object flags), depth is tested, one draw
/// call per object, see-through objects last.
class Drawing {
  public:
    /// ErrorCode::unsupported where there is no OpenGL.
    static Result<std::unique_ptr<Drawing>> create(const Scene& scene, std::uint32_t width, std::uint32_t height);
    ~Drawing();

    /// Draws the objects whose bits are set and waits until it is done. Returns the wall time in seconds.
    double draw(const View& view, std::span<const std::uint64_t> objects, DrawStyle style = DrawStyle::shaded);
    /// What the last draw() drew.
    Image read_back();
    /// Renderer and version.
    std::string description() const;

  private:
    struct State;
    explicit Drawing(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace antumbra
