#include "vdbpack/voids/stamped_solid.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/measure/morphometry/trabeculae.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/voids/shell_field.h"
#include "vdbpack/voids/void_families.h"
#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace vdbpack {

namespace {

/// Voxels of the shorter half-axis at the least, where voids are cut into a pack and where spheres
/// fill what they leave, which walls thinner than a sphere do not matter to; of a wanted thickness.
constexpr double kVoxelsPerHalfAxis = 4, kVoxelsToFill = 2.5, kVoxelsPerThickness = 4;
/// How near to a target BV/TV voids are made; beyond the second it is warned of.
constexpr double kBvtvTolerance = 0.0005, kBvtvWarning = 0.005;
/// The same as shares of the solid, or of the voids where they are less.
constexpr double kBvtvShare = 0.01, kBvtvWarningShare = 0.02;
/// Voxels along the side of the cube that a thickness is measured in.
constexpr double kThicknessVoxels = 320;
/// Of the half-axis b: voids of a foam then leave what looks like bone.
constexpr double kFoamBlend = 0.1, kFoamStrut[2] = {0.08, 0.2};  // in plane and space

/// How the voids of a setting join.
template <int Dim>
VoidJoin joinOf(const VoidSetting<Dim>& s) {
    VoidJoin join;
    double blend = 0, strut = 0;
    if (std::get_if<FoamVoids>(&s.recipe.method) && !(s.recipe.blend && s.recipe.strut)) {
        const double mean = voidRadii(s).mean() * shapeOf(s.recipe)->radiusFactor;
        blend = kFoamBlend * mean;
        strut = kFoamStrut[Dim - 2] * mean;
    }
    join.blend = s.recipe.blend.value_or(blend);
    join.strut = 0.5 * s.recipe.strut.value_or(strut);
    join.strutShare = s.recipe.strutShare.value_or(1);
    return join;
}

/// The volume that voids are cut into, mm^Dim. In a box, as voxels fill it whose centers lie in it:
/// the voids are counted so as well, and at a low BV/TV the difference to the box would matter.
template <int Dim>
double totalVolume(const VoidSetting<Dim>& s, double voxelSize) {
    const std::string& kind = s.domain.facts().kind;
    if (s.recipe.hasShell() || !(kind == "box" || kind == "rect" || s.domain.cell().any()))
        return regionOf(s).volume();
    const Box<Dim> box = s.domain.bounds();
    const Vec<Dim> origin = fieldOrigin(box, voxelSize);
    double volume = 1;
    for (int d = 0; d < Dim; ++d)
        volume *= voxelSize * (std::floor((box.hi[d] - origin[d]) / voxelSize) -
                               std::ceil((box.lo[d] - origin[d]) / voxelSize) + 1);
    return volume;
}

/// The target share of the solid, or that of the voids if it is less.
double lessOf(const VoidRecipe& recipe) {
    const double target = *targetBvtvOf(recipe);
    return std::min(target, 1 - target);
}

template <int Dim>
double longestSide(const VoidSetting<Dim>& s) {
    const Vec<Dim> size = s.domain.bounds().size();
    return *std::max_element(size.c.begin(), size.c.end());
}

}  // namespace

double bvtvTolerance(const VoidRecipe& recipe) {
    return std::min(kBvtvTolerance, kBvtvShare * lessOf(recipe));
}

double voidVoxelFor(const VoidRecipe& recipe, double least) {
    if (recipe.voxelSize > 0) return recipe.voxelSize;
    // Struts between the voids of a foam are half as thick as these.
    const double detail = recipe.as<FoamVoids>() ? least / 2 : least;
    const double voxel = detail / (recipe.fill == Fill::solid ? kVoxelsToFill : kVoxelsPerHalfAxis);
    const auto thickness = targetTbthOf(recipe);
    return thickness ? std::min(voxel, *thickness / kVoxelsPerThickness) : voxel;
}

