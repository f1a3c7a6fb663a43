#include "vdbpack/voids/structure_fit.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/voids/knob_search.h"
#include "vdbpack/voids/make_voids.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// What is varied; BV/TV if no target says it. Logarithms but for spread, jitter and the share of
/// struts; the spread is the standard deviation of the logarithm of the radii, blend and width of
/// struts are in mean b.
enum KnobName : std::size_t {
    kScale,
    kSpread,
    kAspect,
    kJitter,
    kBlend,
    kStrutShare,
    kBvtv,
    kStrutWidth
};
using Knobs = std::vector<double>;

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
constexpr double kMostOfPlates = 1.1;
/// Mean b in trabecular periods (Tb.Th + Tb.Sp); Conn.D times a period cubed of usual bone.
constexpr double kRadiusInPeriods = 0.28, kUsualConnectivity = 5;
/// Standard deviation of the local spacing in its mean, for a spread of 1.
constexpr double kScatterOfSpread = 0.85;
/// Voxels of a trabecula; of a small specimen, and of one that is measured for good.
constexpr double kCoarseVoxels = 4, kFineVoxels = 5;
/// Trabecular periods along a specimen.
constexpr double kCoarsePeriods = 5, kFinePeriods = 8, kLeastPeriods = 3.5;
/// The most voxels that a specimen is measured in.
constexpr double kMostVoxels = 1.2e8;
constexpr int kSpreadRounds = 4, kCoarseRounds = 9, kDraftRounds = 4, kFineRounds = 4,
              kRangeRounds = 4, kScatterSeeds = 3, kScatterRounds = 2;
/// Errors of DA and of scatters are relative to this at the least.
constexpr double kLeastShare = 0.2;
/// Relative errors that end a search.
constexpr double kCoarseError = 0.02, kDraftError = 0.01, kFineError = 0.025;
/// Beyond the first a target is named, beyond the second it yields to the others, beyond the third
/// it is refused.
constexpr double kWarnedError = 0.03, kToleratedError = 0.06, kRefusedError = 0.1;
/// Error of a coarse specimen by which a target must be out of reach.
constexpr double kMissedError = 0.07;
/// Scatters are not numbers that were asked for: an error of them counts this much.
constexpr double kThicknessScatterWeight = 0.15, kSeparationScatterWeight = 0.15;
/// Nor are distances from the distributions of a sample: they count from the first on, and up to
/// the second the search goes on.
constexpr double kNearDistance = 0.08, kEnoughDistance = 0.11, kDistanceWeight = 0.6;
/// So far away they do not count if targets are missed; and never, if usual foams are as far as the
/// second.
constexpr double kFarDistance = 0.17, kHopelessDistance = 0.3;
/// Share of the solid that may lie beside its largest component; more of it counts.
constexpr double kFewCrumbs = 0.005, kCrumbsWeight = 1;
/// Of a target that cannot be met, while the others are.
constexpr double kYieldingWeight = 0.03;

/// The numbers of a specimen.
enum class Number {
    thickness,
    spacing,
    anisotropy,
    connectivity,
    thicknessScatter,
    spacingScatter,
    crumbs,
    thicknessDistance,
    spacingDistance
};

/// Of the distribution of a length from that of a sample: Kolmogorov and Smirnov's.
double distanceTo(const LengthStatistics& have, const std::vector<double>& sample) {
    LengthStatistics other;
    other.quantiles = sample;
    return ksDistance(have, other);
}

bool isDistance(Number number) {
    return number == Number::thicknessDistance || number == Number::spacingDistance;
}

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
    return std::clamp((slenderness - 0.1) / 0.8, 0.4 * plates, kMostOfPlates * plates);
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

