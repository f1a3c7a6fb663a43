#include "vdbpack/run/void_stage.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/domain/surface_level_set.h"
#include "vdbpack/measure/attached.h"
#include "vdbpack/measure/morphometry/trabeculae.h"
#include "vdbpack/pack/largest_ball.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/solve_target.h"
#include "vdbpack/voids/stamp_memory.h"
#include "vdbpack/voids/thinning.h"
#include "vdbpack/voids/void_list.h"
#include "vdbpack/voids/void_matrix.h"

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
constexpr const char* kPaperCone = "tz=uniform:0,6.283185307179586;tx=uniform:-0.358,0.358";
constexpr const char* kPaperTilt = "phi=uniform:-0.358,0.358";
/// Holes of the paper's Figure 10, in largest radii of the spheres.
constexpr double kDefaultHole[2] = {1.5, 2.5};

/// Voxels of the shorter half-axis at the least, and of a wanted thickness.
constexpr double kVoxelsPerHalfAxis = 4, kVoxelsPerThickness = 4;

/// How near to a wanted BV/TV the voids are made, where they are a list and where they are packed.
constexpr double kBvtvTolerance = 0.0005, kPackedTolerance = 0.002;
constexpr double kBvtvWarning = 0.005;
constexpr double kThicknessTolerance = 0.01;
constexpr int kThicknessRounds = 4;
/// Voxels along the side of the cube that a thickness is measured in.
constexpr double kThicknessVoxels = 320;
/// Radii of large spheres pending at a time, as a share of those that fit and at least and most.
constexpr double kPendingShare = 0.1, kPendingVoids[2] = {4, 64};
/// Holes with less beside them would be no pack.
constexpr double kMostProbability = 0.9;

template <int Dim>
Vec<Dim> latticeOf(const VoidSetting<Dim>& s, double voxelSize) {
    return fieldOrigin(s.domain.bounds(), voxelSize);
}

template <int Dim>
VoidRegion<Dim> regionOf(const VoidSetting<Dim>& s) {
    return {s.domain, s.recipe.shell};
}

/// `f` times all lengths of a SPEC.
std::string timesSpec(const std::string& spec, double f, int dim) {
    return SizeDistribution::parse(spec, dim).scaled(f).spec();
}

template <int Dim>
std::string radiusSpec(const VoidSetting<Dim>& s, std::vector<std::string>* chosen) {
    if (!s.recipe.radius.empty()) return s.recipe.radius;
    const std::string spec = fmt::format("uniform:{:.6g},{:.6g}", kDefaultHole[0] * s.largestRadius,
                                         kDefaultHole[1] * s.largestRadius);
    if (chosen)
        chosen->push_back(
            fmt::format("void radii {} mm, 1.5 to 2.5 times the largest sphere, since "
                        "`voids.radius` is not given",
                        spec));
    return spec;
}

template <int Dim>
VoidShape<Dim> shapeOf(const VoidSetting<Dim>& s, std::vector<std::string>* chosen = nullptr) {
    const VoidMethod method = methodOf(s.recipe);
    const bool ball = method == VoidMethod::mixed;
    OrientationRecipe orientation = s.recipe.orientation;
    if (orientation.angles.empty() && orientation.axis.empty() && orientation.field.empty()) {
        orientation.angles = method == VoidMethod::boolean || ball ? "isotropic"
                             : Dim == 3                            ? kPaperCone
                                                                   : kPaperTilt;
        if (chosen && !ball)
            chosen->push_back(
                fmt::format("void directions {}, since none are given", orientation.angles));
    }
    std::string aspect = s.recipe.aspect;
    if (ball) aspect = "constant:1";
    if (aspect.empty()) {
        aspect = "constant:2";
        if (chosen)
            chosen->push_back("voids twice as long as wide, since `voids.aspect` is not given");
    }
    return {SizeDistribution::parse(radiusSpec(s, chosen), Dim),
            SizeDistribution::parse(aspect, Dim),
            makeOrientation<Dim>(orientation, s.domain.bounds(), s.sliceHeight)};
}

