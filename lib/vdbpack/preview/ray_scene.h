// Private to previews: intersects rays with spheres and triangles, by Embree.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/mesh/triangle_mesh.h"
#include "vdbpack/preview/float3.h"
#include "vdbpack/preview/preview.h"

#if VDBPACK_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace vdbpack {

/// Coordinates of the drawing: relative to the middle of the scene and scaled by its size, so that
/// single precision suffices for a bone far from the origin.
struct Local {
    Vec<3> middle;
    double scale = 1;

    explicit Local(const Box<3>& bounds)
        : middle(bounds.center()), scale(2 / std::max(length(bounds.size()), 1e-300)) {}
    Float3 operator()(const Vec<3>& x) const { return single((x - middle) * scale); }
    Vec<3> inMm(const Float3& x) const { return middle + Vec<3>{{x.x, x.y, x.z}} * (1 / scale); }
};

struct Hit {
    float t = std::numeric_limits<float>::infinity();
    unsigned primitive = RTC_INVALID_GEOMETRY_ID, geometry = RTC_INVALID_GEOMETRY_ID;
    float u = 0, v = 0;
    Float3 normal;
    bool any() const { return geometry != RTC_INVALID_GEOMETRY_ID; }
};

class Device {
public:
    /// @throws ResourceError if Embree cannot start.
    Device();
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    RTCDevice get() const { return device_; }
    /// @throws ResourceError for any error of Embree since the last call.
    void check() const;

private:
    RTCDevice device_;
};

/// Triangles with smooth normals.
struct Surface {
    std::vector<std::array<float, 3>> vertices;
    std::vector<Float3> normals;  ///< one per vertex
    std::vector<std::array<std::uint32_t, 3>> triangles;

    /// @param cut  triangles on the removed side are left out.
    Surface(const TriangleMesh& mesh, const Local& local, const std::optional<PreviewCut>& cut);
    Float3 at(std::uint32_t k) const { return {vertices[k][0], vertices[k][1], vertices[k][2]}; }

    /// The smooth normal at a hit; at creases the normal of the facet.
    Float3 normalAt(const Hit& hit) const;
};

/// Rays that Embree casts together.
inline constexpr int kTogether = 8;

/// Up to `kTogether` rays; Embree skips those that are not set.
class Rays {
public:
    void set(int k, const Float3& from, const Float3& along, float near, float far) {
        RTCRay8& r = rays_.ray;
        r.org_x[k] = from.x, r.org_y[k] = from.y, r.org_z[k] = from.z;
        r.dir_x[k] = along.x, r.dir_y[k] = along.y, r.dir_z[k] = along.z;
        r.tnear[k] = near, r.tfar[k] = far;
        r.time[k] = 0, r.mask[k] = ~0u, r.id[k] = 0, r.flags[k] = 0;
        valid_[k] = -1;
    }
    void startAt(int k, float near) { rays_.ray.tnear[k] = near; }
    void drop(int k) { valid_[k] = 0; }
    bool has(int k) const { return valid_[k] != 0; }
    Float3 along(int k) const {
        return {rays_.ray.dir_x[k], rays_.ray.dir_y[k], rays_.ray.dir_z[k]};
    }

private:
    friend class RayScene;
    RTCRayHit8 rays_;
    alignas(32) int valid_[kTogether] = {};
};

/// A scene of Embree. The geometry added to it must outlive it.
class RayScene {
public:
    explicit RayScene(const Device& device);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    /// @param spheres  center and radius.
    void addSpheres(const std::vector<std::array<float, 4>>& spheres);
    void addSurface(const Surface& surface);
    /// @throws Interrupted once `request` is made.
    void commit(StopRequest& request);

    /// The first hit of each ray between its ends.
    std::array<Hit, kTogether> first(Rays rays) const;
    /// Of each ray whether it hits anything between its ends.
    std::array<bool, kTogether> blocked(Rays rays) const;

    static constexpr unsigned kSpheres = 0, kSurface = 1;  ///< `Hit::geometry`

private:
    void attach(RTCGeometry g, unsigned id);

    const Device& device_;
    RTCScene scene_;
};

// Inline: a pixel casts several rays.

inline std::array<Hit, kTogether> RayScene::first(Rays rays) const {
    RTCRayHit8& r = rays.rays_;
    for (int k = 0; k < kTogether; ++k)
        r.hit.geomID[k] = r.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
#if VDBPACK_EMBREE >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect8(rays.valid_, scene_, &r, &arguments);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect8(rays.valid_, scene_, &context, &r);
#endif
    std::array<Hit, kTogether> hits;
    for (int k = 0; k < kTogether; ++k) {
        if (!rays.has(k) || r.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
        hits[static_cast<std::size_t>(k)] = {
            r.ray.tfar[k], r.hit.primID[k], r.hit.geomID[k],
            r.hit.u[k],    r.hit.v[k],      {r.hit.Ng_x[k], r.hit.Ng_y[k], r.hit.Ng_z[k]}};
    }
    return hits;
}

inline std::array<bool, kTogether> RayScene::blocked(Rays rays) const {
    RTCRay8& ray = rays.rays_.ray;
#if VDBPACK_EMBREE >= 4
    rtcOccluded8(rays.valid_, scene_, &ray);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded8(rays.valid_, scene_, &context, &ray);
#endif
    std::array<bool, kTogether> are{};
    for (int k = 0; k < kTogether; ++k)
        are[static_cast<std::size_t>(k)] = rays.has(k) && ray.tfar[k] < 0;
    return are;
}

}  // namespace vdbpack
