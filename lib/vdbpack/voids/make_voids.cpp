#include "vdbpack/voids/make_voids.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/domain/surface_level_set.h"
#include "vdbpack/measure/morphometry/trabeculae.h"
#include "vdbpack/pack/largest_ball.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/shell_field.h"
#include "vdbpack/voids/solve_target.h"
#include "vdbpack/voids/structure_fit.h"
#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kDefaultBvtv = 0.3;
/// The paper's.
constexpr double kDefaultProbability = 0.02;
/// Voxels of the shorter half-axis at the least, where voids are cut into a pack and where spheres
/// fill what they leave, which walls thinner than a sphere do not matter to; of a wanted thickness.
constexpr double kVoxelsPerHalfAxis = 4, kVoxelsToFill = 2.5, kVoxelsPerThickness = 4;

/// How near to a target BV/TV voids are made that are packed; beyond the second it is warned of.
constexpr double kPackedTolerance = 0.002;
constexpr double kBvtvTolerance = 0.0005, kBvtvWarning = 0.005;
/// The same as shares of the solid, or of the voids where they are less.
constexpr double kBvtvShare = 0.01, kBvtvWarningShare = 0.02;
constexpr double kThicknessTolerance = 0.01, kThicknessWarning = 0.02;
constexpr int kThicknessRounds = 6;  // the last repeats the nearest of the others
/// Voxels along the side of the cube that a thickness is measured in.
constexpr double kThicknessVoxels = 320;
/// Of the half-axis b: voids of a foam then leave what looks like bone.
constexpr double kFoamBlend = 0.1, kFoamStrut[2] = {0.08, 0.2};  // in plane and space
/// Holes with less beside them would be no pack.
constexpr double kMostProbability = 0.9;

template <int Dim>
Vec<Dim> latticeOf(const VoidSetting<Dim>& s, double voxelSize) {
    return fieldOrigin(s.domain.bounds(), voxelSize);
}

/// How the voids of a setting join.
template <int Dim>
VoidJoin joinOf(const VoidSetting<Dim>& s) {
    VoidJoin join;
    double blend = 0, strut = 0;
    if (methodOf(s.recipe) == VoidMethod::foam && !(s.recipe.blend && s.recipe.strut)) {
        const double mean =
            SizeDistribution::parse(voidRadiusSpec(s, nullptr), Dim).mean() * s.recipe.radiusScale;
        blend = kFoamBlend * mean;
        strut = kFoamStrut[Dim - 2] * mean;
    }
    join.blend = s.recipe.blend.value_or(blend);
    join.strut = 0.5 * s.recipe.strut.value_or(strut);
    join.strutShare = s.recipe.strutShare.value_or(1);
    return join;
}

/// `voidVoxelFor`, unless it is asked for, such that a whole number of voxels makes the shortest
/// length along which a domain repeats: then each plane of them counts once.
template <int Dim>
double voxelFor(const VoidSetting<Dim>& s, double least) {
    const double voxel = voidVoxelFor(s.recipe, least);
    const PeriodicCell<Dim> cell = s.domain.cell();
    if (!cell.any() || s.recipe.voxelSize > 0) return voxel;
    return cell.shortest() / std::ceil(cell.shortest() / voxel * (1 - 1e-9));
}

/// The volume that voids are cut into, mm^Dim. In a box, as voxels fill it whose centers lie in it:
/// the voids are counted so as well, and at a low BV/TV the difference to the box would matter.
template <int Dim>
double totalVolume(const VoidSetting<Dim>& s, double voxelSize) {
    const std::string& kind = s.domain.facts().kind;
    if (s.recipe.hasShell() || !(kind == "box" || kind == "rect" || s.domain.cell().any()))
        return regionOf(s).volume();
    const Box<Dim> box = s.domain.bounds();
    const Vec<Dim> origin = latticeOf(s, voxelSize);
    double volume = 1;
    for (int d = 0; d < Dim; ++d)
        volume *= voxelSize * (std::floor((box.hi[d] - origin[d]) / voxelSize) -
                               std::ceil((box.lo[d] - origin[d]) / voxelSize) + 1);
    return volume;
}

