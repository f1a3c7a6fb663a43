// Generates lists of voids: their positions, sizes and directions.
#pragma once

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/voids/orientation.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace vdbpack {

struct VoidMatrix;

/// Shape of voids: half-axis b, ratio a / b, and the direction of a.
template <int Dim>
struct VoidShape {
    SizeDistribution radius;  ///< b, mm
    SizeDistribution aspect;  ///< a / b
    std::shared_ptr<const Orientation<Dim>> orientation;

    /// The longest possible half-axis, mm.
    double reach() const { return radius.max() * std::max(1.0, aspect.max()); }
    double meanMeasure() const;  ///< mean volume (2D: area), mm^Dim
};

/// The part of the domain in which voids may lie: all that is deeper than the shell.
template <int Dim>
struct VoidRegion {
    const Domain<Dim>& domain;
    ShellThickness shell{};  ///< below the wall of `domain.envelope()`
    double volume() const;
};

/// Removes voids that cannot reach deeper than the shell.
template <int Dim>
void keepReaching(const VoidRegion<Dim>& region, std::vector<Ellipsoid<Dim>>& voids);

/// Ellipsoids at independent random positions, uniform over the box around the domain grown by the
/// longest half-axis (not along axes that wrap: there over the cell); those that cannot reach
/// deeper than the shell are left out.
///
/// A list of higher density begins with the voids of one of lower density. The expected share
/// outside of all voids is exp(-density * mean measure).
/// @param density  centers per mm^Dim.
/// @param share    of that density, from 0 to 1, at a center; empty: all of it.
/// Source: Chiu, Stoyan, Kendall, Mecke (2013), Stochastic Geometry, 3.1: the Boolean model.
template <int Dim>
std::vector<Ellipsoid<Dim>> booleanVoids(const VoidRegion<Dim>& region, const VoidShape<Dim>& shape,
                                         std::uint64_t seed, double density,
                                         const std::function<double(const Vec<Dim>&)>& share = {});

/// A lattice of boxes over a domain.
template <int Dim>
struct VoidLattice {
    Vec<Dim> origin;  ///< low corner of the first box, mm
    Vec<Dim> cell;    ///< sides of a box, mm
    std::array<std::int64_t, 3> count{1, 1, 1};
};

/// A lattice of boxes of the given sides, centered on the domain and covering it; without sides, as
/// many boxes as the matrix has cells.
/// @param wraps  axes along which the domain repeats: there the sides are those next to the given
///               ones of which a whole number makes its length.
/// @param cell   one side, or one for each direction, mm.
/// @throws ParameterError if a side is not positive, or their number is another.
template <int Dim>
VoidLattice<Dim> voidLattice(const Box<Dim>& bounds, const std::vector<double>& cell,
                             const VoidMatrix* matrix, const std::array<bool, Dim>& wraps = {});

/// The largest ellipsoid of revolution in each selected box, its axes along the sides.
/// @param matrix       selects boxes, repeated if it is smaller than the lattice; null: all.
/// @param probability  of keeping a selected box. The boxes kept at a smaller probability are a
///                     subset of those kept at a larger one.
template <int Dim>
std::vector<Ellipsoid<Dim>> latticeVoids(const VoidRegion<Dim>& region,
                                         const VoidLattice<Dim>& lattice, const VoidMatrix* matrix,
                                         double probability, std::uint64_t seed);

/// An ellipsoid at each sphere: inside it (a = radius, b = radius / aspect) or about it
/// (b = radius, a = radius * aspect).
template <int Dim>
std::vector<Ellipsoid<Dim>> voidsAtSpheres(const std::vector<Sphere<Dim>>& spheres, bool inside,
                                           const VoidShape<Dim>& shape, std::uint64_t seed);

/// Shuffles a list, the same for the same seed.
template <int Dim>
void shuffle(std::vector<Ellipsoid<Dim>>& voids, std::uint64_t seed);

}  // namespace vdbpack
