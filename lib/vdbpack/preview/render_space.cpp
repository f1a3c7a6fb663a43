// Ray tracing through Embree: the only source that knows it.
#include "vdbpack/core/error.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/preview/scene.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <new>

namespace vdbpack {

namespace {

/// Side of a tile, and how far its light is smoothed beyond it, pixels.
constexpr int kTile = 80, kApron = 2;
constexpr int kSamples = 4;
/// Light: a broad lamp from the upper left behind the camera, the sky, and a little from the
/// camera itself.
constexpr float kKey = 0.62f, kSky = 0.56f, kFill = 0.06f, kShine = 0.10f;
/// Tangent of half the angle that the lamp fills: what makes shadows soft.
constexpr float kLamp = 0.11f;
/// Reach of ambient occlusion: in mean radii, and of the size of the scene.
constexpr float kAmbientRadii = 7, kAmbientShare = 0.05f;
/// Opacity of the wall seen head-on and edge-on; layers of it that are looked at.
constexpr float kVeil = 0.07f, kEdge = 0.6f;
constexpr int kLayers = 2;
/// How much darker what lies under the wall is where the wall faces away from the lamp.
constexpr float kForm = 0.25f;
/// Light on the inner side of the wall of a bone that is cut open.
constexpr float kInnerDark = 0.2f, kInnerLight = 0.2f;
/// Half the width of the line in which a cut meets the wall, and the rim of cut faces, pixels.
constexpr double kWallLine = 1.25, kRim = 0.9;
/// Share of a disc's radius that its rim takes at the most.
constexpr double kLargestRim = 0.14;
constexpr float kRimShade = 0.5f;
/// Facets that meet in a sharper edge (cosine) are not smoothed.
constexpr float kCrease = 0.6f;

struct V {
    float x = 0, y = 0, z = 0;
    friend V operator+(const V& a, const V& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend V operator-(const V& a, const V& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend V operator*(const V& a, float s) { return {a.x * s, a.y * s, a.z * s}; }
    V operator-() const { return {-x, -y, -z}; }
    float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};
float dot(const V& a, const V& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
V normalized(const V& a) {
    const float square = dot(a, a);
    return square > 0 ? a * (1 / std::sqrt(square)) : a;
}
V cross(const V& a, const V& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
V single(const Vec<3>& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}
/// Two directions across `n`, without a branch that would show as a seam: Duff et al. (2017),
/// "Building an orthonormal basis, revisited", JCGT 6(1).
void basis(const V& n, V& s, V& t) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z), b = n.x * n.y * a;
    s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
}

/// The first two dimensions of Sobol's sequence, a net in base 2 for every aligned block of a
/// power of two of them.
std::array<float, 2> sobol(std::uint32_t n, std::uint32_t scramble0, std::uint32_t scramble1) {
    std::uint32_t a = 0, b = 0, direction = 1u << 31;
    for (std::uint32_t bit = 0, v = n; v != 0; ++bit, v >>= 1) {
        if (v & 1) {
            a ^= 1u << (31 - bit);
            b ^= direction;
        }
        direction ^= direction >> 1;
    }
    const auto unit = [](std::uint32_t v) { return static_cast<float>(v >> 8) * 0x1p-24f; };
    return {unit(a ^ scramble0), unit(b ^ scramble1)};
}

/// Where in its pixel a sample lies: a rotated grid, no two in a row or column.
constexpr std::array<std::array<double, 2>, kSamples> kInPixel{
    {{0.125, 0.625}, {0.375, 0.125}, {0.625, 0.875}, {0.875, 0.375}}};
/// Neighboring pixels of a square of 4 x 4 take points of the sequence that differ much.
constexpr std::array<std::uint32_t, 16> kSquare{0, 8,  2, 10, 12, 4, 14, 6,
                                                3, 11, 1, 9,  15, 7, 13, 5};

/// Where the drawing lives: about the middle of the scene and of its size, so that floats are
/// as good for a bone far from the origin.
struct Local {
    Vec<3> middle;
    double scale = 1;

    explicit Local(const Box<3>& bounds)
        : middle(bounds.center()), scale(2 / std::max(length(bounds.size()), 1e-300)) {}
    V operator()(const Vec<3>& x) const { return single((x - middle) * scale); }
    Vec<3> inMm(const V& x) const { return middle + Vec<3>{{x.x, x.y, x.z}} * (1 / scale); }
};

struct Hit {
    float t = std::numeric_limits<float>::infinity();
    unsigned primitive = RTC_INVALID_GEOMETRY_ID, geometry = RTC_INVALID_GEOMETRY_ID;
    float u = 0, v = 0;
    V normal;
    bool any() const { return geometry != RTC_INVALID_GEOMETRY_ID; }
};

class Device {
public:
    Device() : device_(rtcNewDevice(nullptr)) {
        if (!device_) throw ResourceError("preview: Embree cannot start; is there memory left?");
    }
    ~Device() { rtcReleaseDevice(device_); }
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    RTCDevice get() const { return device_; }
    void check() const {
        const RTCError error = rtcGetDeviceError(device_);
        if (error == RTC_ERROR_OUT_OF_MEMORY)
            throw ResourceError("preview: not enough memory to draw this; leave --preview out");
        if (error != RTC_ERROR_NONE)
            throw ResourceError(
                fmt::format("preview: Embree fails with error {}; leave --preview "
                            "out",
                            static_cast<int>(error)));
    }

private:
    RTCDevice device_;
};

/// Triangles with smooth normals.
struct Surface {
    std::vector<std::array<float, 3>> vertices;
    std::vector<V> normals;  ///< one a vertex
    std::vector<std::array<std::uint32_t, 3>> triangles;

    Surface(const TriangleMesh& mesh, const Local& local, const std::optional<PreviewCut>& cut) {
        vertices.reserve(mesh.vertices.size() + 1);
        for (const auto& x : mesh.vertices) {
            const V v = local(x);
            vertices.push_back({v.x, v.y, v.z});
        }
        normals.resize(vertices.size());
        for (const auto& t : mesh.triangles) {
            const V n = cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
            for (const auto k : t) normals[k] = normals[k] + n;
            const auto kept = [&](std::uint32_t k) {
                return !cut || keptDepth(*cut, mesh.vertices[k]) >= 0;
            };
            if (kept(t[0]) || kept(t[1]) || kept(t[2])) triangles.push_back(t);
        }
        for (V& n : normals) n = normalized(n);
        // Embree reads 16 bytes of the last vertex.
        vertices.push_back({});
    }
    V at(std::uint32_t k) const { return {vertices[k][0], vertices[k][1], vertices[k][2]}; }

    /// The normal at a hit; that of the facet at creases.
    V normalAt(const Hit& hit) const {
        const auto& t = triangles[hit.primitive];
        const V facet = normalized(hit.normal);
        V smooth{};
        const std::array<float, 3> share{1 - hit.u - hit.v, hit.u, hit.v};
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(std::fabs(dot(normals[t[k]], facet)) > kCrease)) return facet;
            smooth = smooth + normals[t[k]] * share[k];
        }
        smooth = normalized(smooth);
        return dot(smooth, facet) < 0 ? -smooth : smooth;
    }
};

/// A scene of Embree, with what must outlive it.
class RayScene {
public:
    explicit RayScene(const Device& device) : device_(device), scene_(rtcNewScene(device.get())) {
        device_.check();
        // Rays through edges of boxes hit, however the hierarchy was built: the same picture from
        // any number of threads.
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    }
    ~RayScene() { rtcReleaseScene(scene_); }
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    void addSpheres(const std::vector<std::array<float, 4>>& spheres) {
        if (spheres.empty()) return;
        RTCGeometry g = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_SPHERE_POINT);
        rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, spheres.data(),
                                   0, sizeof(spheres[0]), spheres.size());
        attach(g, kSpheres);
    }
    void addSurface(const Surface& surface) {
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
    /// @throws Interrupted as soon as `request` is made.
    void commit(StopRequest& request) {
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
        request.stop();  // which Embree takes for an error
        device_.check();
    }

    Hit first(const V& from, const V& along, float near,
              float far = std::numeric_limits<float>::infinity()) const {
        RTCRayHit r;
        r.ray = rayOf(from, along, near, far);
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcIntersect1(scene_, &context, &r);
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
    bool blocked(const V& from, const V& along, float far) const {
        RTCRay ray = rayOf(from, along, 0, far);
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene_, &context, &ray);
        return ray.tfar < 0;
    }

    static constexpr unsigned kSpheres = 0, kSurface = 1;

private:
    void attach(RTCGeometry g, unsigned id) {
        device_.check();
        rtcCommitGeometry(g);
        rtcAttachGeometryByID(scene_, g, id);
        rtcReleaseGeometry(g);
        device_.check();
    }
    static RTCRay rayOf(const V& from, const V& along, float near, float far) {
        RTCRay ray;
        ray.org_x = from.x, ray.org_y = from.y, ray.org_z = from.z;
        ray.dir_x = along.x, ray.dir_y = along.y, ray.dir_z = along.z;
        ray.tnear = near, ray.tfar = far;
        ray.time = 0, ray.mask = ~0u, ray.id = 0, ray.flags = 0;
        return ray;
    }

    const Device& device_;
    RTCScene scene_;
};

/// One ray of a pixel, and what it met.
struct Sample {
    bool hit = false;
    V at, normal;  ///< normal towards the camera's side
    Color albedo;
    float open = 1;  ///< share of the sky that is seen
    float lit = 1;   ///< share of the lamp that is seen
    float shine = kShine;
    Color veil;         ///< light of the wall before it
    float through = 1;  ///< what the wall lets pass
};

class SpaceTracer {
public:
    SpaceTracer(const SpacePreview& scene, const PreviewOptions& options, StopRequest& request)
        : scene_(scene),
          options_(options),
          local_(checkScene(scene, options)),
          camera_(previewCamera(scene, options)),
          bodies_(device_),
          walls_(device_) {
        eye_ = local_(camera_.position);
        right_ = single(camera_.right);
        up_ = single(camera_.up);
        toward_ = single(camera_.toward);
        lamp_ = normalized(right_ * -0.5f + up_ * 0.75f + toward_ * 0.75f);
        basis(lamp_, lampS_, lampT_);
        pixel_ = 2 * camera_.tanX / options.width;
        if (scene.pack) {
            addSpheres(*scene.pack);
            bodies_.addSpheres(spheres_);
        }
        if (scene.solid) {
            solid_ = std::make_unique<Surface>(*scene.solid, local_, options.cut);
            bodies_.addSurface(*solid_);
        }
        if (scene.wall) {
            wall_ = std::make_unique<Surface>(*scene.wall, local_, options.cut);
            walls_.addSurface(*wall_);
        }
        bodies_.commit(request);
        walls_.commit(request);
        if (options.cut) {
            cutNormal_ = {};
            const auto side = static_cast<float>(-keptSide(*options.cut));
            (options.cut->axis == 0   ? cutNormal_.x
             : options.cut->axis == 1 ? cutNormal_.y
                                      : cutNormal_.z) = side;
            if (scene.pack) discs_.emplace(sectionOf(*scene.pack, *options.cut));
            if (scene.wall)
                lines_.emplace(
                    sectionOf(*scene.wall, *options.cut, kWallLine * pixel_ * camera_.target));
        }
    }