template <int Dim>
StampOptions<Dim> stampOptions(const VoidSetting<Dim>& s, double voxelSize) {
    StampOptions<Dim> options;
    options.voxelSize = voxelSize;
    options.origin = latticeOf(s, voxelSize);
    options.shell = shellOf(s);
    options.join = joinOf(s);
    if (s.recipe.cull == Cull::touch) options.reach = s.largestRadius + 2 * voxelSize;
    return options;
}

/// Stamps a list, and cuts it where components are to be removed; sets BV/TV.
template <int Dim>
void stamp(const VoidSetting<Dim>& s, double voxelSize, MadeVoids<Dim>& made) {
    made.stamped = stampVoids(made.list, s.domain, stampOptions(s, voxelSize), s.callbacks);
    made.report.count = made.list.size();
    made.report.voxelSize = voxelSize;
    if (!(made.report.totalVolume > 0)) made.report.totalVolume = totalVolume(s, voxelSize);
    made.report.bvtv = std::max(0.0, 1 - made.stamped->volume() / made.report.totalVolume);
}

/// The level sets of space; what is dropped of the solid is taken off BV/TV.
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
void cut(const VoidSetting<2>&, MadeVoids<2>&) {}

/// The target share of the solid, or that of the voids if it is less.
double lessOf(const VoidRecipe& recipe) {
    return std::min(*recipe.targetBvtv, 1 - *recipe.targetBvtv);
}

/// BV/TV of what `made` holds, with what is dropped.
template <int Dim>
double bvtvOf(const VoidSetting<Dim>& s, double voxelSize, MadeVoids<Dim>& made) {
    stamp(s, voxelSize, made);
    if (s.recipe.keepConnected) cut(s, made);
    return *made.report.bvtv;
}

/// Tb.Th of what voids leave, mm: near the deepest point, since a part of a large bone represents
/// the thickness of all of it.
std::optional<double> thicknessOf(const VoidSetting<3>& s, MadeVoids<3>& made,
                                  const Vec<3>& deepest) {
    cut(s, made);
    const double edge = kThicknessVoxels * made.report.voxelSize;
    const Box<3> sample =
        intersection(s.domain.bounds(), Box<3>{deepest, deepest}.grown(0.5 * edge));
    return trabecularThickness(*made.solid.grid, sample, s.domain, shellOf(s));
}
std::optional<double> thicknessOf(const VoidSetting<2>& s, MadeVoids<2>& made, const Vec<2>&) {
    const double voxel = made.report.voxelSize;
    StampedVoids<2>::Sampler distance(*made.stamped);
    return trabecularThickness([&](const Vec<2>& x) { return distance(x); }, s.domain, shellOf(s),
                               latticeOf(s, voxel), voxel);
}

/// Scales the voids until the walls between them have the wanted thickness at the wanted BV/TV.
template <int Dim>
void solveThickness(const VoidSetting<Dim>& s, MadeVoids<Dim>& made,
                    const std::function<void(const VoidSetting<Dim>&, MadeVoids<Dim>&)>& solve) {
    VoidRecipe recipe = s.recipe;
    const double target = *recipe.targetTbth;
    const Vec<Dim> size = s.domain.bounds().size();
    const double side = *std::min_element(size.c.begin(), size.c.end());
    if (!(target < 0.25 * side))
        throw ParameterError(
            fmt::format("`targetTbth` {}: not reachable, trabeculae in a domain of {:.4g} mm are "
                        "thinner than a "
                        "quarter of it; give a smaller one",
                        target, side));
    // Walls are about as thick as b times -1/ln(BV/TV), to begin with: then by what was measured.
    if (recipe.radius.empty() && !(s.largestRadius > 0))
        recipe.radius = defaultVoidRadius(1);
    else
        recipe.radius = voidRadiusSpec(s, nullptr);
    const SizeDistribution first = SizeDistribution::parse(recipe.radius, Dim);
    if (s.recipe.radius.empty()) recipe.radiusScale = 1.2 * target / first.mean();
    // Without walls all points are.
    const Vec<Dim> deepest =
        s.domain.cell().all() ? s.domain.bounds().center() : largestBall(s.domain).center;
    double least = std::numeric_limits<double>::infinity();  // miss of a round
    double nearest = recipe.radiusScale;                     // that of this round
    for (int round = 0;; ++round) {
        const VoidSetting<Dim> setting = withRecipe(s, recipe);
        made.surface.reset();
        made.report.totalVolume = 0;
        solve(setting, made);
        s.callbacks.stopIfCancelled();
        const auto thickness = thicknessOf(setting, made, deepest);
        if (!thickness)
            throw InputError(fmt::format(
                "`targetTbth` {}: no solid is left to measure; give a higher `targetBvtv`",
                target));
        made.report.thickness = thickness;
        made.report.radius = first.scaled(recipe.radiusScale).spec();
        if (std::fabs(*thickness - target) <= kThicknessTolerance * target ||
            round == kThicknessRounds)
            break;
        if (const double miss = std::fabs(*thickness - target); miss < least) {
            least = miss;
            nearest = recipe.radiusScale;
        }
        recipe.radiusScale =
            round == kThicknessRounds - 1 ? nearest : recipe.radiusScale * target / *thickness;
    }
    if (std::fabs(*made.report.thickness - target) > kThicknessWarning * target)
        s.callbacks.warn(
            fmt::format("`targetTbth` {}: the nearest value found is {:.4g} mm; give a larger "
                        "domain or a smaller "
                        "`voids.voxelSize`",
                        target, *made.report.thickness));
}

}  // namespace

