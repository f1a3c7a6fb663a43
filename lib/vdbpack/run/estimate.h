// What a run will give and take, estimated before its work: spheres, voids, time, memory, disk
// space. One model for dry runs and for refusals; its errors: assets/guides/reliability.md.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/report/report.h"
#include "vdbpack/run/recipe.h"
#include "vdbpack/run/run.h"

#include <limits>
#include <string>
#include <vector>

namespace vdbpack {

/// Voids as far as memory and time depend on them. Lengths in mm.
struct VoidExtent {
    double count = 0;      ///< 0: none
    double half = 0;       ///< mean half-axis b
    double wall = 0;       ///< area (2D: length) of their walls outside of other voids
    double voxelSize = 0;  ///< of their level sets
    double reach = 0;      ///< as `StampOptions::reach`
    double left = 1;       ///< share of the domain that lies outside of all voids
    bool foam = false;     ///< made from a pack of as many spheres
};

/// What is known of a run, or expected. Lengths in mm.
struct Extent {
    int dim = 3;
    double count = 0;         ///< spheres before voids are cut, with the spheres of an input pack
    double kept = 1;          ///< share of them that voids leave
    bool searching = false;   ///< for a target count: packs are made until it is met
    bool densifying = false;  ///< spheres are moved, and further ones added
    bool solid = false;       ///< the spheres fill what the voids leave, inside its contour
    double volume = 0;        ///< of the domain, mm^dim
    double area = 0;          ///< of its wall, mm^(dim-1)
    FieldPlan field;          ///< without triangles: the domain is a shape
    VoidExtent voids;
    bool isBox = false;      ///< the domain, a box along the axes
    double boxVolume = 0;    ///< of the bounds of the domain in space, mm³
    double shapeVoxel = 0;   ///< of the level set of a shape, if one is written; 0: a file
    double imageVoxels = 0;  ///< of the image in which a solid is measured
    double solidVoxels = 0;  ///< of that for `measureSolid`
    double labelVoxels = 0;  ///< of the label maps that are written
};

/// The extent of a domain whose field `DomainSource::build` is to make for such radii.
Extent extentOf(const DomainSource& source, double detail, double reach, double voxelSize = 0);

/// Adds the voids that a recipe specifies, or that its target needs, to a domain with spheres.
/// @param largestRadius  of the spheres, mm; 0: none.
void addVoids(Extent& extent, const VoidRecipe& recipe, double largestRadius);

/// For which radii the field of a pack is made, mm, and about what its sizes are scaled by. A
/// search for a target count starts from these, so that other values would change packs.
struct FieldRadii {
    double scale = 1, detail = 0, reach = 0;
    double share = 1;  ///< of the domain (`Fill::solid`) or of the spheres that voids leave, about
};

/// What to expect of a pack before it is made.
struct PackPlan {
    RequestedSizes requested;
    FieldRadii radii{};
    Extent extent{};
    double count = 0;          ///< spheres, with the existing ones
    double existing = 0;       ///< of these
    double solidFraction = 0;  ///< of the domain, with existing spheres
    bool densified = true;     ///< whether `densify` reaches its solid fraction
    double scale = 1;          ///< of the radii, for a target count
    /// The largest radius that fits, where the domain is thin for the radii, mm.
    double room = std::numeric_limits<double>::infinity();
    Report::Seconds seconds{};  ///< of one processor, without reading and writing
};
/// @param closer  also reads existing spheres, and makes the domain if it is clipped, sliced, or
///                thin, or sizes differ by place in it, unless its field takes more than a second.
/// @throws as `requireShell` and `requireRepeating`.
PackPlan planPack(const PackRecipe& recipe, const DomainSource& source, bool closer = false);

/// Bytes at the peak of stamping voids, with their level sets.
double stampBytes(const Extent& extent);
/// Triangles of the contour that voids leave of a domain, about.
double contourTriangles(const Extent& extent);

/// The estimate for a run of this extent with the outputs and the picture of `settings`: over
/// ranks, the memory of one of them.
Estimate estimate(const Extent& extent, const RunSettings& settings);

/// Refuses a run of this extent with these settings whose estimate exceeds memory or disk space.
/// @throws ResourceError
void requireResources(const Extent& extent, const RunSettings& settings);

}  // namespace vdbpack
