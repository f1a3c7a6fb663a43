// Solids described by signed distances: swept tubes, ellipsoids and bent plates, joined smoothly.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/vec.h"

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace vdbpack {

/// A solid by its signed distance, negative inside. Away from the surface the value may differ
/// from the true distance; only its sign and its zero set must be exact.
///
/// Only +, -, *, / and square roots are used, so that every processor computes the same bits.
class Shape {
public:
    virtual ~Shape() = default;
    virtual double distance(const Vec<3>& p) const = 0;
    /// A box around the solid, mm.
    virtual Box<3> bounds() const = 0;
};

using ShapePtr = std::shared_ptr<const Shape>;

/// A right-handed orthonormal frame: `z` along `along`, `x` as close to `across` as possible.
struct Frame {
    Vec<3> x, y, z;

    /// `across` must not be parallel to `along`; neither needs length one.
    static Frame of(const Vec<3>& along, const Vec<3>& across);
};

/// An ellipsoid with semi-axes `radii` (mm) along the axes of `frame`.
ShapePtr ellipsoid(const Vec<3>& center, const Vec<3>& radii,
                   const Frame& frame = {{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}});

/// One cross-section of a tube. `across` gives the direction of the width and need not be
/// perpendicular to the tube.
struct Section {
    Vec<3> center;     ///< mm
    double halfWidth;  ///< along `across`, mm
    double halfDepth;  ///< perpendicular to it and to the tube, mm
    Vec<3> across{{{1, 0, 0}}};
};

enum class Profile {
    kEllipse,
    kStadium,  ///< a strip with round edges; for flat parts
};

/// Sections joined along a Catmull-Rom spline, with round ends; two or more are needed.
ShapePtr tube(const std::vector<Section>& sections, Profile profile = Profile::kEllipse);

/// A round tube.
struct Bead {
    Vec<3> center;  ///< mm
    double radius;  ///< mm
};
ShapePtr roundTube(const std::vector<Bead>& beads);

/// A sheet over a plane: outline in the plane's coordinates (u, v), bent and thickened.
struct Plate {
    Vec<3> origin;
    Frame frame;                                   ///< u along x, v along y, height along z
    std::vector<std::array<double, 2>> outline;    ///< closed, smoothed by a Catmull-Rom spline, mm
    std::function<double(double, double)> height;  ///< of the middle surface, mm
    std::function<double(double, double)> halfThickness;  ///< mm, > 0
};
ShapePtr plate(const Plate& plate);

/// How a shape changes a sculpture.
enum class Join { kAdd, kCut };

/// Shapes added to and cut from one another in order, each with a rounded seam.
class Sculpture {
public:
    /// @param mirrored  the solid is symmetric in x; shapes describe the side x >= 0.
    explicit Sculpture(bool mirrored = false) : mirrored_(mirrored) {}

    /// `blend` is the width of the seam's rounding, mm; 0 leaves an edge.
    Sculpture& add(ShapePtr shape, double blend) { return join(Join::kAdd, shape, blend); }
    Sculpture& cut(ShapePtr shape, double blend) { return join(Join::kCut, shape, blend); }
    Sculpture& join(Join how, ShapePtr shape, double blend);

    double distance(const Vec<3>& p) const;
    Vec<3> gradient(const Vec<3>& p) const;
    /// A box around everything that was added, mm.
    Box<3> bounds() const;

private:
    struct Step {
        Join how;
        ShapePtr shape;
        double blend;
        Box<3> bounds;
    };
    bool mirrored_;
    std::vector<Step> steps_;
};

/// A finished sculpture as a shape of another one, its surface moved inward by `inset` mm.
ShapePtr insetOf(std::shared_ptr<const Sculpture> sculpture, double inset);

}  // namespace vdbpack
