#include <antumbra/compare.hpp>

#include "bake/viewpoint.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"
#include "evaluate/item_buffer.hpp"
#include "evaluate/spatial_cells.hpp"

#include <antumbra/evaluate.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

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
          b_{b, spatial_cells(b), antumbra::crack_width(b)}, words_((scene.objects().size() + 63) / 64),
          counted_(words_, 0), objects_(scene.objects().size()) {
        for (std::uint32_t o = 0; o < scene.objects().size(); ++o)
            if (!scene.objects()[o].has(kAlwaysVisible))
                set_bit(counted_, o);
    }

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

    void rows_of(const Piece& piece, std::vector<std::uint64_t>& a, std::vector<std::uint64_t>& b) const;
    void check_bound(const Piece& piece, const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b);
    void add_words();
    std::vector<ComparedObject> most(int side) const;

    const Scene& scene_;
    const CompareOptions& options_;
    Side a_, b_;
    std::size_t words_;
    std::vector<std::uint64_t> counted_; ///< objects that are not always visible
    std::vector<PerObject> objects_;
    std::vector<Piece> pieces_;
    double volume_ = 0;
    CompareResult result_;
};

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

/// Bits of counted objects alone.
void Comparison::rows_of(const Piece& piece, std::vector<std::uint64_t>& a, std::vector<std::uint64_t>& b) const {
    unite_rows(a_.pvs, a_.cells[piece.a], a);
    unite_rows(b_.pvs, b_.cells[piece.b], b);
    a.resize(words_); // without volumes
    b.resize(words_);
    for (std::size_t w = 0; w < words_; ++w) {
        a[w] &= counted_[w];
        b[w] &= counted_[w];
    }
}

void Comparison::count_pairs() {
    std::vector<std::uint64_t> a, b;
    for (const Piece& piece : pieces_) {
        rows_of(piece, a, b);
        double weight = volume(piece.box) / volume_;
        std::uint64_t counts[3] = {0, 0, 0}; // a, b, both
        for (std::size_t w = 0; w < words_; ++w) {
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
        for (std::size_t w = 0; w < words_; ++w)
            for (std::uint64_t rest = k ? b[w] & ~a[w] : a[w] & ~b[w]; rest; rest &= rest - 1) {
                ++result_.contradictions;
                auto o = std::uint32_t(w * 64 + unsigned(std::countr_zero(rest)));
                if (result_.first.size() < kMostContradictions)
                    result_.first.push_back({o, a_.cells[piece.a].cell, b_.cells[piece.b].cell, k == 0, piece.box});
            }
    }
    result_.pieces_bound += bound;
}

Status Comparison::count_pixels(const Job& job) {
    if (options_.viewpoints == 0)
        return {};
    constexpr int kMostDraws = 256;
    Tracer tracer = Tracer::build(scene_, job);
    Arbiter arbiter(tracer);
    std::vector<double> sums;
    double sum = 0;
    for (const Piece& piece : pieces_)
        sums.push_back(sum += volume(piece.box));
    std::mutex mutex;
    std::uint64_t done = 0;
    parallel_for(options_.viewpoints, job, [&](std::size_t sample, unsigned) {
        Random random(options_.seed, sample, 0x636f6d70);
        Vec3d eye;
        std::size_t at = 0;
        bool free = false;
        for (int draw = 0; draw < kMostDraws && !free; ++draw) {
            auto found = std::upper_bound(sums.begin(), sums.end(), random.uniform() * sum);
            at = std::min(std::size_t(found - sums.begin()), pieces_.size() - 1);
            const Box3d& box = pieces_[at].box;
            for (int k = 0; k < 3; ++k)
                eye[k] = random.uniform(box.min[k], box.max[k]);
            eye = scene_.to_local(eye);
            free = is_viewpoint(tracer, eye);
        }
        std::vector<std::uint64_t> a, b;
        rows_of(pieces_[at], a, b);
        std::uint64_t pixels = 0, neither = 0;
        std::vector<std::pair<std::uint32_t, int>> only; // object, side: a pixel each
        for (int face = 0; face < 6 && free; ++face) {
            PixelRays rays = PixelRays::of_cube_face(eye, face, options_.face_size);
            Job alone;
            alone.threads = 1;
            ItemOptions item{PixelSampling::jittered, options_.seed, std::uint64_t(sample) * 6 + unsigned(face)};
            ItemBuffer buffer = ItemBuffer::render(tracer, rays, item, alone);
            pixels += rays.pixels();
            for (std::uint32_t y = 0; y < buffer.height(); ++y)
                for (std::uint32_t x = 0; x < buffer.width(); ++x)
                    for (std::uint32_t t : buffer.seen(x, y)) {
                        std::uint32_t o = scene_.triangle_objects()[t];
                        bool in_a = has_bit(a, o), in_b = has_bit(b, o);
                        if ((in_a && in_b) || !has_bit(counted_, o))
                            continue;
                        Ray ray = buffer.ray(x, y);
                        if (arbiter.sees(ray.origin, ray.origin + ray.direction, t) != Verdict::clear)
                            continue;
                        if (in_a || in_b)
                            only.push_back({o, in_b});
                        else
                            ++neither;
                    }
        }
        std::lock_guard lock(mutex);
        result_.viewpoints += free;
        result_.pixels += pixels;
        result_.pixels_neither += neither;
        for (auto [o, side] : only) {
            ++objects_[o].pixels[side];
            ++(side ? result_.b : result_.a).pixels_only;
        }
        if (++done; job.progress)
            job.progress({"compare", done, options_.viewpoints, "viewpoints"});
    });
    return job.cancelled() ? Status(ErrorCode::cancelled, "stopped") : Status();
}

std::vector<ComparedObject> Comparison::most(int side) const {
    std::vector<ComparedObject> list;
    for (std::uint32_t o = 0; o < objects_.size(); ++o)
        if (objects_[o].pairs[side])
            list.push_back({o, objects_[o].pairs[side], objects_[o].volume[side], objects_[o].pixels[side]});
    std::stable_sort(list.begin(), list.end(), [](const ComparedObject& x, const ComparedObject& y) {
        return x.pixels != y.pixels ? x.pixels > y.pixels : x.volume > y.volume;
    });
    if (list.size() > options_.listed)
        list.resize(options_.listed);
    return list;
}

void Comparison::add_words() {
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

} // namespace

Result<CompareResult> compare(const Scene& scene, const Pvs& a, const Pvs& b, const CompareOptions& options,
                              const Job& job) {
    if (options.face_size == 0 || options.face_size > 8192)
        return Status(ErrorCode::usage, "compare needs 1 to 8192 pixels along a face");
    if (Status status = check_belongs(scene, a); !status)
        return status.in("A");
    if (Status status = check_belongs(scene, b); !status)
        return status.in("B");
    Comparison comparison(scene, a, b, options);
    if (Status status = comparison.find_pieces(); !status)
        return status;
    comparison.count_pairs();
    if (Status status = comparison.count_pixels(job); !status)
        return status;
    return comparison.finish();
}

} // namespace antumbra