    const PreviewCamera& camera() const { return camera_; }
    double mmPerPixel() const { return pixel_ * camera_.target; }

    void colorBy(std::vector<Color> colors) { colors_ = std::move(colors); }

    /// Where the cut is met, or the eye.
    struct Start {
        bool sees = true;  ///< false: never gets to what stays
        float t = 0;
        Vec<3> at;  ///< in the cut, mm
    };
    /// The ray through a point of the picture, in pixels.
    V rayAt(double x, double y) const {
        return normalized(
            single(camera_.direction(2 * x / options_.width - 1, 2 * y / options_.height - 1)));
    }
    Start startOf(double x, double y) const {
        Start start;
        if (!options_.cut) return start;
        const int axis = options_.cut->axis;
        const Vec<3> along = vdbpack::normalized(
            camera_.direction(2 * x / options_.width - 1, 2 * y / options_.height - 1));
        const double speed = keptSide(*options_.cut) * along[axis];
        const double depth = keptDepth(*options_.cut, camera_.position);
        if (!(speed > 0)) {
            start.sees = false;
            return start;
        }
        const double t = -depth / speed;
        start.at = camera_.position + along * t;
        start.at[axis] = options_.cut->at;
        start.t = static_cast<float>(t * local_.scale);
        return start;
    }

