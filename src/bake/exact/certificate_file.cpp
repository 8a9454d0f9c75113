#include "bake/exact/certificate_file.hpp"

#include "bake/exact/baked_cells.hpp"
#include "bake/exact/frame.hpp"
#include "base/bytes.hpp"
#include "base/crc32c.hpp"
#include "base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <mutex>

namespace antumbra {
namespace {

using certify::HiddenTree;
using certify::Integer;
using certify::Polygon;
using exact::GridBox;

constexpr char kMagic[8] = {'\x89', 'P', 'R', 'F', '\r', '\n', '\x1a', '\n'};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeader = 56, kBlockHeader = 24;
constexpr std::size_t kLargestInteger = 1 << 16; ///< bytes

enum class Kind : std::uint8_t { hidden = 0, visible = 1, touches = 2, undecided = 3 };

/// Seven bits a byte, lowest first, up to 64 bits.
void put_number(ByteWriter& out, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7)
        out.u8(std::uint8_t(value | 0x80));
    out.u8(std::uint8_t(value));
}
void put_signed(ByteWriter& out, std::int64_t value) {
    put_number(out, std::uint64_t(value) << 1 ^ std::uint64_t(value >> 63));
}
void put_integer(ByteWriter& out, const Integer& value) {
    std::vector<unsigned char> bytes;
    Integer magnitude = abs(value);
    if (magnitude != 0)
        export_bits(magnitude, std::back_inserter(bytes), 8, false);
    put_number(out, std::uint64_t(bytes.size()) << 1 | std::uint64_t(value < 0));
    for (unsigned char byte : bytes)
        out.u8(byte);
}
void put_point(ByteWriter& out, const GridPoint& p) {
    for (int k = 0; k < 3; ++k)
        put_signed(out, p[k]);
}

/// Reads numbers; ok() turns false, for good, once the bytes end or make no sense.
class Reader {
  public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    bool ok() const { return ok_; }
    bool at_end() const { return ok_ && at_ == bytes_.size(); }

    std::uint8_t byte() {
        if (at_ >= bytes_.size())
            ok_ = false;
        return ok_ ? std::to_integer<std::uint8_t>(bytes_[at_++]) : std::uint8_t(0);
    }
    std::uint64_t number() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 64 && ok_; shift += 7) {
            std::uint8_t b = byte();
            value |= std::uint64_t(b & 0x7F) << shift;
            if (b < 0x80)
                return value;
        }
        ok_ = false;
        return 0;
    }
    /// Of things that take at least a byte each.
    std::size_t count() {
        std::uint64_t n = number();
        if (n > bytes_.size() - std::min(at_, bytes_.size()))
            ok_ = false;
        return ok_ ? std::size_t(n) : 0;
    }
    std::int64_t signed_number() {
        std::uint64_t n = number();
        return std::int64_t(n >> 1) ^ -std::int64_t(n & 1);
    }
    Integer integer() {
        std::uint64_t head = number();
        std::size_t size = std::size_t(head >> 1);
        Integer value = 0;
        if (size > kLargestInteger || size > bytes_.size() - std::min(at_, bytes_.size()))
            ok_ = false;
        if (!ok_ || size == 0)
            return value;
        auto first = reinterpret_cast<const unsigned char*>(bytes_.data() + at_);
        import_bits(value, first, first + size, 8, false);
        at_ += size;
        return head & 1 ? Integer(-value) : value;
    }
    GridPoint point() {
        GridPoint p;
        for (int k = 0; k < 3; ++k) {
            p[k] = signed_number();
            if (p[k] < -(1 << 25) || p[k] > 1 << 25)
                ok_ = false;
        }
        return p;
    }
    void fail() { ok_ = false; }

  private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
    bool ok_ = true;
};

void put_rational_point(ByteWriter& out, const Vec3<certify::Rational>& p) {
    for (int k = 0; k < 3; ++k) {
        put_integer(out, numerator(p[k]));
        put_integer(out, denominator(p[k]));
    }
}