double bvtvTolerance(const VoidRecipe& recipe) {
    return std::min(kBvtvTolerance, kBvtvShare * lessOf(recipe));
}

template <int Dim>
void warnIfOff(const VoidSetting<Dim>& s, const VoidReport& report) {
    if (!s.recipe.targetBvtv || std::fabs(*report.bvtv - *s.recipe.targetBvtv) <=
                                    std::min(kBvtvWarning, kBvtvWarningShare * lessOf(s.recipe)))
        return;
    s.callbacks.warn(fmt::format(
        "`targetBvtv` {}: the nearest value found is {:.4f}; give smaller voids or a larger domain",
        *s.recipe.targetBvtv, *report.bvtv));
}

template <int Dim>
std::vector<std::shared_ptr<const VdbGrid>> MadeVoids<Dim>::levelSets() const {
    if (!solid.grid) return {};
    return {surface, voids, solid.grid};
}

double voidVoxelFor(const VoidRecipe& recipe, double least) {
    if (recipe.voxelSize > 0) return recipe.voxelSize;
    // Struts between the voids of a foam are half as thick as these.
    const double detail = methodOf(recipe) == VoidMethod::foam ? least / 2 : least;
    const double voxel = detail / (recipe.fill == Fill::solid ? kVoxelsToFill : kVoxelsPerHalfAxis);
    return recipe.targetTbth ? std::min(voxel, *recipe.targetTbth / kVoxelsPerThickness) : voxel;
}

double plannedVoxel(const VoidRecipe& recipe, int dim) {
    const VoidMethod method = methodOf(recipe);
    if (method == VoidMethod::none || isThinning(method) || recipe.radius.empty() ||
        recipe.voxelSize > 0 || scalesVoids(recipe))
        return recipe.voxelSize;
    const double aspect =
        recipe.aspect.empty() ? 1 : SizeDistribution::parse(recipe.aspect, dim).min();
    return voidVoxelFor(recipe,
                        SizeDistribution::parse(recipe.radius, dim).min() * std::min(1.0, aspect));
}

double depthForShell(const VoidRecipe& recipe, double voxel) {
    const double thickest = shellRange(recipe).second;
    return thickest > 0 ? 1.1 * thickest + 10 * voxel : 0;
}

namespace {

/// Refuses voids that are larger than the domain.
template <int Dim>
void requireFitting(const VoidSetting<Dim>& s, double halfAxis) {
    const Vec<Dim> size = s.domain.bounds().size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    if (const double cell = s.domain.cell().shortest(); 2 * halfAxis > cell * (1 + 1e-9))
        throw ParameterError(
            fmt::format("voids with half-axes of up to {:.4g} mm would overlap their own images in "
                        "the periodic cell, which is {:.4g} mm long; give smaller ones or a longer "
                        "cell",
                        halfAxis, cell));
    if (2 * halfAxis > longest * (1 + 1e-9))
        throw ParameterError(
            fmt::format("voids with half-axes of up to {:.4g} mm are larger than the domain, which "
                        "is {:.4g} mm "
                        "long; give smaller ones",
                        halfAxis, longest));
}

}  // namespace

