// Private to previews: finds what a ray through a pixel hits, and the light at that point.
#pragma once

#include "vdbpack/preview/color.h"
#include "vdbpack/preview/ray_scene.h"
#include "vdbpack/preview/scene.h"
#include "vdbpack/preview/section.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace vdbpack {

/// What is seen at a point of the picture.
struct Sample {
    bool hit = false;
    bool flat = false;       ///< on a cut face: drawn without light
    std::uint64_t body = 0;  ///< the same for all points of a sphere, a disc, or the solid; 0: none
    Float3 at, normal;       ///< the normal points to the camera's side
    Float3 origin;           ///< of rays to lamp and sky
    Color albedo;

    bool takesLight() const { return hit && !flat; }
    float open = 1;     ///< visible share of the sky
    float lit = 1;      ///< visible share of the lamp
    Color veil;         ///< light of the wall in front
    float through = 1;  ///< transmittance of the wall
};

class SpaceTracer {
public:
    /// @param options  as `facingCut` returns them.
    SpaceTracer(const SpacePreview& scene, const PreviewOptions& options,
                const PreviewCamera& camera, StopRequest& request);

    const PreviewCamera& camera() const { return camera_; }
    double mmPerPixel() const { return pixel_ * camera_.target; }

    void colorBy(std::vector<Color> colors) { colors_ = std::move(colors); }

    /// The sphere seen through a point of the picture; -1: none.
    std::int32_t sphereAt(double x, double y) const;

    /// A point of the picture, pixels, and the point of a sequence for the light there.
    struct Spot {
        double x = 0, y = 0;
        std::uint32_t point = 0;
        Sample* sample = nullptr;  ///< written in place: copying samples takes a tenth of the time
        const Sample* near = nullptr;  ///< whose veil it has where both see a body; null: its own
        float share = 1;               ///< of its light that one ray to lamp and sky each finds
    };
    /// Rays to lamp and sky each from a point, of which the pixels around have others: broad
    /// surfaces show fewer steps of light than spheres.
    int lightRays() const { return solid_ ? 4 : 2; }
    /// Finds what is seen at up to `kTogether` spots, whose samples are empty.
    void see(const Spot* spots, int count) const;
    /// Casts a ray to the lamp and one to the sky from those that take light.
    void light(const Spot* spots, int count) const;

    Color shade(const Sample& s) const;

    /// Distance within which points around one lie in about the same plane: 2.5 pixels.
    float planeTolerance(const Float3& at) const {
        return 2.5f * static_cast<float>(pixel_) * std::sqrt(dot(at - eye_, at - eye_));
    }

private:
    /// The start of a ray: at the cut face, or at the eye.
    struct Start {
        bool sees = true;  ///< false: the ray never reaches the part that is kept
        float t = 0;
        Vec<3> at;  ///< on the cut face, mm
    };
    /// The direction of the ray through a point of the picture, in pixels.
    inline Vec<3> directionAt(double x, double y) const;
    inline Start startOf(const Vec<3>& direction) const;

    void addSpheres(const Pack<3>& pack);
    std::int32_t indexOf(unsigned primitive) const {
        return index_.empty() ? static_cast<std::int32_t>(primitive) : index_[primitive];
    }
    /// Width of the dark rim of a cut face, mm.
    double rimOf(std::int32_t index) const;
    /// The length of a ray within the part that a cut keeps.
    inline float freeWay(const Float3& from, const Float3& along) const;
    /// A point of the cut face, drawn without light.
    inline void showCut(const Start& start, const Color& color, std::uint64_t body,
                        Sample& s) const;
    /// The line of the wall or the disc of a sphere at the cut face. @return whether there is one.
    inline bool showSection(const Start& start, Sample& s) const;
    /// The surface of a body where a ray hits it. @return false: it is seen from within, at its cut
    /// face.
    inline bool showBody(const Hit& hit, const Float3& along, Sample& s) const;
    /// Adds the wall along rays that end at their hits, or behind everything if they start inside.
    void addVeil(Rays rays, const Spot* spots) const;
    /// One layer of it. @return whether there may be another one behind
    inline bool addLayer(int layer, const Hit& hit, const Float3& along, Sample& s) const;
    const SpacePreview& scene_;
    const PreviewOptions options_;
    Local local_;
    PreviewCamera camera_;
    Device device_;
    RayScene bodies_, walls_;
    std::vector<std::array<float, 4>> spheres_;
    std::vector<std::int32_t> index_;  ///< of `spheres_` in the pack; empty: the same
    std::vector<Color> colors_;
    std::unique_ptr<Surface> solid_, wall_;
    std::optional<PlaneDiscs> discs_;
    std::optional<PlaneLines> lines_;
    Float3 eye_, right_, up_, toward_, lamp_, lampS_, lampT_, cutNormal_;
    float ambient_ = 0;  ///< reach of ambient occlusion
    double pixel_ = 0;   ///< width of a pixel at distance one
};

}  // namespace vdbpack
