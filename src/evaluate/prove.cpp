// Proof by many random frames: no method that promises not to lose pixels may lose one.
#include "evaluate/cull_scene.hpp"
#include "evaluate/proving.hpp"

#include "bake/viewpoint.hpp"

#include <antumbra/occluder_finding.hpp>

#include <algorithm>
#include <bit>

namespace antumbra {
namespace {

constexpr std::size_t kMostLosses = 20;

std::uint64_t count(const std::vector<std::uint64_t>& bits) {
    std::uint64_t sum = 0;
    for (std::uint64_t word : bits)
        sum += std::uint64_t(std::popcount(word));
    return sum;
}

struct Method {
    std::unique_ptr<Culler> culler;
    ViewState state;
    CullResult result;
};

std::vector<std::string> names_of(const ProofOptions& options) {
    if (!options.methods.empty())
        return options.methods;
    std::vector<std::string> names;
    for (std::string_view name : culler_names())
        if (name != "none" && name != "frustum-scalar" && (name != "pvs" || options.pvs))
            names.emplace_back(name);
    return names;
}

Result<Method> make_method(const CullScene& scene, const std::string& name, const ProofOptions& options) {
    CullerOptions culler_options;
    culler_options.pvs = options.pvs;
    if (options.occluders > 0)
        culler_options.occluders = options.occluders;
    Result<std::unique_ptr<Culler>> culler = make_culler(name, scene, culler_options);
    if (!culler)
        return culler.status();
    return Method{std::move(*culler), {}, {}};
}

ProofMethod& method_of(ProofResult& result, const std::string& name) {
    for (ProofMethod& method : result.methods)
        if (method.name == name)
            return method;
    result.methods.push_back({});
    result.methods.back().name = name;
    return result.methods.back();
}

Status check(const Scene& scene, const ProofOptions& options) {
    if (scene.triangles().empty())
        return {ErrorCode::usage, "the scene has no triangles: there is nothing to prove"};
    if (options.width == 0 || options.height == 0 || options.width > 8192 || options.height > 8192)
        return {ErrorCode::usage, "a picture needs 1 to 8192 pixels along each side"};
    if (options.truth_scale < 1 || options.truth_scale > 8)
        return {ErrorCode::usage, "the truth scale goes from 1 to 8"};
    return options.pvs ? check_belongs(scene, *options.pvs) : Status();
}

} // namespace

ProofFrame::ProofFrame(const Tracer& tracer, const View& view, std::uint64_t frame, const ProofOptions& options,
                       const Job& job)
    : tracer_(tracer), view_(view), frame_(frame), options_(options),
      rays_(PixelRays::of_view(view, options.width * options.truth_scale, options.height * options.truth_scale)
                .from_depth(view.near_plane)),
      buffer_(ItemBuffer::render(tracer, rays_, {PixelSampling::jittered, options.seed, frame}, job)),
      seen_((tracer.scene().objects().size() + 63) / 64, 0) {
    mark_seen(tracer.scene(), buffer_, seen_);
}

void ProofFrame::judge(const std::vector<std::uint64_t>& in_frustum, const std::vector<std::uint64_t>& reported,
                       ProofMethod& method, std::vector<ProofLoss>& losses) const {
    // Beyond the frustum is another method's matter (and its own: `frustum` is judged with everything in it).
    std::vector<std::uint64_t> hidden(seen_.size()), judged(seen_.size());
    bool suspicious = false;
    for (std::size_t word = 0; word < hidden.size(); ++word) {
        hidden[word] = in_frustum[word] & ~reported[word];
        judged[word] = ~hidden[word];
        suspicious = suspicious || (seen_[word] & hidden[word]);
    }
    ++method.frames;
    method.in_frustum += count(in_frustum);
    method.hidden += count(hidden);
    method.pixels += rays_.pixels();
    std::vector<LostPixels> lost;
    if (suspicious)
        lost = find_lost_pixels(tracer_.scene(), Arbiter(tracer_), buffer_, judged);
    aim(hidden, method, lost);
    for (const LostPixels& one : lost) {
        method.lost_objects += one.confirmed > 0;
        method.lost_pixels += one.confirmed;
        method.grazing_pixels += one.grazing;
        method.unconfirmed_pixels += one.unconfirmed;
        if (one.confirmed > 0 && losses.size() < kMostLosses)
            losses.push_back({method.name, frame_, view_, one.object, one.confirmed});
    }
}

void ProofFrame::aim(const std::vector<std::uint64_t>& hidden, ProofMethod& method,
                     std::vector<LostPixels>& lost) const {
    const Scene& scene = tracer_.scene();
    std::vector<std::uint32_t> objects;
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o)
        if (has_bit(hidden, o) && scene.objects()[o].triangle_count > 0)
            objects.push_back(o);
    if (objects.empty())
        return;
    Random random(options_.seed ^ 0x41494D4544ull, frame_);
    Arbiter arbiter(tracer_);
    std::vector<std::uint32_t> triangles;
    Vec3d forward = normalized(view_.target - view_.eye), right = normalized(cross(forward, view_.up));
    Vec3d up = cross(right, forward);
    double aspect = double(rays_.width()) / rays_.height();
    bool flat = view_.projection == Projection::orthographic;
    double half = flat ? view_.height / 2 : half_tangent(view_.fov_y_deg);
    for (std::uint32_t k = 0; k < options_.aimed; ++k) {
        std::uint32_t object = objects[random.below(std::uint32_t(objects.size()))];
        const Object& target = scene.objects()[object];
        std::uint32_t triangle = target.first_triangle + random.below(target.triangle_count);
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1)
            u = 1 - u, v = 1 - v;
        Vec3d a = scene.vertex(triangle, 0), b = scene.vertex(triangle, 1), c = scene.vertex(triangle, 2);
        Vec3d offset = a + (b - a) * u + (c - a) * v - view_.eye;
        double depth = dot(offset, forward), scale = flat ? 1 : depth;
        double x = dot(offset, right), y = dot(offset, up);
        if (!(depth > view_.near_plane && std::abs(x) < scale * half * aspect && std::abs(y) < scale * half))
            continue;
        ++method.aimed;
        double column = (x / (scale * half * aspect) + 1) / 2 * rays_.width();
        Ray ray = rays_.at(column, (1 - y / (scale * half)) / 2 * rays_.height());
        triangles.clear();
        tracer_.seen(ray, triangles);
        for (std::uint32_t one : triangles) {
            std::uint32_t seen = scene.triangle_objects()[one];
            if (!has_bit(hidden, seen))
                continue;
            Verdict verdict = arbiter.sees(ray.origin, ray.origin + ray.direction, one);
            auto entry = std::find_if(lost.begin(), lost.end(), [&](const LostPixels& l) { return l.object == seen; });
            if (entry == lost.end()) {
                lost.push_back({});
                entry = lost.end() - 1;
                entry->object = seen;
            }
            ++(verdict == Verdict::clear        ? entry->confirmed
               : verdict == Verdict::degenerate ? entry->grazing
                                                : entry->unconfirmed);
        }
    }
}

