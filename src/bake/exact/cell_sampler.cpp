#include "bake/exact/cell_sampler.hpp"

#include <algorithm>
#include <cmath>

namespace antumbra::exact {
namespace {

Vec3d to_vector(const GridPoint& p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

/// How far past an edge a ray is aimed, as a share of the triangle's size.
constexpr double kPastEdge[2] = {0.05, 0.6};

/// Of the rays that look around, one in so many marks the boxes that it reaches.
constexpr std::uint32_t kMarkEvery = 4;

/// Exploring goes on in batches of so many rays, while so many find a unit: about what one exact query costs.
constexpr std::uint64_t kBatch = 32768, kRaysWorthAUnit = 700;

Vec3d unit_direction(Random& random) {
    for (;;) {
        Vec3d v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        double square = dot(v, v);
        if (square > 1e-4 && square <= 1)
            return v;
    }
}

} // namespace

CellSampler::CellSampler(const SceneTree& tree, const Tracer& tracer, SeenUnits& seen)
    : tree_(tree), tracer_(tracer), scene_(tree.scene()), arbiter_(tracer), seen_(seen),
      reached_(tree.nodes().size(), 0), eye_(tree.nodes().size()) {}

void CellSampler::begin(const GridBox& cell, std::uint64_t seed, SamplerCounters& counters) {
    cell_ = {tree_.to_local(to_vector(cell.min)), tree_.to_local(to_vector(cell.max))};
    random_ = Random(seed, 0x7261797356697369u);
    counters_ = &counters;
    for (std::uint32_t n : touched_)
        reached_[n] = 0;
    touched_.clear();
    leads_.clear();
    found_.clear();
    next_lead_ = 0;
}

Vec3d CellSampler::random_eye() {
    Vec3d eye;
    for (int k = 0; k < 3; ++k)
        eye[k] = std::clamp(random_.uniform(cell_.min[k], cell_.max[k]), cell_.min[k], cell_.max[k]);
    return eye;
}

/// Where the ray ends (in lengths of `direction`).
double CellSampler::cast(const Vec3d& eye, const Vec3d& direction, Kind kind) {
    ++counters_->rays;
    hits_.clear();
    Hit hit = tracer_.seen({eye, direction}, hits_);
    for (std::uint32_t t : hits_) {
        std::uint32_t unit = tree_.units().of[t];
        if (seen_.seen(unit) || arbiter_.sees(eye, eye + direction, t) != Verdict::clear)
            continue;
        seen_.see(unit);
        ++(kind == Kind::uniform  ? counters_->uniform
           : kind == Kind::guided ? counters_->guided
           : kind == Kind::aimed  ? counters_->aimed
                                  : counters_->mutated);
        leads_.push_back({eye, t, kind == Kind::uniform ? Kind::guided : kind});
    }
    return hit.t;
}

/// Marks the nodes whose boxes the ray enters before it ends.
void CellSampler::mark(const Vec3d& eye, const Vec3d& direction, double end) {
    double scale = 1 / tree_.scene().step();
    Vec3d p = eye * scale, d = direction * scale, inverse{1 / d.x, 1 / d.y, 1 / d.z};
    stack_.assign(1, 0);
    while (!stack_.empty()) {
        std::uint32_t n = stack_.back();
        stack_.pop_back();
        const SceneTree::Node& node = tree_.nodes()[n];
        double first = 0, last = end;
        for (int k = 0; k < 3; ++k) {
            double low = static_cast<double>(node.box.min[k]) - p[k], high = static_cast<double>(node.box.max[k]) - p[k];
            if (d[k] == 0) {
                if (low > 0 || high < 0)
                    last = -1;
                continue;
            }
            double a = low * inverse[k], b = high * inverse[k];
            first = std::max(first, std::min(a, b));
            last = std::min(last, std::max(a, b));
        }
        if (!(first < last) || node.count <= 1)
            continue;
        if (!reached_[n]) {
            reached_[n] = 1;
            eye_[n] = {static_cast<float>(eye.x), static_cast<float>(eye.y), static_cast<float>(eye.z)};
            touched_.push_back(n);
        }
        if (node.children != 0) {
            stack_.push_back(node.children);
            stack_.push_back(node.children + 1);
        }
    }
}

void CellSampler::mark_line(const Vec3d& eye, const Vec3d& at) {
    Vec3d from = tree_.to_local(eye), direction = tree_.to_local(at) - from;
    hits_.clear();
    Hit hit = tracer_.seen({from, direction}, hits_);
    mark(from, direction, std::max(1.0, hit.t));
}

bool CellSampler::try_line(const Vec3d& p, const Vec3d& q, std::uint32_t node) {
    Vec3d origin = tree_.to_local(p), direction = tree_.to_local(q) - origin;
    double first = -1e30, last = 1e30;
    for (int k = 0; k < 3; ++k) {
        if (direction[k] == 0) {
            if (origin[k] < cell_.min[k] || origin[k] > cell_.max[k])
                return false;
            continue;
        }
        double a = (cell_.min[k] - origin[k]) / direction[k], b = (cell_.max[k] - origin[k]) / direction[k];
        first = std::max(first, std::min(a, b));
        last = std::min(last, std::max(a, b));
    }
    if (!(first <= last))
        return false;
    Vec3d eye = origin + direction * last; // where it leaves the cell
    for (int k = 0; k < 3; ++k)
        eye[k] = std::clamp(eye[k], cell_.min[k], cell_.max[k]);
    mark(eye, direction, cast(eye, direction, Kind::aimed));
    return reached_[node];
}

void CellSampler::look_around(std::uint32_t rays) {
    constexpr std::uint32_t kPerEye = 16; // rays from one eye share the top of the tree in the caches
    Vec3d eye;
    for (std::uint32_t r = 0; r < rays; ++r) {
        if (r % kPerEye == 0)
            eye = random_eye();
        Vec3d direction = unit_direction(random_);
        double end = cast(eye, direction, Kind::uniform);
        if (r % kMarkEvery == 0)
            mark(eye, direction, end);
    }
}

/// Rays past each edge and corner of the triangle, from the eye that saw it and from another one.
void CellSampler::follow_edges(const Lead& lead) {
    Vec3d v[3], centre{0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        v[k] = scene_.vertex(lead.triangle, k);
        centre = centre + v[k] * (1.0 / 3);
    }
    Vec3d other = random_eye();
    for (int k = 0; k < 6; ++k) {
        double along = random_.uniform(0.1, 0.9);
        Vec3d at = k < 3 ? v[k] + (v[(k + 1) % 3] - v[k]) * along : v[k - 3];
        double past = 1 + kPastEdge[0] + (kPastEdge[1] - kPastEdge[0]) * random_.uniform() * random_.uniform();
        Vec3d toward = centre + (at - centre) * past;
        Vec3d direction = toward - (k % 2 ? other : lead.eye);
        if (dot(direction, direction) > 0)
            cast(k % 2 ? other : lead.eye, direction, lead.kind);
    }
}

void CellSampler::follow(std::uint32_t rays) {
    std::uint64_t last = counters_->rays + rays;
    while (next_lead_ < leads_.size() && counters_->rays < last) {
        Lead lead = leads_[next_lead_++];
        follow_edges(lead);
    }
    if (next_lead_ == leads_.size()) {
        leads_.clear();
        next_lead_ = 0;
    }
}

void CellSampler::explore(std::uint64_t rays) {
    std::uint64_t last = counters_->rays + rays;
    auto found = [&] { return counters_->uniform + counters_->guided; };
    for (std::size_t k = 0; counters_->rays < last;) {
        std::uint64_t rays_before = counters_->rays, found_before = found();
        look_around(kBatch / 8);
        while (counters_->rays < rays_before + kBatch) {
            if (next_lead_ < leads_.size()) {
                found_.push_back(leads_[next_lead_++]);
                follow_edges(Lead(found_.back()));
            } else if (found_.empty()) {
                break;
            } else {
                k = k + 1 < found_.size() ? k + 1 : 0;
                follow_edges({random_eye(), found_[k].triangle, Kind::guided});
            }
        }
        if (counters_->rays - rays_before > kRaysWorthAUnit * (found() - found_before))
            break;
    }
    leads_.clear();
    next_lead_ = 0;
}

void CellSampler::mutate(const Vec3d& eye, const Vec3d& at, std::uint32_t triangle) {
    Vec3d from = tree_.to_local(eye);
    for (int k = 0; k < 3; ++k) // rounding may have moved it out of the cell
        from[k] = std::clamp(from[k], cell_.min[k], cell_.max[k]);
    // Small changes of the line itself, then past the edges of what it met.
    Vec3d line = tree_.to_local(at) - from;
    double size = length(line);
    for (int k = 0; k < 3; ++k) {
        Vec3d shake = unit_direction(random_) * (0.002 * size * (k + 1));
        cast(from, line + shake, Kind::mutated);
    }
    leads_.push_back({from, triangle, Kind::mutated});
}

bool CellSampler::aim_at_triangle(std::uint32_t triangle, std::uint32_t rays) {
    std::uint32_t unit = tree_.units().of[triangle];
    Vec3d v[3];
    for (int k = 0; k < 3; ++k)
        v[k] = scene_.vertex(triangle, k);
    for (std::uint32_t r = 0; r < rays && !seen_.seen(unit); ++r) {
        double a = random_.uniform(), b = random_.uniform();
        if (a + b > 1) {
            a = 1 - a;
            b = 1 - b;
        }
        Vec3d eye = random_eye(), direction = v[0] + (v[1] - v[0]) * a + (v[2] - v[0]) * b - eye;
        if (dot(direction, direction) > 0)
            cast(eye, direction, Kind::aimed);
    }
    return seen_.seen(unit);
}

bool CellSampler::aim_at_box(std::uint32_t node, std::uint32_t rays) {
    const GridBox& box = tree_.nodes()[node].box;
    Vec3d low = tree_.to_local(to_vector(box.min)), high = tree_.to_local(to_vector(box.max));
    std::uint32_t parent = tree_.parents()[node];
    for (std::uint32_t r = 0; r < rays && !reached_[node]; ++r) {
        Vec3d eye = random_eye(), at;
        if (r % 2 == 0 && reached_[parent]) // near the eye that reached the box around it
            for (int k = 0; k < 3; ++k) {
                double mix = random_.uniform();
                eye[k] = std::clamp(static_cast<double>(eye_[parent][k]) + (eye[k] - static_cast<double>(eye_[parent][k])) * mix * mix * mix,
                                    cell_.min[k], cell_.max[k]);
            }
        for (int k = 0; k < 3; ++k)
            at[k] = random_.uniform(low[k], high[k]);
        Vec3d direction = at - eye;
        if (!(dot(direction, direction) > 0))
            continue;
        double enters = 0;
        for (int k = 0; k < 3; ++k) {
            if (direction[k] == 0)
                continue;
            double a = (low[k] - eye[k]) / direction[k], b = (high[k] - eye[k]) / direction[k];
            enters = std::max(enters, std::min(a, b));
        }
        if (double end = cast(eye, direction, Kind::aimed); end > enters)
            mark(eye, direction, end);
    }
    return reached_[node];
}

} // namespace antumbra::exact