    /// The sphere seen through a point of the picture; -1: none.
    std::int32_t sphereAt(double x, double y) const {
        const Start start = startOf(x, y);
        if (!start.sees) return -1;
        if (discs_) {
            const auto found = discs_->at(CutAxes(options_.cut->axis).flat(start.at));
            if (found.index >= 0) return found.index;
        }
        const Hit hit = bodies_.first(eye_, rayAt(x, y), start.t);
        return hit.geometry == RayScene::kSpheres ? indexOf(hit.primitive) : -1;
    }

    Sample trace(int px, int py, int k) const {
        Sample s;
        const auto& offset = kInPixel[static_cast<std::size_t>(k)];
        const double x = px + offset[0], y = py + offset[1];
        const Start start = startOf(x, y);
        if (!start.sees) return s;
        const V along = rayAt(x, y);
        V origin;  // of further rays
        float reach = std::numeric_limits<float>::infinity();
        const auto cap = [&](const Color& color) {
            s.hit = true;
            s.normal = cutNormal_;
            s.at = local_(start.at);
            s.albedo = color;
            s.shine = 0;
            reach = start.t;
        };
        if (options_.cut) {
            const Vec<2> flat = CutAxes(options_.cut->axis).flat(start.at);
            if (lines_ && lines_->distance(flat) < kWallLine * mmPerPixel()) {
                cap(inkColor());
                return s;
            }
            if (discs_) {
                const auto found = discs_->at(flat);
                if (found.index >= 0) {
                    const Color color = colors_[static_cast<std::size_t>(found.index)];
                    cap(color * (found.rim < rimOf(found.index) ? kRimShade : 1));
                    return s;
                }
            }
        }
        const Hit hit = bodies_.first(eye_, along, start.t);
        if (hit.any()) {
            s.hit = true;
            reach = hit.t;
            s.at = eye_ + along * hit.t;
            if (hit.geometry == RayScene::kSpheres) {
                const auto& ball = spheres_[hit.primitive];
                const V center{ball[0], ball[1], ball[2]};
                s.albedo = colors_[static_cast<std::size_t>(indexOf(hit.primitive))];
                s.normal = normalized(s.at - center);
                // From behind: the ray began inside, by a rounding at the rim of a cut face.
                if (options_.cut && dot(s.normal, along) > 0) {
                    cap(s.albedo * kRimShade);
                    return s;
                }
                s.at = center + s.normal * ball[3];
                origin = center + s.normal * (ball[3] * 1.0005f + 2e-6f);
            } else {
                V facet = normalized(hit.normal);
                if (dot(facet, along) > 0) {
                    // Inside the body, where the cut opens it.
                    if (options_.cut) {
                        cap(boneCutColor());
                        return s;
                    }
                    facet = -facet;
                }
                s.albedo = boneColor();
                s.normal = solid_->normalAt(hit);
                if (dot(s.normal, facet) < 0) s.normal = -s.normal;
                origin = s.at + facet * 2e-5f;
            }
        }
        if (wall_) addVeil(along, start.t, reach, s);
        if (s.hit) addLight(px, py, k, origin, s);
        return s;
    }

