#include "vdbpack/voids/void_families.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/domain/core_volume.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/voids/dilated_pack.h"
#include "vdbpack/voids/local_dilation.h"
#include "vdbpack/voids/orientation.h"
#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace vdbpack {

namespace {

/// Directions of the paper (see the README), about z or in the plane.
constexpr const char* kPaperCone = "tz=uniform:0,6.283185307179586;tx=uniform:-0.358,0.358";
constexpr const char* kPaperTilt = "phi=uniform:-0.358,0.358";
/// Holes of the paper's Figure 10, in largest radii of the spheres.
constexpr double kDefaultHole[2] = {1.5, 2.5};

/// Radii of large spheres pending at a time: a share of those that fit, within limits.
constexpr double kPendingShare = 0.1, kPendingVoids[2] = {4, 64};

/// So that the text of a default gives the same voids.
double sixDigits(double x) {
    if (!(x > 0)) return x;
    const double scale = std::pow(10, 5 - std::floor(std::log10(x)));
    return std::round(x * scale) / scale;
}

/// Where less is wanted, voids are as many as leave this share.
constexpr double kSparsestBvtv = 0.005;
constexpr double kFoamJitter = 0.25;
/// Points for the mean of a field.
constexpr int kFieldPoints = 200'000;

template <int Dim>
VoidFamily<Dim> booleanFamily(const VoidSetting<Dim>& s, double target,
                              std::vector<std::string>* chosen) {
    const VoidShape<Dim> shape = voidShapeOf(s, chosen);
    VoidFamily<Dim> family;
    family.guess = -std::log(target) / shape.meanMeasure();
    family.most = 60 / shape.meanMeasure();
    family.remedy = "; take larger voids";
    family.leastHalfAxis = shape.radius.min() * std::min(1.0, shape.aspect.min());
    const auto& setting = s;
    std::function<double(const Vec<Dim>&)> share;
    if (s.bvtv) {
        // Voids of density d leave the share exp(-d v).
        family.guess = -std::log(kSparsestBvtv) / shape.meanMeasure();
        share = [&setting](const Vec<Dim>& x) {
            return std::log(std::clamp(setting.bvtv(x), kSparsestBvtv, 1.0)) /
                   std::log(kSparsestBvtv);
        };
    }
    family.list = [&setting, shape, share](double density) {
        return booleanVoids(regionOf(setting), shape, setting.seed, density, share);
    };
    return family;
}

template <int Dim>
VoidFamily<Dim> overlayFamily(const VoidSetting<Dim>& s, std::vector<std::string>* chosen) {
    const VoidShape<Dim> shape = voidShapeOf(s, chosen);
    // The ellipsoids lie in balls that touch one another and stay clear of the shell.
    PackOptions options(shape.radius.scaled(std::max(1.0, shape.aspect.mean())));
    options.seed = s.seed;
    if (s.domain.cell().shortest() < 2 * kCellDiameters * options.sizes.max())
        throw InputError(
            fmt::format("the periodic cell is {:.6g} mm long, less than {:g} times the largest "
                        "void, {:.6g} mm. Give a longer cell or smaller voids",
                        s.domain.cell().shortest(), kCellDiameters, 2 * options.sizes.max()));
    const auto core = coreDomain(s.domain, s.recipe.shell);
    const double expected = 0.6 * regionOf(s).volume() / options.sizes.meanBall(Dim);
    options.pending = static_cast<std::size_t>(
        std::clamp(kPendingShare * expected, kPendingVoids[0], kPendingVoids[1]));
    Callbacks quiet;
    quiet.cancelled = s.callbacks.cancelled;
    const auto result = packSpheres(core ? *core : s.domain, options, quiet);
    if (result.interrupted) throw Interrupted();
    auto voids = voidsAtSpheres(result.pack.spheres, true, shape, s.seed);
    shuffle(voids, s.seed);
    VoidFamily<Dim> family;
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

/// The direction of all voids, if there is one.
template <int Dim>
std::optional<Vec<Dim>> commonAxis(const VoidSetting<Dim>& s) {
    const std::optional<VoidAxis>& axis = shapeOf(s.recipe)->orientation.axis;
    if (!axis) return std::nullopt;
    const Vec<Dim> direction = directionOf<Dim>(*axis);
    return Dim == 3 && direction[Dim - 1] < 0 ? -direction : direction;
}

template <int Dim>
VoidFamily<Dim> foamFamily(const VoidSetting<Dim>& s, const FoamVoids& foam, double target,
                           std::vector<std::string>* chosen) {
    const VoidShape<Dim> shape = voidShapeOf(s, chosen);
    const PeriodicCell<Dim> cell = s.domain.cell();
    const FoamOptions<Dim> options{compressible(commonAxis(s), cell),
                                   foam.jitter.value_or(kFoamJitter), s.seed};
    FoamPacks<Dim> own;
    FoamPacks<Dim>& packs = s.packs ? *s.packs : own;
    const auto pack = packs.get(voidRadii(s, nullptr), foamExtent(regionOf(s), shape, options),
                                cell.wraps, s.seed, s.callbacks);
    const auto voids = foamVoids(regionOf(s), pack->pack, shape, options);
    VoidFamily<Dim> family;
    family.most = kMostDilation;
    // Spheres that touch leave 0.36 (2D: 0.17), an eighth more in radius a third of that.
    const double touching = Dim == 3 ? 0.36 : 0.17;
    family.guess = target > touching ? std::pow((1 - target) / (1 - touching), 1.0 / Dim)
                                     : 1 + 0.125 * std::log(touching / target);
    if (packs.dilation > 0) family.guess = packs.dilation;
    // Measured; the walls of all voids move at once.
    family.steepness = 2 + 0.27 / target;
    family.remedy = "; take larger voids, or a smaller `voids.jitter`";
    family.leastHalfAxis = leastHalfAxis(voids);
    const auto& setting = s;
    const auto local = std::make_shared<std::vector<double>>();
    family.list = [&setting, voids, local](double factor) {
        return dilated(regionOf(setting), voids, factor, *local);
    };
    if (!s.bvtv) return family;
    family.guess = 1;
    family.follow = [&setting, voids, local, target](const StampOptions<Dim>& stamp) {
        const double mean = meanBvtv(setting), share = mean > 0 ? target / mean : 1;
        const auto wanted = [&setting, share](const Vec<Dim>& x) {
            return std::clamp(share * setting.bvtv(x), 0.0, 1.0);
        };
        *local = localDilation<Dim>(regionOf(setting), voids, wanted, stamp, setting.callbacks);
    };
    return family;
}

template <int Dim>
VoidFamily<Dim> gridFamily(const VoidSetting<Dim>& s, const GridVoids& grid,
                           std::vector<std::string>* chosen) {
    std::shared_ptr<const VoidMatrix> matrix;
    if (!grid.matrix.empty()) matrix = std::make_shared<VoidMatrix>(readVoidMatrix(grid.matrix));
    if (Dim == 2 && matrix && matrix->size[2] > 1)
        throw InputError(fmt::format("{}: has {} layers, but the domain is a plane; keep one layer",
                                     grid.matrix, matrix->size[2]));
    const PeriodicCell<Dim> cell = s.domain.cell();
    const auto lattice = voidLattice<Dim>(s.domain.bounds(), grid.cell, matrix.get(), cell.wraps);
    if (cell.any() && !grid.cell.empty() && chosen) {
        std::string sides;
        for (int d = 0; d < Dim; ++d)
            sides += fmt::format("{}{:.6g}", d > 0 ? " by " : "", lattice.cell[d]);
        chosen->push_back(
            fmt::format("boxes of {} mm, of which whole numbers make the periodic cell", sides));
    }
    VoidFamily<Dim> family;
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

}  // namespace

template <int Dim>
std::shared_ptr<const typename FoamPacks<Dim>::Entry> FoamPacks<Dim>::get(
    const SizeDistribution& sizes, const Vec<Dim>& half, const std::array<bool, Dim>& wraps,
    std::uint64_t seed, const Callbacks& callbacks) {
    for (const auto& entry : entries)
        if (entry->seed == seed && entry->sizes == sizes.spec() && entry->pack.fills(half, wraps))
            return entry;
    entries.push_back(std::make_shared<const Entry>(
        Entry{sizes.spec(), seed, foamPack<Dim>(sizes, half, seed, callbacks, wraps)}));
    return entries.back();
}

template <int Dim>
VoidRegion<Dim> regionOf(const VoidSetting<Dim>& s) {
    return {s.domain, shellOf(s)};
}

SizeDistribution defaultVoidRadius(double largestSphere) {
    return SizeDistribution::uniform(sixDigits(kDefaultHole[0] * largestSphere),
                                     sixDigits(kDefaultHole[1] * largestSphere));
}

template <int Dim>
SizeDistribution voidRadii(const VoidSetting<Dim>& s, std::vector<std::string>* chosen) {
    const SizeRequest& asked = shapeOf(s.recipe)->radius;
    if (!asked.empty()) return asked.in(Dim);
    const SizeDistribution radii = defaultVoidRadius(s.largestRadius);
    if (chosen)
        chosen->push_back(
            fmt::format("void radii {} mm, 1.5 to 2.5 times the largest sphere", radii.spec()));
    return radii;
}

template <int Dim>
VoidShape<Dim> voidShapeOf(const VoidSetting<Dim>& s, std::vector<std::string>* chosen) {
    const VoidShapeRecipe& asked = *shapeOf(s.recipe);
    const bool foam = std::holds_alternative<FoamVoids>(s.recipe.method);
    const auto* holes = std::get_if<FrontHoles>(&s.recipe.method);
    const bool directed = asked.orientation.any();
    // A foam without a direction has none.
    const bool ball = (holes && holes->as == FrontHoles::As::spheres) ||
                      (foam && !directed && asked.aspect.empty());
    OrientationRecipe orientation = asked.orientation;
    if (!directed) {
        const bool isotropic = foam || std::holds_alternative<BooleanVoids>(s.recipe.method);
        orientation.angles = VoidAngles::parse(isotropic || ball ? "isotropic"
                                               : Dim == 3        ? kPaperCone
                                                                 : kPaperTilt);
        if (chosen && !ball)
            chosen->push_back(fmt::format("void directions {}", orientation.angles->text));
    }
    SizeRequest aspect = asked.aspect;
    if (ball) aspect = SizeDistribution::constant(1);
    if (aspect.empty()) {
        aspect = SizeDistribution::constant(foam ? kDefaultFoamAspect : kDefaultAspect);
        if (chosen)
            chosen->push_back(foam ? "voids 1.4 times as long as wide"
                                   : "voids twice as long as wide");
    }
    return {voidRadii(s, chosen).scaled(asked.radiusFactor), aspect.in(Dim),
            makeOrientation<Dim>(orientation, s.domain.bounds(), s.sliceHeight)};
}

template <int Dim>
double meanBvtv(const VoidSetting<Dim>& s) {
    // The additive recurrence in the box around the domain (Roberts 2018).
    constexpr double kSteps[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    const Box<Dim> box = s.domain.bounds();
    const auto envelope = s.domain.envelope().sampler(), inside = s.domain.sampler();
    const ShellThickness shell = shellOf(s);
    double sum = 0;
    int count = 0;
    for (int k = 0; k < kFieldPoints; ++k) {
        Vec<Dim> x;
        for (int d = 0; d < Dim; ++d)
            x[d] = box.lo[d] + std::fmod((k + 0.5) * kSteps[d], 1.0) * box.size()[d];
        if (!(shell.isDeeper(x, -envelope->signedDistance(x)) && inside->signedDistance(x) < 0))
            continue;
        sum += s.bvtv(x);
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

template <int Dim>
VoidFamily<Dim> voidFamily(const VoidSetting<Dim>& s, double bvtv,
                           std::vector<std::string>* chosen) {
    if (std::holds_alternative<BooleanVoids>(s.recipe.method))
        return booleanFamily(s, bvtv, chosen);
    if (std::holds_alternative<OverlayVoids>(s.recipe.method)) return overlayFamily(s, chosen);
    if (const auto* foam = std::get_if<FoamVoids>(&s.recipe.method))
        return foamFamily(s, *foam, bvtv, chosen);
    if (const auto* grid = std::get_if<GridVoids>(&s.recipe.method))
        return gridFamily(s, *grid, chosen);
    throw ParameterError("`voids` " + nameOf(s.recipe) + ": is no family of voids at random");
}

#define VDBPACK_INSTANTIATE(Dim)                                                             \
    template struct FoamPacks<Dim>;                                                          \
    template VoidRegion<Dim> regionOf(const VoidSetting<Dim>&);                              \
    template double meanBvtv(const VoidSetting<Dim>&);                                       \
    template SizeDistribution voidRadii(const VoidSetting<Dim>&, std::vector<std::string>*); \
    template VoidShape<Dim> voidShapeOf(const VoidSetting<Dim>&, std::vector<std::string>*); \
    template VoidFamily<Dim> voidFamily(const VoidSetting<Dim>&, double, std::vector<std::string>*);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