template <int Dim>
double coreOf(const VoidSetting<Dim>& s) {
    return regionOf(s).volume();
}

/// Stamps a list, and cuts it where pieces are to be dropped; sets BV/TV.
template <int Dim>
void stamp(const VoidSetting<Dim>& s, double voxelSize, MadeVoids<Dim>& made) {
    StampOptions<Dim> options;
    options.voxelSize = voxelSize;
    options.origin = latticeOf(s, voxelSize);
    options.shell = s.recipe.shell;
    if (s.recipe.cull == Cull::touch) options.reach = s.largestRadius + 2 * voxelSize;
    made.stamped = stampVoids(made.list, s.domain, options, s.callbacks);
    made.report.count = made.list.size();
    made.report.voxelSize = voxelSize;
    made.report.totalVolume = coreOf(s);
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
    made.solid = cutVoids(*made.surface, *made.voids, s.recipe.shell, s.recipe.keepConnected);
    made.report.solidAttached = made.solid.attached;
    made.report.solidPieces = made.solid.pieces;
    made.report.bvtv =
        std::max(0.0, 1 - (made.stamped->volume() + made.solid.dropped) / made.report.totalVolume);
}
void cut(const VoidSetting<2>&, MadeVoids<2>&) {}

/// BV/TV of what `made` holds, with what is dropped.
template <int Dim>
double bvtvOf(const VoidSetting<Dim>& s, double voxelSize, MadeVoids<Dim>& made) {
    stamp(s, voxelSize, made);
    if (s.recipe.keepConnected) cut(s, made);
    return *made.report.bvtv;
}

/// Few large voids leave steps between the amounts there are.
template <int Dim>
void warnIfOff(const VoidSetting<Dim>& s, const VoidReport& report) {
    if (!s.recipe.targetBvtv || std::fabs(*report.bvtv - *s.recipe.targetBvtv) <= kBvtvWarning)
        return;
    s.callbacks.warn(fmt::format(
        "`targetBvtv` {}: {:.4f} is as near as it gets; give smaller voids or a larger domain",
        *s.recipe.targetBvtv, *report.bvtv));
}

/// Lists of one method by how much of it there is.
template <int Dim>
struct Family {
    double most = 0;   ///< the largest amount; infinite where there is no end
    double guess = 0;  ///< of the amount for the target
    std::string remedy;
    double leastHalfAxis = 0;
    std::function<std::vector<Ellipsoid<Dim>>(double amount)> list;
};

template <int Dim>
Family<Dim> booleanFamily(const VoidSetting<Dim>& s, double target,
                          std::vector<std::string>* chosen) {
    const VoidShape<Dim> shape = shapeOf(s, chosen);
    Family<Dim> family;
    family.guess = -std::log(target) / shape.meanMeasure();
    family.most = 60 / shape.meanMeasure();
    family.remedy = "; take larger voids";
    family.leastHalfAxis = shape.radius.min() * std::min(1.0, shape.aspect.min());
    const auto& setting = s;
    family.list = [&setting, shape](double density) {
        return booleanVoids(regionOf(setting), shape, setting.seed, density);
    };
    return family;
}

template <int Dim>
Family<Dim> overlayFamily(const VoidSetting<Dim>& s, std::vector<std::string>* chosen) {
    const VoidShape<Dim> shape = shapeOf(s, chosen);
    // Balls that hold the ellipsoids touch one another; those lie apart from the shell as well.
    PackOptions options(shape.radius.scaled(std::max(1.0, shape.aspect.mean())));
    options.seed = s.seed;
    std::unique_ptr<Domain<Dim>> inset;
    if (s.recipe.shell > 0) inset = insetDomain(s.domain, s.recipe.shell);
    const double expected = 0.6 * coreOf(s) / options.sizes.meanBall(Dim);
    options.pending = static_cast<std::size_t>(
        std::clamp(kPendingShare * expected, kPendingVoids[0], kPendingVoids[1]));
    Callbacks quiet;
    quiet.cancelled = s.callbacks.cancelled;
    const auto result = packSpheres(inset ? *inset : s.domain, options, quiet);
    if (result.interrupted) throw Interrupted();
    auto voids = voidsAtSpheres(result.pack.spheres, true, shape, s.seed);
    shuffle(voids, s.seed);
    Family<Dim> family;
    family.most = static_cast<double>(voids.size());
    family.guess = 0.5 * family.most;
    family.remedy = "; take a smaller `voids.aspect`, or `voids` boolean, whose voids overlap";
    family.leastHalfAxis = leastHalfAxis(voids);
    family.list = [voids](double count) {
        const auto n = static_cast<std::ptrdiff_t>(
            std::clamp(std::round(count), 0.0, static_cast<double>(voids.size())));
        return std::vector<Ellipsoid<Dim>>(voids.begin(), voids.begin() + n);
    };
    return family;
}