    Color shade(const Sample& s) const {
        const V toEye = normalized(eye_ - s.at);
        const float key = std::max(0.0f, dot(s.normal, lamp_));
        const float sky = 0.72f + 0.28f * s.normal.z;
        const V half = normalized(toEye + lamp_);
        const float gloss = std::pow(std::max(0.0f, dot(s.normal, half)), 40.0f) * s.shine;
        const float light = kKey * key * s.lit + kSky * sky * s.open +
                            kFill * std::max(0.0f, dot(s.normal, toEye)) * s.open;
        Color c = s.albedo * (s.shine > 0 ? light : 0.95f);
        if (gloss > 0) c += Color{1, 1, 1} * (gloss * s.lit * (key > 0 ? 1.0f : 0.0f));
        return c;
    }

    int width() const { return options_.width; }
    int height() const { return options_.height; }
    double footprint() const { return pixel_; }
    const V& eye() const { return eye_; }

private:
    void addSpheres(const Pack<3>& pack) {
        double sum = 0;
        spheres_.reserve(pack.spheres.size());
        for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
            const auto& s = pack.spheres[i];
            if (options_.cut && !(keptDepth(*options_.cut, s.center) > -s.radius)) continue;
            const V c = local_(s.center);
            spheres_.push_back({c.x, c.y, c.z, static_cast<float>(s.radius * local_.scale)});
            if (options_.cut) index_.push_back(static_cast<std::int32_t>(i));
            sum += s.radius;
        }
        if (!spheres_.empty())
            ambient_ = std::max(
                ambient_, kAmbientRadii * static_cast<float>(sum * local_.scale /
                                                             static_cast<double>(spheres_.size())));
    }
    std::int32_t indexOf(unsigned primitive) const {
        return index_.empty() ? static_cast<std::int32_t>(primitive) : index_[primitive];
    }
    /// Width of the dark rim of a cut face, mm.
    double rimOf(std::int32_t index) const {
        const Sphere<3>& s = scene_.pack->spheres[static_cast<std::size_t>(index)];
        return std::min(kRim * mmPerPixel(), kLargestRim * s.radius);
    }
    /// How far a ray may go in what stays of a cut.
    float freeWay(const V& from, const V& along) const {
        if (!options_.cut) return std::numeric_limits<float>::infinity();
        const double out = dot(along, cutNormal_);
        if (!(out > 0)) return std::numeric_limits<float>::infinity();
        const double depth = keptDepth(*options_.cut, local_.inMm(from)) * local_.scale;
        return static_cast<float>(depth / out);
    }
    /// The wall before what was hit, or behind it all where the ray begins inside.
    void addVeil(const V& along, float near, float far, Sample& s) const {
        for (int layer = 0; layer < kLayers; ++layer) {
            const Hit hit = walls_.first(eye_, along, near, far);
            if (!hit.any()) return;
            V n = wall_->normalAt(hit);
            const bool inner = layer == 0 && options_.cut && dot(hit.normal, along) > 0;
            if (dot(n, along) > 0) n = -n;
            if (inner && !s.hit) {
                // The far side of an opened bone: without it one would look out through the pack.
                const float light = kInnerDark + kInnerLight * std::max(0.0f, dot(n, lamp_));
                s.veil += boneColor() * (light * s.through);
                s.through = 0;
                return;
            }
            const float across = 1 - std::min(1.0f, -dot(n, along));
            const float opacity = kVeil + kEdge * across * across * across * across;
            const float key = std::max(0.0f, dot(n, lamp_));
            s.veil += boneColor() * ((0.62f + 0.38f * key) * opacity * s.through);
            // What lies behind is shaded along with the wall: the form of the bone shows, where
            // spheres have light and dark sides of their own.
            s.through *= (1 - opacity) * (layer == 0 ? 1 - kForm + kForm * key : 1);
            near = hit.t + 2e-5f;
        }
    }
    void addLight(int px, int py, int k, const V& origin, Sample& s) const {
        const std::uint32_t n =
            kSquare[static_cast<std::size_t>((py & 3) * 4 + (px & 3))] * kSamples +
            static_cast<std::uint32_t>(k);
        const auto lampPoint = sobol(n, 0x3c6ef372u, 0xa54ff53au);
        const auto skyPoint = sobol(n, 0x510e527fu, 0x9b05688cu);
        constexpr float kTurn = 2 * static_cast<float>(kPi);
        {
            const float r = kLamp * std::sqrt(lampPoint[0]), turn = kTurn * lampPoint[1];
            const V to =
                normalized(lamp_ + lampS_ * (r * std::cos(turn)) + lampT_ * (r * std::sin(turn)));
            if (dot(s.normal, to) <= 0) {
                s.lit = 0;
            } else {
                const float way = freeWay(origin, to);
                s.lit = way > 0 && bodies_.blocked(origin, to, way) ? 0.0f : 1.0f;
            }
        }
        const float r = std::sqrt(skyPoint[0]), turn = kTurn * skyPoint[1];
        V a, b;
        basis(s.normal, a, b);
        const V to = a * (r * std::cos(turn)) + b * (r * std::sin(turn)) +
                     s.normal * std::sqrt(std::max(0.0f, 1 - skyPoint[0]));
        const float way = std::min(ambient_, freeWay(origin, to));
        s.open = way > 0 && bodies_.blocked(origin, to, way) ? 0.0f : 1.0f;
    }

