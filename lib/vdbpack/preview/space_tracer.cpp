#include "vdbpack/preview/space_tracer.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/preview/sphere_colors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

/// Light: a wide lamp at the upper left behind the camera, the sky, a little from the camera, and
/// highlights.
constexpr float kKey = 0.62f, kSky = 0.56f, kFill = 0.06f, kShine = 0.10f;
/// Tangent of half the angular size of the lamp, which makes shadows soft.
constexpr float kLamp = 0.11f;
/// Reach of ambient occlusion: in mean radii, and as a share of the size of the scene.
constexpr float kAmbientRadii = 7, kAmbientShare = 0.05f;
/// Opacity of the wall seen head-on, added opacity edge-on, and the number of layers drawn.
constexpr float kVeil = 0.07f, kEdge = 0.6f;
constexpr int kLayers = 2;
/// Darkening of what is behind the wall where the wall faces away from the lamp.
constexpr float kForm = 0.25f;
/// Light on the inner side of the wall of a cut bone.
constexpr float kInnerDark = 0.2f, kInnerLight = 0.2f;
/// Half the width of the line where a cut intersects the wall, and the rim of cut faces, pixels.
constexpr double kWallLine = 1.25, kRim = 0.9;
/// Largest share of a disc's radius for its rim.
constexpr double kLargestRim = 0.14;
constexpr float kRimShade = 0.5f;
/// Numbers of bodies: spheres from one, then discs, then these.
constexpr std::uint64_t kDiscs = std::uint64_t{1} << 32, kCutLine = 2 * kDiscs,
                        kSolidBody = kCutLine + 1, kSolidCut = kCutLine + 2;

float square(float x) {
    return x * x;
}

constexpr float kFar = std::numeric_limits<float>::infinity();

}  // namespace

