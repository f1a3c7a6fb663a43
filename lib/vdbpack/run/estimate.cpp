#include "vdbpack/run/estimate.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/formats/label_outputs.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/measure/morphometry/solid_image.h"
#include "vdbpack/pack/front_fraction.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/voids/make_voids.h"
#include "vdbpack/voids/shell_field.h"
#include "vdbpack/voids/structure_fit.h"
#include "vdbpack/voids/void_list.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>

namespace vdbpack {

namespace {

double ballOf(int dim, double radius) {
    return dim == 3 ? Measure<3>::ball(radius) : Measure<2>::ball(radius);
}

double meanOf(const SizeRequest& sizes, int dim, double otherwise) {
    return sizes.empty() ? otherwise : sizes.in(dim).mean();
}

/// Area of an ellipsoid with half-axes a, b, b (2D: length of an ellipse), to about a tenth.
double surfaceArea(int dim, double a, double b) {
    return dim == 3 ? 4 * kPi * b * (2 * a + b) / 3 : kPi * (a + b);
}

template <int Dim>
VoidExtent listed(const VoidRecipe& recipe, double domain) {
    VoidExtent v;
    // A pipe can be read once only, when the voids are made.
    const std::string& file = recipe.as<ListedVoids>()->file;
    if (std::error_code failed; !std::filesystem::is_regular_file(file, failed)) return v;
    const auto list = readVoidList<Dim>(file);
    if (list.empty()) return v;
    v.count = static_cast<double>(list.size());
    double volume = 0;
    for (const auto& one : list) {
        v.wall += surfaceArea(Dim, one.a, one.b);
        v.half += one.b / v.count;
        volume += one.volume();
    }
    v.left = std::exp(-volume / domain);  // the Boolean model
    v.wall *= v.left;
    v.voxelSize = voidVoxelFor(recipe, leastHalfAxis(list));
    return v;
}

/// Voids with mean half-axes a and b by a method that makes them.
VoidExtent planned(const VoidRecipe& r, const Extent& e, double a, double b) {
    const auto target = targetBvtvOf(r);
    const double each = ballOf(e.dim, b) * a / b;
    const double most = 0.6 * e.volume / ballOf(e.dim, std::max(a, b));
    // The Boolean model's number for a target.
    const double needed = -std::log(target.value_or(kDefaultBvtv)) * e.volume / each;
    VoidExtent v;
    v.foam = r.as<FoamVoids>();
    v.half = b;
    const auto* boolean = r.as<BooleanVoids>();
    const auto* holes = r.as<FrontHoles>();
    if (r.as<GridVoids>())
        v.count = e.volume / std::pow(2 * b, e.dim);
    else if (const auto* overlay = r.as<OverlayVoids>())
        v.count = std::min(most, overlay->count.value_or(most));
    else if (v.foam)  // as a dense pack
        v.count = 0.64 * e.volume / each;
    else if (holes && !target)
        v.count = holes->probability.value_or(kDefaultProbability) * e.count;
    else
        v.count = boolean && !target ? boolean->count.value_or(needed) : needed;
    const double share = v.count * each / e.volume;
    double open = 1;  // share of the walls, where voids overlap
    if (v.foam) {
        v.left = target.value_or(kDefaultBvtv);
        // Before the dilation of its spheres; a tenth more than at a BV/TV from 0.07 to 0.47.
        open = std::min(0.7, 1.1 * std::pow(v.left / 0.36, 0.6));
    } else if (boolean) {
        v.left = open = std::exp(-share);
    } else {
        v.left = std::max(0.0, 1 - share);
    }
    v.wall = v.count * surfaceArea(e.dim, a, b) * open;
    // Voids reach into the domain, or beyond its shell, from outside.
    const double reach = std::max(a, b) - shellRange(r).first;
    if ((v.foam || boolean) && reach > 0)
        v.count *= std::pow(1 + e.area * reach / (e.dim * e.volume), e.dim);
    v.voxelSize = plannedVoxel(r, e.dim);
    if (!(v.voxelSize > 0)) v.voxelSize = voidVoxelFor(r, 0.75 * std::min(a, b));
    return v;
}

/// The share of a domain that voids leave (`Fill::solid`), or of the spheres that fill it.
/// @param shell    share of the domain that is shell.
/// @param left     share of the rest outside of all voids, where the recipe says nothing.
/// @param touched  factor where all spheres that meet a void are removed.
double keptShare(const VoidRecipe& voids, double shell, double left, double touched) {
    constexpr double kLeast = 0.01;
    shell = std::clamp(shell, 0.0, 1 - kLeast);
    const auto* thinning = voids.as<Thinning>();
    if (thinning && thinning->fraction) left = 1 - *thinning->fraction;
    const double bvtv = targetBvtvOf(voids).value_or(left);
    const double share = std::max(shell + (1 - shell) * bvtv, kLeast);
    return voids.fill == Fill::domain && voids.cull == Cull::touch ? touched * share : share;
}

/// The thickness of the shell times the area of the wall in the volume of the domain.
double shellLayer(const VoidRecipe& voids, const Extent& e) {
    const auto [least, most] = shellRange(voids);
    return e.volume > 0 ? 0.5 * (least + most) * e.area / e.volume : 1;
}

/// @param e     the domain. @param ball  mean volume (2D: area) of a sphere, mm^dim.
FieldRadii fieldRadii(const PackRecipe& recipe, const RequestedSizes& requested,
                      const DomainSource& source, Extent e, double ball) {
    FieldRadii radii;
    if (requested.targetCount > 0) {
        // Half full is the lowest that is to be expected: the field is deep and fine enough.
        const double guess = source.volume() / (requested.targetCount * ball);
        radii.scale = std::pow((e.dim == 3 ? 0.58 : 0.8) * guess, 1.0 / e.dim);
    }
    if (!recipe.voids.empty() && e.volume > 0) {
        e.count = requested.targetCount;
        addVoids(e, recipe.voids, requested.largest() * radii.scale);
        radii.share = keptShare(recipe.voids, shellLayer(recipe.voids, e), e.voids.left, 0.8);
        if (requested.targetCount > 0) radii.scale *= std::pow(radii.share, 1.0 / e.dim);
    }
    radii.detail = requested.detail() * radii.scale;
    radii.reach = std::max(requested.largest() * radii.scale * 1.05 + recipe.packing.gap,
                           depthForVoids(recipe.voids, plannedVoxel(recipe.voids, e.dim),
                                         requested.largest() * radii.scale, e.dim) /
                               3);
    return radii;
}

/// The share of the spheres that voids leave, as expected: with the curvature of the shell, and
/// for spheres that must not touch a void with voids larger by most of a radius.
double expectedShare(const VoidRecipe& voids, const Extent& e, double radius) {
    if (voids.empty()) return 1;
    double left = e.voids.left;
    if (const auto* grid = voids.as<GridVoids>())
        left = 1 - (1 - left) * grid->probability.value_or(1);
    else if (voids.as<FrontHoles>())  // holes take the place of spheres
        left = 1 / (1 + e.voids.count * ballOf(e.dim, e.voids.half) / e.volume);
    const double layer = std::min(1.0, shellLayer(voids, e) / e.dim);
    const double larger = e.voids.half > 0 ? 1 + 0.8 * radius / e.voids.half : 1;
    return keptShare(voids, 1 - std::pow(1 - layer, e.dim), left,
                     std::pow(targetBvtvOf(voids).value_or(left), std::pow(larger, e.dim) - 1));
}

/// The share of a volume that the front of a recipe fills, as `frontFraction`. Factors of effort
/// and order: box:60,60,60 with uniform:0.6,1.2.
double fractionOf(const PackRecipe& recipe, int dim, double mean, double ball, double wall) {
    double factor = recipe.packing.effort == Effort::fast && dim == 3 ? 0.95 : 1;
    if (!sweeps(recipe.packing.order)) factor *= recipe.packing.order == Order::fifo ? 0.95 : 0.99;
    const double gap = recipe.packing.gap;
    return factor * (dim == 3 ? frontFraction<3>(mean, ball, wall, gap)
                              : frontFraction<2>(mean, ball, wall, gap));
}

/// Seconds of one processor (AMD EPYC, GCC 12, `--threads 1`), linear in what was measured to
/// matter in the packs above: triangles and voxels of the field in mandible, hip, femur and
/// skull_seg3d (42,000 to 625,000 triangles, 0.1 to 15 million voxels), spheres and wall in these
/// with 2,000 to 690,000 spheres; radii up to eight times the mean in box:60,60,60; 24 densified
/// packs, 29 with voids. assets/guides/reliability.md compares estimates with runs.
/// @param mean, largest  radii, mm.
/// @param dense          how much of what densifying can add is asked for; 0: nothing.
Report::Seconds secondsOf(const Extent& e, const PackRecipe& recipe, double mean, double largest,
                          double dense) {
    const double plane = e.dim == 2 ? 0.2 : 1, searched = e.searching ? 1.6 : 1;
    const double triangles =
        static_cast<double>(e.field.triangles) + (e.solid ? contourTriangles(e) : 0);
    const double clips = recipe.domain.clips.empty() ? 0 : 0.6;
    const double atWalls = e.dim == 3 && triangles > 0 ? e.area / (mean * mean) : 0;
    Report::Seconds s;
    s.domain = 1.9e-6 * triangles + 20e-9 * e.field.voxels() + clips;
    s.pack = searched * plane *
             (4.3e-6 * e.count * std::max(1.0, 0.55 * largest / mean) + 2.5e-6 * atWalls);
    // Towards the densest pack a sphere takes ever longer.
    if (dense > 0) s.densify = searched * e.count * (dense < 1 ? 8e-6 / (1.1 - dense) : 180e-6);
    if (recipe.randomStart) {
        s.pack = 0;
        s.densify = s.densify / searched + 20e-6 * e.count;
    }
    if (recipe.settle) s.settle = searched * e.count * 9e-6;
    // For a foam in space, a pack is densified; its targets are fitted on images.
    s.voids = (e.voids.foam && e.dim == 3 ? 28e-9 : 9e-9) * stampBytes(e) + 5e-6 * e.imageVoxels;
    s.measure = plane * (triangles > 0 ? 3e-6 : 1e-6) * e.kept * e.count + 1e-6 * triangles + clips;
    s.measure += 0.26e-6 * e.solidVoxels;
    return s;
}

/// Makes volume and area of a domain what they are without its existing spheres.
/// @return the volume of these.
double leaveOut(const std::vector<Sphere<3>>& existing, const DomainSource& source, PackPlan& plan,
                double& volume, double& area) {
    double sum = 0;
    for (const Sphere<3>& s : existing) {
        if (source.dim() == 3 && !source.domainBounds().contains(s.center)) continue;
        const double ball = ballOf(source.dim(), s.radius);
        ++plan.existing;
        sum += ball;
        area += source.dim() * ball / s.radius;
    }
    volume = std::max(0.0, volume - sum);
    return sum;
}

/// Spheres, voids and time. @param ball  mean volume (2D: area) of a sphere, mm^dim.
void expectSpheres(PackPlan& plan, const PackRecipe& recipe, const DomainSource& source,
                   double ball, const std::vector<Sphere<3>>& existing) {
    Extent& e = plan.extent;
    SizeDistribution sizes = plan.requested.sizes;
    const double target = plan.requested.targetCount;
    if (!(target > 0) && plan.room < sizes.max()) {
        if (plan.room < sizes.min()) return;
        sizes = sizes.upTo(plan.room);
        ball = sizes.meanBall(e.dim);
    }
    const double mean = sizes.mean() * std::pow(ball / sizes.meanBall(e.dim), 1.0 / e.dim);
    double volume = e.volume, area = e.area, scale = 1;
    const double others = leaveOut(existing, source, plan, volume, area);
    const auto front = [&] {
        return fractionOf(recipe, e.dim, scale * mean, std::pow(scale, e.dim) * ball,
                          volume > 0 ? area / volume : 0);
    };
    e.count = target > 0 ? target / (e.solid ? 1 : plan.radii.share) : front() * volume / ball;
    addVoids(e, recipe.voids, plan.requested.largest() * plan.radii.scale);
    e.kept = expectedShare(recipe.voids, e, plan.radii.scale * mean);
    double whole = e.volume;
    if (e.solid) {
        whole = volume *= e.kept;
        area = area * e.kept + e.voids.wall;
        e.kept = 1;
    }
    constexpr int kRounds = 3;
    double filled = 0, dense = 0;
    for (int round = 0; round < kRounds; ++round) {
        filled = front();
        if (recipe.densify.fraction > 0) {
            // More than a front, at most: 0.059 to 0.077 of it in 14 packs, 0.05 to 0.105 in the
            // plane.
            const double gain = e.dim == 3 ? 0.067 : 0.075;
            const double more = (recipe.densify.fraction * whole - others) / (filled * volume) - 1;
            dense = std::clamp(more / gain, 0.0, 1.0);
            plan.densified = more <= 1.5 * gain || std::isinf(recipe.densify.fraction);
            filled *= recipe.randomStart && more < 0 ? 1 + more : 1 + gain * dense;
        }
        if (target > 0) scale = std::pow(filled * volume * e.kept / (target * ball), 1.0 / e.dim);
    }
    const double largestFitting = largestScale(sizes, plan.room);
    const bool isCapped = target > 0 && scale > largestFitting;
    if (isCapped && scale * sizes.min() > plan.room) return;
    if (isCapped) {
        scale = largestFitting;
        filled = front();
    }
    e.count = target > 0 && !isCapped ? target / e.kept
                                      : filled * volume / (std::pow(scale, e.dim) * ball);
    if (recipe.packing.maxCount > 0)
        e.count = std::min(e.count, static_cast<double>(recipe.packing.maxCount));
    plan.seconds = secondsOf(e, recipe, scale * mean, scale * sizes.max(), dense);
    plan.count = e.kept * e.count + plan.existing;
    plan.solidFraction = (e.kept * e.count * std::pow(scale, e.dim) * ball + others) / whole;
    plan.scale = scale;
    e.count += plan.existing;
}

/// Mean volume (2D: area) of a sphere where sizes differ by place, mm^dim.
template <int Dim>
double localBall(const PackRecipe& recipe, const RequestedSizes& requested,
                 const DomainSource::Built& built) {
    const Domain<Dim>& domain = *ofDim<Dim>(built);
    const auto shell = shellOver(recipe.voids, domain.bounds(), built.sliceHeight);
    const auto local = localSizes(recipe, requested, domain, built.sliceHeight, shell);
    return LocalBalls<Dim>(domain, requested.sizes, local).mean();
}

/// Makes the domain for its volume and area, for the largest ball in it, and for the mean volume of
/// its spheres where sizes differ by place. What takes more than about a second is left as it was
/// estimated.
void lookCloser(PackPlan& plan, const PackRecipe& recipe, const DomainSource& source, double voxel,
                double& ball) {
    // Of all threads, so that other work beside this one does not decide.
    constexpr double kQuickSeconds = 0.6;
    const std::clock_t begin = std::clock();
    Callbacks timed;
    timed.cancelled = [&] {
        return static_cast<double>(std::clock() - begin) > kQuickSeconds * CLOCKS_PER_SEC;
    };
    try {
        const auto built = source.build(plan.radii.detail, plan.radii.reach, timed, voxel);
        plan.extent.volume = built.space ? built.space->volume() : built.plane->volume();
        if (plan.requested.differByPlace())
            ball = source.dim() == 3 ? localBall<3>(recipe, plan.requested, built)
                                     : localBall<2>(recipe, plan.requested, built);
        timed.stopIfCancelled();
        if (!plan.requested.differByPlace())
            plan.room = (built.space ? largestBall(*built.space).radius
                                     : largestBall(*built.plane).radius) -
                        recipe.packing.gap;
        timed.stopIfCancelled();
        plan.extent.area = built.space ? built.space->wallArea() : built.plane->wallArea();
    } catch (const Interrupted&) {
    }
}

}  // namespace

Extent extentOf(const DomainSource& source, double detail, double reach, double voxelSize) {
    Extent e;
    e.dim = source.dim();
    e.field = source.plan(detail, reach, voxelSize);
    if (!source.isFile()) {
        const auto built = source.build(0, 0);
        e.volume = built.space ? built.space->volume() : built.plane->volume();
        e.area = built.space ? built.space->wallArea() : built.plane->wallArea();
        if (built.space) {
            e.isBox = built.space->facts().kind == "box";
            e.boxVolume = built.space->bounds().volume();
            e.shapeVoxel = shapeVoxelSize(built.space->bounds());
        }
    } else {
        const auto left = source.left();
        e.volume = left.volume;
        e.area = left.area;
        e.boxVolume = source.domainBounds().volume();
    }
    return e;
}

void addVoids(Extent& e, const VoidRecipe& asked, double largestRadius) {
    const VoidRecipe r = usualFoam(asked);
    if (!r.makesVoids() || !(e.volume > 0)) return;
    if (r.as<ListedVoids>()) {
        e.voids = e.dim == 3 ? listed<3>(r, e.volume) : listed<2>(r, e.volume);
    } else if (const auto* grid = r.as<GridVoids>()) {  // as wide as its boxes; a matrix has few
        if (!grid->cell.empty() && grid->cell.front() > 0)
            e.voids = planned(r, e, grid->cell.front() / 2, grid->cell.front() / 2);
    } else {
        const VoidShapeRecipe& shape = *shapeOf(r);
        const auto* holes = r.as<FrontHoles>();
        const bool balls = holes && holes->as == FrontHoles::As::spheres;
        const auto thickness = targetTbthOf(r);
        const double chosen = thickness ? kRadiusPerThickness * *thickness : 2 * largestRadius;
        const double b = meanOf(shape.radius, e.dim, chosen);
        const bool round = balls || (r.as<FoamVoids>() && !shape.orientation.any());
        const double usual = round ? 1 : r.as<FoamVoids>() ? kDefaultFoamAspect : kDefaultAspect;
        const double aspect = balls ? 1 : meanOf(shape.aspect, e.dim, usual);
        if (b > 0) e.voids = planned(r, e, b * aspect, b);
    }
    e.voids.wall *= std::pow(1 - std::min(1.0, shellLayer(r, e) / e.dim), e.dim);
    if (r.cull == Cull::touch) e.voids.reach = largestRadius;
    e.imageVoxels = specimenVoxels(asked, e.isBox ? e.volume : 0);
    if (r.measureSolid && e.voids.voxelSize > 0)
        e.solidVoxels = (e.isBox && !r.hasShell() ? 1 : kWalledVoxel) * e.boxVolume /
                        std::pow(e.voids.voxelSize, 3);
}

PackPlan planPack(const PackRecipe& recipe, const DomainSource& source, bool closer) {
    constexpr double kQuickVoxels = 6e7;  // about a second of a processor
    requireShell(shellRange(recipe.voids).first, source, closer);
    requireRepeating(source, recipe.voids);
    const int dim = source.dim();
    PackPlan plan{requestedSizes(recipe, dim)};
    const RequestedSizes& requested = plan.requested;
    Extent& e = plan.extent;
    e = extentOf(source, requested.least(), requested.largest());
    const double shell = requested.shellSizes ? std::min(1.0, shellLayer(recipe.voids, e)) : 0;
    double ball = requested.meanBall(dim, shell);
    const double voxel = plannedVoxel(recipe.voids, dim);
    const FieldRadii& radii = plan.radii = fieldRadii(recipe, requested, source, e, ball);
    e.field = source.plan(radii.detail, radii.reach, voxel);
    e.searching = requested.targetCount > 0;
    e.densifying = recipe.densify.fraction > 0 || recipe.settle;
    e.solid = recipe.voids.fill == Fill::solid;
    if (const auto labels = labelGridOf(recipe.outputs, {&source}, recipe.memoryLimit))
        e.labelVoxels = static_cast<double>(labels->voxels());
    const bool isThin = e.area * requested.largest() * radii.scale > e.volume;
    const bool needed = requested.differByPlace() || recipe.domain.slice || isThin;
    if (closer && needed && e.field.voxels() < kQuickVoxels)
        lookCloser(plan, recipe, source, voxel, ball);
    expectSpheres(plan, recipe, source, ball,
                  closer ? readExisting<3>(recipe, 0).spheres : std::vector<Sphere<3>>());
    return plan;
}

}  // namespace vdbpack
