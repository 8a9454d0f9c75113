// The workshop of the generators: closed solids, one after the other, into a RawScene.
//
// Every vertex is snapped to a grid after its frame has been applied, and everything before that uses only
// operations that IEEE 754 rounds correctly (+ - * / floor sqrt): a scene is the same bytes on every machine.
// The language does not order the arguments of a call: at most one of them may draw a random number. Every
// solid is closed and wound outward (counter-clockwise seen from outside), whatever frame places it.
#pragma once

#include <antumbra/scene.hpp>

#include <span>
#include <string>
#include <vector>

namespace antumbra::generation {

/// Metres. The coordinates of a generated scene are whole multiples of one of these: exact in float up to 4
/// km, and for things that have millimetres up to 256 m.
inline constexpr double kGrid = 1.0 / 4096, kFineGrid = 1.0 / 65536;

/// sin and cos of `turns` full turns; exact at quarter turns, else good to about 1e-15, the same on every
/// machine.
double sine(double turns);
double cosine(double turns);

/// A right-handed orthonormal frame: where local coordinates lie in the world.
struct Frame {
    Vec3d origin;
    Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

    Vec3d apply(const Vec3d& p) const { return origin + x * p.x + y * p.y + z * p.z; }
    Vec3d turn(const Vec3d& v) const { return x * v.x + y * v.y + z * v.z; }
    /// The frame `inner`, given in this frame's coordinates.
    Frame operator*(const Frame& inner) const {
        return {apply(inner.origin), turn(inner.x), turn(inner.y), turn(inner.z)};
    }
};

/// Unturned at `origin`.
Frame at(const Vec3d& origin);
/// Turned about the upward axis Y: local +Z looks toward (sin, 0, cos) of `turns`.
Frame turned(const Vec3d& origin, double turns);
/// A frame at `origin` whose z axis is `direction` (any length but zero). The other two axes are arbitrary
/// but fixed.
Frame looking(const Vec3d& origin, const Vec3d& direction);

struct Vec2 {
    double x = 0, y = 0;
};

/// Axis of an extrusion. The outline's (x, y) are the next two axes in cyclic order: along y they are (z, x).
enum class Axis : int { x = 0, y = 1, z = 2 };

/// Collects objects. Not thread-safe. Never fails: shapes come from our own generators.
class Modeller {
  public:
    explicit Modeller(std::string source, double grid = kGrid);

    /// Starts the next object; everything until the next begin() belongs to it.
    void begin(std::string name, std::uint32_t flags = kOccludes);
    void place(const Frame& frame) { frame_ = frame; }

    /// 12 triangles.
    void box(const Vec3d& low, const Vec3d& high);
    /// A box given by its eight corners, numbered as Box3::corner; the faces should be planar. 12 triangles.
    void hexahedron(std::span<const Vec3d> corners);
    /// A box with a box-shaped cavity of walls `thickness` that is open towards +axis. 28 triangles.
    void open_box(const Vec3d& low, const Vec3d& high, double thickness, Axis open);
    /// A rectangular frame around a rectangular hole, from low to high along `axis`. 32 triangles.
    void ring(Axis axis, Vec2 outer_low, Vec2 outer_high, Vec2 hole_low, Vec2 hole_high, double low,
              double high);
    /// A simple polygon (counter-clockwise, no hole, may be concave) of n corners, extruded. 4 n - 4
    /// triangles.
    void extrude(Axis axis, std::span<const Vec2> outline, double low, double high);
    /// A polygon that its centre (0, 0) sees whole: 4 n triangles, two fans and a rim.
    void star(Axis axis, std::span<const Vec2> outline, double low, double high);
    /// A surface of revolution about `axis` through the local origin: (radius, height) from low to high,
    /// radius 0 only at the ends. 2 sides per band between two radii > 0, `sides` for a pole, sides - 2 for a
    /// flat end.
    void lathe(Axis axis, std::span<const Vec2> profile, int sides);
    /// The same with a flat top and bottom. 4 sides - 4 triangles.
    void cylinder(Axis axis, double radius, double low, double high, int sides);
    /// A tube of constant or varying radius along a polyline, flat ends. sides * 2 * (n-1) + 2 (sides - 2).
    void tube(std::span<const Vec3d> path, std::span<const double> radii, int sides);
    /// Eight triangles around `centre`.
    void octahedron(const Vec3d& centre, const Vec3d& radii);
    /// One triangle, for leaves of objects that are kDoubleSided.
    void leaf(const Vec3d& a, const Vec3d& b, const Vec3d& c);
    /// Raw access for shapes of one generator: a vertex, and a triangle of the current object.
    std::uint32_t vertex(const Vec3d& local);
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);

    std::size_t triangle_count() const { return scene_.triangles.size(); }
    std::size_t object_count() const { return scene_.objects.size(); }
    RawScene finish() { return std::move(scene_); }

  private:
    void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);
    void fan(std::span<const std::uint32_t> ring, bool reversed);
    void band(std::span<const std::uint32_t> lower, std::span<const std::uint32_t> upper);
    Frame frame_;
    double grid_;
    RawScene scene_;
};

} // namespace antumbra::generation