template <int Dim>
Family<Dim> gridFamily(const VoidSetting<Dim>& s) {
    std::shared_ptr<const VoidMatrix> matrix;
    if (!s.recipe.matrix.empty())
        matrix = std::make_shared<VoidMatrix>(readVoidMatrix(s.recipe.matrix));
    if (Dim == 2 && matrix && matrix->size[2] > 1)
        throw InputError(fmt::format("{}: holds {} layers, and the domain is a plane; keep one",
                                     s.recipe.matrix, matrix->size[2]));
    const auto lattice = voidLattice(s.domain.bounds(), s.recipe.cell, matrix.get());
    Family<Dim> family;
    family.most = 1;
    family.guess = 0.5;
    family.remedy = "; take `voids` boolean, whose voids overlap";
    const auto& setting = s;
    family.list = [&setting, lattice, matrix](double probability) {
        return latticeVoids(regionOf(setting), lattice, matrix.get(), probability, setting.seed);
    };
    family.leastHalfAxis = leastHalfAxis(family.list(1));
    return family;
}

/// Scales the voids until the walls between them have the wanted thickness at the wanted BV/TV.
void solveThickness(const VoidSetting<3>& s, MadeVoids<3>& made,
                    const std::function<void(const VoidSetting<3>&, MadeVoids<3>&)>& solve) {
    VoidRecipe recipe = s.recipe;
    recipe.radius = radiusSpec(s, nullptr);
    const double target = *recipe.targetTbth;
    const Vec<3> size = s.domain.bounds().size();
    const double side = *std::min_element(size.c.begin(), size.c.end());
    if (!(target < 0.25 * side))
        throw ParameterError(
            fmt::format("`targetTbth` {}: not reachable, trabeculae in a domain of {:.4g} mm are "
                        "thinner than a "
                        "quarter of it; give a smaller one",
                        target, side));
    // Walls are about as thick as b times -1/ln(BV/TV), to begin with: then by what was measured.
    const SizeDistribution first = SizeDistribution::parse(recipe.radius, 3);
    if (s.recipe.radius.empty())
        recipe.radius = timesSpec(recipe.radius, 1.2 * target / first.mean(), 3);
    // A part of a large bone tells the thickness of all.
    const Sphere<3> deepest = largestBall(s.domain);
    for (int round = 0;; ++round) {
        const VoidSetting<3> setting{recipe, s.domain,        s.sliceHeight,
                                     s.seed, s.largestRadius, s.callbacks};
        made.surface.reset();
        solve(setting, made);
        cut(setting, made);
        s.callbacks.stopIfCancelled();
        const double edge = kThicknessVoxels * made.report.voxelSize;
        const Box<3> sample = intersection(
            s.domain.bounds(), Box<3>{deepest.center, deepest.center}.grown(0.5 * edge));
        const auto thickness =
            trabecularThickness(*made.solid.grid, sample, s.domain, s.recipe.shell);
        if (!thickness)
            throw InputError(fmt::format(
                "`targetTbth` {}: no solid is left to measure; give a higher `targetBvtv`",
                target));
        made.report.thickness = thickness;
        made.report.radius = recipe.radius;
        if (std::fabs(*thickness - target) <= kThicknessTolerance * target ||
            round == kThicknessRounds)
            break;
        recipe.radius = timesSpec(recipe.radius, target / *thickness, 3);
    }
    if (std::fabs(*made.report.thickness - target) > 0.05 * target)
        s.callbacks.warn(fmt::format(
            "`targetTbth` {}: {:.4g} mm is as near as it gets; give a larger domain or a smaller "
            "`voids.voxelSize`",
            target, *made.report.thickness));
}
void solveThickness(const VoidSetting<2>&, MadeVoids<2>&,
                    const std::function<void(const VoidSetting<2>&, MadeVoids<2>&)>&) {
    throw ParameterError("`targetTbth` is measured in space; leave it out in a plane");
}

}  // namespace

