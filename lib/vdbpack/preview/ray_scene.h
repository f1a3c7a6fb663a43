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

    /// The first hit between `near` and `far`.
    Hit first(const Float3& from, const Float3& along, float near,
              float far = std::numeric_limits<float>::infinity()) const;
    /// Whether anything is hit nearer than `far`.
    bool blocked(const Float3& from, const Float3& along, float far) const;

    static constexpr unsigned kSpheres = 0, kSurface = 1;  ///< `Hit::geometry`

private:
    void attach(RTCGeometry g, unsigned id);

    const Device& device_;
    RTCScene scene_;
};

// Inline: each pixel casts a dozen rays.

inline RTCRay rayOf(const Float3& from, const Float3& along, float near, float far) {
    RTCRay ray;
    ray.org_x = from.x, ray.org_y = from.y, ray.org_z = from.z;
    ray.dir_x = along.x, ray.dir_y = along.y, ray.dir_z = along.z;
    ray.tnear = near, ray.tfar = far;
    ray.time = 0, ray.mask = ~0u, ray.id = 0, ray.flags = 0;
    return ray;
}

inline Hit RayScene::first(const Float3& from, const Float3& along, float near, float far) const {
    RTCRayHit r;
    r.ray = rayOf(from, along, near, far);
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if VDBPACK_EMBREE >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect1(scene_, &r, &arguments);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect1(scene_, &context, &r);
#endif
    Hit hit;
    if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return hit;
    hit.t = r.ray.tfar;
    hit.geometry = r.hit.geomID;
    hit.primitive = r.hit.primID;
    hit.u = r.hit.u;
    hit.v = r.hit.v;
    hit.normal = {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z};
    return hit;
}

inline bool RayScene::blocked(const Float3& from, const Float3& along, float far) const {
    RTCRay ray = rayOf(from, along, 0, far);
#if VDBPACK_EMBREE >= 4
    rtcOccluded1(scene_, &ray);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene_, &context, &ray);
#endif
    return ray.tfar < 0;
}

}  // namespace vdbpack
