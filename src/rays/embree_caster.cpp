#include "rays/embree_caster.hpp"

#include "base/parallel.hpp"

#include <embree3/rtcore.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <cstring>
#include <string>
#include <vector>

namespace antumbra {
namespace {

/// Flush-to-zero and denormals-are-zero, which Embree wants, for one scope and thread.
class FlushDenormals {
  public:
#if defined(__x86_64__)
    FlushDenormals() : saved_(_mm_getcsr()) {
        _mm_setcsr(saved_ | 0x8040u);
    }
    ~FlushDenormals() {
        _mm_setcsr(saved_);
    }

  private:
    unsigned saved_;
#else
    FlushDenormals() {}
#endif
  public:
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;
};

/// Rejects hits of single-sided triangles from behind; the ray then goes on.
void reject_backs(const RTCFilterFunctionNArguments* arguments) {
    // Only rtcIntersect1 is called: one ray at a time.
    auto* ray = reinterpret_cast<RTCRay*>(arguments->ray);
    auto* hit = reinterpret_cast<RTCHit*>(arguments->hit);
    if (hit->Ng_x * ray->dir_x + hit->Ng_y * ray->dir_y + hit->Ng_z * ray->dir_z > 0)
        arguments->valid[0] = 0;
}

} // namespace

struct EmbreeCaster::Implementation {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<std::uint32_t>
        triangles[2]; ///< by geometry (0: double-sided, 1: single-sided): index in the Scene

    ~Implementation() {
        if (scene)
            rtcReleaseScene(scene);
        if (device)
            rtcReleaseDevice(device);
    }

    void attach(const Scene& source, unsigned id) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        std::size_t vertices = source.positions().size(), count = triangles[id].size();
        if (void* to =
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices))
            std::memcpy(to, source.positions().data(), vertices * 12);
        if (void* to =
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count))
            for (std::size_t i = 0; i < count; ++i)
                std::memcpy(static_cast<char*>(to) + 12 * i, source.triangles()[triangles[id][i]].data(), 12);
        if (id == 1)
            rtcSetGeometryIntersectFilterFunction(geometry, reject_backs);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
    }

    Status status() const {
        RTCError error = rtcGetDeviceError(device);
        if (error == RTC_ERROR_NONE)
            return {};
        if (error == RTC_ERROR_OUT_OF_MEMORY)
            return Status(
                ErrorCode::limit,
                "not enough memory for Embree's hierarchy; close other programs or split the scene");
        return Status(ErrorCode::internal,
                      "Embree refused to build (error " + std::to_string(error) + "); please report");
    }

    Hit cast(const Ray& ray, RTCIntersectContext& context) const {
        RTCRayHit query;
        query.ray.org_x = static_cast<float>(ray.origin.x);
        query.ray.org_y = static_cast<float>(ray.origin.y);
        query.ray.org_z = static_cast<float>(ray.origin.z);
        query.ray.dir_x = static_cast<float>(ray.direction.x);
        query.ray.dir_y = static_cast<float>(ray.direction.y);
        query.ray.dir_z = static_cast<float>(ray.direction.z);
        query.ray.tnear = 0;
        query.ray.tfar = std::numeric_limits<float>::infinity();
        query.ray.time = 0;
        query.ray.mask = ~0u;
        query.ray.flags = 0;
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            return {};
        return {static_cast<double>(query.ray.tfar), triangles[query.hit.geomID][query.hit.primID]};
    }
};

EmbreeCaster::EmbreeCaster(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
EmbreeCaster::~EmbreeCaster() = default;
EmbreeCaster::EmbreeCaster(EmbreeCaster&&) noexcept = default;
EmbreeCaster& EmbreeCaster::operator=(EmbreeCaster&&) noexcept = default;

Result<EmbreeCaster> EmbreeCaster::build(const Scene& scene, const Job& job) {
    auto implementation = std::make_unique<Implementation>();
    Implementation& embree = *implementation;
    embree.device = rtcNewDevice(("threads=" + std::to_string(worker_count(job))).c_str());
    if (!embree.device)
        return Status(ErrorCode::internal,
                      "Embree does not run on this machine; use the strict tracer instead");
    embree.scene = rtcNewScene(embree.device);
    rtcSetSceneFlags(embree.scene, RTC_SCENE_FLAG_ROBUST);
    for (std::uint32_t t = 0; t < scene.triangles().size(); ++t)
        if (const Object& object = scene.object_of(t); object.has(kOccludes))
            embree.triangles[object.has(kDoubleSided) ? 0 : 1].push_back(t);
    for (unsigned id : {0u, 1u})
        if (!embree.triangles[id].empty())
            embree.attach(scene, id);
    rtcCommitScene(embree.scene);
    if (Status status = embree.status(); !status)
        return status;
    return EmbreeCaster(std::move(implementation));
}

void EmbreeCaster::first_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    FlushDenormals scope;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (std::size_t i = 0; i < rays.size(); ++i)
        hits[i] = implementation_->cast(rays[i], context);
}

} // namespace antumbra
