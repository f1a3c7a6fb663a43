#include "vdbpack/run/structure_fit.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/run/void_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

namespace vdbpack {

namespace {

/// What is varied, in units in which a step of one matters.
enum Knob { kScale, kSpread, kAspect, kJitter, kBlend, kStruts, kKnobs };
using Knobs = std::array<double, kKnobs>;

struct KnobRule {
    double usual, width;  ///< where it stays if no target asks for more, and how gladly it leaves
    double low, high;
    double step;   ///< of differences
    double limit;  ///< of one step of the solver
};
/// Logarithms but for spread, jitter and struts. The spread is the standard deviation of the
/// logarithm of the radii; the blend is that in mean b.
constexpr std::array<KnobRule, kKnobs> kRules{{{0, 100, -40, 40, 0.05, 0.4},
                                               {0.4, 0.3, 0.05, 0.75, 0.12, 0.2},
                                               {0.336, 1, 0, 1.2, 0.15, 0.3},
                                               {0.35, 0.4, 0, 1, 0.2, 0.3},
                                               {-2.5, 0.8, -3.9, -0.9, 0.4, 0.6},
                                               {0.6, 0.4, 0, 1, -0.25, 0.35}}};

/// BV/TV if no target says it, and of plates a share of what they would have.
constexpr double kUsualBvtv = 0.2, kShareOfPlates = 0.7;
/// Mean b in trabecular periods (Tb.Th + Tb.Sp); Conn.D times a period cubed of usual bone.
constexpr double kRadiusInPeriods = 0.28, kUsualConnectivity = 5;
/// Standard deviation of the local spacing in its mean, for a spread of 1.
constexpr double kScatterOfSpread = 0.65;
/// Voxels of a trabecula; of a small specimen, and of one that is measured for good.
constexpr double kCoarseVoxels = 4, kFineVoxels = 5;
/// Trabecular periods along a specimen.
constexpr double kCoarsePeriods = 5, kFinePeriods = 8, kLeastPeriods = 3.5;
/// The most voxels that a specimen is measured in.
constexpr double kMostVoxels = 1.2e8;
constexpr int kSpreadRounds = 4, kCoarseRounds = 9, kFineRounds = 5, kRangeRounds = 4,
              kScatterSeeds = 3;
/// Relative error that ends the search; beyond the second a target is warned of, beyond the third
/// refused.
constexpr double kCoarseError = 0.02, kFineError = 0.02, kWarnedError = 0.03, kRefusedError = 0.1;
/// A step of one width away from a usual value weighs as much as this relative error.
constexpr double kPriorError = 0.01;
/// Scatters are not numbers that were asked for: an error of them counts this much.
constexpr double kThicknessScatterWeight = 0.3, kSeparationScatterWeight = 0.15;
/// Of a target that cannot be met, while the others are; of one whose range is looked for.
constexpr double kYieldingWeight = 0.06, kPushingWeight = 0.1;
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

struct Target {
    const char* name;  ///< of the parameter; of a scatter what it is
    double asked;
    double weight = 1;
    double power = 0;      ///< how the value goes with all lengths
    bool isNumber = true;  ///< was asked for; else it is a scatter to come near to
};

/// The numbers of a specimen, in the order of the targets.
struct Specimen {
    std::vector<double> values, errors;  ///< errors are relative to what was asked
    LengthStatistics thickness, separation;
    double bvtv = 0;  ///< as measured
};

/// Thickness of trabeculae in their spacing, of usual bone.
double usualSlenderness(double bvtv) {
    return 0.1 + 0.8 * bvtv;
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
    g.bvtv =
        r.targetBvtv.value_or(r.targetTbth && r.targetTbsp
                                  ? kShareOfPlates * *r.targetTbth / (*r.targetTbth + *r.targetTbsp)
                                  : kUsualBvtv);
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
        : s_(setting), r_(setting.recipe), packs_(packs) {
        const Guess guess =
            guessOf(r_, r_.radius.empty() && s_.largestRadius == 0
                            ? 0
                            : SizeDistribution::parse(voidRadiusSpec(s_, nullptr), 3).mean());
        bvtv_ = guess.bvtv;
        period_ = guess.period;
        thickness_ = guess.thickness;
        if (r_.targetTbth) targets_.push_back({"targetTbth", *r_.targetTbth, 1, 1});
        if (r_.targetTbsp) targets_.push_back({"targetTbsp", *r_.targetTbsp, 1, 1});
        if (r_.targetDa) targets_.push_back({"targetDa", std::max(*r_.targetDa, 0.05)});
        if (r_.targetConnd) targets_.push_back({"targetConnd", *r_.targetConnd, 1, -3});
        if (r_.thicknessScatter)
            targets_.push_back(
                {"thickness", *r_.thicknessScatter, kThicknessScatterWeight, 0, false});
        if (r_.separationScatter)
            targets_.push_back(
                {"separation", *r_.separationScatter, kSeparationScatterWeight, 0, false});
        free_.fill(true);
        free_[kScale] = r_.targetTbth || r_.targetTbsp || r_.targetConnd;
        free_[kSpread] = r_.radius.empty();
        free_[kAspect] = r_.aspect.empty() && r_.targetDa;
        free_[kJitter] = !r_.jitter;
        free_[kBlend] = !r_.blend;
        free_[kStruts] = !r_.strutShare && !(r_.strut && *r_.strut == 0);
        for (int k = 0; k < kKnobs; ++k)
            x_[static_cast<std::size_t>(k)] = kRules[static_cast<std::size_t>(k)].usual;
        if (r_.separationScatter && free_[kSpread])
            x_[kSpread] = std::clamp(*r_.separationScatter / kScatterOfSpread, kRules[kSpread].low,
                                     kRules[kSpread].high);
        x_[kScale] = std::log(kRadiusInPeriods * period_ / meanRadius(x_));
        if (r_.aspect.empty() && !r_.targetDa && !directed()) x_[kAspect] = 0;
    }

    StructureFit run() {
        strut_ = std::clamp(0.9 * std::sqrt(bvtv_), 0.1, 0.25);
        // Small and coarse first.
        const auto small = boxAbout(Vec<3>{{1, 1, 1}} * (kCoarsePeriods * period_));
        coarse_ = {small.get(), thickness_ / kCoarseVoxels};
        // Then as it will be.
        fine_ = {&s_.domain, r_.voxelSize > 0 ? r_.voxelSize : thickness_ / kFineVoxels};
        std::shared_ptr<const Domain<3>> cube;
        const Vec<3> size = s_.domain.bounds().size();
        double side = *std::min_element(size.c.begin(), size.c.end());
        const bool whole = s_.domain.facts().kind == "box" && !s_.recipe.hasShell() && !s_.bvtv &&
                           r_.orientation.field.empty() && side > kLeastPeriods * period_ &&
                           s_.domain.volume() / std::pow(fine_.voxel, 3) <= kMostVoxels;
        if (!whole) {
            side = std::min(kFinePeriods * period_, std::cbrt(kMostVoxels) * fine_.voxel);
            cube = boxAbout(Vec<3>{{1, 1, 1}} * side);
            fine_.domain = cube.get();
        }
        makeFirst();
        searchBoth();
        judgeMissed();
        const Specimen found = best_->second;
        const Knobs knobs = best_->first;
        StructureFit result;
        use(fine_);
        result.recipe = recipeOf(knobs);
        result.recipe.shell = r_.shell;
        result.recipe.shellField = r_.shellField;
        result.recipe.bvtvField = r_.bvtvField;
        result.recipe.bvtvRange = r_.bvtvRange;
        result.recipe.keepConnected = r_.keepConnected;
        result.recipe.orientation = r_.orientation;
        if (!directed() && knobs[kAspect] != 0) result.recipe.orientation.axis = "0,0,1";
        result.specimen = side;
        report(found, knobs, result);
        return result;
    }

private:
    bool directed() const {
        const OrientationRecipe& o = r_.orientation;
        return !o.axis.empty() || !o.field.empty() || !o.angles.empty();
    }

    static std::shared_ptr<const Domain<3>> boxAbout(const Vec<3>& size) {
        return boxDomain(Box<3>{size * -0.5, size * 0.5});
    }

    std::string radiusSpec(const Knobs& x) const {
        if (!free_[kSpread]) return r_.radius;
        return spreadRadii(x[kSpread]);
    }
    double meanRadius(const Knobs& x) const {
        return SizeDistribution::parse(radiusSpec(x), 3).mean();
    }

    /// The foam of some knobs, in a box of its own.
    VoidRecipe recipeOf(const Knobs& x) const {
        VoidRecipe r = withoutTargets(r_);
        r.targetBvtv = bvtv_;
        r.bvtvField.clear();
        r.bvtvRange.clear();
        r.shell = 0;
        r.shellField.clear();
        r.voxelSize = voxel_;
        r.radius = radiusSpec(x);
        r.radiusScale = free_[kScale] || free_[kSpread] ? std::exp(x[kScale]) : r_.radiusScale;
        const double mean = meanRadius(x) * r.radiusScale;
        if (r_.aspect.empty()) r.aspect = fmt::format("constant:{:.6g}", std::exp(x[kAspect]));
        r.jitter = r_.jitter.value_or(x[kJitter]);
        r.blend = r_.blend.value_or(std::exp(x[kBlend]) * mean);
        r.strut = r_.strut.value_or(strut_ * mean);
        r.strutShare = r_.strutShare.value_or(x[kStruts]);
        if (!r.orientation.field.empty() || !directed()) {
            r.orientation.field.clear();
            r.orientation.axis = "0,0,1";
        }
        return r;
    }

    /// What specimens are cut from, and their voxels, mm.
    struct Stage {
        const Domain<3>* domain = nullptr;
        double voxel = 0;
    };
    void use(const Stage& stage) {
        domain_ = stage.domain;
        voxel_ = stage.voxel;
    }
    /// Goes on from the best knobs with other specimens.
    void goOn(const Stage& stage) {
        use(stage);
        const Knobs x = best_->first;
        best_.reset();
        offer(x, measure(x));
    }

    /// In coarse specimens from the best knobs on, then in fine ones.
    /// @param left  as that of `search`.
    void searchBoth(std::size_t left = kNone) {
        spreadIsKept_ = false;
        goOn(coarse_);
        differences();
        search(kCoarseRounds, kCoarseError, left);
        spreadIsKept_ = true;
        goOn(fine_);
        search(kFineRounds, kFineError, left);
    }

    Specimen measure(const Knobs& x) { return measure(x, s_.seed); }

    Specimen measure(const Knobs& x, std::uint64_t seed) {
        s_.callbacks.stopIfCancelled();
        s_.callbacks.report("voids", 0, 0);
        Callbacks quiet;
        quiet.cancelled = s_.callbacks.cancelled;
        const VoidRecipe recipe = recipeOf(x);
        VoidSetting<3> setting{recipe, *domain_, 0, seed, 0, quiet};
        setting.packs = &packs_;
        MadeVoids<3> made = makeVoids(setting);
        packs_.dilation = made.report.amount.value_or(0);
        measureVoids(setting, 0, static_cast<const Pack<3>*>(nullptr), made);
        const VoxelImage image = sampleLevelSet(*made.solid.grid, domain_->bounds());
        const Morphometry m = measureMorphometry(image);
        if (!m.thickness || !m.separation || !m.anisotropy)
            throw ParameterError(fmt::format(
                "`targetBvtv` {}: leaves nothing to measure; give a higher one", bvtv_));
        Specimen found;
        found.bvtv = m.solidFraction;
        found.thickness = *m.thickness;
        found.separation = *m.separation;
        for (const Target& t : targets_) {
            const std::string name = t.name;
            const double value = name == "targetTbth"    ? m.thickness->mean
                                 : name == "targetTbsp"  ? m.separation->mean
                                 : name == "targetDa"    ? m.anisotropy->degree
                                 : name == "targetConnd" ? m.connectivityDensity
                                 : name == "thickness"   ? m.thickness->sd / m.thickness->mean
                                                         : m.separation->sd / m.separation->mean;
            found.values.push_back(value);
            found.errors.push_back(value / t.asked - 1);
        }
        return found;
    }

    /// Struts thinner than those that leave too much solid.
    void makeFirst() {
        use(coarse_);
        for (int round = 0;; ++round) {
            try {
                offer(x_, measure(x_));
                return;
            } catch (const ParameterError&) {
                if (round == 4) throw;
                strut_ *= 0.7;
            }
        }
    }

    double merit(const Knobs& x, const Specimen& found) const {
        double sum = 0;
        for (std::size_t i = 0; i < targets_.size(); ++i)
            sum += std::pow(targets_[i].weight * found.errors[i], 2);
        for (std::size_t k = 0; k < kKnobs; ++k)
            if (free_[k]) sum += std::pow(kPriorError * (x[k] - start(k)) / kRules[k].width, 2);
        return sum;
    }
    double start(std::size_t k) const {
        return k == kScale || k == kSpread ? x_[k] : kRules[k].usual;
    }

    void offer(const Knobs& x, Specimen found) {
        if (!best_ || merit(x, found) < merit(best_->first, best_->second))
            best_.emplace(x, std::move(found));
    }

    void differences() {
        jacobian_.assign(targets_.size(), Knobs{});
        const Specimen& at = best_->second;
        const Knobs from = best_->first;
        std::vector<std::pair<Knobs, Specimen>> tried;
        for (std::size_t k = 0; k < kKnobs; ++k) {
            if (!free_[k]) continue;
            if (k == kScale) continue;  // known
            Knobs x = from;
            x[k] += kRules[k].step;
            Specimen found;
            try {
                found = measure(x);
            } catch (const ParameterError&) {
                continue;  // no solid of that kind: leave this knob to the others
            }
            for (std::size_t i = 0; i < targets_.size(); ++i)
                jacobian_[i][k] = (found.errors[i] - at.errors[i]) / kRules[k].step;
            tried.emplace_back(x, std::move(found));
        }
        for (auto& [x, found] : tried) offer(x, std::move(found));
    }

    /// The step from `x` that the linear model says is best, within the limits of the knobs.
    Knobs step(const Knobs& x, const Specimen& found, double trust) {
        for (std::size_t i = 0; i < targets_.size(); ++i)
            jacobian_[i][kScale] = targets_[i].power * (1 + found.errors[i]);
        std::array<bool, kKnobs> held{};
        // Another spread is another pack, whose numbers differ by chance.
        held[kSpread] = spreadIsKept_;
        Knobs d{};
        for (int round = 0; round < kKnobs; ++round) {
            // Normal equations of the free knobs that are not held at a limit.
            std::vector<std::size_t> at;
            for (std::size_t k = 0; k < kKnobs; ++k)
                if (free_[k] && !held[k]) at.push_back(k);
            const std::size_t n = at.size();
            std::vector<std::vector<double>> a(n, std::vector<double>(n + 1));
            for (std::size_t p = 0; p < n; ++p) {
                for (std::size_t i = 0; i < targets_.size(); ++i) {
                    const double w = targets_[i].weight * targets_[i].weight;
                    double rest = found.errors[i];
                    for (std::size_t k = 0; k < kKnobs; ++k)
                        if (held[k]) rest += jacobian_[i][k] * d[k];
                    for (std::size_t q = 0; q < n; ++q)
                        a[p][q] += w * jacobian_[i][at[p]] * jacobian_[i][at[q]];
                    a[p][n] -= w * jacobian_[i][at[p]] * rest;
                }
                const double prior = std::pow(kPriorError / kRules[at[p]].width, 2);
                a[p][p] += prior;
                a[p][n] -= prior * (x[at[p]] - start(at[p]));
            }
            const std::vector<double> solved = solve(std::move(a));
            bool stops = false;
            for (std::size_t p = 0; p < n; ++p) {
                const std::size_t k = at[p];
                const double low = std::max(kRules[k].low - x[k], -trust * kRules[k].limit);
                const double high = std::min(kRules[k].high - x[k], trust * kRules[k].limit);
                d[k] = std::clamp(solved[p], std::min(low, 0.0), std::max(high, 0.0));
                if (d[k] != solved[p]) held[k] = stops = true;
            }
            if (!stops) break;
        }
        return d;
    }

    /// Gauss's elimination of a positive definite system, the right side in the last column.
    static std::vector<double> solve(std::vector<std::vector<double>> a) {
        const std::size_t n = a.size();
        for (std::size_t k = 0; k < n; ++k)
            for (std::size_t i = k + 1; i < n; ++i) {
                const double f = a[i][k] / a[k][k];
                for (std::size_t j = k; j <= n; ++j) a[i][j] -= f * a[k][j];
            }
        std::vector<double> x(n);
        for (std::size_t k = n; k-- > 0;) {
            x[k] = a[k][n];
            for (std::size_t j = k + 1; j < n; ++j) x[k] -= a[k][j] * x[j];
            x[k] /= a[k][k];
        }
        return x;
    }

    /// What one specimen more says of the Jacobian, but for the scale, whose part is known.
    void learn(const Knobs& d, const Specimen& from, const Specimen& to) {
        double square = 0;
        for (std::size_t k = kScale + 1; k < kKnobs; ++k)
            square += std::pow(d[k] / kRules[k].step, 2);
        for (std::size_t i = 0; i < targets_.size(); ++i) {
            const double power = targets_[i].power;
            double miss = to.errors[i] + 1 - (from.errors[i] + 1) * std::exp(power * d[kScale]);
            for (std::size_t k = kScale + 1; k < kKnobs; ++k) miss -= jacobian_[i][k] * d[k];
            if (square > 1e-4)
                for (std::size_t k = kScale + 1; k < kKnobs; ++k)
                    jacobian_[i][k] += miss * d[k] / std::pow(kRules[k].step, 2) / square;
        }
    }

    /// @param left  a target that need not be met.
    void search(int rounds, double enough, std::size_t left = kNone) {
        double trust = 1;
        for (int round = 0; round < rounds && worstBut(left) > enough; ++round) {
            if (round == kSpreadRounds) spreadIsKept_ = true;
            const auto from = *best_;
            const Knobs d = step(from.first, from.second, trust);
            Knobs x = from.first;
            double moved = 0;
            for (std::size_t k = 0; k < kKnobs; ++k) {
                x[k] += d[k];
                moved = std::max(moved, std::fabs(d[k] / kRules[k].step));
            }
            if (moved < 1e-3) return;
            Specimen found;
            try {
                found = measure(x);
            } catch (const ParameterError&) {
                trust *= 0.4;
                continue;
            }
            learn(d, from.second, found);
            seen_.push_back(found);
            offer(x, found);
            trust = best_->first == x ? std::min(1.0, 2 * trust) : 0.5 * trust;
        }
    }

    /// The target that is missed most.
    std::size_t worstTarget() const {
        std::size_t worst = 0;
        for (std::size_t i = 0; i < targets_.size(); ++i)
            if (targets_[i].isNumber && errorOf(i) > errorOf(worst)) worst = i;
        return worst;
    }
    double errorOf(std::size_t i) const { return std::fabs(best_->second.errors[i]); }

    /// Names a target that is missed, with the range that can be reached beside the others.
    /// @throws ParameterError with it if the target is far off and was asked for by itself.
    void judgeMissed() {
        if (worstBut(kNone) <= kWarnedError) return;
        // The others first: mostly the connectivity is what foams of that kind do not have.
        std::size_t missed = worstTarget();
        for (std::size_t i = 0; i < targets_.size(); ++i)
            if (std::string(targets_[i].name) == "targetConnd") missed = i;
        const auto before = best_;
        const double weight = targets_[missed].weight;
        targets_[missed].weight = kYieldingWeight;
        searchBoth(missed);
        if (worstBut(missed) > kWarnedError && worstBut(missed) > 0.5 * worstOf(*before)) {
            // It is not that one.
            targets_[missed].weight = weight;
            best_ = before;
            missed = worstTarget();
            targets_[missed].weight = kYieldingWeight;
        }
        const auto found = best_;
        goOn(coarse_);
        differences();
        auto [low, high] = rangeOf(missed);
        best_ = found;
        low = std::min(low, found->second.values[missed]);
        high = std::max(high, found->second.values[missed]);
        const double error = errorOf(missed);
        const std::string text = fmt::format(
            "`{}` {:.4g}: beside the other targets, values from {:.3g} to {:.3g} were found",
            targets_[missed].name, targets_[missed].asked, low, high);
        const bool ofBone = !r_.thicknessQuantiles.empty() || !r_.trabecular.empty();
        if (error > kRefusedError && !ofBone)
            throw ParameterError(text + "; give one of these, or leave another target out");
        s_.callbacks.warn(
            fmt::format("{}; this structure has {:.4g}", text, found->second.values[missed]));
    }

    double worstBut(std::size_t left) const { return worstOf(*best_, left); }
    double worstOf(const std::pair<Knobs, Specimen>& tried, std::size_t left = kNone) const {
        double worst = 0;
        for (std::size_t i = 0; i < targets_.size(); ++i)
            if (targets_[i].isNumber && i != left)
                worst = std::max(worst, std::fabs(tried.second.errors[i]));
        return worst;
    }

    /// The values of a target that were found while the others were nearly met.
    std::pair<double, double> rangeOf(std::size_t target) {
        const auto kept = best_;
        const Target asked = targets_[target];
        double low = kept->second.values[target], high = low;
        const auto saved = jacobian_;
        const double enough = std::max(kWarnedError, 1.5 * worstBut(target));
        for (const double factor : {0.5, 2.0}) {
            best_ = kept;
            jacobian_ = saved;
            targets_[target].asked = factor * kept->second.values[target];
            targets_[target].weight = kPushingWeight;
            best_->second.errors[target] = 1 / factor - 1;
            for (double& j : jacobian_[target]) j *= asked.asked / targets_[target].asked;
            seen_.clear();
            search(kRangeRounds, 0);
            for (const Specimen& s : seen_) {
                double others = 0;
                for (std::size_t i = 0; i < targets_.size(); ++i)
                    if (targets_[i].isNumber && i != target)
                        others = std::max(others, std::fabs(s.errors[i]));
                if (others > enough) continue;
                low = std::min(low, s.values[target]);
                high = std::max(high, s.values[target]);
            }
            targets_[target] = asked;
        }
        best_ = kept;
        jacobian_ = saved;
        return {low, high};
    }

    void report(const Specimen& found, const Knobs& knobs, StructureFit& result) {
        for (std::size_t i = 0; i < targets_.size(); ++i)
            if (targets_[i].isNumber)
                result.targets.push_back(
                    {targets_[i].name, targets_[i].asked, found.values[i], std::nullopt});
        const auto toSample = [](const LengthStatistics& have, const std::vector<double>& sample) {
            LengthStatistics other;
            other.quantiles = sample;
            return sample.empty() ? std::nullopt : std::optional(ksDistance(have, other));
        };
        result.thicknessDistance = toSample(found.thickness, r_.thicknessQuantiles);
        result.separationDistance = toSample(found.separation, r_.separationQuantiles);
        // How specimens of other seeds differ, from small ones.
        use(coarse_);
        std::vector<Specimen> others;
        for (int n = 1; n <= kScatterSeeds; ++n) try {
                others.push_back(measure(knobs, s_.seed + static_cast<std::uint64_t>(n)));
            } catch (const ParameterError&) {
                return;
            }
        std::size_t row = 0;
        for (std::size_t i = 0; i < targets_.size(); ++i) {
            if (!targets_[i].isNumber) continue;
            double mean = 0, square = 0;
            for (const Specimen& o : others) mean += o.values[i] / kScatterSeeds;
            for (const Specimen& o : others)
                square += std::pow(o.values[i] - mean, 2) / (kScatterSeeds - 1);
            result.targets[row++].scatter = std::sqrt(square);
        }
    }

    const VoidSetting<3>& s_;
    const VoidRecipe& r_;
    FoamPacks<3>& packs_;
    std::vector<Target> targets_;
    std::array<bool, kKnobs> free_{};
    Knobs x_{};  ///< the first
    double bvtv_ = 0, period_ = 0, thickness_ = 0;
    bool spreadIsKept_ = false;
    double strut_ = 0;  ///< thickness of struts in mean b
    Stage coarse_, fine_;
    double voxel_ = 0;  ///< of the specimens, mm
    const Domain<3>* domain_ = nullptr;
    std::vector<Knobs> jacobian_;  ///< of the errors, a row a target
    std::optional<std::pair<Knobs, Specimen>> best_;
    std::vector<Specimen> seen_;  ///< by the searches so far
};

/// BV/TV of plates, and of rods that are as thin as those of a cubic lattice, as shares of what
/// Tb.Th and Tb.Sp say: bounds with room to spare.
constexpr double kMostOfPlates = 1.3, kLeastOfRods = 0.6;

}  // namespace

VoidRecipe usualFoam(const VoidRecipe& asked) {
    if (!hasStructureTargets(asked)) return asked;
    VoidRecipe r = withoutTargets(asked);
    const bool scaled = asked.targetTbth || asked.targetTbsp || asked.targetConnd;
    if (!scaled) return r;
    const Guess guess = guessOf(asked, 0);
    r.targetBvtv = guess.bvtv;
    const std::string radius = r.radius.empty() ? spreadRadii(kRules[kSpread].usual) : asked.radius;
    const SizeDistribution sizes = SizeDistribution::parse(radius, 3);
    r.radius = sizes.scaled(kRadiusInPeriods * guess.period / sizes.mean()).spec();
    if (!(r.voxelSize > 0)) r.voxelSize = guess.thickness / kFineVoxels;
    return r;
}

void requireConsistent(const VoidRecipe& r) {
    if (!(r.targetBvtv && r.targetTbth && r.targetTbsp)) return;
    const double share = *r.targetTbth / (*r.targetTbth + *r.targetTbsp);
    const double most = kMostOfPlates * share, least = kLeastOfRods * share * share;
    if (*r.targetBvtv <= most && *r.targetBvtv >= least) return;
    throw ParameterError(fmt::format(
        "`targetBvtv` {:g} contradicts `targetTbth` {:g} and `targetTbsp` {:g}: rods of that "
        "thickness and spacing have at least {:.2g}, plates at most {:.2g}; change one of them",
        *r.targetBvtv, *r.targetTbth, *r.targetTbsp, least, std::min(most, 1.0)));
}

StructureFit fitStructure(const VoidSetting<3>& setting, FoamPacks<3>& packs) {
    requireConsistent(setting.recipe);
    return Fit(setting, packs).run();
}

}  // namespace vdbpack