    const SpacePreview& scene_;
    const PreviewOptions options_;
    Local local_;
    PreviewCamera camera_;
    Device device_;
    RayScene bodies_, walls_;
    std::vector<std::array<float, 4>> spheres_;
    std::vector<std::int32_t> index_;  ///< in the pack; empty: the same
    std::vector<Color> colors_;
    std::unique_ptr<Surface> solid_, wall_;
    std::optional<PlaneDiscs> discs_;
    std::optional<PlaneLines> lines_;
    V eye_, right_, up_, toward_, lamp_, lampS_, lampT_, cutNormal_;
    float ambient_ = 2 * kAmbientShare;
    double pixel_ = 0;  ///< width of a pixel at distance one
};

/// Light of a few rays a pixel is speckled: it is averaged over the 4 x 4 pixels around (those at
/// the border by half), which hold all points of the sequence, among samples of about the same
/// plane and direction.
void smooth(const SpaceTracer& tracer, const std::vector<Sample>& samples, int columns, int rows,
            int x, int y, Sample& s) {
    const auto at = [&](int i, int j) {
        return (static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) +
                static_cast<std::size_t>(i)) *
               kSamples;
    };
    const float tolerance = 2.5f * static_cast<float>(tracer.footprint()) *
                            std::sqrt(dot(s.at - tracer.eye(), s.at - tracer.eye()));
    float open = 0, lit = 0, sum = 0;
    for (int j = std::max(0, y - kApron); j <= std::min(rows - 1, y + kApron); ++j)
        for (int i = std::max(0, x - kApron); i <= std::min(columns - 1, x + kApron); ++i) {
            const float share = (std::abs(i - x) == kApron ? 0.5f : 1.0f) *
                                (std::abs(j - y) == kApron ? 0.5f : 1.0f);
            const Sample* near = &samples[at(i, j)];
            for (int m = 0; m < kSamples; ++m, ++near) {
                if (!near->hit) continue;
                const float cosine = dot(near->normal, s.normal);
                if (cosine < 0.7f) continue;
                if (std::fabs(dot(near->at - s.at, s.normal)) > tolerance) continue;
                const float weight = share * (cosine - 0.65f);
                open += weight * near->open;
                lit += weight * near->lit;
                sum += weight;
            }
        }
    s.open = open / sum;
    s.lit = lit / sum;
}