double plannedVoxel(const VoidRecipe& recipe, int dim) {
    const VoidShapeRecipe* const shape = shapeOf(recipe);
    if (!shape || shape->radius.empty() || recipe.voxelSize > 0 || scalesVoids(recipe))
        return recipe.makesVoids() ? recipe.voxelSize : 0;
    const double aspect = shape->aspect.empty() ? 1 : shape->aspect.in(dim).min();
    return voidVoxelFor(recipe, shape->radius.in(dim).min() * std::min(1.0, aspect));
}

double depthForVoids(const VoidRecipe& recipe, double voxel, double largestSphere, int dim) {
    const double thickest = shellRange(recipe).second;
    const double depth = thickest > 0 ? 1.1 * thickest + 10 * voxel : 0;
    const auto* const overlay = recipe.as<OverlayVoids>();
    if (!overlay) return depth;
    const VoidShapeRecipe& shape = overlay->shape;
    if (shape.radius.empty() && !(largestSphere > 0)) return depth;
    const SizeDistribution radii =
        shape.radius.empty() ? defaultVoidRadius(largestSphere) : shape.radius.in(dim);
    const double aspect = shape.aspect.empty() ? kDefaultAspect : shape.aspect.in(dim).mean();
    // They are packed as balls.
    const double ball = radii.max() * shape.radiusFactor * std::max(1.0, aspect);
    return std::max(depth, 1.1 * (thickest + ball));
}

template <int Dim>
double voxelFor(const VoidSetting<Dim>& s, double least) {
    const double voxel = voidVoxelFor(s.recipe, least);
    const PeriodicCell<Dim> cell = s.domain.cell();
    if (!cell.any() || s.recipe.voxelSize > 0) return voxel;
    return cell.shortest() / std::ceil(cell.shortest() / voxel * (1 - 1e-9));
}

template <int Dim>
StampOptions<Dim> stampOptions(const VoidSetting<Dim>& s, double voxelSize) {
    StampOptions<Dim> options;
    options.voxelSize = voxelSize;
    options.origin = fieldOrigin(s.domain.bounds(), voxelSize);
    options.shell = shellOf(s);
    options.join = joinOf(s);
    if (s.recipe.cull == Cull::touch) options.reach = s.largestRadius + 2 * voxelSize;
    return options;
}

template <int Dim>
double bvtvOf(const VoidSetting<Dim>& s, double voxelSize, MadeVoids<Dim>& made) {
    StampOptions<Dim> options = stampOptions(s, voxelSize);
    if (!made.core || made.report.voxelSize != voxelSize) made.core = unknownCore<Dim>();
    options.core = made.core;
    made.stamped = stampVoids(made.list, s.domain, options, s.callbacks);
    made.report.count = made.list.size();
    made.report.voxelSize = voxelSize;
    if (!(made.report.totalVolume > 0)) made.report.totalVolume = totalVolume(s, voxelSize);
    made.report.bvtv = std::max(0.0, 1 - made.stamped->volume() / made.report.totalVolume);
    if (s.recipe.keepConnected) cut(s, made);
    return *made.report.bvtv;
}

void cut(const VoidSetting<3>& s, MadeVoids<3>& made) {
    s.callbacks.stopIfCancelled();
    if (!made.surface || std::fabs(made.report.voxelSize - voxelSizeOf(*made.surface)) >
                             1e-9 * made.report.voxelSize)
        made.surface = surfaceLevelSet(s.domain, made.report.voxelSize);
    s.callbacks.stopIfCancelled();
    made.voids = made.stamped->grid();
    const Domain<3>& envelope = s.domain.envelope();
    const ShellThickness shell = shellOf(s);
    std::function<bool(const Vec<3>&)> inShell;
    if (&envelope != &s.domain || !shell.isUniform())
        inShell = [sampler = std::shared_ptr<DomainSampler<3>>(envelope.sampler()),
                   shell](const Vec<3>& x) { return sampler->signedDistance(x) > -shell.at(x); };
    made.solid = cutVoids(*made.surface, *made.voids, shell.most(), s.recipe.keepConnected, inShell,
                          s.domain.cell());
    made.report.solidAttached = made.solid.attached;
    made.report.solidPieces = made.solid.components;
    made.report.bvtv =
        std::max(0.0, 1 - (made.stamped->volume() + made.solid.dropped) / made.report.totalVolume);
}

