#include "vdbpack/voids/foam_model.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/voids/make_voids.h"
#include "vdbpack/voids/structure_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace vdbpack {

namespace {

/// What looks like bone, and how far each may go.
std::vector<Knob> usualKnobs() {
    return {{0, 1e6, -40, 40, 0.05, 0.4},                         // scale
            {0.4, 0.2, 0.05, 0.75, 0.12, 0.2},                    // spread
            {0.336, 1, 0, 1.2, 0.15, 0.3},                        // aspect
            {0.35, 0.4, 0, 1, 0.2, 0.3},                          // jitter
            {-2.5, 0.8, -3.9, -0.9, 0.4, 0.6},                    // blend
            {0.6, 0.4, 0, 1, -0.25, 0.35},                        // share of struts
            {0, 0.3, std::log(0.03), std::log(0.6), 0.1, 0.3},    // BV/TV
            {0, 0.3, std::log(0.06), std::log(0.3), -0.2, 0.3}};  // width of struts
}

/// BV/TV if no target says or suggests it.
constexpr double kUsualBvtv = 0.2;
/// The most of the BV/TV of plates: means of local thickness weigh thick places more.
constexpr double kMostOfUsualPlates = 1.1;
/// Mean b in trabecular periods (Tb.Th + Tb.Sp); Conn.D times a period cubed of usual bone.
constexpr double kRadiusInPeriods = 0.28, kUsualConnectivity = 5;
/// Standard deviation of the local spacing in its mean, for a spread of 1.
constexpr double kScatterOfSpread = 0.85;
/// Errors of DA and of scatters are relative to this at the least.
constexpr double kLeastFloor = 0.2;
/// Scatters are not numbers that were asked for: an error of them counts this much.
constexpr double kThicknessScatterWeight = 0.15, kSeparationScatterWeight = 0.15;
/// Share of the solid that may lie beside its largest component; more of it counts.
constexpr double kFewCrumbs = 0.005, kCrumbsWeight = 1;

/// @param t  has the distributions of the sample, if distances are asked for.
double numberOf(const Morphometry& m, Number number, const FoamTargets& t) {
    switch (number) {
        case Number::thickness:
            return m.thickness->mean;
        case Number::spacing:
            return m.separation->mean;
        case Number::anisotropy:
            return m.anisotropy->degree;
        case Number::connectivity:
            return m.connectivityDensity;
        case Number::thicknessScatter:
            return m.thickness->sd / m.thickness->mean;
        case Number::spacingScatter:
            return m.separation->sd / m.separation->mean;
        case Number::crumbs:
            return std::max(1 - m.largestComponent.value_or(0), kFewCrumbs);
        case Number::thicknessDistance:
            return std::max(distanceTo(*m.thickness, t.thicknessQuantiles), kNearDistance);
        case Number::spacingDistance:
            return std::max(distanceTo(*m.separation, t.separationQuantiles), kNearDistance);
    }
    return 0;
}

/// Thickness of trabeculae in their spacing, of usual bone.
double usualSlenderness(double bvtv) {
    return 0.1 + 0.8 * bvtv;
}

/// The reverse, in what plates of that thickness would have.
double usualBvtv(double slenderness) {
    const double plates = slenderness / (1 + slenderness);
    return std::clamp((slenderness - 0.1) / 0.8, 0.4 * plates, kMostOfUsualPlates * plates);
}

/// What usual bone has where the targets leave it open, mm.
struct Guess {
    double bvtv = 0, period = 0, thickness = 0;
};

/// @param radius  mean b if no target is a length, mm.
Guess guessOf(const FoamVoids& foam, double radius) {
    const FoamTargets& t = foam.targets;
    Guess g;
    g.bvtv = foam.targetBvtv.value_or(t.tbth && t.tbsp ? usualBvtv(*t.tbth / *t.tbsp) : kUsualBvtv);
    const double slender = usualSlenderness(g.bvtv);
    g.period = t.tbth && t.tbsp ? *t.tbth + *t.tbsp
               : t.tbth         ? *t.tbth * (1 + 1 / slender)
               : t.tbsp         ? *t.tbsp * (1 + slender)
               : t.connd        ? std::cbrt(kUsualConnectivity / *t.connd)
                                : radius * foam.shape.radiusFactor / kRadiusInPeriods;
    g.thickness = t.tbth.value_or(g.period * slender / (1 + slender));
    return g;
}

/// Lognormal radii about 1. Rounded, so that spreads that hardly differ share a pack.
SizeDistribution spreadRadii(double sigma) {
    const auto fifth = [](double x) { return std::round(x * 1e5) / 1e5; };
    return SizeDistribution::lognormal(1, std::round(sigma * 1e4) / 1e4,
                                       fifth(std::exp(-2 * sigma)), fifth(std::exp(2 * sigma)));
}

}  // namespace

