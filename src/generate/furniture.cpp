#include "generate/furniture.hpp"

namespace antumbra::generation {

void carcass(Modeller& modeller, const Frame& frame, const std::string& name, Size size) {
    modeller.begin(name);
    modeller.place(frame);
    modeller.open_box({-size.width / 2, 0, 0}, {size.width / 2, size.height, size.depth}, kBoard, Axis::z);
}

void table(Modeller& modeller, const Frame& frame, const std::string& name, Size size) {
    constexpr double kTop = 0.03, kLeg = 0.06;
    double half = size.width / 2, under = size.height - kTop;
    modeller.begin(name);
    modeller.place(frame);
    modeller.box({-half, under, 0}, {half, size.height, size.depth});
    for (double x : {-half, half - kLeg})
        for (double z : {0.0, size.depth - kLeg})
            modeller.box({x, 0, z}, {x + kLeg, under, z + kLeg});
}

void desk(Modeller& modeller, const Frame& frame, const std::string& name, Size size) {
    constexpr double kTop = 0.03;
    double half = size.width / 2, under = size.height - kTop;
    modeller.begin(name);
    modeller.place(frame);
    modeller.box({-half, under, 0}, {half, size.height, size.depth});
    modeller.box({-half, 0, 0}, {-half + kTop, under, size.depth});
    modeller.box({half - kTop, 0, 0}, {half, under, size.depth});
}

void chair(Modeller& modeller, const Frame& frame, const std::string& name) {
    constexpr double kHalf = 0.21, kDepth = 0.44, kSeat = 0.45, kThick = 0.03, kLeg = 0.04;
    modeller.begin(name);
    modeller.place(frame);
    modeller.box({-kHalf, 0, 0}, {kHalf, 0.9, kThick}); // the back reaches down to the floor
    modeller.box({-kHalf, kSeat - kThick, kThick}, {kHalf, kSeat, kDepth});
    for (double x : {-kHalf, kHalf - kLeg})
        modeller.box({x, 0, kDepth - kLeg}, {x + kLeg, kSeat - kThick, kDepth});
}

void block(Modeller& modeller, const Frame& frame, const std::string& name, Size size) {
    modeller.begin(name);
    modeller.place(frame);
    modeller.box({-size.width / 2, 0, 0}, {size.width / 2, size.height, size.depth});
}

void cupboard(Modeller& modeller, const Frame& frame, const std::string& name, Size size, int doors) {
    carcass(modeller, frame, name, size);
    double step = size.width / doors;
    for (int i = 0; i < doors; ++i) {
        double left = -size.width / 2 + i * step;
        modeller.begin(name + "/door " + std::to_string(i + 1));
        modeller.place(frame);
        modeller.box({left, 0, size.depth}, {left + step, size.height, size.depth + kBoard});
    }
}

void books(Modeller& modeller, const Frame& frame, const std::string& name, int count, double left,
           double right, double tallest, Random& random) {
    double x = left, widest = (right - left) / count;
    for (int i = 0; i < count; ++i) {
        double width = widest * random.uniform(0.6, 1), height = tallest * random.uniform(0.7, 1),
               depth = random.uniform(0.14, 0.2);
        modeller.begin(name + "/book " + std::to_string(i + 1));
        modeller.place(frame);
        modeller.box({x, 0, 0.02}, {x + width, height, 0.02 + depth});
        x += width;
    }
}

void lamp(Modeller& modeller, const Frame& frame, const std::string& name, double height, double radius) {
    modeller.begin(name);
    modeller.place(frame);
    double shade = radius * 1.2;
    modeller.cylinder(Axis::y, radius * 0.8, 0, 0.02, 5);
    modeller.box({-0.015, 0.02, -0.015}, {0.015, height - shade, 0.015});
    Vec2 profile[2] = {{radius, height - shade}, {radius * 0.6, height}};
    modeller.lathe(Axis::y, profile, 5);
}

void window(Modeller& modeller, const Frame& frame, const std::string& name, Vec2 low, Vec2 high) {
    constexpr double kFrame = 0.06, kDeep = 0.04, kPane = 0.005;
    modeller.begin(name + "/frame");
    modeller.place(frame);
    modeller.ring(Axis::z, low, high, {low.x + kFrame, low.y + kFrame}, {high.x - kFrame, high.y - kFrame},
                  -kDeep, kDeep);
    modeller.begin(name + "/pane", 0);
    modeller.box({low.x + kFrame, low.y + kFrame, -kPane}, {high.x - kFrame, high.y - kFrame, kPane});
}

void door(Modeller& modeller, const Frame& frame, const std::string& name, double width, double height,
          double turns) {
    constexpr double kHalf = 0.02;
    modeller.begin(name);
    modeller.place(frame * turned({}, turns));
    modeller.box({0, 0, -kHalf}, {width, height, kHalf});
    modeller.box({width - 0.15, height * 0.5, kHalf}, {width - 0.05, height * 0.5 + 0.02, kHalf + 0.04});
}

} // namespace antumbra::generation
