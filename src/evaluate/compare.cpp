#include <antumbra/compare.hpp>

#include "bake/viewpoint.hpp"
#include "base/collect.hpp"
#include "base/random.hpp"
#include "evaluate/compared_units.hpp"
#include "evaluate/item_buffer.hpp"
#include "evaluate/spatial_cells.hpp"

#include <antumbra/evaluate.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace antumbra {
namespace {

constexpr std::size_t kMostContradictions = 10;

/// Slivers that only rounding makes are no pieces.
bool is_sliver(const Box3d& piece, const Box3d& a, const Box3d& b) {
    for (int k = 0; k < 3; ++k)
        if (piece.size()[k] < 1e-9 * std::min(a.size()[k], b.size()[k]))
            return true;
    return false;
}

struct Piece {
    std::size_t a = 0, b = 0; ///< indices of spatial cells
    Box3d box;
};

struct Side {
    const Pvs& pvs;
    std::vector<SpatialCell> cells;
    double crack_width = 0;
    bool lists_only_visible() const {
        return pvs.guarantee() == Guarantee::exact || pvs.guarantee() == Guarantee::aggressive;
    }
    bool lists_all_visible() const { return !may_lose_pixels(pvs.guarantee()); }
};

/// Does `outer` hold `inner`? Corners of baked grids are whole steps of the scene, which rounding hides.
bool holds(const Box3d& outer, const Box3d& inner, double tolerance) {
    for (int k = 0; k < 3; ++k)
        if (inner.min[k] < outer.min[k] - tolerance || inner.max[k] > outer.max[k] + tolerance)
            return false;
    return true;
}

class Comparison {
  public:
    Comparison(const Scene& scene, const Pvs& a, const Pvs& b, const CompareOptions& options)
        : scene_(scene), options_(options), a_{a, spatial_cells(a), antumbra::crack_width(a)},
          b_{b, spatial_cells(b), antumbra::crack_width(b)} {}

    Status find_units();

    Status find_pieces();
    void count_pairs();
    Status count_pixels(const Job& job);
    CompareResult finish();

  private:
    struct PerObject {
        std::uint64_t pairs[2] = {0, 0}, pixels[2] = {0, 0};
        double volume[2] = {0, 0};
        bool listed[2] = {false, false};
    };

    /// What one viewpoint tells.
    struct SeenPixels {
        bool free = false;
        std::uint64_t pixels = 0, neither = 0;
        std::vector<std::pair<std::uint32_t, int>> only; ///< unit, side: a pixel each
    };
    void look_from(const Tracer& tracer, const Vec3d& eye, const Piece& piece, std::size_t sample, SeenPixels& seen) const;
    void rows_of(const Piece& piece, std::vector<std::uint64_t>& a, std::vector<std::uint64_t>& b) const;
    void check_bound(const Piece& piece, const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b);
    void add_words();
    void add_words_on_units();
    std::vector<ComparedObject> most(int side) const;