double distanceTo(const LengthStatistics& have, const std::vector<double>& sample) {
    LengthStatistics other;
    other.quantiles = sample;
    return ksDistance(have, other);
}

FoamModel::FoamModel(const VoidSetting<3>& setting, FoamPacks<3>& packs)
    : s_(setting),
      r_(setting.recipe),
      foam_(*setting.recipe.as<FoamVoids>()),
      packs_(packs),
      knobs_(usualKnobs()) {
    const FoamTargets& t = foam_.targets;
    const VoidShapeRecipe& shape = foam_.shape;
    const Guess guess =
        guessOf(foam_, shape.radius.empty() && s_.largestRadius == 0 ? 0 : voidRadii(s_).mean());
    knobs_[kBvtv].usual = std::log(guess.bvtv);
    knobs_[kBvtv].isFree = !foam_.targetBvtv && (t.tbth || t.tbsp);
    period_ = guess.period;
    thickness_ = guess.thickness;
    knobs_[kStrutWidth].usual = std::log(std::clamp(0.9 * std::sqrt(guess.bvtv), 0.1, 0.25));
    aim("targetTbth", Number::thickness, t.tbth, {0, 1, 1});
    aim("targetTbsp", Number::spacing, t.tbsp, {0, 1, 1});
    aim("targetDa", Number::anisotropy, t.da, {0, 1, 0});
    aim("targetConnd", Number::connectivity, t.connd, {0, 1, -3});
    aim("", Number::thicknessScatter, t.thicknessScatter,
        {0, kThicknessScatterWeight, 0, 0, false});
    aim("", Number::spacingScatter, t.separationScatter,
        {0, kSeparationScatterWeight, 0, 0, false});
    const KnobTarget distance{0, kDistanceWeight, 0, 1, false, kEnoughDistance - kNearDistance};
    aim("", Number::crumbs, kFewCrumbs, {0, kCrumbsWeight, 0, 1, false});
    if (!t.thicknessQuantiles.empty()) aim("", Number::thicknessDistance, kNearDistance, distance);
    if (!t.separationQuantiles.empty()) aim("", Number::spacingDistance, kNearDistance, distance);
    knobs_[kScale].isFree = t.scale();
    knobs_[kSpread].isFree = spreadIsOpen_ = shape.radius.empty();
    knobs_[kAspect].isFree = shape.aspect.empty() && t.da;
    knobs_[kJitter].isFree = !foam_.jitter;
    knobs_[kBlend].isFree = !r_.blend;
    knobs_[kStrutShare].isFree = !r_.strutShare && !(r_.strut && *r_.strut == 0);
    knobs_[kStrutWidth].isFree = !r_.strut;
    if (t.separationScatter && spreadIsOpen_)
        knobs_[kSpread].usual = std::clamp(*t.separationScatter / kScatterOfSpread,
                                           knobs_[kSpread].low, knobs_[kSpread].high);
    if (shape.aspect.empty() && !t.da && !shape.orientation.any()) knobs_[kAspect].usual = 0;
    for (const Knob& knob : knobs_) first_.push_back(knob.usual);
    first_[kScale] = std::log(kRadiusInPeriods * period_ / radii(first_).mean());
}

void FoamModel::aim(const char* name, Number number, const std::optional<double>& asked,
                    KnobTarget target) {
    if (!asked) return;
    target.asked = *asked;
    const bool isShare = number == Number::anisotropy || !target.isStrict;
    if (isShare && !(target.floor > 0)) target.floor = kLeastFloor;
    names_.push_back(name);
    numbers_.push_back(number);
    targets_.push_back(target);
}

std::shared_ptr<const Domain<3>> FoamModel::boxAbout(const Vec<3>& size) {
    return boxDomain(Box<3>{size * -0.5, size * 0.5});
}

SizeDistribution FoamModel::radii(const Knobs& x) const {
    return spreadIsOpen_ ? spreadRadii(x[kSpread]) : foam_.shape.radius.in(3);
}