SpaceTracer::SpaceTracer(const SpacePreview& scene, const PreviewOptions& options,
                         const PreviewCamera& camera, StopRequest& request)
    : scene_(scene),
      options_(options),
      local_(checkScene(scene, options)),
      camera_(camera),
      bodies_(device_),
      walls_(device_),
      ambient_(2 * kAmbientShare) {
    eye_ = local_(camera_.position);
    right_ = single(camera_.right);
    up_ = single(camera_.up);
    toward_ = single(camera_.toward);
    lamp_ = normalized(right_ * -0.5f + up_ * 0.75f + toward_ * 0.75f);
    basis(lamp_, lampS_, lampT_);
    pixel_ = 2 * camera_.tanX / camera_.width;
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

inline float SpaceTracer::freeWay(const Float3& from, const Float3& along) const {
    if (!options_.cut) return std::numeric_limits<float>::infinity();
    const double out = dot(along, cutNormal_);
    if (!(out > 0)) return std::numeric_limits<float>::infinity();
    const double depth = keptDepth(*options_.cut, local_.inMm(from)) * local_.scale;
    return static_cast<float>(depth / out);
}

inline Vec<3> SpaceTracer::directionAt(double x, double y) const {
    return camera_.direction(2 * x / camera_.width - 1, 2 * y / camera_.height - 1);
}

inline SpaceTracer::Start SpaceTracer::startOf(const Vec<3>& direction) const {
    Start start;
    if (!options_.cut) return start;
    const int axis = options_.cut->axis;
    const Vec<3> along = vdbpack::normalized(direction);
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

std::int32_t SpaceTracer::sphereAt(double x, double y) const {
    const Vec<3> direction = directionAt(x, y);
    const Start start = startOf(direction);
    if (!start.sees) return -1;
    if (discs_) {
        const auto found = discs_->at(CutAxes(options_.cut->axis).flat(start.at));
        if (found.index >= 0) return found.index;
    }
    Rays ray;
    ray.set(0, eye_, normalized(single(direction)), start.t, kFar);
    const Hit hit = bodies_.first(ray)[0];
    return hit.geometry == RayScene::kSpheres ? indexOf(hit.primitive) : -1;
}

inline void SpaceTracer::showCut(const Start& start, const Color& color, std::uint64_t body,
                                 Sample& s) const {
    s.hit = s.flat = true;
    s.body = body;
    s.normal = cutNormal_;
    s.at = local_(start.at);
    s.albedo = color;
}

inline bool SpaceTracer::showSection(const Start& start, Sample& s) const {
    if (!options_.cut) return false;
    const Vec<2> flat = CutAxes(options_.cut->axis).flat(start.at);
    if (lines_ && lines_->distance(flat) < kWallLine * mmPerPixel()) {
        showCut(start, inkColor(), kCutLine, s);
        return true;
    }
    if (!discs_) return false;
    const auto found = discs_->at(flat);
    if (found.index < 0) return false;
    const Color color = colors_[static_cast<std::size_t>(found.index)];
    showCut(start, color * (found.rim < rimOf(found.index) ? kRimShade : 1),
            kDiscs + static_cast<std::uint32_t>(found.index), s);
    return true;
}

inline bool SpaceTracer::showBody(const Hit& hit, const Float3& along, Sample& s) const {
    s.hit = true;
    s.at = eye_ + along * hit.t;
    if (hit.geometry == RayScene::kSpheres) {
        const auto& ball = spheres_[hit.primitive];
        const Float3 center{ball[0], ball[1], ball[2]};
        s.body = 1 + std::uint64_t{hit.primitive};
        s.albedo = colors_[static_cast<std::size_t>(indexOf(hit.primitive))];
        s.normal = normalized(s.at - center);
        // Hit from behind: by rounding, the ray started inside at the rim of a cut face.
        if (options_.cut && dot(s.normal, along) > 0) {
            s.albedo = s.albedo * kRimShade;
            return false;
        }
        s.at = center + s.normal * ball[3];
        s.origin = center + s.normal * (ball[3] * 1.0005f + 2e-6f);
        return true;
    }
    s.body = kSolidBody;
    Float3 facet = normalized(hit.normal);
    if (dot(facet, along) > 0) {
        s.albedo = boneCutColor();
        if (options_.cut) {  // the ray starts inside the body
            s.body = kSolidCut;
            return false;
        }
        facet = -facet;
    }
    s.albedo = boneColor();
    s.normal = solid_->normalAt(hit);
    if (dot(s.normal, facet) < 0) s.normal = -s.normal;
    s.origin = s.at + facet * 2e-5f;
    return true;
}

void SpaceTracer::see(const Spot* spots, int count) const {
    std::array<Start, kTogether> starts;
    Rays rays;
    for (int k = 0; k < count; ++k) {
        const auto n = static_cast<std::size_t>(k);
        const Vec<3> direction = directionAt(spots[k].x, spots[k].y);
        starts[n] = startOf(direction);
        if (starts[n].sees && !showSection(starts[n], *spots[k].sample))
            rays.set(k, eye_, normalized(single(direction)), starts[n].t, kFar);
    }
    const auto hits = bodies_.first(rays);
    for (int k = 0; k < count; ++k) {
        const auto n = static_cast<std::size_t>(k);
        if (!rays.has(k)) continue;
        const Float3 along = rays.along(k);
        Sample& s = *spots[k].sample;
        if (hits[n].any() && !showBody(hits[n], along, s)) {
            showCut(starts[n], s.albedo, s.body, s);
            rays.drop(k);
            continue;
        }
        if (const Sample* near = spots[k].near; near && near->hit && s.hit) {
            s.veil = near->veil, s.through = near->through;
            rays.drop(k);
        } else {
            rays.set(k, eye_, along, starts[n].t, hits[n].t);
        }
    }
    if (wall_) addVeil(rays, spots);
}

Color SpaceTracer::shade(const Sample& s) const {
    const Float3 toEye = normalized(eye_ - s.at);
    const float key = std::max(0.0f, dot(s.normal, lamp_));
    const float sky = 0.72f + 0.28f * s.normal.z;
    const Float3 half = normalized(toEye + lamp_);
    const float c2 = square(std::max(0.0f, dot(s.normal, half))), c8 = square(square(c2));
    const float gloss = square(square(c8)) * c8 * kShine;  // c to the power of 40
    const float light = kKey * key * s.lit + kSky * sky * s.open +
                        kFill * std::max(0.0f, dot(s.normal, toEye)) * s.open;
    Color c = s.albedo * (s.flat ? 0.95f : light);
    if (!s.flat && gloss > 0) c += Color{1, 1, 1} * (gloss * s.lit * (key > 0 ? 1.0f : 0.0f));
    return c;
}

void SpaceTracer::addSpheres(const Pack<3>& pack) {
    double sum = 0;
    spheres_.reserve(pack.spheres.size());
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const auto& s = pack.spheres[i];
        if (options_.cut && !(keptDepth(*options_.cut, s.center) > -s.radius)) continue;
        const Float3 c = local_(s.center);
        spheres_.push_back({c.x, c.y, c.z, static_cast<float>(s.radius * local_.scale)});
        if (options_.cut) index_.push_back(static_cast<std::int32_t>(i));
        sum += s.radius;
    }
    if (!spheres_.empty())
        ambient_ = std::max(
            ambient_, kAmbientRadii * static_cast<float>(sum * local_.scale /
                                                         static_cast<double>(spheres_.size())));
}

double SpaceTracer::rimOf(std::int32_t index) const {
    const Sphere<3>& s = scene_.pack->spheres[static_cast<std::size_t>(index)];
    return std::min(kRim * mmPerPixel(), kLargestRim * s.radius);
}

inline bool SpaceTracer::addLayer(int layer, const Hit& hit, const Float3& along, Sample& s) const {
    Float3 n = wall_->normalAt(hit);
    const bool inner = layer == 0 && options_.cut && dot(hit.normal, along) > 0;
    if (dot(n, along) > 0) n = -n;
    if (inner && !s.hit) {
        // The far side of a cut bone: drawn opaque, to close the view behind the pack.
        const float light = kInnerDark + kInnerLight * std::max(0.0f, dot(n, lamp_));
        s.veil += boneColor() * (light * s.through);
        s.through = 0;
        return false;
    }
    const float across = 1 - std::min(1.0f, -dot(n, along));
    const float opacity = kVeil + kEdge * across * across * across * across;
    const float key = std::max(0.0f, dot(n, lamp_));
    s.veil += boneColor() * ((0.62f + 0.38f * key) * opacity * s.through);
    // What is behind is shaded like the wall: this shows the form of the bone, which the shading of
    // single spheres would hide.
    s.through *= (1 - opacity) * (layer == 0 ? 1 - kForm + kForm * key : 1);
    return true;
}

void SpaceTracer::addVeil(Rays rays, const Spot* spots) const {
    for (int layer = 0; layer < kLayers; ++layer) {
        const auto hits = walls_.first(rays);
        for (int k = 0; k < kTogether; ++k) {
            const Hit& hit = hits[static_cast<std::size_t>(k)];
            if (hit.any() && addLayer(layer, hit, rays.along(k), *spots[k].sample))
                rays.startAt(k, hit.t + 2e-5f);
            else
                rays.drop(k);
        }
    }
}

void SpaceTracer::light(const Spot* spots, int count) const {
    constexpr float kTurn = 2 * static_cast<float>(kPi);
    Rays toLamp, toSky;
    for (int k = 0; k < count; ++k) {
        Sample& s = *spots[k].sample;
        if (!s.takesLight()) continue;
        const auto lampPoint = sobol(spots[k].point, 0x3c6ef372u, 0xa54ff53au);
        float r = kLamp * std::sqrt(lampPoint[0]), turn = kTurn * lampPoint[1];
        Float3 to =
            normalized(lamp_ + lampS_ * (r * std::cos(turn)) + lampT_ * (r * std::sin(turn)));
        if (dot(s.normal, to) <= 0)
            s.lit -= spots[k].share;
        else if (const float way = freeWay(s.origin, to); way > 0)
            toLamp.set(k, s.origin, to, 0, way);
        const auto skyPoint = sobol(spots[k].point, 0x510e527fu, 0x9b05688cu);
        r = std::sqrt(skyPoint[0]), turn = kTurn * skyPoint[1];
        Float3 a, b;
        basis(s.normal, a, b);
        to = a * (r * std::cos(turn)) + b * (r * std::sin(turn)) +
             s.normal * std::sqrt(std::max(0.0f, 1 - skyPoint[0]));
        if (const float way = std::min(ambient_, freeWay(s.origin, to)); way > 0)
            toSky.set(k, s.origin, to, 0, way);
    }
    const auto dark = bodies_.blocked(toLamp), closed = bodies_.blocked(toSky);
    for (int k = 0; k < count; ++k) {
        if (dark[static_cast<std::size_t>(k)]) spots[k].sample->lit -= spots[k].share;
        if (closed[static_cast<std::size_t>(k)]) spots[k].sample->open -= spots[k].share;
    }
}

}  // namespace vdbpack