template <int Dim>
void checkRoom(const VoidSetting<Dim>& s, bool early) {
    const double core = regionOf(s).volume();
    if (!(core > 1e-9 * s.domain.volume()))
        throw InputError(
            fmt::format("`{}` {} mm: no part of the domain lies deeper than the shell; its "
                        "deepest point lies "
                        "{:.4g} mm below the wall; give a thinner shell",
                        s.localShell.isUniform() ? "shell" : "shellField", shellOf(s).most(),
                        largestBall(s.domain).radius));
    const VoidMethod method = methodOf(s.recipe);
    if (method == VoidMethod::none || isThinning(method)) return;
    const Vec<Dim> size = s.domain.bounds().size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    if (!(s.recipe.voxelSize <= longest))
        throw ParameterError(
            fmt::format("`voids.voxelSize` {}: larger than the domain, which is {:.4g} mm long; "
                        "give a quarter of "
                        "the shorter half-axis of the voids, or leave it out",
                        s.recipe.voxelSize, longest));
    if (method == VoidMethod::list && !early) return;
    double half = 0;
    if (method == VoidMethod::grid || method == VoidMethod::list) {
        const auto list = method == VoidMethod::grid ? voidFamily(s, 0.5, nullptr).list(1)
                                                     : readVoidList<Dim>(listFile(s.recipe));
        for (const auto& e : list) half = std::max({half, e.a, e.b});
    } else if (!scalesVoids(s.recipe)) {
        half = voidShapeOf(s).reach();
    }
    requireFitting(s, half);
}

namespace {

/// Replaces the targets of a structure by the parameters of a foam that has it.
void fitTo(const VoidSetting<3>& s, FoamPacks<3>& packs, VoidRecipe& recipe, VoidReport& report) {
    const StructureFit fit = fitStructure(withRecipe(s, recipe), packs);
    recipe = fit.recipe;
    report.targets = fit.targets;
    report.specimen = fit.specimen;
    report.thicknessDistance = fit.thicknessDistance;
    report.separationDistance = fit.separationDistance;
    const SizeDistribution radius =
        SizeDistribution::parse(recipe.radius, 3).scaled(recipe.radiusScale);
    report.radius = radius.spec();
    report.parameters = fmt::format(
        "--voids foam --target-bvtv {:.4g} {}--void-radius {} --void-aspect {} --void-jitter "
        "{:.4g} "
        "--void-blend {:.4g} --void-strut {:.4g} --void-strut-share {:.4g} --void-voxel {:.4g}",
        *recipe.targetBvtv,
        recipe.orientation.axis.empty() ? "" : "--void-axis " + recipe.orientation.axis + " ",
        radius.spec(), recipe.aspect, *recipe.jitter, *recipe.blend, *recipe.strut,
        *recipe.strutShare, recipe.voxelSize);
}
void fitTo(const VoidSetting<2>&, FoamPacks<2>&, VoidRecipe& recipe, VoidReport&) {
    for (const auto& [name, target] :
         {std::pair{"targetTbsp", recipe.targetTbsp}, std::pair{"targetDa", recipe.targetDa},
          std::pair{"targetConnd", recipe.targetConnd}})
        if (target)
            throw ParameterError(fmt::format(
                "`{}` {:g}: is measured in space; leave it out in a plane", name, *target));
}

}  // namespace