template <int Dim>
std::vector<std::shared_ptr<const VdbGrid>> MadeVoids<Dim>::levelSets() const {
    if (!solid.grid) return {};
    return {surface, voids, solid.grid};
}

double voidVoxelFor(const VoidRecipe& recipe, double least) {
    if (recipe.voxelSize > 0) return recipe.voxelSize;
    const double voxel = least / kVoxelsPerHalfAxis;
    return recipe.targetTbth ? std::min(voxel, *recipe.targetTbth / kVoxelsPerThickness) : voxel;
}

double plannedVoxel(const VoidRecipe& recipe, int dim) {
    const VoidMethod method = methodOf(recipe);
    if (method == VoidMethod::none || isThinning(method) || recipe.radius.empty() ||
        recipe.voxelSize > 0 || recipe.targetTbth)
        return recipe.voxelSize;
    const double aspect =
        recipe.aspect.empty() ? 1 : SizeDistribution::parse(recipe.aspect, dim).min();
    return voidVoxelFor(recipe,
                        SizeDistribution::parse(recipe.radius, dim).min() * std::min(1.0, aspect));
}

double depthForShell(const VoidRecipe& recipe) {
    return recipe.shell > 0 ? 1.1 * recipe.shell + 10 * recipe.voxelSize : 0;
}

namespace {

/// Refuses voids that are larger than the domain.
template <int Dim>
void requireFitting(const VoidSetting<Dim>& s, double halfAxis) {
    const Vec<Dim> size = s.domain.bounds().size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
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
    const double core = coreOf(s);
    if (!(core > 1e-9 * s.domain.volume()))
        throw InputError(fmt::format(
            "`shell` {} mm: everything is cortical, nothing of the domain lies deeper (its deepest "
            "place lies {:.4g} mm below the wall); give a thinner shell",
            s.recipe.shell, largestBall(s.domain).radius));
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
        const auto list = method == VoidMethod::grid ? gridFamily(s).list(1)
                                                     : readVoidList<Dim>(listFile(s.recipe));
        for (const auto& e : list) half = std::max({half, e.a, e.b});
    } else {
        half = shapeOf(s).reach();
    }
    requireFitting(s, half);
    // What is there before hours of work; the list itself is looked at again.
    if (method == VoidMethod::boolean && s.recipe.count) {
        const VoidShape<Dim> shape = shapeOf(s);
        Ellipsoid<Dim> e;
        e.center = s.domain.bounds().center();
        e.a = shape.radius.mean() * shape.aspect.mean();
        e.b = shape.radius.mean();
        e.axis[0] = 1;
        StampOptions<Dim> options;
        options.voxelSize =
            voidVoxelFor(s.recipe, shape.radius.min() * std::min(1.0, shape.aspect.min()));
        requireStampMemory(*s.recipe.count, e, s.domain, options);
    }
}