Vec3<certify::Rational> get_rational_point(Reader& in) {
    Vec3<certify::Rational> p;
    for (int k = 0; k < 3; ++k) {
        Integer above = in.integer(), below = in.integer();
        if (below <= 0)
            in.fail();
        p[k] = in.ok() ? certify::Rational(above, below) : certify::Rational(0);
    }
    return p;
}

void put_tree(ByteWriter& out, const HiddenTree& tree) {
    put_number(out, tree.nodes.size());
    for (const HiddenTree::Node& node : tree.nodes) {
        out.u8(std::uint8_t(node.kind));
        if (node.kind == HiddenTree::Kind::split) {
            for (const Integer& coordinate : node.hyperplane)
                put_integer(out, coordinate);
            put_signed(out, node.child[0]);
            put_signed(out, node.child[1]);
        } else if (node.kind == HiddenTree::Kind::blocked) {
            put_number(out, node.occluder);
            out.u8(std::uint8_t(node.crossing + 1));
        }
    }
}

HiddenTree get_tree(Reader& in, std::size_t blockers) {
    HiddenTree tree;
    std::size_t nodes = in.count();
    for (std::size_t n = 0; n < nodes && in.ok(); ++n) {
        HiddenTree::Node node;
        std::uint8_t kind = in.byte();
        if (kind > std::uint8_t(HiddenTree::Kind::blocked))
            in.fail();
        node.kind = HiddenTree::Kind(kind);
        if (node.kind == HiddenTree::Kind::split) {
            for (Integer& coordinate : node.hyperplane)
                coordinate = in.integer();
            for (std::int32_t& child : node.child) {
                std::int64_t index = in.signed_number();
                if (index < 0 || std::uint64_t(index) >= nodes)
                    in.fail();
                child = std::int32_t(index);
            }
        } else if (node.kind == HiddenTree::Kind::blocked) {
            std::uint64_t occluder = in.number();
            if (occluder >= blockers)
                in.fail();
            node.occluder = std::uint32_t(occluder);
            node.crossing = std::int8_t(in.byte() - 1);
        }
        tree.nodes.push_back(std::move(node));
    }
    return tree;
}

Polygon cell_face(const GridBox& cell, int face) {
    auto corners = exact::face_of(cell, face / 2, face % 2);
    return {{corners.begin(), corners.end()}, true};
}

Polygon triangle_polygon(const exact::SceneTree& tree, std::uint32_t t, bool turned) {
    const auto& c = tree.corners(t);
    return {turned ? std::vector<GridPoint>{c[0], c[2], c[1]} : std::vector<GridPoint>{c[0], c[1], c[2]},
            tree.both_sides(t)};
}

void put_proof(ByteWriter& out, const exact::SceneTree& tree, const GridBox& cell, const exact::PairProof& proof) {
    auto face_number = [&](const Polygon& from) {
        for (int face = 0; face < 6; ++face)
            if (cell_face(cell, face).corners == from.corners)
                return face;
        return 6;
    };
    if (proof.answer == exact::Answer::undecided) {
        out.u8(std::uint8_t(Kind::undecided));
    } else if (proof.answer == exact::Answer::visible && proof.by_definition) {
        out.u8(std::uint8_t(Kind::touches));
        put_number(out, proof.triangle);
    } else if (proof.answer == exact::Answer::visible) {
        out.u8(std::uint8_t(Kind::visible));
        put_number(out, proof.triangle);
        out.u8(std::uint8_t(face_number(proof.from)));
        out.u8(proof.to.corners != triangle_polygon(tree, proof.triangle, false).corners);
        put_rational_point(out, proof.witness.p);
        put_rational_point(out, proof.witness.q);
    } else {
        out.u8(std::uint8_t(Kind::hidden));
        put_number(out, proof.boxes.size());
        for (const GridBox& box : proof.boxes) {
            put_point(out, box.min);
            put_point(out, box.max);
        }
        put_number(out, proof.parts.size());
        for (const exact::HiddenPart& part : proof.parts) {
            out.u8(std::uint8_t(face_number(part.from)));
            out.u8(std::uint8_t(part.part.corners.size()));
            for (const GridPoint& corner : part.part.corners)
                put_point(out, corner);
            put_number(out, part.blockers.size());
            for (std::uint32_t blocker : part.blockers)
                put_number(out, blocker);
            put_tree(out, part.tree);
        }
    }
}