template <int Dim>
MadeVoids<Dim> makeVoids(const VoidSetting<Dim>& s) {
    const VoidRecipe& r = s.recipe;
    const VoidMethod method = methodOf(r);
    MadeVoids<Dim> made;
    made.report.method = r.method;
    noteShell(s, made.report);
    if (method == VoidMethod::none || isThinning(method)) return made;
    if (method == VoidMethod::list) {
        made.list = readVoidList<Dim>(listFile(r));
        if (made.list.empty())
            throw InputError(listFile(r) + ": holds no voids; give a list with at least one row");
        double largest = 0;
        for (const auto& e : made.list) largest = std::max({largest, e.a, e.b});
        requireFitting(s, largest);
        bvtvOf(s, voxelFor(s, leastHalfAxis(made.list)), made);
    } else {
        std::vector<std::string> chosen;
        const bool undecided = (method == VoidMethod::boolean && !r.count && !r.targetBvtv) ||
                               (method == VoidMethod::foam && !r.targetBvtv &&
                                !(Dim == 3 && hasStructureTargets(r) && !s.bvtv));
        VoidRecipe decided = r;
        if (undecided && s.bvtv) {
            const double mean = meanBvtv(s);
            if (!(mean > 0 && mean < 1))
                throw InputError(fmt::format(
                    "`bvtvField` {}: BV/TV is {:g} in all of the domain; check `bvtvRange` {}",
                    r.bvtvField, mean, r.bvtvRange));
            decided.targetBvtv = mean;
            chosen.push_back(fmt::format(
                "{} BV/TV {:.4f}, the mean of {}",
                method == VoidMethod::foam ? "voids dilated to" : "as many voids as make", mean,
                r.bvtvField));
        } else if (undecided) {
            decided.targetBvtv = kDefaultBvtv;
            chosen.push_back(fmt::format(
                "{} BV/TV {}",
                method == VoidMethod::foam ? "voids dilated to" : "as many voids as make",
                kDefaultBvtv));
        }
        FoamPacks<Dim> ownPacks;
        FoamPacks<Dim>* const packs = s.packs ? s.packs : &ownPacks;
        if (hasStructureTargets(r)) {
            const bool open = !decided.targetBvtv;
            fitTo(s, *packs, decided, made.report);
            if (open)
                chosen.push_back(
                    fmt::format("BV/TV {:.4g}, as bone of that thickness and spacing has",
                                *decided.targetBvtv));
        }
        bool told = false;
        const auto solve = [&](const VoidSetting<Dim>& setting, MadeVoids<Dim>& result) {
            const VoidRecipe& asked = setting.recipe;
            const auto family = voidFamily(setting, asked.targetBvtv.value_or(kDefaultBvtv),
                                           told ? nullptr : &chosen);
            told = true;
            const double voxel = voxelFor(setting, family.leastHalfAxis);
            if (family.follow) family.follow(stampOptions(setting, voxel));
            const auto bvtvAt = [&](double amount) {
                result.list = family.list(amount);
                return bvtvOf(setting, voxel, result);
            };
            if (asked.targetBvtv)
                result.report.amount =
                    solveForBvtv(asked, 0, family.guess, family.most, bvtvTolerance(asked),
                                 family.remedy, bvtvAt, family.steepness);
            else
                bvtvAt(method == VoidMethod::boolean   ? *asked.count / regionOf(setting).volume()
                       : method == VoidMethod::overlay ? asked.count.value_or(family.most)
                                                       : asked.probability.value_or(1));
        };
        VoidSetting<Dim> setting = withRecipe(s, decided);
        setting.packs = packs;
        if (decided.targetTbth)
            solveThickness<Dim>(setting, made, solve);
        else
            solve(setting, made);
        made.report.chosen = chosen;
        warnIfOff(s, made.report);
        if (method == VoidMethod::overlay && r.count &&
            *r.count > static_cast<double>(made.list.size()) + 0.5)
            s.callbacks.warn(fmt::format("`voids.count` {:.0f}: only {} fit into the domain",
                                         *r.count, made.list.size()));
    }
    if (made.list.empty())
        s.callbacks.warn("no void lies in the part of the domain that may have them");
    return made;
}