class Fit {
public:
    Fit(const VoidSetting<3>& setting, FoamPacks<3>& packs)
        : s_(setting),
          r_(setting.recipe),
          foam_(*setting.recipe.as<FoamVoids>()),
          packs_(packs),
          knobs_(usualKnobs()) {
        const FoamTargets& t = foam_.targets;
        const VoidShapeRecipe& shape = foam_.shape;
        const Guess guess = guessOf(
            foam_, shape.radius.empty() && s_.largestRadius == 0 ? 0 : voidRadii(s_).mean());
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
        if (!t.thicknessQuantiles.empty())
            aim("", Number::thicknessDistance, kNearDistance, distance);
        if (!t.separationQuantiles.empty())
            aim("", Number::spacingDistance, kNearDistance, distance);
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

    StructureFit run() {
        // Small and coarse first, then as it will be.
        const auto small = boxAbout(Vec<3>{{1, 1, 1}} * (kCoarsePeriods * period_));
        coarse_ = {small.get(), voxelFor(thickness_ / kCoarseVoxels, kCoarsePeriods), {}};
        const double voxel = r_.voxelSize > 0 ? r_.voxelSize : thickness_ / kFineVoxels;
        fine_ = {&s_.domain, voxel, {}};
        std::shared_ptr<const Domain<3>> cube;
        const Vec<3> size = s_.domain.bounds().size();
        double side = *std::min_element(size.c.begin(), size.c.end());
        const bool whole = s_.domain.facts().kind == "box" && !r_.hasShell() && !s_.bvtv &&
                           foam_.shape.orientation.field.empty() &&
                           side > kLeastPeriods * period_ &&
                           s_.domain.volume() / std::pow(fine_.voxel, 3) <= kMostVoxels;
        if (!whole) {
            side = kFinePeriods * period_;
            fine_.voxel = voxelFor(voxel, kFinePeriods);
            cube = boxAbout(Vec<3>{{1, 1, 1}} * side);
            fine_.domain = cube.get();
        }
        draft_ = {fine_.domain, std::max(fine_.voxel, thickness_ / kCoarseVoxels), {}};
        if (draft_.voxels() > 1.5 * coarse_.voxels()) draft_ = coarse_;
        KnobSearch search(knobs_, targets_, [this](const Knobs& x) { return valuesAt(x); });
        beginFirst(search);
        searchCoarse(search);
        if (search.worst(search.best()) > kCoarseError && leaveDistances(search, kFarDistance))
            search.search(kCoarseRounds - kSpreadRounds, kCoarseError);
        std::size_t left = KnobSearch::kNone;
        if (search.worst(search.best()) > kMissedError) left = yieldOne(search);
        searchFine(search, left);
        if (left == KnobSearch::kNone && search.worst(search.best()) > kToleratedError) {
            left = yieldOne(search);
            if (left != KnobSearch::kNone) searchFine(search, left);
        }
        judge(search, left == KnobSearch::kNone ? search.worstTarget(search.best()) : left);
        const KnobTrial best = search.best();
        StructureFit result;
        use(fine_);
        result.recipe = recipeOf(best.knobs);
        result.recipe.voxelSize = voxel;
        result.recipe.shell = r_.shell;
        result.recipe.shellField = r_.shellField;
        FoamVoids& foam = *result.recipe.as<FoamVoids>();
        foam.bvtvField = foam_.bvtvField;
        foam.shape.orientation = foam_.shape.orientation;
        if (!foam_.shape.orientation.any() && best.knobs[kAspect] != 0)
            foam.shape.orientation.axis = "0,0,1";
        result.specimen = side;
        report(best, result);
        return result;
    }

private:
    /// What specimens are cut from, and their voxels, mm.
    struct Stage {
        const Domain<3>* domain = nullptr;
        double voxel = 0;
        /// What the numbers would be in finer voxels, in what they are; none: the same.
        std::vector<double> correction;

        double voxels() const { return domain->volume() / std::pow(voxel, 3); }
    };

    /// Larger where a cube of some periods would have too many.
    double voxelFor(double voxel, double periods) const {
        return std::max(voxel, periods * period_ / std::cbrt(kMostVoxels));
    }

    void aim(const char* name, Number number, const std::optional<double>& asked,
             KnobTarget target) {
        if (!asked) return;
        target.asked = *asked;
        const bool isShare = number == Number::anisotropy || !target.isStrict;
        if (isShare && !(target.floor > 0)) target.floor = kLeastShare;
        names_.push_back(name);
        numbers_.push_back(number);
        targets_.push_back(target);
    }

    static std::shared_ptr<const Domain<3>> boxAbout(const Vec<3>& size) {
        return boxDomain(Box<3>{size * -0.5, size * 0.5});
    }

    SizeDistribution radii(const Knobs& x) const {
        return spreadIsOpen_ ? spreadRadii(x[kSpread]) : foam_.shape.radius.in(3);
    }

    /// The foam of some knobs, in a box of its own.
    VoidRecipe recipeOf(const Knobs& x) const {
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
            shape.orientation.axis = "0,0,1";
        }
        return r;
    }