void drawTile(const SpaceTracer& tracer, int x0, int y0, Image& image) {
    const int x1 = std::min(x0 + kTile, image.width), y1 = std::min(y0 + kTile, image.height);
    const int left = std::max(0, x0 - kApron), top = std::max(0, y0 - kApron);
    const int columns = std::min(image.width, x1 + kApron) - left;
    const int rows = std::min(image.height, y1 + kApron) - top;
    std::vector<Sample> samples(static_cast<std::size_t>(columns * rows) * kSamples);
    std::size_t next = 0;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            for (int k = 0; k < kSamples; ++k) samples[next++] = tracer.trace(left + i, top + j, k);
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            Color sum;
            for (int k = 0; k < kSamples; ++k) {
                const int i = x - left, j = y - top;
                Sample s = samples[static_cast<std::size_t>(j * columns + i) * kSamples +
                                   static_cast<std::size_t>(k)];
                Color behind{1, 1, 1};
                if (s.hit) {
                    if (s.shine > 0) smooth(tracer, samples, columns, rows, i, j, s);
                    behind = tracer.shade(s);
                }
                // Each sample within what can be shown, or a bright one would fray an edge.
                Color c = s.veil + behind * s.through;
                c = {std::min(c.r, 1.0f), std::min(c.g, 1.0f), std::min(c.b, 1.0f)};
                sum += c;
            }
            toSrgb(sum * (1.0f / kSamples), image.pixel(x, y));
        }
}

