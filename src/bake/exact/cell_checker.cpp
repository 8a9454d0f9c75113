#include "bake/exact/cell_checker.hpp"

namespace antumbra::certificates {

/// Is some of the cell in front of the triangle, is some behind and the triangle drawn from there?
void CellChecker::sides(std::uint32_t t, bool& front, bool& back) const {
    std::size_t triple[3];
    exact::GridPlane plane = exact::plane_of(tree_.corners(t), triple);
    front = back = false;
    for (int i = 0; i < 8; ++i) {
        GridPoint p{i & 1 ? cell_.max.x : cell_.min.x, i & 2 ? cell_.max.y : cell_.min.y, i & 4 ? cell_.max.z : cell_.min.z};
        exact::Int128 at = plane.at(p);
        front |= at > 0;
        back |= at < 0 && tree_.both_sides(t);
    }
}

/// The tree for this pair of polygons, or the empty one, which holds if nothing of them faces each other.
Status CellChecker::hides(const std::map<Key, Tree>& trees, int face, const Polygon& part) const {
    static const Tree kNone;
    auto found = trees.find(key_of(face, part.corners));
    const Tree& tree = found == trees.end() ? kNone : found->second;
    std::vector<Polygon> blockers;
    for (std::uint32_t t : tree.blockers)
        blockers.push_back(triangle_polygon(tree_, t, false));
    return certify::verify_hidden(cell_face(cell_, face), part, blockers, tree.tree);
}

Status CellChecker::covers_box(const std::map<Key, Tree>& trees, const GridBox& box) const {
    if (cell_.touches(box))
        return {ErrorCode::mismatch, "a box that is called hidden touches the cell"};
    for (int from = 0; from < 6; ++from)
        for (int to = 0; to < 6; ++to) {
            int b = (to / 2 + 1) % 3, c = (to / 2 + 2) % 3;
            bool looks_back = to % 2 ? cell_.max[to / 2] > box.max[to / 2] : cell_.min[to / 2] < box.min[to / 2];
            if (!looks(from, box) || !looks_back || box.min[b] == box.max[b] || box.min[c] == box.max[c])
                continue;
            if (Status status = hides(trees, from, cell_face(box, to)); !status)
                return status;
        }
    return {};
}

Status CellChecker::covers_triangle(const std::map<Key, Tree>& trees, std::uint32_t t) const {
    bool front, back;
    sides(t, front, back);
    if (exact::touches(cell_, tree_.corners(t)))
        return front || back ? Status(ErrorCode::mismatch, "a triangle that is called hidden touches the cell") : Status();
    GridBox box;
    for (const GridPoint& p : tree_.corners(t))
        box.extend(p);
    for (int turned = 0; turned < 2; ++turned)
        for (int from = 0; (turned ? back : front) && from < 6; ++from)
            if (looks(from, box))
                if (Status status = hides(trees, from, triangle_polygon(tree_, t, turned)); !status)
                    return status;
    return {};
}

Status CellChecker::check_hidden(Reader& in, std::uint32_t unit, CertificateFileResult& result) const {
    std::vector<GridBox> boxes(in.count());
    for (GridBox& box : boxes) {
        box.min = in.point();
        box.max = in.point();
        for (int k = 0; k < 3; ++k)
            if (box.min[k] > box.max[k])
                in.fail();
    }
    std::map<Key, Tree> trees;
    std::size_t count = in.count();
    for (std::size_t k = 0; k < count && in.ok(); ++k) {
        int face = in.byte();
        std::vector<GridPoint> corners(in.byte());
        if (face > 5 || corners.size() < 3 || corners.size() > 4)
            in.fail();
        for (GridPoint& corner : corners)
            corner = in.point();
        Tree tree;
        tree.blockers.resize(in.count());
        for (std::uint32_t& blocker : tree.blockers) {
            std::uint64_t t = in.number();
            if (t >= tree_.corners_count() || !tree_.occludes(std::uint32_t(t)))
                in.fail(); // only what occludes may block
            blocker = std::uint32_t(t);
        }
        tree.tree = get_tree(in, tree.blockers.size());
        ++result.trees;
        result.nodes += tree.tree.nodes.size();
        trees[key_of(face, corners)] = std::move(tree);
    }
    if (!in.ok())
        return {};
    for (const GridBox& box : boxes)
        if (Status status = covers_box(trees, box); !status)
            return status;
    for (std::uint32_t t : tree_.units().triangles_of(unit)) {
        GridBox own;
        for (const GridPoint& p : tree_.corners(t))
            own.extend(p);
        bool covered = std::any_of(boxes.begin(), boxes.end(), [&](const GridBox& box) {
            GridBox both = box;
            both.extend(own);
            return both == box;
        });
        if (!covered)
            if (Status status = covers_triangle(trees, t); !status)
                return status;
    }
    return {};
}

Status CellChecker::check_visible(Reader& in, std::uint32_t unit) const {
    std::uint64_t t = in.number();
    int face = in.byte();
    bool turned = in.byte() != 0;
    exact::PairProof proof;
    proof.witness.p = get_rational_point(in);
    proof.witness.q = get_rational_point(in);
    if (!in.ok())
        return {};
    if (!is_of(t, unit) || face > 5 || (turned && !tree_.both_sides(std::uint32_t(t))))
        return {ErrorCode::mismatch, "a witness ends on something else than the object"};
    proof.answer = exact::Answer::visible;
    proof.triangle = std::uint32_t(t);
    proof.from = cell_face(cell_, face);
    proof.to = triangle_polygon(tree_, proof.triangle, turned);
    return exact::verify_proof(tree_, proof);
}

Status CellChecker::check_touch(Reader& in, std::uint32_t unit) const {
    std::uint64_t t = in.number();
    bool front = false, back = false, own = is_of(t, unit);
    if (own)
        sides(std::uint32_t(t), front, back);
    if (!own || !exact::touches(cell_, tree_.corners(std::uint32_t(t))) || !(front || back))
        return {ErrorCode::mismatch, "the object does not touch the cell as it is said to"};
    return {};
}

Kind CellChecker::check(Reader& in, std::uint32_t unit, CertificateFileResult& result, std::string& problem) {
    Status status;
    auto kind = Kind(in.byte());
    switch (kind) {
    case Kind::hidden:
        status = check_hidden(in, unit, result);
        ++result.hidden;
        break;
    case Kind::visible:
        status = check_visible(in, unit);
        ++result.visible;
        break;
    case Kind::touches:
        status = check_touch(in, unit);
        ++result.by_definition;
        break;
    case Kind::undecided:
        ++result.undecided;
        break;
    default:
        in.fail();
    }
    if (!status) {
        ++result.rejected;
        problem = status.message();
    }
    return kind;
}

} // namespace antumbra::certificates
