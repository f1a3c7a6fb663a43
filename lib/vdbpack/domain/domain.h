// The region that is filled: inside tests, clearance to the wall, integrals.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/vec.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

struct DepthRange;
struct RepairReport;
class VdbGrid;

/// The point of the wall nearest to a query point.
template <int Dim>
struct WallPoint {
    Vec<Dim> point;       ///< on the wall, mm
    double distance = 0;  ///< from the query point, mm, >= 0
};

/// Queries a domain from one thread; keeps that thread's caches.
template <int Dim>
class DomainSampler {
public:
    virtual ~DomainSampler() = default;

    /// Estimate of the distance to the wall, mm: negative inside, positive outside, clamped to
    /// the width of the field. One lookup. Exact for analytic shapes; for meshes the field's
    /// trilinear value, off by about a voxel at worst near the wall.
    virtual double signedDistance(const Vec<Dim>& x) = 0;

    /// Certain bounds of the depth of `x`, where they are closer than the error of
    /// `signedDistance`; by default none. A little slower than that.
    virtual DepthRange depthRange(const Vec<Dim>& x);

    /// Whether `x` is inside, by the wall itself: in gaps narrower than a voxel, a field may take
    /// the outside for inside. Slower than `signedDistance`. A front needs it only where it starts,
    /// since what touches a sphere inside is inside.
    virtual bool contains(const Vec<Dim>& x) { return signedDistance(x) < 0; }

    /// The wall point nearest to `x`, if one is closer than `reach`: exact to rounding (for a
    /// mesh, by its triangles). Does not depend on the side that `x` is on.
    /// @return false, `wall` untouched, if no wall is closer than `reach`.
    virtual bool nearestWall(const Vec<Dim>& x, double reach, WallPoint<Dim>& wall) = 0;

    /// Appends the nearest point of every smooth piece of wall (a face of a box, a triangle) that
    /// is closer to `x` than `reach`, in no order; some may be repeated. By default the nearest
    /// point of all alone.
    virtual void wallsWithin(const Vec<Dim>& x, double reach, std::vector<WallPoint<Dim>>& points) {
        WallPoint<Dim> wall;
        if (nearestWall(x, reach, wall)) points.push_back(wall);
    }

    /// Whether any wall is closer than `reach`: as `nearestWall`, but faster.
    virtual bool isWallCloser(const Vec<Dim>& x, double reach) {
        WallPoint<Dim> wall;
        return nearestWall(x, reach, wall);
    }
};

/// Facts for a report; zero where they do not apply.
struct DomainFacts {
    std::string kind;  ///< "mesh", "levelset", "box", "ball", "cylinder", "rect", "disc", "slice",
                       ///< "periodic", ...
    std::uint64_t triangles = 0;
    double meshVolume = 0;  ///< mm³, without cavities
    double voxelSize = 0;   ///< mm
    std::uint64_t activeVoxels = 0;
    std::uint64_t boundaryEdges = 0;
    std::uint64_t nonManifoldEdges = 0;
    std::shared_ptr<const RepairReport> repair;  ///< of the mesh; null: it was not repaired
};

/// A bounded region of the plane or of space. Immutable, shared between threads; each thread
/// queries it through a sampler of its own.
template <int Dim>
class Domain {
public:
    virtual ~Domain() = default;

    /// A box around the domain, mm.
    virtual Box<Dim> bounds() const = 0;
    /// Volume (2D: area), mm^Dim.
    virtual double volume() const = 0;
    /// The center of its volume, mm; nothing where the domain does not know it: a mesh with flaws.
    virtual std::optional<Vec<Dim>> centroid() const { return std::nullopt; }
    /// Area of the wall (2D: its length, the perimeter), mm^(Dim-1).
    virtual double wallArea() const = 0;
    /// Volume (2D: area) of the part farther than `depth` >= 0 from the wall, mm^Dim.
    /// Exact for plain shapes, else from the field (`depth` within its width).
    virtual double volumeDeeperThan(double depth) const = 0;
    /// The same of several depths, which ascend; in one pass where a field has them.
    virtual std::vector<double> volumesDeeperThan(const std::vector<double>& depths) const {
        std::vector<double> volumes;
        for (const double depth : depths)
            volumes.push_back(!volumes.empty() && volumes.back() == 0 ? 0
                                                                      : volumeDeeperThan(depth));
        return volumes;
    }
    /// Largest depth up to which `signedDistance` is not clamped, mm; infinity for shapes.
    virtual double fieldDepth() const = 0;
    virtual std::unique_ptr<DomainSampler<Dim>> sampler() const = 0;
    virtual DomainFacts facts() const = 0;
    /// The cell in which it repeats: its box is `bounds()`, and there are no walls along the axes
    /// that wrap. Samplers answer for points beyond its faces as for their images. By default no
    /// axis wraps.
    virtual PeriodicCell<Dim> cell() const { return {}; }
    /// The domain whose wall a shell is measured from: this one, or a larger one around it, such
    /// as the same with its cavities filled. Lives as long as this one.
    virtual const Domain& envelope() const { return *this; }

    /// `signedDistance` of many points, in parallel. @return one value per point, mm.
    std::vector<double> signedDistances(const std::vector<Vec<Dim>>& points) const;
};

/// The thickness of the layer along the wall of a domain's envelope, mm. A point belongs to the
/// shell if its depth below that wall is not larger than the thickness at the point itself.
class ShellThickness {
public:
    /// The same everywhere; 0: there is no shell. Converts from a thickness in mm.
    ShellThickness(double uniform = 0) : least_(uniform), most_(uniform) {}
    /// @param at           thickness by place, from `least` to `most`; thread-safe.
    /// @param sliceHeight  2D: height of the plane, mm.
    ShellThickness(std::function<double(const Vec<3>&)> at, double least, double most,
                   double sliceHeight = 0)
        : at_(std::move(at)), least_(least), most_(most), sliceHeight_(sliceHeight) {}

    /// Whether there is a shell anywhere.
    bool any() const { return most_ > 0; }
    bool isUniform() const { return !at_; }
    double least() const { return least_; }
    double most() const { return most_; }
    double at(const Vec<3>& x) const { return at_ ? at_(x) : most_; }
    double at(const Vec<2>& x) const { return at({{x[0], x[1], sliceHeight_}}); }
    /// Whether a point at a depth (mm) lies deeper; seeks the thickness only where that matters.
    template <int Dim>
    bool isDeeper(const Vec<Dim>& x, double depth) const {
        return depth > most_ || (depth > least_ && depth > at(x));
    }

private:
    std::function<double(const Vec<3>&)> at_;
    double least_ = 0, most_ = 0, sliceHeight_ = 0;
};

/// A domain as narrow-band level set: three voxels on both sides, named `surface`. From the
/// triangles where the domain is a mesh; else (shapes, clipped domains) from the distances that its
/// sampler returns, which outside of edges are lower bounds. Of a periodic cell it is the box,
/// closed at its faces.
///
/// @param voxelSize  mm.
/// @throws ParameterError unless the voxel size is positive; ResourceError if memory does not
/// suffice.
std::shared_ptr<const VdbGrid> surfaceLevelSet(const Domain<3>& domain, double voxelSize);

}  // namespace vdbpack