/// Header of the file: magic, version, reserved, scene fingerprint, length and CRC of the .pvs, CRC of what stands before,
/// number of blocks.
void put_header(ByteWriter& out, const Scene& scene, std::span<const std::byte> pvs_bytes, std::uint64_t blocks) {
    for (char c : kMagic)
        out.u8(std::uint8_t(c));
    out.u32(kVersion);
    out.u32(0);
    for (std::uint8_t byte : scene.fingerprint())
        out.u8(byte);
    out.u64(pvs_bytes.size());
    out.u32(crc32c(pvs_bytes));
    out.u32(std::uint32_t(blocks));
    out.u32(0);
    out.u32(crc32c(std::span<const std::byte>(out.bytes)));
}

GridBox grid_cell(const exact::SceneTree& tree, const exact::BakedCell& cell) {
    return {tree.to_grid(tree.scene().to_local(cell.box.min)), tree.to_grid(tree.scene().to_local(cell.box.max))};
}

Status check_belongs(const Scene& scene, const Pvs& pvs) {
    if (pvs.scene_fingerprint() != scene.fingerprint() || pvs.object_count() != scene.objects().size())
        return {ErrorCode::mismatch, "the file was baked from another scene, or from this one read otherwise"};
    return {};
}

/// Checks the certificates of one cell. Knows the scene's triangles and the rules of what makes an object hidden, not the
/// solver.
class CellChecker {
  public:
    CellChecker(const exact::SceneTree& tree, const GridBox& cell) : tree_(tree), cell_(cell) {}

    /// Which answer the next certificate proves; `problem` says what is wrong with it.
    Kind check(Reader& in, std::uint32_t unit, CertificateFileResult& result, std::string& problem);

  private:
    using Key = std::pair<int, std::vector<std::array<std::int64_t, 3>>>;
    struct Tree {
        std::vector<std::uint32_t> blockers;
        HiddenTree tree;
    };

    static Key key_of(int face, const std::vector<GridPoint>& corners) {
        Key key{face, {}};
        for (const GridPoint& p : corners)
            key.second.push_back({p.x, p.y, p.z});
        return key;
    }
    bool looks(int face, const GridBox& box) const {
        return face % 2 ? box.max[face / 2] > cell_.max[face / 2] : box.min[face / 2] < cell_.min[face / 2];
    }
    Status hides(const std::map<Key, Tree>& trees, int face, const Polygon& part) const;
    Status covers_box(const std::map<Key, Tree>& trees, const GridBox& box) const;
    Status covers_triangle(const std::map<Key, Tree>& trees, std::uint32_t t) const;
    void sides(std::uint32_t t, bool& front, bool& back) const;
    /// The triangles of a unit: from the first to before the last.
    std::pair<std::uint32_t, std::uint32_t> triangles(std::uint32_t unit) const {
        return {tree_.units().first[unit], tree_.units().first[unit + 1]};
    }
    Status check_hidden(Reader& in, std::uint32_t unit, CertificateFileResult& result) const;
    Status check_visible(Reader& in, std::uint32_t unit) const;
    Status check_touch(Reader& in, std::uint32_t unit) const;

    const exact::SceneTree& tree_;
    GridBox cell_;
};

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
    auto [first, last] = triangles(unit);
    for (std::uint32_t t = first; t < last; ++t) {
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
    auto [first, last] = triangles(unit);
    if (t < first || t >= last || face > 5 ||
        (turned && !tree_.both_sides(std::uint32_t(t))))
        return {ErrorCode::mismatch, "a witness ends on something else than the object"};
    proof.answer = exact::Answer::visible;
    proof.triangle = std::uint32_t(t);
    proof.from = cell_face(cell_, face);
    proof.to = triangle_polygon(tree_, proof.triangle, turned);
    return exact::verify_proof(tree_, proof);
}