template <int Dim>
PackResult<Dim> packWithHoles(const VoidSetting<Dim>& s, const PackOptions& options,
                              const std::vector<Sphere<Dim>>& existing, MadeVoids<Dim>& made) {
    const VoidRecipe& r = s.recipe;
    made.report.method = r.method;
    made.report.shell = r.shell;
    const VoidShape<Dim> shape = voidShapeOf(s, &made.report.chosen);
    const double voxel = voidVoxelFor(r, shape.radius.min() * std::min(1.0, shape.aspect.min()));
    PackResult<Dim> result;
    std::size_t holes = 0;
    double wanted = 0;
    const auto bvtvAt = [&](double probability) {
        PackOptions mixed = options;
        mixed.species.push_back({shape.radius, probability, r.shell});
        result = packSpheres(s.domain, mixed, s.callbacks, existing);
        std::vector<Sphere<Dim>> places;
        std::vector<std::uint8_t> keep(result.pack.spheres.size(), 1);
        for (std::size_t i = 0; i < keep.size(); ++i)
            if (result.species[i] != 0) {
                keep[i] = 0;
                places.push_back(result.pack.spheres[i]);
            }
        holes = places.size();
        made.report.amount = probability;
        const auto deep = deeperThan(result.pack.spheres, s.domain, r.shell);
        const auto core = std::max<std::ptrdiff_t>(1, std::count(deep.begin(), deep.end(), 1));
        made.report.reachedShare = static_cast<double>(holes) / static_cast<double>(core);
        wanted = probability * static_cast<double>(core);
        keepOnly(result.pack, keep);
        // Placed in this order, without gaps.
        for (std::size_t i = 0; i < result.pack.order.size(); ++i)
            result.pack.order[i] = static_cast<std::int64_t>(i);
        made.list = voidsAtSpheres(places, false, shape, s.seed);
        if (!result.interrupted) {
            try {
                return bvtvOf(s, voxel, made);
            } catch (const Interrupted&) {
                result.interrupted = true;
            }
        }
        // An interrupted pack is kept unchanged, without voids and further trials.
        made.stamped.reset();
        made.solid = {};
        made.report.bvtv.reset();
        return r.targetBvtv.value_or(0);
    };
    if (r.targetBvtv) {
        const double each = shape.meanMeasure(), ball = options.sizes.meanBall(Dim);
        // As if holes took their share of what is filled.
        const double left = -std::log(*r.targetBvtv);
        const double guess = std::clamp(left * ball / (left * ball + each), 1e-4, 0.3);
        solveForBvtv(r, 0, guess, kMostProbability, kPackedTolerance,
                     "; give larger or longer voids, or set `voids` boolean, whose voids overlap",
                     bvtvAt);
        if (!result.interrupted) warnIfOff(s, made.report);
    } else {
        if (!r.probability)
            made.report.chosen.push_back(
                fmt::format("a hole with probability {}", kDefaultProbability));
        bvtvAt(r.probability.value_or(kDefaultProbability));
    }
    if (holes == 0)
        s.callbacks.warn(
            "no hole found room: give smaller ones, a larger `voids.probability` or a "
            "thinner shell");
    else if (const auto found = static_cast<double>(holes);
             found < 0.8 * wanted && found < wanted - 3 * std::sqrt(wanted))  // no chance
        s.callbacks.warn(
            fmt::format("{:.3g} of the spheres were to be holes, {:.3g} are: no more found room",
                        *made.report.amount, *made.report.reachedShare));
    return result;
}

template <int Dim>
void measureVoids(const VoidSetting<Dim>& s, double contactTolerance, const Pack<Dim>* pack,
                  MadeVoids<Dim>& made) {
    if (made.stamped && !made.solid.grid) cut(s, made);
    if (pack && !s.recipe.keepConnected && (!s.recipe.empty() || s.recipe.hasShell()))
        attachedToShell(s, contactTolerance, *pack, made.report);
}

#define VDBPACK_INSTANTIATE(Dim)                                                              \
    template void warnIfOff(const VoidSetting<Dim>&, const VoidReport&);                      \
    template struct MadeVoids<Dim>;                                                           \
    template void checkRoom(const VoidSetting<Dim>&, bool);                                   \
    template MadeVoids<Dim> makeVoids(const VoidSetting<Dim>&);                               \
    template PackResult<Dim> packWithHoles(const VoidSetting<Dim>&, const PackOptions&,       \
                                           const std::vector<Sphere<Dim>>&, MadeVoids<Dim>&); \
    template void measureVoids(const VoidSetting<Dim>&, double, const Pack<Dim>*, MadeVoids<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