    void use(const Stage& stage) {
        lastOf_.first.clear();
        stage_ = &stage;
    }

    /// @throws ParameterError where the dilation cannot reach BV/TV
    Morphometry specimen(const Knobs& x, std::uint64_t seed) {
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

    std::vector<double> numbersOf(const Morphometry& m) const {
        std::vector<double> values;
        for (const Number number : numbers_) values.push_back(numberOf(m, number, foam_.targets));
        return values;
    }

    std::optional<std::vector<double>> valuesAt(const Knobs& x) {
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

    /// With struts as thin as leave little enough solid.
    void beginFirst(KnobSearch& search) {
        use(coarse_);
        for (int round = 0; !search.begin(first_); ++round) {
            if (round == 4 || r_.strut) throw ParameterError(unreachable_);
            first_[kStrutWidth] -= 0.35;
        }
    }

    /// Goes on from the best knobs with other specimens.
    void goOn(KnobSearch& search, const Stage& stage) {
        if (stage_ == &stage) return;
        use(stage);
        const Knobs x = search.best().knobs;
        if (!search.begin(x)) throw ParameterError(unreachable_);
    }

    /// In coarse specimens from the best knobs on.
    /// @param left  as that of `KnobSearch::search`.
    void searchCoarse(KnobSearch& search, std::size_t left = KnobSearch::kNone) {
        leaveDistances(search, kHopelessDistance);
        search.knobs()[kSpread].isFree = spreadIsOpen_;
        search.takeDifferences();
        search.search(kSpreadRounds, kCoarseError, left);
        // Another spread is another pack, whose numbers differ by chance.
        search.knobs()[kSpread].isFree = false;
        search.search(kCoarseRounds - kSpreadRounds, kCoarseError, left);
        for (int round = 0; round < kScatterRounds && meetScatter(search, left); ++round)
            ;
    }

    std::size_t indexOf(Number number) const {
        const auto at = std::find(numbers_.begin(), numbers_.end(), number);
        return at == numbers_.end() ? KnobSearch::kNone
                                    : static_cast<std::size_t>(at - numbers_.begin());
    }

    /// Where the spacing is distributed otherwise than in the sample, changes the spread as its
    /// scatter asks for, and the other knobs with it.
    /// @return whether that came nearer
    bool meetScatter(KnobSearch& search, std::size_t left) const {
        const std::size_t scatter = indexOf(Number::spacingScatter),
                          distance = indexOf(Number::spacingDistance);
        if (!spreadIsOpen_ || scatter == KnobSearch::kNone || distance == KnobSearch::kNone)
            return false;
        const KnobTrial before = search.best();
        if (before.errors[distance] <= targets_[distance].slack) return false;
        const double share = targets_[scatter].asked / before.values[scatter];
        auto x = before.knobs;
        x[kSpread] = std::clamp(x[kSpread] * std::clamp(share, 0.7, 1.4), knobs_[kSpread].low,
                                knobs_[kSpread].high);
        if (search.begin(x)) search.search(kCoarseRounds - kSpreadRounds, kCoarseError, left);
        if (search.merit(search.best()) < search.merit(before)) return true;
        search.setBest(before);
        return false;
    }

    /// In few voxels, whose errors each measurement of the specimen itself corrects.
    void searchFine(KnobSearch& search, std::size_t left) {
        std::optional<KnobTrial> best, last;
        draft_.correction.clear();
        goOn(search, draft_);
        for (int round = 0; round < kFineRounds; ++round) {
            use(draft_);
            search.search(kDraftRounds, round == 0 ? kFineError : kDraftError, left);
            const KnobTrial draft = search.best();
            if (last && draft.knobs == last->knobs) break;
            goOn(search, fine_);
            const KnobTrial fine = search.best();
            last = fine;
            if (!best || search.merit(fine) < search.merit(*best)) best = fine;
            if (search.isNear(*best, kFineError, left)) break;
            // So that the best knobs have the same numbers in coarse voxels.
            draft_.correction.resize(fine.values.size(), 1);
            for (std::size_t i = 0; i < fine.values.size(); ++i)
                if (draft.values[i] > 0) draft_.correction[i] *= fine.values[i] / draft.values[i];
        }
        search.setBest(*best);
    }

    /// Lets go of distributions at least that far from those of the sample, so that the targets
    /// are met if no more can be. @return whether there is one
    bool leaveDistances(KnobSearch& search, double far) const {
        bool found = false;
        for (std::size_t i = 0; i < numbers_.size(); ++i) {
            if (!isDistance(numbers_[i]) || search.best().errors[i] < far - kNearDistance) continue;
            search.targets()[i].weight = 0;
            search.targets()[i].slack = std::numeric_limits<double>::infinity();
            found = true;
        }
        return found;
    }

    /// Where not all targets can be met, lets one of them yield, and searches again in coarse
    /// specimens. @return which; none if a single one is missed
    std::size_t yieldOne(KnobSearch& search) {
        const KnobTrial before = search.best();
        const std::size_t worst = search.worstTarget(before);
        if (search.worst(before, worst) <= kWarnedError) return KnobSearch::kNone;
        for (std::size_t i = 0; i < numbers_.size(); ++i)
            if (isDistance(numbers_[i])) search.targets()[i] = targets_[i];
        // The others first: mostly the connectivity is what foams of that kind do not have.
        std::size_t missed = worst;
        for (std::size_t i = 0; i < numbers_.size(); ++i)
            if (numbers_[i] == Number::connectivity) missed = i;
        search.targets()[missed].weight = kYieldingWeight;
        use(coarse_);
        // Not from what half meets it.
        if (!search.begin(first_)) throw ParameterError(unreachable_);
        searchCoarse(search, missed);
        if (search.worst(search.best(), missed) > kCoarseError &&
            leaveDistances(search, kFarDistance))
            search.search(kCoarseRounds - kSpreadRounds, kCoarseError, missed);
        const double others = search.worst(search.best(), missed);
        if (missed != worst && others > kWarnedError && others > 0.5 * search.worst(before)) {
            // It is not that one.
            search.targets()[missed].weight = 1;
            missed = worst;
            search.targets()[missed].weight = kYieldingWeight;
            search.setBest(before);
        }
        return missed;
    }

    /// Names the targets that are missed: `missed` with the range that can be reached beside the
    /// others, and then those of the others that are.
    /// @throws ParameterError if one is far off and was asked for by itself.
    void judge(KnobSearch& search, std::size_t missed) {
        const KnobTrial found = search.best();
        if (std::fabs(found.errors[missed]) > kWarnedError)
            say(found, missed, "beside the other targets, " + rangeText(search, missed));
        for (std::size_t i = 0; i < targets_.size(); ++i)
            if (targets_[i].isStrict && i != missed && std::fabs(found.errors[i]) > kWarnedError)
                say(found, i, "is not met beside the other targets");
    }

    /// The values of a target that are found beside the others, from the best knobs on.
    std::string rangeText(KnobSearch& search, std::size_t missed) {
        const KnobTrial found = search.best();
        double low = found.values[missed], high = low;
        use(coarse_);
        if (search.begin(found.knobs)) {
            search.takeDifferences();
            const double near = std::max(kWarnedError, 1.5 * search.worst(search.best(), missed));
            const auto range = search.rangeOf(missed, kRangeRounds, near);
            low = std::min(low, range.first);
            high = std::max(high, range.second);
            search.setBest(found);
        }
        return fmt::format("values from {:.3g} to {:.3g} were found", low, high);
    }

    void say(const KnobTrial& found, std::size_t missed, const std::string& what) const {
        const std::string text =
            fmt::format("`{}` {:.4g}: {}", names_[missed], targets_[missed].asked, what);
        if (std::fabs(found.errors[missed]) > kRefusedError && !foam_.targets.ofBone)
            throw ParameterError(text + "; give another value, or leave another target out");
        s_.callbacks.warn(fmt::format("{}; this structure has {:.4g}", text, found.values[missed]));
    }

    void report(const KnobTrial& best, StructureFit& result) {
        for (std::size_t i = 0; i < targets_.size(); ++i)
            if (targets_[i].isStrict)
                result.targets.push_back(
                    {names_[i], targets_[i].asked, best.values[i], std::nullopt});
        const FoamTargets& t = foam_.targets;
        if (!t.thicknessQuantiles.empty()) {
            if (lastOf_.first != best.knobs) valuesAt(best.knobs);
            result.thicknessDistance = distanceTo(lastOf_.second[0], t.thicknessQuantiles);
            result.separationDistance = distanceTo(lastOf_.second[1], t.separationQuantiles);
        }
        addScatter(best.knobs, result);
    }

    /// How specimens of other seeds differ, from small ones.
    void addScatter(const Knobs& x, StructureFit& result) {
        use(coarse_);
        std::vector<std::vector<double>> others;
        try {
            for (std::uint64_t n = 1; n <= kScatterSeeds; ++n)
                others.push_back(numbersOf(specimen(x, s_.seed + n)));
        } catch (const ParameterError&) {
            return;  // one of them cannot have the BV/TV
        }
        for (std::size_t i = 0; i < result.targets.size(); ++i) {
            double mean = 0, square = 0;
            for (const auto& o : others) mean += o[i] / kScatterSeeds;
            for (const auto& o : others) square += std::pow(o[i] - mean, 2) / (kScatterSeeds - 1);
            result.targets[i].scatter = std::sqrt(square);
        }
    }

    const VoidSetting<3>& s_;
    const VoidRecipe& r_;
    const FoamVoids& foam_;  ///< of that recipe
    FoamPacks<3>& packs_;
    std::vector<Knob> knobs_;
    std::vector<KnobTarget> targets_;  ///< strict ones first
    std::vector<Number> numbers_;      ///< of the targets
    std::vector<const char*> names_;   ///< of their parameters
    Knobs first_;
    bool spreadIsOpen_ = false;  ///< whether the spread of the radii is to be found
    double period_ = 0, thickness_ = 0;
    Stage coarse_, draft_, fine_;
    const Stage* stage_ = nullptr;
    /// Of the last specimen: its knobs, local thickness and spacing.
    std::pair<Knobs, std::array<LengthStatistics, 2>> lastOf_;
    std::string unreachable_;  ///< why the last knobs had no specimen
};

}  // namespace

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

void aimAt(const Morphometry& m, const std::string& name, FoamVoids& foam,
           const Callbacks& callbacks) {
    if (!m.thickness || !m.separation || !m.anisotropy)
        throw InputError(
            fmt::format("{}: BV/TV is {:g}, so that there is no structure to be like; check what "
                        "is solid in it (`likeThreshold`) and its total volume (`likeDomain`)",
                        name, m.solidFraction));
    const auto fill = [](std::optional<double>& target, double value) {
        if (!target) target = value;
    };
    FoamTargets& t = foam.targets;
    fill(foam.targetBvtv, m.solidFraction);
    fill(t.tbth, m.thickness->mean);
    fill(t.tbsp, m.separation->mean);
    fill(t.da, m.anisotropy->degree);
    if (m.connectivityDensity > 0)
        fill(t.connd, m.connectivityDensity);
    else
        callbacks.warn(fmt::format("{}: Conn.D is {:.3g} /mm³, so that it is no target", name,
                                   m.connectivityDensity));
    fill(t.thicknessScatter, m.thickness->sd / m.thickness->mean);
    fill(t.separationScatter, m.separation->sd / m.separation->mean);
    t.thicknessQuantiles = m.thickness->quantiles;
    t.separationQuantiles = m.separation->quantiles;
    t.ofBone = true;
    if (foam.shape.orientation.any()) return;
    const Vec<3>& axis = m.anisotropy->axes[0];
    foam.shape.orientation.axis = fmt::format("{:.6g},{:.6g},{:.6g}", axis[0], axis[1], axis[2]);
}

StructureFit fitStructure(const VoidSetting<3>& setting, FoamPacks<3>& packs) {
    return Fit(setting, packs).run();
}

}  // namespace vdbpack