template <>
std::optional<double> thicknessOf(const VoidSetting<3>& s, MadeVoids<3>& made,
                                  const Vec<3>& deepest) {
    cut(s, made);
    const double edge = kThicknessVoxels * made.report.voxelSize;
    const Box<3> sample =
        intersection(s.domain.bounds(), Box<3>{deepest, deepest}.grown(0.5 * edge));
    return trabecularThickness(*made.solid.grid, sample, s.domain, shellOf(s));
}

template <>
std::optional<double> thicknessOf(const VoidSetting<2>& s, MadeVoids<2>& made, const Vec<2>&) {
    const double voxel = made.report.voxelSize;
    StampedVoids<2>::Sampler distance(*made.stamped);
    return trabecularThickness([&](const Vec<2>& x) { return distance(x); }, s.domain, shellOf(s),
                               fieldOrigin(s.domain.bounds(), voxel), voxel);
}

template <int Dim>
void requireFitting(const VoidSetting<Dim>& s, double halfAxis) {
    if (const double cell = s.domain.cell().shortest(); 2 * halfAxis > cell * (1 + 1e-9))
        throw ParameterError(fmt::format(
            "voids with half-axes of up to {:.4g} mm would overlap their own images in the "
            "periodic cell, which is {:.4g} mm long; give smaller ones or a longer cell",
            halfAxis, cell));
    if (const double longest = longestSide(s); 2 * halfAxis > longest * (1 + 1e-9))
        throw ParameterError(
            fmt::format("voids with half-axes of up to {:.4g} mm are larger than the domain, which "
                        "is {:.4g} mm long; give smaller ones",
                        halfAxis, longest));
}

template <int Dim>
void checkRoom(const VoidSetting<Dim>& s, bool early) {
    if (!(regionOf(s).volume() > 1e-9 * s.domain.volume()))
        throw InputError(
            fmt::format("`{}` {} mm: no part of the domain lies deeper than the shell; its deepest "
                        "point lies {:.4g} mm below the wall; give a thinner shell",
                        s.localShell.isUniform() ? "shell" : "shellField", shellOf(s).most(),
                        largestBall(s.domain).radius));
    if (!s.recipe.makesVoids()) return;
    if (const double longest = longestSide(s); !(s.recipe.voxelSize <= longest))
        throw ParameterError(
            fmt::format("`voids.voxelSize` {}: larger than the domain, which is {:.4g} mm long; "
                        "give a quarter of the shorter half-axis of the voids, or leave it out",
                        s.recipe.voxelSize, longest));
    if (const auto* listed = std::get_if<ListedVoids>(&s.recipe.method)) {
        if (early) requireFitting(s, longestHalfAxis(readVoidList<Dim>(listed->file)));
    } else if (std::get_if<GridVoids>(&s.recipe.method)) {
        requireFitting(s, longestHalfAxis(voidFamily(s, kDefaultBvtv, nullptr).list(1)));
    } else if (!scalesVoids(s.recipe)) {
        requireFitting(s, voidShapeOf(s).reach());
    }
}

template <int Dim>
void warnIfOff(const VoidSetting<Dim>& s, const VoidReport& report) {
    const auto target = targetBvtvOf(s.recipe);
    if (!target || std::fabs(*report.bvtv - *target) <=
                       std::min(kBvtvWarning, kBvtvWarningShare * lessOf(s.recipe)))
        return;
    s.callbacks.warn(fmt::format(
        "`targetBvtv` {}: the nearest value found is {:.4f}; give smaller voids or a larger domain",
        *target, *report.bvtv));
}

#define VDBPACK_INSTANTIATE(Dim)                                              \
    template double voxelFor(const VoidSetting<Dim>&, double);                \
    template StampOptions<Dim> stampOptions(const VoidSetting<Dim>&, double); \
    template double bvtvOf(const VoidSetting<Dim>&, double, MadeVoids<Dim>&); \
    template void requireFitting(const VoidSetting<Dim>&, double);            \
    template void checkRoom(const VoidSetting<Dim>&, bool);                   \
    template void warnIfOff(const VoidSetting<Dim>&, const VoidReport&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