Status CellChecker::check_touch(Reader& in, std::uint32_t unit) const {
    std::uint64_t t = in.number();
    auto [first, last] = triangles(unit);
    bool front = false, back = false, own = t >= first && t < last;
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

void add(CertificateFileResult& total, const CertificateFileResult& one) {
    total.pairs += one.pairs;
    total.visible += one.visible;
    total.by_definition += one.by_definition;
    total.hidden += one.hidden;
    total.undecided += one.undecided;
    total.trees += one.trees;
    total.nodes += one.nodes;
    total.rejected += one.rejected;
    total.disagree += one.disagree;
}

} // namespace

Result<std::vector<std::byte>> make_certificates(const Scene& scene, const Pvs& pvs, std::span<const std::byte> pvs_bytes,
                                                 CertificateFileResult& result, const Job& job) {
    if (Status status = check_belongs(scene, pvs); !status)
        return status;
    Result<std::vector<exact::BakedCell>> found = exact::baked_cells(pvs);
    if (!found)
        return found.status();
    const std::vector<exact::BakedCell>& cells = *found;
    exact::SceneTree tree = exact::SceneTree::build(scene, exact::units_of(scene, pvs));
    std::vector<std::vector<std::byte>> blocks(cells.size());
    std::mutex mutex;
    std::uint64_t done = 0;
    parallel_for(cells.size(), job, [&](std::size_t index, unsigned) {
        GridBox cell = grid_cell(tree, cells[index]);
        exact::ProofLimits limits;
        limits.cancelled = [&] { return job.cancelled(); };
        exact::Prover prover(tree, limits);
        ByteWriter out;
        CertificateFileResult counted;
        for (std::uint32_t unit = 0; unit < tree.units().count(); ++unit) {
            if (exact::is_always_visible(scene, pvs, tree.units(), unit))
                continue;
            exact::PairProof proof = prover.prove(cell, unit);
            put_proof(out, tree, cell, proof);
            ++counted.pairs;
            counted.undecided += proof.answer == exact::Answer::undecided;
            counted.hidden += proof.answer == exact::Answer::hidden;
            counted.visible += proof.answer == exact::Answer::visible && !proof.by_definition;
            counted.by_definition += proof.by_definition;
            for (const exact::HiddenPart& part : proof.parts) {
                ++counted.trees;
                counted.nodes += part.tree.nodes.size();
            }
        }
        blocks[index] = std::move(out.bytes);
        std::lock_guard lock(mutex);
        add(result, counted);
        if (++done; job.progress)
            job.progress({"prove", done, cells.size(), "cells"});
    });
    if (job.cancelled())
        return Status(ErrorCode::cancelled, "stopped");
    ByteWriter file;
    put_header(file, scene, pvs_bytes, cells.size());
    for (std::size_t index = 0; index < cells.size(); ++index) {
        file.u64(cells[index].number);
        file.u64(blocks[index].size());
        file.u32(crc32c(std::span<const std::byte>(blocks[index])));
        file.u32(crc32c(std::span<const std::byte>(file.bytes).last(kBlockHeader - 4)));
        file.bytes.insert(file.bytes.end(), blocks[index].begin(), blocks[index].end());
    }
    result.cells = cells.size();
    result.bytes = file.bytes.size();
    return std::move(file.bytes);
}