Status prove(const Scene& scene, const ProofOptions& options, ProofResult& result, const Job& job) {
    if (Status status = check(scene, options); !status)
        return status;
    Tracer tracer = Tracer::build(scene, job);
    CullScene cull_scene = cull_scene_of(scene, find_occluders(scene));
    Result<Method> frustum = make_method(cull_scene, "frustum", options);
    if (!frustum)
        return frustum.status();
    std::vector<std::string> names = names_of(options);
    std::vector<Method> methods;
    for (const std::string& name : names) {
        Result<Method> method = make_method(cull_scene, name, options);
        if (!method)
            return method.status();
        method_of(result, name).guarantee = method->culler->guarantee();
        methods.push_back(std::move(*method));
    }
    Job inner = job;
    inner.progress = nullptr;
    std::uint64_t blocks = (options.frames + kProofBlock - 1) / kProofBlock;
    std::vector<std::uint64_t> everything((scene.objects().size() + 63) / 64, 0);
    for (std::uint32_t o = 0; o < scene.objects().size(); ++o)
        set_bit(everything, o);
    for (std::uint64_t block = 0; block < blocks; ++block) {
        ProofResult next = result;
        bool any = false;
        for (Method& method : methods)
            method.state = {};
        for (std::uint64_t f = block * kProofBlock; f < (block + 1) * kProofBlock; ++f) {
            std::vector<std::size_t> due;
            for (std::size_t m = 0; m < methods.size(); ++m)
                if (method_of(next, names[m]).frames == f)
                    due.push_back(m);
            if (due.empty())
                break;
            any = true;
            View view = proof_view(tracer, options.seed, f, double(options.width) / options.height);
            ProofFrame truth(tracer, view, f, options, inner);
            if (job.cancelled())
                return {ErrorCode::cancelled, "stopped after " + std::to_string(block * kProofBlock) + " frames"};
            next.seen_objects += count(truth.seen());
            frustum->culler->cull(view, frustum->state, frustum->result);
            bool in_matter = options.pvs && !is_viewpoint(tracer, view.eye);
            for (std::size_t m : due) {
                methods[m].culler->cull(view, methods[m].state, methods[m].result);
                const auto& within = names[m] == "frustum" ? everything : frustum->result.visible;
                // A baked file promises nothing to an eye inside matter.
                const auto& reported = in_matter && names[m] == "pvs" ? within : methods[m].result.visible;
                truth.judge(within, reported, method_of(next, names[m]), next.losses);
            }
            if (job.progress)
                job.progress({"prove", f + 1, blocks * kProofBlock, "frames"});
        }
        result = std::move(next);
        if (any && options.keep)
            if (Status status = options.keep(result); !status)
                return status;
    }
    return {};
}

} // namespace antumbra
