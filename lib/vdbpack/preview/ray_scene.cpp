#include "vdbpack/preview/ray_scene.h"

#include "vdbpack/core/error.h"
#include "vdbpack/preview/section.h"

#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <mutex>

namespace vdbpack {

namespace {

/// Facets that meet at a larger angle than of this cosine are not smoothed.
constexpr float kCrease = 0.6f;

}  // namespace

Device::Device() : device_(rtcNewDevice(nullptr)) {
    if (!device_) throw ResourceError("preview: Embree cannot start; check the available memory");
}

Device::~Device() {
    rtcReleaseDevice(device_);
}

void Device::check() const {
    const RTCError error = rtcGetDeviceError(device_);
    if (error == RTC_ERROR_OUT_OF_MEMORY)
        throw ResourceError(
            "preview: not enough memory to draw the scene; leave `preview.file` out");
    if (error != RTC_ERROR_NONE)
        throw ResourceError(
            fmt::format("preview: Embree failed with error {}; leave `preview.file` out",
                        static_cast<int>(error)));
}

Surface::Surface(const TriangleMesh& mesh, const Local& local,
                 const std::optional<PreviewCut>& cut) {
    vertices.reserve(mesh.vertices.size() + 1);
    for (const auto& x : mesh.vertices) {
        const Float3 v = local(x);
        vertices.push_back({v.x, v.y, v.z});
    }
    normals.resize(vertices.size());
    for (const auto& t : mesh.triangles) {
        const Float3 n = cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
        for (const auto k : t) normals[k] = normals[k] + n;
        const auto kept = [&](std::uint32_t k) {
            return !cut || keptDepth(*cut, mesh.vertices[k]) >= 0;
        };
        if (kept(t[0]) || kept(t[1]) || kept(t[2])) triangles.push_back(t);
    }
    for (Float3& n : normals) n = normalized(n);
    // Embree reads 16 bytes of the last vertex.
    vertices.push_back({});
}

Float3 Surface::normalAt(const Hit& hit) const {
    const auto& t = triangles[hit.primitive];
    const Float3 facet = normalized(hit.normal);
    Float3 smooth{};
    const std::array<float, 3> share{1 - hit.u - hit.v, hit.u, hit.v};
    for (std::size_t k = 0; k < 3; ++k) {
        if (!(std::fabs(dot(normals[t[k]], facet)) > kCrease)) return facet;
        smooth = smooth + normals[t[k]] * share[k];
    }
    smooth = normalized(smooth);
    return dot(smooth, facet) < 0 ? -smooth : smooth;
}

RayScene::RayScene(const Device& device) : device_(device), scene_(rtcNewScene(device.get())) {
    device_.check();
    // Rays through edges of boxes hit, however the hierarchy was built: the picture is the same for
    // any number of threads.
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
}

RayScene::~RayScene() {
    rtcReleaseScene(scene_);
}

void RayScene::addSpheres(const std::vector<std::array<float, 4>>& spheres) {
    if (spheres.empty()) return;
    RTCGeometry g = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_SPHERE_POINT);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, spheres.data(), 0,
                               sizeof(spheres[0]), spheres.size());
    attach(g, kSpheres);
}

void RayScene::addSurface(const Surface& surface) {
    if (surface.triangles.empty()) return;
    RTCGeometry g = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               surface.vertices.data(), 0, sizeof(surface.vertices[0]),
                               surface.vertices.size() - 1);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               surface.triangles.data(), 0, sizeof(surface.triangles[0]),
                               surface.triangles.size());
    attach(g, kSurface);
}

void RayScene::commit(StopRequest& request) {
    struct Monitor {
        StopRequest& request;
        std::mutex mutex;
        std::exception_ptr failure;  // no exception may pass through Embree
    } monitor{request, {}, {}};
    const auto goOn = [](void* asked, double) {
        auto& m = *static_cast<Monitor*>(asked);
        try {
            return !m.request.made();
        } catch (...) {
            const std::lock_guard<std::mutex> lock(m.mutex);
            m.failure = std::current_exception();
            return false;
        }
    };
    rtcSetSceneProgressMonitorFunction(scene_, goOn, &monitor);
    rtcCommitScene(scene_);
    rtcSetSceneProgressMonitorFunction(scene_, nullptr, nullptr);
    if (monitor.failure) std::rethrow_exception(monitor.failure);
    request.stop();  // before the check: Embree reports it as an error
    device_.check();
}

void RayScene::attach(RTCGeometry g, unsigned id) {
    device_.check();
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(scene_, g, id);
    rtcReleaseGeometry(g);
    device_.check();
}

}  // namespace vdbpack
