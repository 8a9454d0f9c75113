// Queries that start where the box around came down to: "children start at the leaves that their parent reached". A child
// lies in the silhouette of its parent, so of the bounds of the part of the picture where the parent reached a leaf only
// those that are planes of the tree can cut it; what was hidden of the parent is never looked at again.
#include "occlusion_tree/occlusion_tree.hpp"

namespace antumbra {

void OcclusionTree::look_through(const std::array<Vec3d, 4>& window) {
    std::uint32_t corners[4];
    for (std::size_t i = 0; i < 4; ++i)
        corners[i] = sight_.add_point(window[i]);
    reached_lines_.clear();
    for (std::size_t i = 0; i < 4; ++i)
        reached_lines_.push_back(sight_.add_edge(corners[i], corners[(i + 1) % 4]));
    reached_.assign(1, {root_, 0, 4});
}

OcclusionTree::Reach OcclusionTree::whole_picture() {
    reached_[0].child = root_;
    return {0, 1};
}

void OcclusionTree::release(Reach last) {
    reached_.resize(last.first + last.count);
    const Reached& end = reached_.back();
    reached_lines_.resize(end.first_line + end.lines);
}

/// False if there is no room.
bool OcclusionTree::keep(Child child, const PicturePolygon& piece) {
    if (reached_.size() == kMostReached || reached_lines_.size() + static_cast<std::size_t>(piece.count) > reached_lines_.capacity())
        return false;
    auto first = static_cast<std::uint32_t>(reached_lines_.size());
    for (int i = 0; i < piece.count; ++i)
        if (piece.flagged(i))
            reached_lines_.push_back(piece.edge(i));
    reached_.push_back({child, first, static_cast<std::uint32_t>(reached_lines_.size()) - first});
    return true;
}

bool OcclusionTree::keep(const Reached& place) {
    if (reached_.size() == kMostReached || reached_lines_.size() + place.lines > reached_lines_.capacity())
        return false;
    auto first = static_cast<std::uint32_t>(reached_lines_.size());
    for (std::uint32_t i = 0; i < place.lines; ++i)
        reached_lines_.push_back(reached_lines_[place.first_line + i]);
    reached_.push_back({place.child, first, place.lines});
    return true;
}

/// To the place's part of the picture. Nothing left: count is 0. What cannot be decided is left as it is, which can only hide less.
bool OcclusionTree::clip(PicturePolygon& polygon, const Reached& place) {
    signed char sides[PicturePolygon::kMost];
    for (std::uint32_t i = 0; i < place.lines; ++i) {
        LineRef line = reached_lines_[place.first_line + i];
        ++planes_tested_;
        switch (locate(sight_, line, polygon, sides)) {
        case Place::inside: break;
        case Place::outside: return false;
        case Place::undecided: break;
        case Place::both:
            if (cut(sight_, line, polygon, sides, &clipped_, nullptr))
                polygon = clipped_;
            break;
        }
    }
    return true;
}

bool OcclusionTree::hides(const Box3d& box, Reach from, Vec3d* seen, Reach* reached) {
    if (reached)
        *reached = from;
    if (box.contains(sight_.eye()))
        return false;
    Sight::Mark mark = sight_.mark();
    if (!silhouette_of(box, silhouette_))
        return visibility_by_faces(box) == Visibility::invisible;
    bool hidden = true;
    std::uint32_t at = from.first, end = from.first + from.count;
    for (; at < end && hidden; ++at) {
        Reached place = reached_[at];
        pool(0) = silhouette_;
        if (!clip(pool(0), place))
            continue;
        stack_.assign(1, {place.child, kRoot, 0});
        Work shown;
        hidden = all_hidden(box, seen, shown);
        if (hidden || !reached)
            continue;
        auto first = static_cast<std::uint32_t>(reached_.size());
        bool room = keep(shown.child, pool(shown.polygon));
        for (std::size_t i = stack_.size(); i-- > 0;)
            room = room && keep(stack_[i].child, pool(stack_[i].polygon));
        for (std::uint32_t rest = at + 1; rest < end; ++rest)
            room = room && keep(Reached(reached_[rest]));
        if (room)
            *reached = {first, static_cast<std::uint32_t>(reached_.size()) - first};
        else
            release({first - 1, 1});
    }
    sight_.forget(mark);
    return hidden;
}

OcclusionTree::Reach OcclusionTree::narrow(const Box3d& box, Reach from) {
    auto first = static_cast<std::uint32_t>(reached_.size());
    for (std::uint32_t at = from.first; at < from.first + from.count; ++at) {
        Reached place = reached_[at];
        if (reached_.size() == kMostReached || reached_lines_.size() + place.lines > reached_lines_.capacity()) {
            release({first - 1, 1});
            return from;
        }
        auto first_line = static_cast<std::uint32_t>(reached_lines_.size());
        bool outside = false;
        for (std::uint32_t i = 0; i < place.lines && !outside; ++i) {
            LineRef line = reached_lines_[place.first_line + i];
            Sight::Range range = sight_.line_range(line, box);
            ++planes_tested_;
            outside = range.most < 0;
            if (range.least < 0)
                reached_lines_.push_back(line);
        }
        if (outside) {
            reached_lines_.resize(first_line);
            continue;
        }
        auto lines = static_cast<std::uint32_t>(reached_lines_.size()) - first_line;
        reached_.push_back({descend(box, {place.child}).child, first_line, lines});
    }
    auto count = static_cast<std::uint32_t>(reached_.size()) - first;
    return {first, count};
}

bool OcclusionTree::is_seen(const Vec3d& point, Reach from) {
    for (std::uint32_t at = from.first; at < from.first + from.count; ++at) {
        const Reached& place = reached_[at];
        bool inside = true;
        for (std::uint32_t i = 0; i < place.lines && inside; ++i) {
            ++planes_tested_;
            inside = sight_.line_range(reached_lines_[place.first_line + i], point).least > 0;
        }
        if (inside)
            return is_seen(point, Start{place.child});
    }
    return false;
}

} // namespace antumbra