template <int Dim>
MadeVoids<Dim> makeVoids(const VoidSetting<Dim>& s) {
    const VoidRecipe& r = s.recipe;
    const VoidMethod method = methodOf(r);
    MadeVoids<Dim> made;
    made.report.method = r.method;
    made.report.shell = r.shell;
    if (method == VoidMethod::none || isThinning(method)) return made;
    if (method == VoidMethod::list) {
        made.list = readVoidList<Dim>(listFile(r));
        if (made.list.empty())
            throw InputError(listFile(r) + ": holds no voids; give a list with at least one row");
        double largest = 0;
        for (const auto& e : made.list) largest = std::max({largest, e.a, e.b});
        requireFitting(s, largest);
        bvtvOf(s, voidVoxelFor(r, leastHalfAxis(made.list)), made);
    } else {
        std::vector<std::string> chosen;
        const auto familyOf = [&](const VoidSetting<Dim>& setting, double target,
                                  std::vector<std::string>* sentences) {
            return method == VoidMethod::boolean   ? booleanFamily(setting, target, sentences)
                   : method == VoidMethod::overlay ? overlayFamily(setting, sentences)
                                                   : gridFamily(setting);
        };
        const bool undecided = method == VoidMethod::boolean && !r.count && !r.targetBvtv;
        VoidRecipe decided = r;
        if (undecided) {
            decided.targetBvtv = kDefaultBvtv;
            chosen.push_back(
                fmt::format("as many voids as make BV/TV {}, since neither "
                            "`targetBvtv` nor `voids.count` is given",
                            kDefaultBvtv));
        }
        bool told = false;
        const auto solve = [&](const VoidSetting<Dim>& setting, MadeVoids<Dim>& result) {
            const VoidRecipe& asked = setting.recipe;
            const auto family = familyOf(setting, asked.targetBvtv.value_or(kDefaultBvtv),
                                         told ? nullptr : &chosen);
            told = true;
            const double voxel = voidVoxelFor(asked, family.leastHalfAxis);
            const auto bvtvAt = [&](double amount) {
                result.list = family.list(amount);
                return bvtvOf(setting, voxel, result);
            };
            if (asked.targetBvtv)
                result.report.amount = solveForBvtv(asked, 0, family.guess, family.most,
                                                    kBvtvTolerance, family.remedy, bvtvAt);
            else
                bvtvAt(method == VoidMethod::boolean   ? *asked.count / coreOf(setting)
                       : method == VoidMethod::overlay ? asked.count.value_or(family.most)
                                                       : asked.probability.value_or(1));
        };
        const VoidSetting<Dim> setting{decided, s.domain,        s.sliceHeight,
                                       s.seed,  s.largestRadius, s.callbacks};
        if (r.targetTbth)
            solveThickness(setting, made, solve);
        else
            solve(setting, made);
        made.report.chosen = chosen;
        warnIfOff(s, made.report);
        if (method == VoidMethod::overlay && r.count &&
            *r.count > static_cast<double>(made.list.size()) + 0.5)
            s.callbacks.warn(fmt::format("`voids.count` {:.0f}: {} fill the domain, no more fit",
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
    const VoidShape<Dim> shape = shapeOf(s, &made.report.chosen);
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
        // What is complete is kept as it is, neither cut nor tried again.
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
                     "; take larger or longer voids, or `voids` boolean, whose voids overlap",
                     bvtvAt);
        if (!result.interrupted) warnIfOff(s, made.report);
    } else {
        if (!r.probability)
            made.report.chosen.push_back(
                fmt::format("a hole with probability {}, since neither `voids.probability` nor "
                            "`targetBvtv` is given",
                            kDefaultProbability));
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

namespace {

/// Which spheres hang together with the shell, or the largest set that does; sets its share.
template <int Dim>
std::vector<std::uint8_t> hangsTogether(const VoidSetting<Dim>& s, double contactTolerance,
                                        const Pack<Dim>& pack, VoidReport& report) {
    auto attached = attachedSpheres(pack.spheres,
                                    s.recipe.shell > 0 ? pack.region : std::vector<std::int32_t>{},
                                    contactTolerance);
    const auto held = static_cast<double>(std::count(attached.begin(), attached.end(), 1));
    if (!attached.empty()) report.spheresAttached = held / static_cast<double>(attached.size());
    return attached;
}

}  // namespace

template <int Dim>
void measureVoids(const VoidSetting<Dim>& s, double contactTolerance, const Pack<Dim>* pack,
                  MadeVoids<Dim>& made) {
    if (made.stamped && !made.solid.grid) cut(s, made);
    if (pack && !s.recipe.keepConnected && (!s.recipe.empty() || s.recipe.shell > 0))
        hangsTogether(s, contactTolerance, *pack, made.report);
}

template <int Dim>
void cullPack(const VoidSetting<Dim>& s, double contactTolerance, std::size_t standing,
              MadeVoids<Dim>& made, Pack<Dim>& pack) {
    const VoidRecipe& r = s.recipe;
    const VoidMethod method = methodOf(r);
    if (method == VoidMethod::none && !(r.shell > 0)) {
        pack.region.assign(pack.spheres.size(), 0);  // all compact
        return;
    }
    made.report.method = r.method;
    made.report.shell = r.shell;
    pack.region = deeperThan(pack.spheres, s.domain, r.shell);
    const std::size_t before = pack.spheres.size();
    std::vector<std::uint8_t> keep;
    if (isThinning(method)) {
        auto candidates = pack.region;
        std::fill_n(candidates.begin(), std::min(standing, before), 0);
        double all = 0;
        for (std::size_t i = 0; i < before; ++i)
            if (pack.region[i]) all += Measure<Dim>::ball(pack.spheres[i].radius);
        const auto bvtvAt = [&](double fraction) {
            fraction = std::max(fraction, 1e-6);
            keep = method == VoidMethod::threshold
                       ? removeLargest(pack.spheres, candidates, fraction)
                       : removeAround(pack.spheres, candidates, fraction, s.seed);
            double left = 0;
            for (std::size_t i = 0; i < before; ++i)
                if (pack.region[i] && keep[i]) left += Measure<Dim>::ball(pack.spheres[i].radius);
            return all > 0 ? left / all : 0.0;
        };
        made.report.ofSpheres = true;
        made.report.totalVolume = coreOf(s);
        if (r.targetBvtv)
            made.report.amount =
                solveForBvtv(r, 0, 1 - *r.targetBvtv, 1, kBvtvTolerance, "", bvtvAt);
        else
            made.report.amount = r.deleteFraction;
        made.report.bvtv = bvtvAt(*made.report.amount);
        warnIfOff(s, made.report);
    } else if (made.stamped) {
        keep = r.cull == Cull::touch
                   ? spheresOutside(pack.spheres, *made.stamped, r.cull)
                   : centersOutside(pack.spheres, made.list, *made.stamped, pack.region);
    }
    if (!keep.empty()) {
        std::fill_n(keep.begin(), std::min(standing, before), 1);
        keepOnly(pack, keep);
        made.report.culled = before - pack.spheres.size();
    }
    if (r.keepConnected) {
        auto stay = hangsTogether(s, contactTolerance, pack, made.report);
        std::fill_n(stay.begin(), std::min(standing, stay.size()), 1);
        const std::size_t count = pack.spheres.size();
        keepOnly(pack, stay);
        made.report.dropped = count - pack.spheres.size();
    }
    if (r.shell > 0 && !pack.spheres.empty()) {
        double mean = 0;
        std::size_t cortical = 0;
        for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
            if (pack.region[i]) continue;
            mean += pack.spheres[i].radius;
            ++cortical;
        }
        made.report.cortical = cortical;
        if (cortical > 0) {
            made.report.across = r.shell / (2 * mean / static_cast<double>(cortical));
            if (*made.report.across < 3)
                s.callbacks.warn(
                    fmt::format("the shell of {} mm is {:.2g} {} thick; below three it is no "
                                "layer: take smaller "
                                "radii or a thicker shell",
                                r.shell, *made.report.across, Measure<Dim>::kSpheres));
        }
    }
}

#define VDBPACK_INSTANTIATE(Dim)                                                              \
    template struct MadeVoids<Dim>;                                                           \
    template void checkRoom(const VoidSetting<Dim>&, bool);                                   \
    template MadeVoids<Dim> makeVoids(const VoidSetting<Dim>&);                               \
    template PackResult<Dim> packWithHoles(const VoidSetting<Dim>&, const PackOptions&,       \
                                           const std::vector<Sphere<Dim>>&, MadeVoids<Dim>&); \
    template void measureVoids(const VoidSetting<Dim>&, double, const Pack<Dim>*,             \
                               MadeVoids<Dim>&);                                              \
    template void cullPack(const VoidSetting<Dim>&, double, std::size_t, MadeVoids<Dim>&,     \
                           Pack<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
