// Pieces of furniture, each in a local frame: it stands on y = 0 with its back at z = 0 (where a wall would
// be), its front looks along +z, and x = 0 is its middle. Lengths in metres. Each call adds the named objects
// and nothing else.
#pragma once

#include "generate/modeller.hpp"

#include "base/random.hpp"

namespace antumbra::generation {

/// Width (x), height (y), depth (z).
struct Size {
    double width, height, depth;
};

/// Thickness of boards everywhere.
inline constexpr double kBoard = 0.02;

/// One object, 60 triangles: a top and four legs.
void table(Modeller& modeller, const Frame& frame, const std::string& name, Size size);
/// One object, 36 triangles: a top on two side panels.
void desk(Modeller& modeller, const Frame& frame, const std::string& name, Size size);
/// One object, 48 triangles; the sitter looks along +z.
void chair(Modeller& modeller, const Frame& frame, const std::string& name);
/// One object, 12 triangles: a plain box standing on the frame's origin.
void block(Modeller& modeller, const Frame& frame, const std::string& name, Size size);
/// 1 + `doors` objects: a carcass (28 triangles) open to the front, and doors (12 each) that close it without
/// a gap.
void cupboard(Modeller& modeller, const Frame& frame, const std::string& name, Size size, int doors);
/// 1 + `count` objects of 28 triangles: a carcass and drawers, open at the top, that fill it without a gap.
/// `inside(i)` is called after drawer i with a frame on its floor and the free size, to fill it.
template <class Inside>
void drawers(Modeller& modeller, const Frame& frame, const std::string& name, Size size, int count,
             Inside&& inside);
/// `count` objects of 12 triangles: books standing side by side with their spines to the front, from `left`
/// on, for a board at y = 0 of the frame, and not beyond `right`.
void books(Modeller& modeller, const Frame& frame, const std::string& name, int count, double left,
           double right, double tallest, Random& random);
/// 1 + `boards` objects: an open carcass (28 triangles) with boards (12 each) at equal heights. `fill(i)` is
/// called for each of the boards + 1 places with a frame on its ground.
template <class Fill>
void shelf(Modeller& modeller, const Frame& frame, const std::string& name, Size size, int boards,
           Fill&& fill);
/// One object, 44 triangles: foot, pole, shade. `sides` of the shade and foot is 5.
void lamp(Modeller& modeller, const Frame& frame, const std::string& name, double height, double radius);
/// Two objects: a frame (32 triangles) and a pane (12) that lets sight pass; centred in a hole of a wall
/// whose middle plane is z = 0 of the frame, from (x, y) = low to high.
void window(Modeller& modeller, const Frame& frame, const std::string& name, Vec2 low, Vec2 high);
/// One object, 24 triangles: a door leaf from x = 0 (hinge) to `width`, closed at z = 0, opened by `turns`
/// about y.
void door(Modeller& modeller, const Frame& frame, const std::string& name, double width, double height,
          double turns);

void carcass(Modeller& modeller, const Frame& frame, const std::string& name, Size size);

template <class Inside>
void drawers(Modeller& modeller, const Frame& frame, const std::string& name, Size size, int count,
             Inside&& inside) {
    carcass(modeller, frame, name, size);
    double step = (size.height - 2 * kBoard) / count, half = size.width / 2 - kBoard;
    for (int i = 0; i < count; ++i) {
        std::string own = name + "/drawer " + std::to_string(i + 1);
        modeller.begin(own);
        modeller.place(frame * at({0, kBoard + i * step, 0}));
        modeller.open_box({-half, 0, kBoard}, {half, step, size.depth}, kBoard, Axis::y);
        inside(i, own, frame * at({0, 2 * kBoard + i * step, 2 * kBoard}),
               Size{size.width - 4 * kBoard, step - kBoard, size.depth - 3 * kBoard});
    }
}

template <class Fill>
void shelf(Modeller& modeller, const Frame& frame, const std::string& name, Size size, int boards,
           Fill&& fill) {
    carcass(modeller, frame, name, size);
    double step = (size.height - 2 * kBoard) / (boards + 1), half = size.width / 2 - kBoard;
    for (int i = 0; i <= boards; ++i) {
        double ground = kBoard + i * step;
        if (i > 0) {
            modeller.begin(name + "/board " + std::to_string(i));
            modeller.place(frame);
            modeller.box({-half, ground - kBoard, kBoard}, {half, ground, size.depth});
        }
        fill(i, frame * at({0, ground, kBoard}), Size{2 * half, step - kBoard, size.depth - kBoard});
    }
}

} // namespace antumbra::generation
