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
constexpr double kMostOfUsualPlates = 1.1;
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
constexpr double kLeastFloor = 0.2;
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

/// @param r  has the distributions of the sample, if distances are asked for.
double numberOf(const Morphometry& m, Number number, const VoidRecipe& r) {
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
            return std::max(distanceTo(*m.thickness, r.thicknessQuantiles), kNearDistance);
        case Number::spacingDistance:
            return std::max(distanceTo(*m.separation, r.separationQuantiles), kNearDistance);
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

VoidRecipe withoutTargets(VoidRecipe r) {
    r.targetTbth = r.targetTbsp = r.targetDa = r.targetConnd = std::nullopt;
    r.thicknessScatter = r.separationScatter = std::nullopt;
    r.thicknessQuantiles.clear();
    r.separationQuantiles.clear();
    return r;
}

/// What usual bone has where the targets leave it open, mm.
struct Guess {
    double bvtv = 0, period = 0, thickness = 0;
};

/// @param radius  mean b if no target is a length, mm.
Guess guessOf(const VoidRecipe& r, double radius) {
    Guess g;
    g.bvtv = r.targetBvtv.value_or(
        r.targetTbth && r.targetTbsp ? usualBvtv(*r.targetTbth / *r.targetTbsp) : kUsualBvtv);
    const double slender = usualSlenderness(g.bvtv);
    g.period = r.targetTbth && r.targetTbsp ? *r.targetTbth + *r.targetTbsp
               : r.targetTbth               ? *r.targetTbth * (1 + 1 / slender)
               : r.targetTbsp               ? *r.targetTbsp * (1 + slender)
               : r.targetConnd              ? std::cbrt(kUsualConnectivity / *r.targetConnd)
                                            : radius * r.radiusScale / kRadiusInPeriods;
    g.thickness = r.targetTbth.value_or(g.period * slender / (1 + slender));
    return g;
}

/// Lognormal radii about 1.
std::string spreadRadii(double sigma) {
    return fmt::format("lognormal:1,{:.4f},{:.5f},{:.5f}", sigma, std::exp(-2 * sigma),
                       std::exp(2 * sigma));
}

class Fit {
public:
    Fit(const VoidSetting<3>& setting, FoamPacks<3>& packs)
        : s_(setting), r_(setting.recipe), packs_(packs), knobs_(usualKnobs()) {
        const Guess guess =
            guessOf(r_, r_.radius.empty() && s_.largestRadius == 0
                            ? 0
                            : SizeDistribution::parse(voidRadiusSpec(s_, nullptr), 3).mean());
        knobs_[kBvtv].usual = std::log(guess.bvtv);
        knobs_[kBvtv].isFree = !r_.targetBvtv && (r_.targetTbth || r_.targetTbsp);
        period_ = guess.period;
        thickness_ = guess.thickness;
        knobs_[kStrutWidth].usual = std::log(std::clamp(0.9 * std::sqrt(guess.bvtv), 0.1, 0.25));
        aim("targetTbth", Number::thickness, r_.targetTbth, {0, 1, 1});
        aim("targetTbsp", Number::spacing, r_.targetTbsp, {0, 1, 1});
        aim("targetDa", Number::anisotropy, r_.targetDa, {0, 1, 0});
        aim("targetConnd", Number::connectivity, r_.targetConnd, {0, 1, -3});
        aim("", Number::thicknessScatter, r_.thicknessScatter,
            {0, kThicknessScatterWeight, 0, 0, false});
        aim("", Number::spacingScatter, r_.separationScatter,
            {0, kSeparationScatterWeight, 0, 0, false});
        const KnobTarget distance{0, kDistanceWeight, 0, 1, false, kEnoughDistance - kNearDistance};
        aim("", Number::crumbs, kFewCrumbs, {0, kCrumbsWeight, 0, 1, false});
        if (!r_.thicknessQuantiles.empty())
            aim("", Number::thicknessDistance, kNearDistance, distance);
        if (!r_.separationQuantiles.empty())
            aim("", Number::spacingDistance, kNearDistance, distance);
        knobs_[kScale].isFree = r_.targetTbth || r_.targetTbsp || r_.targetConnd;
        knobs_[kSpread].isFree = spreadIsOpen_ = r_.radius.empty();
        knobs_[kAspect].isFree = r_.aspect.empty() && r_.targetDa;
        knobs_[kJitter].isFree = !r_.jitter;
        knobs_[kBlend].isFree = !r_.blend;
        knobs_[kStrutShare].isFree = !r_.strutShare && !(r_.strut && *r_.strut == 0);
        knobs_[kStrutWidth].isFree = !r_.strut;
        if (r_.separationScatter && spreadIsOpen_)
            knobs_[kSpread].usual = std::clamp(*r_.separationScatter / kScatterOfSpread,
                                               knobs_[kSpread].low, knobs_[kSpread].high);
        if (r_.aspect.empty() && !r_.targetDa && !directed()) knobs_[kAspect].usual = 0;
        for (const Knob& knob : knobs_) first_.push_back(knob.usual);
        first_[kScale] = std::log(kRadiusInPeriods * period_ / meanRadius(first_));
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
                           r_.orientation.field.empty() && side > kLeastPeriods * period_ &&
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
        result.recipe.bvtvField = r_.bvtvField;
        result.recipe.bvtvRange = r_.bvtvRange;
        result.recipe.orientation = r_.orientation;
        if (!directed() && best.knobs[kAspect] != 0) result.recipe.orientation.axis = "0,0,1";
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
        if (isShare && !(target.floor > 0)) target.floor = kLeastFloor;
        names_.push_back(name);
        numbers_.push_back(number);
        targets_.push_back(target);
    }

    bool directed() const {
        const OrientationRecipe& o = r_.orientation;
        return !o.axis.empty() || !o.field.empty() || !o.angles.empty();
    }

    static std::shared_ptr<const Domain<3>> boxAbout(const Vec<3>& size) {
        return boxDomain(Box<3>{size * -0.5, size * 0.5});
    }

    std::string radiusSpec(const Knobs& x) const {
        return spreadIsOpen_ ? spreadRadii(x[kSpread]) : r_.radius;
    }
    double meanRadius(const Knobs& x) const {
        return SizeDistribution::parse(radiusSpec(x), 3).mean();
    }

    /// The foam of some knobs, in a box of its own.
    VoidRecipe recipeOf(const Knobs& x) const {
        VoidRecipe r = withoutTargets(r_);
        r.targetBvtv = r_.targetBvtv.value_or(std::exp(x[kBvtv]));
        r.bvtvField.clear();
        r.bvtvRange.clear();
        r.shell = 0;
        r.shellField.clear();
        r.voxelSize = stage_->voxel;
        r.radius = radiusSpec(x);
        r.radiusScale =
            knobs_[kScale].isFree || spreadIsOpen_ ? std::exp(x[kScale]) : r_.radiusScale;
        const double mean = meanRadius(x) * r.radiusScale;
        if (r_.aspect.empty()) r.aspect = fmt::format("constant:{:.6g}", std::exp(x[kAspect]));
        r.jitter = r_.jitter.value_or(x[kJitter]);
        r.blend = r_.blend.value_or(std::exp(x[kBlend]) * mean);
        r.strut = r_.strut.value_or(std::exp(x[kStrutWidth]) * mean);
        r.strutShare = r_.strutShare.value_or(x[kStrutShare]);
        if (!r.orientation.field.empty() || !directed()) {
            r.orientation.field.clear();
            r.orientation.axis = "0,0,1";
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
                            *recipe.targetBvtv));
        return m;
    }

    std::vector<double> numbersOf(const Morphometry& m) const {
        std::vector<double> values;
        for (const Number number : numbers_) values.push_back(numberOf(m, number, r_));
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
        const bool ofBone = !r_.thicknessQuantiles.empty() || !r_.trabecular.empty();
        if (std::fabs(found.errors[missed]) > kRefusedError && !ofBone)
            throw ParameterError(text + "; give another value, or leave another target out");
        s_.callbacks.warn(fmt::format("{}; this structure has {:.4g}", text, found.values[missed]));
    }

    void report(const KnobTrial& best, StructureFit& result) {
        for (std::size_t i = 0; i < targets_.size(); ++i)
            if (targets_[i].isStrict)
                result.targets.push_back(
                    {names_[i], targets_[i].asked, best.values[i], std::nullopt});
        if (!r_.thicknessQuantiles.empty()) {
            if (lastOf_.first != best.knobs) valuesAt(best.knobs);
            result.thicknessDistance = distanceTo(lastOf_.second[0], r_.thicknessQuantiles);
            result.separationDistance = distanceTo(lastOf_.second[1], r_.separationQuantiles);
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
    VoidRecipe r = withoutTargets(asked);
    const bool scaled = asked.targetTbth || asked.targetTbsp || asked.targetConnd;
    if (!scaled) return r;
    const Guess guess = guessOf(asked, 0);
    r.targetBvtv = guess.bvtv;
    const std::string radius =
        r.radius.empty() ? spreadRadii(usualKnobs()[kSpread].usual) : asked.radius;
    const SizeDistribution sizes = SizeDistribution::parse(radius, 3);
    r.radius = sizes.scaled(kRadiusInPeriods * guess.period / sizes.mean()).spec();
    if (!(r.voxelSize > 0)) r.voxelSize = guess.thickness / kFineVoxels;
    return r;
}

double specimenVoxels(const VoidRecipe& asked, double box) {
    if (!hasStructureTargets(asked)) return 0;
    const Guess guess = guessOf(asked, 0);
    if (!(guess.period > 0)) return 0;
    const double voxel = asked.voxelSize > 0 ? asked.voxelSize : guess.thickness / kFineVoxels;
    const bool whole =
        std::cbrt(box) > kLeastPeriods * guess.period && box / std::pow(voxel, 3) <= kMostVoxels;
    const double cube = std::pow(kFinePeriods * guess.period, 3);
    return std::min(kMostVoxels, (whole ? box : cube) / std::pow(voxel, 3));
}

StructureFit fitStructure(const VoidSetting<3>& setting, FoamPacks<3>& packs) {
    return Fit(setting, packs).run();
}

}  // namespace vdbpack