Result<CertificateFileResult> check_certificate_file(const Scene& scene, const Pvs& pvs,
                                                     std::span<const std::byte> pvs_bytes,
                                                     std::span<const std::byte> bytes, const Job& job) {
    if (Status status = check_belongs(scene, pvs); !status)
        return status;
    Status damaged(ErrorCode::corrupt, "is damaged or no file of certificates; write it again with bake --certificates");
    if (bytes.size() < kHeader || std::memcmp(bytes.data(), kMagic, 8) != 0 ||
        crc32c(bytes.first(kHeader - 4)) != load_u32(bytes, kHeader - 4))
        return damaged;
    if (load_u32(bytes, 8) != kVersion)
        return Status(ErrorCode::unsupported, "is of another version of the certificate format");
    if (std::memcmp(bytes.data() + 16, scene.fingerprint().data(), 16) != 0 || load_u64(bytes, 32) != pvs_bytes.size() ||
        load_u32(bytes, 40) != crc32c(pvs_bytes))
        return Status(ErrorCode::mismatch, "belongs to another .pvs file; write it again with bake --certificates");
    Result<std::vector<exact::BakedCell>> found = exact::baked_cells(pvs);
    if (!found)
        return found.status();
    const std::vector<exact::BakedCell>& cells = *found;
    if (load_u32(bytes, 44) != std::uint32_t(cells.size()))
        return damaged;
    std::vector<std::span<const std::byte>> blocks;
    std::size_t at = kHeader;
    for (const exact::BakedCell& cell : cells) {
        if (bytes.size() - at < kBlockHeader || crc32c(bytes.subspan(at, 20)) != load_u32(bytes, at + 20) ||
            load_u64(bytes, at) != cell.number || load_u64(bytes, at + 8) > bytes.size() - at - kBlockHeader)
            return damaged;
        auto size = std::size_t(load_u64(bytes, at + 8));
        blocks.push_back(bytes.subspan(at + kBlockHeader, size));
        if (crc32c(blocks.back()) != load_u32(bytes, at + 16))
            return damaged;
        at += kBlockHeader + size;
    }
    if (at != bytes.size())
        return damaged;

    exact::SceneTree tree = exact::SceneTree::build(scene, exact::units_of(scene, pvs));
    CertificateFileResult result;
    std::vector<std::string> problems(cells.size());
    std::atomic<bool> broken{false};
    std::mutex mutex;
    std::uint64_t done = 0;
    parallel_for(cells.size(), job, [&](std::size_t index, unsigned) {
        CellChecker checker(tree, grid_cell(tree, cells[index]));
        Reader in(blocks[index]);
        CertificateFileResult counted;
        std::vector<std::uint64_t> row(pvs.words_per_row());
        pvs.decode_row(cells[index].row, row);
        std::vector<bool> seen(pvs.object_count(), false); // by what the certificates say of clusters
        for (std::uint32_t unit = 0; unit < tree.units().count() && in.ok() && !job.cancelled(); ++unit) {
            if (exact::is_always_visible(scene, pvs, tree.units(), unit))
                continue;
            std::string problem;
            Kind kind = checker.check(in, unit, counted, problem);
            ++counted.pairs;
            std::size_t bit = exact::bit_of(pvs, unit);
            bool listed = row[bit / 64] >> (bit % 64) & 1, says = kind != Kind::hidden;
            if (pvs.cluster_count() > 0 && says)
                seen[scene.triangle_objects()[tree.units().first[unit]]] = true;
            if (listed != says) {
                ++counted.disagree;
                problem = listed ? "listed, but its certificate says hidden" : "not listed, but its certificate says visible";
            }
            if (!problem.empty() && problems[index].empty())
                problems[index] = "cell " + std::to_string(cells[index].number) + ", " + exact::name_of_unit(pvs, unit) + ": " + problem;
        }
        for (std::uint32_t o = 0; o < pvs.object_count() && pvs.cluster_count() > 0; ++o)
            if (!(pvs.object(o).flags & kAlwaysVisible) && (row[o / 64] >> (o % 64) & 1) != seen[o]) {
                ++counted.disagree;
                if (problems[index].empty())
                    problems[index] = "cell " + std::to_string(cells[index].number) + ", object " + std::to_string(o) +
                                      ": listed otherwise than its clusters";
            }
        if (!in.at_end() && !job.cancelled())
            broken = true;
        std::lock_guard lock(mutex);
        add(result, counted);
        if (++done; job.progress)
            job.progress({"certify", done, cells.size(), "cells"});
    });
    if (job.cancelled())
        return Status(ErrorCode::cancelled, "stopped");
    if (broken)
        return damaged;
    result.cells = cells.size();
    result.bytes = bytes.size();
    for (const std::string& problem : problems)
        if (result.first_problem.empty())
            result.first_problem = problem;
    return result;
}

} // namespace antumbra