/// The foam of some knobs, in a box of its own.
VoidRecipe FoamModel::recipeOf(const Knobs& x) const {
    VoidRecipe r = r_;
    FoamVoids& foam = *r.as<FoamVoids>();
    VoidShapeRecipe& shape = foam.shape;
    foam.targets = {};
    foam.targetBvtv = foam_.targetBvtv.value_or(std::exp(x[kBvtv]));
    foam.bvtvField = {};
    r.shell = 0;
    r.shellField.clear();
    r.voxelSize = stage_->voxel;
    shape.radius = radii(x);
    if (knobs_[kScale].isFree || spreadIsOpen_) shape.radiusFactor = std::exp(x[kScale]);
    const double mean = radii(x).mean() * shape.radiusFactor;
    if (shape.aspect.empty())
        shape.aspect = SizeDistribution::constant(std::round(std::exp(x[kAspect]) * 1e5) / 1e5);
    foam.jitter = foam_.jitter.value_or(x[kJitter]);
    r.blend = r_.blend.value_or(std::exp(x[kBlend]) * mean);
    r.strut = r_.strut.value_or(std::exp(x[kStrutWidth]) * mean);
    r.strutShare = r_.strutShare.value_or(x[kStrutShare]);
    if (!shape.orientation.field.empty() || !shape.orientation.any()) {
        shape.orientation.field.clear();
        shape.orientation.axis = VoidAxis(Vec<3>{{0, 0, 1}});
    }
    return r;
}

void FoamModel::use(const SpecimenStage& stage) {
    lastOf_.first.clear();
    stage_ = &stage;
}

/// @throws ParameterError where the dilation cannot reach BV/TV
Morphometry FoamModel::specimen(const Knobs& x, std::uint64_t seed) {
    s_.callbacks.stopIfCancelled();
    s_.callbacks.report("voids", 0, 0);
    Callbacks quiet;
    quiet.cancelled = s_.callbacks.cancelled;
    const VoidRecipe recipe = recipeOf(x);
    VoidSetting<3> setting{recipe, *stage_->domain, 0, seed, 0, quiet};
    setting.packs = &packs_;
    MadeVoids<3> made = makeVoids(setting);
    packs_.dilation = made.report.amount.value_or(0);
    measureVoids(setting, 0, static_cast<const Pack<3>*>(nullptr), made);
    const VoxelImage image = sampleLevelSet(*made.solid.grid, stage_->domain->bounds());
    Morphometry m = measureMorphometry(image);
    if (!m.thickness || !m.separation || !m.anisotropy)
        throw ParameterError(
            fmt::format("`targetBvtv` {}: leaves nothing to measure; give a higher one",
                        *targetBvtvOf(recipe)));
    return m;
}

std::vector<double> FoamModel::numbersOf(const Morphometry& m) const {
    std::vector<double> values;
    for (const Number number : numbers_) values.push_back(numberOf(m, number, foam_.targets));
    return values;
}

std::optional<std::vector<double>> FoamModel::valuesAt(const Knobs& x) {
    try {
        const Morphometry m = specimen(x, s_.seed);
        lastOf_ = {x, {*m.thickness, *m.separation}};
        std::vector<double> values = numbersOf(m);
        for (std::size_t i = 0; i < stage_->correction.size(); ++i)
            values[i] *= stage_->correction[i];
        return values;
    } catch (const ParameterError& e) {
        unreachable_ = e.what();
        return std::nullopt;
    }
}

VoidRecipe usualFoam(const VoidRecipe& asked) {
    if (!hasStructureTargets(asked)) return asked;
    VoidRecipe r = asked;
    FoamVoids& foam = *r.as<FoamVoids>();
    const FoamTargets targets = std::exchange(foam.targets, {});
    if (!targets.scale()) return r;
    const Guess guess = guessOf(*asked.as<FoamVoids>(), 0);
    foam.targetBvtv = guess.bvtv;
    const SizeDistribution sizes = foam.shape.radius.empty()
                                       ? spreadRadii(usualKnobs()[kSpread].usual)
                                       : foam.shape.radius.in(3);
    foam.shape.radius = sizes.scaled(kRadiusInPeriods * guess.period / sizes.mean());
    if (!(r.voxelSize > 0)) r.voxelSize = guess.thickness / kFineVoxels;
    return r;
}

double specimenVoxels(const VoidRecipe& asked, double box) {
    if (!hasStructureTargets(asked)) return 0;
    const Guess guess = guessOf(*asked.as<FoamVoids>(), 0);
    if (!(guess.period > 0)) return 0;
    const double voxel = asked.voxelSize > 0 ? asked.voxelSize : guess.thickness / kFineVoxels;
    const bool whole =
        std::cbrt(box) > kLeastPeriods * guess.period && box / std::pow(voxel, 3) <= kMostVoxels;
    const double cube = std::pow(kFinePeriods * guess.period, 3);
    return std::min(kMostVoxels, (whole ? box : cube) / std::pow(voxel, 3));
}

}  // namespace vdbpack
