// Sets of directions as boxes in (theta, phi), without trigonometry.
#pragma once

#include <antumbra/pvs.hpp>

namespace antumbra {

/// Closed intervals of theta and phi, in steps.
struct DirectionBox {
    std::uint32_t theta_low, theta_high, phi_low, phi_high;

    bool touches(const ViewRegion& box) const {
        return theta_low <= box.high[3] && theta_high >= box.low[3] && phi_low <= box.high[4] &&
               phi_high >= box.low[4];
    }
};

/// Boxes that hold every direction of a range, one per octant that it reaches.
struct DirectionBoxes {
    std::array<DirectionBox, 8> boxes;
    std::size_t count = 0;

    bool touch(const ViewRegion& box) const {
        for (std::size_t i = 0; i < count; ++i)
            if (boxes[i].touches(box))
                return true;
        return false;
    }
};

/// Conservative: rounded outward by at least one step; near a pole theta is the whole quarter turn.
DirectionBoxes cover_directions(const ViewRange& range);

} // namespace antumbra
