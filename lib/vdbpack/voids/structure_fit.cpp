#include "vdbpack/voids/structure_fit.h"

#include "vdbpack/core/error.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/voids/foam_model.h"
#include "vdbpack/voids/knob_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

constexpr int kSpreadRounds = 4, kCoarseRounds = 9, kDraftRounds = 4, kFineRounds = 4,
              kRangeRounds = 4, kScatterSeeds = 3, kScatterRounds = 2;
/// Relative errors that end a search.
constexpr double kCoarseError = 0.02, kDraftError = 0.01, kFineError = 0.025;
/// Beyond the first a target is named, beyond the second it yields to the others, beyond the third
/// it is refused.
constexpr double kWarnedError = 0.03, kToleratedError = 0.06, kRefusedError = 0.1;
/// Error of a coarse specimen by which a target must be out of reach.
constexpr double kMissedError = 0.07;
/// So far away they do not count if targets are missed; and never, if usual foams are as far as the
/// second.
constexpr double kFarDistance = 0.17, kHopelessDistance = 0.3;
/// Of a target that cannot be met, while the others are.
constexpr double kYieldingWeight = 0.03;

class Fit : FoamModel {
public:
    Fit(const VoidSetting<3>& setting, FoamPacks<3>& packs) : FoamModel(setting, packs) {}

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
            foam.shape.orientation.axis = VoidAxis(Vec<3>{{0, 0, 1}});
        result.specimen = side;
        report(best, result);
        return result;
    }

private:
    /// Larger where a cube of some periods would have too many.
    double voxelFor(double voxel, double periods) const {
        return std::max(voxel, periods * period_ / std::cbrt(kMostVoxels));
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
    void goOn(KnobSearch& search, const SpecimenStage& stage) {
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

    SpecimenStage coarse_, draft_, fine_;
};

}  // namespace

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
    foam.shape.orientation.axis = VoidAxis(m.anisotropy->axes[0]);
}

StructureFit fitStructure(const VoidSetting<3>& setting, FoamPacks<3>& packs) {
    return Fit(setting, packs).run();
}

}  // namespace vdbpack