    const Scene& scene_;
    const CompareOptions& options_;
    Side a_, b_;
    ComparedUnits units_;
    std::vector<PerObject> objects_; ///< per unit
    std::vector<Piece> pieces_;
    double volume_ = 0;
    CompareResult result_;
};

Status Comparison::find_units() {
    Result<ComparedUnits> units = ComparedUnits::make(scene_, a_.pvs, b_.pvs);
    if (!units)
        return units.status();
    units_ = std::move(*units);
    objects_.resize(units_.count());
    result_.units = units_.kind();
    result_.unit_count = units_.count();
    result_.a.clusters = a_.pvs.cluster_count();
    result_.b.clusters = b_.pvs.cluster_count();
    return {};
}

Status Comparison::find_pieces() {
    for_each_common_piece(a_.cells, b_.cells, [&](std::size_t i, std::size_t j, const Box3d& box) {
        if (!is_sliver(box, a_.cells[i].box, b_.cells[j].box)) {
            pieces_.push_back({i, j, box});
            volume_ += volume(box);
        }
    });
    if (pieces_.empty())
        return {ErrorCode::usage, "the two files have no baked space in common: nothing to compare"};
    result_.pieces = pieces_.size();
    const CellGrid &g = a_.pvs.grid(), &h = b_.pvs.grid();
    result_.same_cells = a_.pvs.tree().nodes.empty() && b_.pvs.tree().nodes.empty() && g.count == h.count &&
                         g.bounds == h.bounds;
    auto whole = [](const Side& side) {
        double sum = 0;
        for (const SpatialCell& cell : side.cells)
            sum += volume(cell.box);
        return sum;
    };
    result_.common_of_a = volume_ / whole(a_);
    result_.common_of_b = volume_ / whole(b_);
    result_.a.cells = a_.cells.size();
    result_.b.cells = b_.cells.size();
    return {};
}

void Comparison::rows_of(const Piece& piece, std::vector<std::uint64_t>& a, std::vector<std::uint64_t>& b) const {
    unite_rows(a_.pvs, a_.cells[piece.a], a);
    unite_rows(b_.pvs, b_.cells[piece.b], b);
    a = units_.listed(0, a);
    b = units_.listed(1, b);
}

void Comparison::count_pairs() {
    std::vector<std::uint64_t> a, b;
    for (const Piece& piece : pieces_) {
        double weight = volume(piece.box) / volume_;
        unite_rows(a_.pvs, a_.cells[piece.a], a);
        unite_rows(b_.pvs, b_.cells[piece.b], b);
        result_.a.mean_triangles += weight * double(units_.triangles(0, a));
        result_.b.mean_triangles += weight * double(units_.triangles(1, b));
        rows_of(piece, a, b);
        std::uint64_t counts[3] = {0, 0, 0}; // a, b, both
        for (std::size_t w = 0; w < a.size(); ++w) {
            counts[0] += unsigned(std::popcount(a[w]));
            counts[1] += unsigned(std::popcount(b[w]));
            counts[2] += unsigned(std::popcount(a[w] & b[w]));
            for (std::uint64_t rest = a[w] | b[w]; rest; rest &= rest - 1) {
                auto o = std::uint32_t(w * 64 + unsigned(std::countr_zero(rest)));
                bool in_a = has_bit(a, o), in_b = has_bit(b, o);
                objects_[o].listed[0] |= in_a;
                objects_[o].listed[1] |= in_b;
                if (in_a != in_b) {
                    ++objects_[o].pairs[in_b];
                    objects_[o].volume[in_b] += weight;
                }
            }
        }
        ComparedFile* files[2] = {&result_.a, &result_.b};
        for (int k = 0; k < 2; ++k) {
            files[k]->pairs += counts[k];
            files[k]->pairs_only += counts[k] - counts[2];
            files[k]->mean_objects += weight * double(counts[k]);
            files[k]->mean_only += weight * double(counts[k] - counts[2]);
        }
        result_.pairs_both += counts[2];
        check_bound(piece, a, b);
    }
    for (const PerObject& object : objects_)
        for (int k = 0; k < 2; ++k) {
            ComparedFile& file = k ? result_.b : result_.a;
            file.objects += object.listed[k];
            file.objects_only += object.listed[k] && !object.listed[1 - k];
        }
}

/// The one that lists only what is visible, from a cell within that of the one that lists all of it, must be a subset.
void Comparison::check_bound(const Piece& piece, const std::vector<std::uint64_t>& a,
                             const std::vector<std::uint64_t>& b) {
    if (a_.crack_width != b_.crack_width)
        return;
    bool bound = false;
    for (int k = 0; k < 2; ++k) {
        const Side &less = k ? b_ : a_, &more = k ? a_ : b_;
        const SpatialCell &from = k ? b_.cells[piece.b] : a_.cells[piece.a],
                          &in = k ? a_.cells[piece.a] : b_.cells[piece.b];
        bool grids = less.pvs.tree().nodes.empty() && more.pvs.tree().nodes.empty();
        if (!less.lists_only_visible() || !more.lists_all_visible() ||
            !holds(in.inner, from.outer, grids ? 1e-6 * scene_.step() : 0))
            continue;
        bound = true;
        for (std::size_t w = 0; w < a.size(); ++w)
            for (std::uint64_t rest = k ? b[w] & ~a[w] : a[w] & ~b[w]; rest; rest &= rest - 1) {
                ++result_.contradictions;
                auto o = std::uint32_t(w * 64 + unsigned(std::countr_zero(rest)));
                if (result_.first.size() < kMostContradictions)
                    result_.first.push_back({units_.object(o), o, a_.cells[piece.a].cell, b_.cells[piece.b].cell, k == 0, piece.box});
            }
    }
    result_.pieces_bound += bound;
}

Status Comparison::count_pixels(const Job& job) {
    if (options_.viewpoints == 0)
        return {};
    constexpr int kMostDraws = 256;
    Tracer tracer = Tracer::build(scene_, job);
    std::vector<double> sums;
    double sum = 0;
    for (const Piece& piece : pieces_)
        sums.push_back(sum += volume(piece.box));
    auto look = [&](std::size_t sample, unsigned) {
        SeenPixels seen;
        Random random(options_.seed, sample, 0x636f6d70);
        Vec3d eye;
        std::size_t at = 0;
        for (int draw = 0; draw < kMostDraws && !seen.free; ++draw) {
            auto found = std::upper_bound(sums.begin(), sums.end(), random.uniform() * sum);
            at = std::min(std::size_t(found - sums.begin()), pieces_.size() - 1);
            const Box3d& box = pieces_[at].box;
            for (int k = 0; k < 3; ++k)
                eye[k] = random.uniform(box.min[k], box.max[k]);
            eye = scene_.to_local(eye);
            seen.free = is_viewpoint(tracer, eye);
        }
        if (seen.free)
            look_from(tracer, eye, pieces_[at], sample, seen);
        return seen;
    };
    auto take = [&](std::size_t, const SeenPixels& seen) {
        result_.viewpoints += seen.free;
        result_.pixels += seen.pixels;
        result_.pixels_neither += seen.neither;
        for (auto [unit, side] : seen.only) {
            ++objects_[unit].pixels[side];
            ++(side ? result_.b : result_.a).pixels_only;
        }
    };
    return collect(options_.viewpoints, job, "compare", "viewpoints", look, take);
}

/// Every pixel around an eye in a piece.
void Comparison::look_from(const Tracer& tracer, const Vec3d& eye, const Piece& piece, std::size_t sample,
                           SeenPixels& seen) const {
    Arbiter arbiter(tracer);
    std::vector<std::uint64_t> a, b;
    rows_of(piece, a, b);
    for (int face = 0; face < 6; ++face) {
        PixelRays rays = PixelRays::of_cube_face(eye, face, options_.face_size);
        Job alone;
        alone.threads = 1;
        ItemOptions item{PixelSampling::jittered, options_.seed, std::uint64_t(sample) * 6 + unsigned(face)};
        ItemBuffer buffer = ItemBuffer::render(tracer, rays, item, alone);
        seen.pixels += rays.pixels();
        for (std::uint32_t y = 0; y < buffer.height(); ++y)
            for (std::uint32_t x = 0; x < buffer.width(); ++x)
                for (std::uint32_t t : buffer.seen(x, y)) {
                    std::uint32_t unit = units_.of(t);
                    bool in_a = has_bit(a, unit), in_b = has_bit(b, unit);
                    if ((in_a && in_b) || !units_.is_counted(unit))
                        continue;
                    Ray ray = buffer.ray(x, y);
                    if (arbiter.sees(ray.origin, ray.origin + ray.direction, t) != Verdict::clear)
                        continue;
                    if (in_a || in_b)
                        seen.only.push_back({unit, in_b});
                    else
                        ++seen.neither;
                }
    }
}

std::vector<ComparedObject> Comparison::most(int side) const {
    std::vector<ComparedObject> list;
    for (std::uint32_t o = 0; o < objects_.size(); ++o)
        if (objects_[o].pairs[side])
            list.push_back({units_.object(o), o, objects_[o].pairs[side], objects_[o].volume[side], objects_[o].pixels[side]});
    std::stable_sort(list.begin(), list.end(), [](const ComparedObject& x, const ComparedObject& y) {
        return x.pixels != y.pixels ? x.pixels > y.pixels : x.volume > y.volume;
    });
    if (list.size() > options_.listed)
        list.resize(options_.listed);
    return list;
}

/// What the units are, if they are not those of both files.
void Comparison::add_words_on_units() {
    auto name = [](const Pvs& pvs) {
        return pvs.cluster_count() ? std::to_string(pvs.cluster_count()) + " clusters" : std::string("objects alone");
    };
    if (a_.crack_width != b_.crack_width) {
        const Side &closed = a_.crack_width > b_.crack_width ? a_ : b_, &open = &closed == &a_ ? b_ : a_;
        char text[320];
        std::snprintf(text, sizeof text,
                      "%s is of the scene with cracks closed up to %g, %s up to %g: objects are compared. What only %s lists "
                      "is seen through cracks of up to %g, or where corners were moved by as much.",
                      &closed == &a_ ? "A" : "B", closed.crack_width, &closed == &a_ ? "B" : "A", open.crack_width,
                      &closed == &a_ ? "B" : "A", closed.crack_width);
        result_.words.push_back(text);
    } else if (result_.units == CompareUnits::groups) {
        result_.words.push_back("A lists " + name(a_.pvs) + ", B " + name(b_.pvs) + "; compared as " +
                                std::to_string(result_.unit_count) +
                                " groups of triangles, the finest parts that clusters of both make up.");
    } else if ((a_.pvs.cluster_count() > 0) != (b_.pvs.cluster_count() > 0)) {
        result_.words.push_back("A lists " + name(a_.pvs) + ", B " + name(b_.pvs) + ": objects are compared.");
    }
}

void Comparison::add_words() {
    add_words_on_units();
    bool any = false;
    for (int k = 0; k < 2; ++k) {
        const Side &less = k ? b_ : a_, &more = k ? a_ : b_;
        if (!less.lists_only_visible() || !more.lists_all_visible())
            continue;
        any = true;
        const std::string x = k ? "B" : "A", y = k ? "A" : "B";
        if (a_.crack_width != b_.crack_width) {
            result_.words.push_back(x + " lists only what is visible and " + y + " all that is, but of scenes with "
                                    "different crack widths: neither set must hold the other.");
            continue;
        }
        std::uint64_t only = k ? result_.b.pairs_only : result_.a.pairs_only;
        std::string text = x + " (" + to_string(less.pvs.guarantee()) + ") lists only what is visible, " + y + " (" +
                           to_string(more.pvs.guarantee()) + ") all that is: what " + x + " lists, " + y +
                           " must list wherever the cell of " + x + " lies within that of " + y + ".";
        if (only > 0 && result_.contradictions == 0)
            text += " The " + std::to_string(only) + " pairs of " + x + " alone lie elsewhere.";
        result_.words.push_back(std::move(text));
    }
    if (!any)
        result_.words.push_back(std::string("A is ") + to_string(a_.pvs.guarantee()) + ", B is " +
                                to_string(b_.pvs.guarantee()) + ": neither set must hold the other.");
    else if (result_.pieces_bound == 0 && a_.crack_width == b_.crack_width)
        result_.words.push_back("No cell of the one lies within a cell of the other, so nothing follows here.");
    auto missed = [&](const Side& sampled, const Side& other, const std::string& x, const ComparedFile& more) {
        if (sampled.pvs.guarantee() == Guarantee::aggressive && other.pvs.guarantee() == Guarantee::exact &&
            result_.same_cells)
            result_.words.push_back(x + " missed " + std::to_string(more.pairs_only) +
                                    " pairs that are visible: false invisible, as its guarantee allows.");
        if (sampled.pvs.guarantee() == Guarantee::conservative && other.pvs.guarantee() == Guarantee::exact &&
            result_.same_cells)
            result_.words.push_back(x + " adds " + std::to_string((&more == &result_.b ? result_.a : result_.b).pairs_only) +
                                    " pairs that are hidden: false visible, as its guarantee allows.");
    };
    missed(a_, b_, "A", result_.b);
    missed(b_, a_, "B", result_.a);
}

CompareResult Comparison::finish() {
    result_.only_a = most(0);
    result_.only_b = most(1);
    add_words();
    return std::move(result_);
}

/// One file must be of the scene as it was read; the other may be of the same one with another crack width.
Status check_both(const Scene& scene, const Pvs& a, const Pvs& b) {
    bool own_a = crack_width(a) == scene.crack_width(), own_b = crack_width(b) == scene.crack_width();
    for (int k = 0; k < 2; ++k) {
        const Pvs& pvs = k ? b : a;
        const char* name = k ? "B" : "A";
        bool own = k ? own_b : own_a, other_is_own = k ? own_a : own_b;
        if (own || !other_is_own) {
            if (Status status = check_belongs(scene, pvs); !status)
                return status.in(name);
        } else if (pvs.structure_fingerprint() != scene.structure_fingerprint() ||
                   pvs.object_count() != scene.objects().size()) {
            return Status(ErrorCode::mismatch, "was baked from another scene; bake this one again").in(name);
        }
    }
    return {};
}

} // namespace

Result<CompareResult> compare(const Scene& scene, const Pvs& a, const Pvs& b, const CompareOptions& options,
                              const Job& job) {
    if (options.face_size == 0 || options.face_size > 8192)
        return Status(ErrorCode::usage, "compare needs 1 to 8192 pixels along a face");
    if (Status status = check_both(scene, a, b); !status)
        return status;
    Comparison comparison(scene, a, b, options);
    if (Status status = comparison.find_units(); !status)
        return status;
    if (Status status = comparison.find_pieces(); !status)
        return status;
    comparison.count_pairs();
    if (Status status = comparison.count_pixels(job); !status)
        return status;
    return comparison.finish();
}

} // namespace antumbra
