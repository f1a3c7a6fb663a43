#include "vdbpack/run/void_plan.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/run/memory_estimate.h"
#include "vdbpack/voids/make_voids.h"
#include "vdbpack/voids/structure_fit.h"
#include "vdbpack/voids/tile_lattice.h"
#include "vdbpack/voids/void_list.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace vdbpack {

namespace {

/// Bytes of a leaf of the level sets `surface`, `voids` and `solid` and the tile it is made from.
constexpr double kBytesPerLeaf = 6000;

double meanOf(const SizeRequest& sizes, int dim, double otherwise) {
    return sizes.empty() ? otherwise : sizes.in(dim).mean();
}

/// Area of an ellipsoid with half-axes a, b, b (2D: length of an ellipse), to about a tenth.
double surfaceArea(int dim, double a, double b) {
    return dim == 3 ? 4 * kPi * b * (2 * a + b) / 3 : kPi * (a + b);
}

/// The share of walls that lies outside of other voids of this volume, by the Boolean model.
double shareOutside(double voids, const Extent& e) {
    return std::exp(-voids / e.volume);
}

/// The same of a foam, for its spheres before their dilation, with a tenth more than was measured
/// at a BV/TV from 0.07 to 0.47.
double openWalls(double bvtv) {
    return std::min(0.7, 1.1 * std::pow(bvtv / 0.36, 0.6));
}

template <int Dim>
VoidExtent listed(const VoidRecipe& recipe, const Extent& e) {
    // A pipe can be read once only, when the voids are made.
    const std::string& file = recipe.as<ListedVoids>()->file;
    if (std::error_code failed; !std::filesystem::is_regular_file(file, failed)) return {};
    const auto list = readVoidList<Dim>(file);
    if (list.empty()) return {};
    VoidExtent plan;
    plan.count = static_cast<double>(list.size());
    double volume = 0;
    for (const auto& v : list) {
        plan.wall += surfaceArea(Dim, v.a, v.b);
        volume += v.volume();
    }
    plan.left = shareOutside(volume, e);
    plan.wall *= plan.left;
    plan.voxelSize = voidVoxelFor(recipe, leastHalfAxis(list));
    return plan;
}

/// Voids with mean half-axes a and b by a method that makes them.
VoidExtent planned(const VoidRecipe& r, const Extent& e, double a, double b) {
    const auto ball = [&](double radius) {
        return e.dim == 3 ? Measure<3>::ball(radius) : Measure<2>::ball(radius);
    };
    const double each = ball(b) * a / b;
    // The Boolean model's number for a target.
    const auto target = targetBvtvOf(r);
    const double needed = -std::log(target.value_or(kDefaultBvtv)) * e.volume / each;
    VoidExtent plan;
    bool apart = true;
    if (r.as<GridVoids>()) {
        plan.count = e.volume / std::pow(2 * b, e.dim);
    } else if (const auto* overlay = r.as<OverlayVoids>()) {
        const double most = 0.6 * e.volume / ball(std::max(a, b));
        plan.count = std::min(most, overlay->count.value_or(most));
    } else if (const auto* holes = r.as<FrontHoles>()) {
        plan.count = target ? needed : holes->probability.value_or(kDefaultProbability) * e.count;
    } else if (const auto* boolean = r.as<BooleanVoids>()) {
        plan.count = target ? needed : boolean->count.value_or(needed);
        apart = false;
    } else {  // a foam: as a dense pack, whose holes are walls all around
        plan.count = plan.packed = 0.64 * e.volume / each;
        apart = false;
    }
    const double share = plan.count * each / e.volume;
    plan.left = apart ? std::max(0.0, 1 - share) : shareOutside(plan.count * each, e);
    const bool foam = plan.packed > 0;
    if (foam) plan.left = target.value_or(kDefaultBvtv);
    const double open = foam ? openWalls(plan.left) : plan.left;
    plan.wall = plan.count * surfaceArea(e.dim, a, b) * (apart ? 1 : open);
    plan.voxelSize = plannedVoxel(r, e.dim);
    if (!(plan.voxelSize > 0)) plan.voxelSize = voidVoxelFor(r, 0.75 * std::min(a, b));
    return plan;
}

}  // namespace

VoidExtent planVoids(const VoidRecipe& asked, const Extent& e, double largestRadius) {
    const VoidRecipe r = usualFoam(asked);
    if (!r.makesVoids() || !(e.volume > 0)) return {};
    VoidExtent plan;
    if (r.as<ListedVoids>()) {
        plan = e.dim == 3 ? listed<3>(r, e) : listed<2>(r, e);
    } else if (const auto* grid = r.as<GridVoids>()) {  // as wide as its boxes; a matrix has few
        if (!grid->cell.empty() && grid->cell.front() > 0)
            plan = planned(r, e, grid->cell.front() / 2, grid->cell.front() / 2);
    } else {
        const VoidShapeRecipe& shape = *shapeOf(r);
        const auto* holes = r.as<FrontHoles>();
        const bool balls = holes && holes->as == FrontHoles::As::spheres;
        const auto thickness = targetTbthOf(r);
        const double chosen = thickness ? kRadiusPerThickness * *thickness : 2 * largestRadius;
        const double b = meanOf(shape.radius, e.dim, chosen);
        const double aspect = balls ? 1 : meanOf(shape.aspect, e.dim, 2);
        if (b > 0) plan = planned(r, e, b * aspect, b);
    }
    if (r.cull == Cull::touch) plan.reach = largestRadius;
    plan.specimenVoxels = specimenVoxels(asked, e.isBox ? e.volume : 0);
    return plan;
}

double stampBytes(const Extent& e) {
    const VoidExtent& v = e.voids;
    if (!(v.count > 0) || !(v.voxelSize > 0)) return 0;
    const double side = kTileSide * v.voxelSize, band = kStampBand * v.voxelSize;
    // A wall enters as many leaves as a layer of its band and one leaf has.
    const double layer = side + band + std::max(band, v.reach);
    const double leaves = (std::min(v.wall * layer, e.volume + e.area * side) + e.area * side) /
                          std::pow(side, e.dim);
    return kBytesPerLeaf * leaves;
}

}  // namespace vdbpack