std::string titleOf(const SpacePreview& scene) {
    if (!scene.pack) return "a solid";
    return groupedCount(scene.pack->spheres.size()) + " spheres";
}

}  // namespace

bool canDrawSpace() {
    return true;
}

std::vector<std::int32_t> visibleSpheres(const SpacePreview& scene, const PreviewOptions& options) {
    SpacePreview spheres = scene;
    spheres.wall = spheres.solid = nullptr;
    StopRequest request(options.cancelled);
    const SpaceTracer tracer(spheres, options, request);
    std::vector<std::int32_t> seen(static_cast<std::size_t>(options.width) *
                                   static_cast<std::size_t>(options.height));
    tbb::parallel_for(0, options.height, [&](int y) {
        for (int x = 0; x < options.width; ++x)
            seen[static_cast<std::size_t>(y) * static_cast<std::size_t>(options.width) +
                 static_cast<std::size_t>(x)] = tracer.sphereAt(x + 0.5, y + 0.5);
    });
    return seen;
}

Image renderPreview(const SpacePreview& scene, const PreviewOptions& options) {
    try {
        checkScene(scene, options);
        SphereColors colors;
        if (scene.pack) colors = sphereColors(*scene.pack, options.color);
        StopRequest request(options.cancelled);
        SpaceTracer tracer(scene, options, request);
        tracer.colorBy(std::move(colors.color));
        Image image;
        image.width = options.width;
        image.height = options.height;
        image.pixels.resize(3 * static_cast<std::size_t>(image.width) *
                            static_cast<std::size_t>(image.height));
        const int columns = (image.width + kTile - 1) / kTile;
        const int rows = (image.height + kTile - 1) / kTile;
        tbb::parallel_for(0, columns * rows, [&](int tile) {
            request.stop();
            drawTile(tracer, tile % columns * kTile, tile / columns * kTile, image);
        });
        const ScaleBar bar = scaleBarFor(tracer.mmPerPixel(), image.width);
        drawScaleBar(bar, tracer.mmPerPixel(), image);
        std::string words = colors.words;
        const auto add = [&](const std::string& more) {
            words += (words.empty() ? "" : "; ") + more;
        };
        if (options.cut)
            add(fmt::format("cut at {0} = {1:g} mm, {2} {0} stays", "xyz"[options.cut->axis],
                            options.cut->at, keptSide(*options.cut) > 0 ? "higher" : "lower"));
        const V from = single(tracer.camera().toward);
        add(fmt::format("seen from ({:.2f}, {:.2f}, {:.2f})", from.x, from.y, from.z));
        add(fmt::format("scale bar {:g} mm in {} parts", bar.length, bar.parts));
        describe(titleOf(scene), words, image);
        return image;
    } catch (const std::bad_alloc&) {
        throw ResourceError("preview: not enough memory to draw this; leave --preview out");
    }
}

}  // namespace vdbpack
