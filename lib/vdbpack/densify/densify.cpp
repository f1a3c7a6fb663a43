#include "vdbpack/densify/densify.h"

#include "vdbpack/core/ball_share.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/densify/further_spheres.h"
#include "vdbpack/densify/group_boundary.h"
#include "vdbpack/densify/input_check.h"
#include "vdbpack/densify/label_homes.h"
#include "vdbpack/densify/local_further.h"
#include "vdbpack/densify/on_first_rank.h"
#include "vdbpack/densify/pace.h"
#include "vdbpack/densify/relaxation.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/pack/local_sizes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

/// Way that circles of nearly equal size are moved at random first, in radii along each axis.
constexpr double kStir = 0.8;
constexpr std::uint64_t kStirring = 0x7374697272696e67ull;
constexpr std::uint64_t kMixing = 0x6d6978696e67ull;
/// Ratio of the factors up to which a sphere may lie where another one is requested.
constexpr double kNearFactor = 1.2;
/// A fraction is reached but for this.
constexpr double kRounding = 1e-9;
/// Increments of the solid fraction on the way to the densest pack; the last one ends it.
constexpr std::array<double, 3> kStages{0.02, 0.01, 0.005};
/// The way to the densest pack of a periodic cell: in one stage from the front, by as much as can
/// be of the first; then in stages. Each of these is tried twice, with further spheres of its own:
/// which of them jams is chance.
constexpr std::array<double, 4> kGainsAtOnce{0.049, 0.047, 0.045, 0.0425};
constexpr std::array<double, 2> kStagesOfCell{0.005, 0.0025};
constexpr int kTries = 2;
constexpr RelaxationPace kPaceOfCell{0.997, 0.25, 3};
/// Equal spheres stay at random at this pace where they have no walls, along which they
/// crystallize.
constexpr RelaxationPace kPaceOfEqualInCell{0.995, 0.1, 3};
/// Of equal spheres, with or without walls: in several stages they are agitated for longer and
/// crystallize.
constexpr std::array<double, 11> kGainsOfEqual{0.0425, 0.041, 0.0395, 0.038, 0.0365, 0.035,
                                               0.032,  0.029, 0.025,  0.018, 0.01};
/// Below this, equal spheres are loose enough for another such gain.
constexpr double kLoose = 0.63;
/// Fractions above this are no packs of spheres: only a single crystal comes close.
template <int Dim>
constexpr double kMostFraction = Dim == 3 ? 0.95 : 0.98;

template <int Dim>
void checkOptions(const DensifyOptions& options, std::size_t count, double volume) {
    if (!(options.gap >= 0) || !std::isfinite(options.gap))
        throw ParameterError(fmt::format("`gap` {} mm: must be 0 or more", options.gap));
    if (std::isnan(options.fraction) || options.fraction < 0)
        throw ParameterError(fmt::format(
            "`fraction` {}: is no solid fraction; request 0 (overlaps alone) to {}, or max",
            options.fraction, kMostFraction<Dim>));
    if (std::isfinite(options.fraction) && options.fraction > kMostFraction<Dim>)
        throw ParameterError(fmt::format(
            "`fraction` {}: {} cannot be packed as densely; request at most {}, or max for the "
            "densest pack",
            options.fraction, Measure<Dim>::kSpheres, kMostFraction<Dim>));
    if (options.fixed > count)
        throw ParameterError(fmt::format("`fixed` {}: there are {} {}; fix no more than these",
                                         options.fixed, count, Measure<Dim>::kSpheres));
    if (!(volume > 0))
        throw InputError(fmt::format("densify: the domain has no {}; check its unit and clips",
                                     Measure<Dim>::kVolume));
    if (!options.regions.empty() && options.regions.size() != count)
        throw ParameterError(fmt::format("`regions`: {} for {} {}; pass one each, or none",
                                         options.regions.size(), count, Measure<Dim>::kSpheres));
}

template <int Dim>
class Densifier {
public:
    Densifier(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
              const DensifyOptions& options, const Callbacks& callbacks)
        : options_(options),
          outer_(domain),
          callbacks_(callbacks),
          volume_(domain.volume()),
          shell_(0.5 * options.gap),
          ranks_(options.ranks),
          sizes_(spheres, options),
          local_(options.local ? std::make_unique<LocalFurther<Dim>>(domain, spheres, options)
                               : nullptr),
          paces_(Dim, local_ ? local_->radii() : sizes_.radii(), ranks_),
          moving_(sumOver(ranks_, std::uint64_t{sizes_.radii().size()})) {
        if (shell_ > 0) inset_ = insetDomain(domain, shell_);
        domain_ = inset_ ? inset_.get() : &domain;
        result_.spheres = spheres;
        result_.regions = local_ ? local_->classes() : options.regions;
        if (local_) relative_ = local_->relative();
        if (local_ && options.local->shellSizes) boundary_.emplace(domain, options.local->shell);
        result_.before = fractionOf(result_.spheres);
        places_.resize(spheres.size());
        std::iota(places_.begin(), places_.end(), 0u);
        if (!ranks_) return;
        places_ = result_.labels = options.labels;
        homes_.emplace(*ranks_, options.labels, options.pieces);
    }

    DensifyResult<Dim> run() {
        result_.apart = moving_ == 0 || ranks_ || isApart();
        if (moving_ > 0) {
            if (!(options_.fraction > result_.before))
                removeOverlaps();
            else if (std::isfinite(options_.fraction))
                reach(options_.fraction);
            else
                reachMost();
        }
        if (moved_ && options_.contacts && !result_.interrupted) drawTogether();
        result_.after = reachedFraction();
        result_.reached = result_.apart && result_.after >= options_.fraction - kRounding;
        if (ranks_) {
            sortOverRanks();
            result_.pieces = homes_->pieces();
        } else {
            sortByPlace();
        }
        return std::move(result_);
    }

private:
    /// Adds no sphere. Every pace is tried: any of them may succeed here.
    void removeOverlaps() {
        if (!result_.apart) attempt(result_.before, paces_.all());
    }

    /// Tries the fraction at once, or else goes towards it as towards the densest pack: what is out
    /// of reach ends no less dense than that.
    void reach(double wanted) {
        if (attemptGain(wanted) || result_.interrupted) return;
        stage_ = 0;
        if (isInCell()) climbInCell(wanted);
        if (!result_.interrupted && reachedFraction() < wanted - kRounding) climb(wanted);
    }

    /// Goes to the densest pack; of equal spheres to the densest random one.
    void reachMost() {
        constexpr double most = std::numeric_limits<double>::infinity();
        if (isInCell())
            climbInCell(most);
        else if (paces_.areEqualSpheres())
            climbAtRandom(most);
        else
            climb(most);
    }

    bool isInCell() const { return Dim == 3 && domain_->cell().any(); }

    /// To the densest pack of a periodic cell, or up to `most`.
    void climbInCell(double most) {
        if (paces_.areEqualSpheres()) return climbAtRandom(most);
        double failed = 1;  // the least fraction that has
        for (const double gain : kGainsAtOnce) {
            const double next = std::min(result_.before + gain, most);
            if (!(next < failed)) continue;
            failed = next;
            if (attempt(next, {kPaceOfCell}) || result_.interrupted) break;
            stage_ = 0;
        }
        for (const double stage : kStagesOfCell)
            for (int tries = 0; tries < kTries && !result_.interrupted;) {
                if (reachedFraction() >= most - kRounding) return;
                tries += !attempt(std::min(reachedFraction() + stage, most), {kPaceOfCell});
            }
    }

    /// As dense as paces allow that leave equal spheres at random, or up to `most`.
    void climbAtRandom(double most) {
        const bool walls = !domain_->cell().all();
        for (bool loose = true; loose && !result_.interrupted;) {
            const double from = reachedFraction();
            double failed = 1;  // the least fraction that has
            loose = false;
            for (const double gain : kGainsOfEqual) {
                const std::uint64_t stage = stage_;
                const double next = std::min(from + gain, most);
                if (!(next < failed)) continue;
                failed = next;
                if (attempt(next, walls ? paces_.randomForGain(next - result_.before)
                                        : std::vector<RelaxationPace>{kPaceOfEqualInCell})) {
                    loose = gain == kGainsOfEqual.front() && next < kLoose && next < most;
                    break;
                }
                if (result_.interrupted) return;
                stage_ = stage;
            }
        }
    }

    /// Climbs in stages until the smallest one fails, or `most` is reached.
    void climb(double most) {
        for (const double stage : kStages)
            while (!result_.interrupted) {
                const double next = reachedFraction() + stage;
                if (next > kMostFraction<Dim> || !attemptGain(std::min(next, most))) break;
                if (reachedFraction() >= most - kRounding) return;
            }
    }

    double fractionOf(const std::vector<Sphere<Dim>>& spheres) const {
        return ballShare(spheres, volume_, ranks_);
    }
    double reachedFraction() const { return fractionOf(result_.spheres); }

    std::vector<Sphere<Dim>> withShell(std::vector<Sphere<Dim>> spheres) const {
        for (auto& s : spheres) s.radius += shell_;
        return spheres;
    }

    /// Whether no two spheres of the input pack overlap and none of the moving ones protrudes.
    bool isApart() const {
        return isAccepted(withShell(result_.spheres), options_.fixed, *domain_);
    }

    /// As in the options.
    void mixSizes(std::vector<Sphere<Dim>>& spheres, const std::vector<std::int32_t>& regions) {
        std::map<std::int32_t, std::vector<std::uint32_t>> all;
        for (std::size_t i = options_.fixed; i < places_.size(); ++i)
            all[regions.empty() ? 0 : regions[i]].push_back(static_cast<std::uint32_t>(i));
        const std::vector<Sphere<Dim>> before = spheres;
        const std::vector<std::uint32_t> places = places_;
        RandomStream random(options_.seed ^ kMixing, stage_);
        for (const auto& [region, to] : all) {
            std::vector<std::uint32_t> from = to;
            for (std::size_t k = from.size(); k > 1; --k)
                std::swap(from[k - 1], from[random.bits() % k]);
            for (std::size_t k = 0; k < to.size(); ++k) {
                spheres[to[k]].center = before[from[k]].center;
                places_[to[k]] = places[from[k]];
            }
        }
    }

    /// Moves circles at random within the domain: a front leaves equal ones in rows along the wall.
    /// @param labels  over ranks: of the spheres.
    void stir(std::vector<Sphere<Dim>>& spheres, const std::vector<std::uint32_t>& labels) const {
        parallelFor(IndexRange(options_.fixed, spheres.size(), 1024), [&](const IndexRange& part) {
            const auto sampler = domain_->sampler();
            for (std::size_t i = part.begin(); i < part.end(); ++i) {
                RandomStream random(options_.seed ^ kStirring, ranks_ ? labels[i] : i);
                Sphere<Dim>& s = spheres[i];
                Vec<Dim> to = s.center;
                for (int d = 0; d < Dim; ++d)
                    to[d] += kStir * s.radius * (2 * random.uniform() - 1);
                if (sampler->signedDistance(to) < -0.5 * s.radius) s.center = to;
            }
        });
    }

    bool attemptGain(double fraction) {
        return attempt(fraction, paces_.forGain(fraction - result_.before));
    }

    /// Adds spheres up to `fraction` and relaxes, at one pace after the other until a pack has no
    /// overlaps; that is kept. @return whether there is one.
    bool attempt(double fraction, const std::vector<RelaxationPace>& paces) {
        if (local_) return attemptLocally(fraction, paces);
        std::vector<Sphere<Dim>> spheres = result_.spheres;
        std::vector<std::int32_t> regions = result_.regions;
        std::vector<std::uint32_t> labels = result_.labels;
        std::optional<LabelHomes> homes = homes_;
        const std::vector<std::uint32_t> places = places_;
        if (options_.mixSizes && !moved_ && domain_->cell().any() && fraction > result_.before)
            mixSizes(spheres, regions);
        if (ranks_)
            insertOverRanks(fraction, spheres, labels, *homes);
        else
            insert(fraction, spheres, regions);
        ++result_.stages;
        ++stage_;
        for (const RelaxationPace& pace : paces) {
            // From the same start each time: what has jammed stays jammed.
            const bool apart =
                relax(spheres, regions, labels, homes, [&](Relaxation<Dim>& relaxation) {
                    return isRelaxed(relaxation, pace, fraction, spheres.size());
                });
            if (result_.interrupted) break;
            if (!apart) continue;
            result_.labels = std::move(labels);
            homes_ = std::move(homes);
            result_.spheres = std::move(spheres);
            result_.regions = std::move(regions);
            return moved_ = result_.apart = true;
        }
        places_ = places;
        return false;
    }

    /// Adds spheres up to `fraction` where there is room for them.
    void insert(double fraction, std::vector<Sphere<Dim>>& spheres,
                std::vector<std::int32_t>& regions) const {
        const std::uint64_t stage = stage_;
        RandomStream random(options_.seed ^ 0x64656e73696679ull, stage);
        const FurtherSpheres added = sizes_.draw((fraction - reachedFraction()) * volume_, random);
        if (added.radii.empty()) return;
        Relaxation<Dim> present(*domain_, withShell(spheres), options_.fixed, regions,
                                options_.seed);
        const auto placed = present.vacancies(added.radii, added.regions, stage);
        spheres.insert(spheres.end(), placed.begin(), placed.end());
        regions.insert(regions.end(), added.regions.begin(), added.regions.end());
        if (paces_.areEqualCircles()) stir(spheres, {});
    }

    /// Spheres where sizes differ by place.
    struct LocalPack {
        std::vector<Sphere<Dim>> spheres;
        std::vector<std::int32_t> classes;
        std::vector<double> relative;  ///< radii where the factor is 1, mm
    };

    /// As `attempt`, where sizes differ by place.
    bool attemptLocally(double fraction, const std::vector<RelaxationPace>& paces) {
        ++result_.stages;
        ++stage_;
        const std::vector<std::uint32_t> places = places_;
        for (const RelaxationPace& pace : paces) {
            LocalPack pack{result_.spheres, result_.regions, relative_};
            if (reachLocally(fraction, pace, pack)) {
                result_.spheres = std::move(pack.spheres);
                result_.regions = std::move(pack.classes);
                relative_ = std::move(pack.relative);
                return moved_ = result_.apart = true;
            }
            places_ = places;
            if (result_.interrupted) return false;
        }
        return false;
    }

    /// Spheres drift to where there is room, which changes what is requested of them: most are
    /// added first, then radii follow the field again, and the others are added. Where there is
    /// room for it, radii follow the field once more.
    bool reachLocally(double fraction, const RelaxationPace& pace, LocalPack& pack) {
        constexpr double kFirst = 0.4;
        constexpr int kFits = 3;
        constexpr double kFit = 2e-3;
        const double begin = reachedFraction();
        for (std::uint64_t turn = 1;; ++turn) {
            const double next = turn == 1 ? begin + kFirst * (fraction - begin) : fraction;
            insertLocally(next, turn << 48, pack);
            if (!relaxLocally(next, pace, pack)) return false;
            if (turn > 1 && fractionOf(pack.spheres) >= fraction - kRounding) break;
            fit(pack);
        }
        for (int k = 0; k < kFits && !(misfitOf(pack) < kFit); ++k) {
            LocalPack fitted = pack;
            const std::vector<std::uint32_t> places = places_;
            fit(fitted);
            if (fractionOf(fitted.spheres) >= fraction - kRounding &&
                relaxLocally(fraction, pace, fitted)) {
                pack = std::move(fitted);
            } else {
                places_ = places;
                break;
            }
        }
        return !result_.interrupted;
    }

    bool relaxLocally(double fraction, const RelaxationPace& pace, LocalPack& pack) {
        const std::size_t count = pack.spheres.size();
        return relaxHere(pack.spheres, pack.classes, [&](Relaxation<Dim>& relaxation) {
            return isRelaxed(relaxation, pace, fraction, count);
        });
    }

    /// Calls `visit(i, size)` for the spheres that lie where about their own size is requested.
    template <class Visit>
    void forEachAtHome(const LocalPack& pack, const Visit& visit) const {
        const std::vector<LocalSize> sizes = localSizesOf(pack.spheres, outer_, *options_.local);
        for (std::size_t i = options_.fixed; i < pack.spheres.size(); ++i)
            if (areNear(sizes[i], LocalFurther<Dim>::sizeOf(pack.classes[i]))) visit(i, sizes[i]);
    }
    static bool areNear(const LocalSize& a, const LocalSize& b) {
        return a.group == b.group && a.factor < kNearFactor * b.factor &&
               b.factor < kNearFactor * a.factor;
    }

    /// The root mean square by which radii differ from those requested, as a share.
    double misfitOf(const LocalPack& pack) const {
        double squares = 0, count = 1;
        forEachAtHome(pack, [&](std::size_t i, const LocalSize& size) {
            const double off = pack.spheres[i].radius / (pack.relative[i] * size.factor) - 1;
            squares += off * off;
            ++count;
        });
        return std::sqrt(squares / count);
    }

    /// Gives spheres the radii that are requested of them where they are.
    void fit(LocalPack& pack) const {
        forEachAtHome(pack, [&](std::size_t i, const LocalSize& size) {
            pack.spheres[i].radius =
                static_cast<double>(static_cast<float>(pack.relative[i] * size.factor));
            pack.classes[i] = LocalFurther<Dim>::classOf(size);
        });
    }

    /// Adds spheres up to `fraction`, each of the size that is requested at its center.
    void insertLocally(double fraction, std::uint64_t salt, LocalPack& pack) const {
        using Further = LocalFurther<Dim>;
        PerThread<LocalSizeSampler<Dim>> samplers(
            [&] { return LocalSizeSampler<Dim>(outer_, *options_.local); });
        const auto belongs = [&](const Vec<Dim>& x, std::int32_t number) {
            return areNear(samplers.local().at(x), Further::sizeOf(number));
        };
        double missing = (fraction - fractionOf(pack.spheres)) * volume_;
        // Factors differ a little from those of their classes: what is missing is added again.
        for (std::uint64_t round = 0; missing > 0; ++round) {
            const std::uint64_t stage = stage_ ^ salt ^ (round << 32);
            RandomStream random(options_.seed ^ 0x64656e73696679ull, stage);
            const FurtherSpheres drawn = local_->draw(missing, random);
            std::vector<double> radii;
            for (std::size_t k = 0; k < drawn.radii.size(); ++k)
                radii.push_back(drawn.radii[k] * Further::sizeOf(drawn.regions[k]).factor);
            Relaxation<Dim> present(*domain_, withShell(pack.spheres), options_.fixed, pack.classes,
                                    options_.seed, true);
            const auto found = present.vacancies(radii, drawn.regions, stage, belongs);
            for (std::size_t k = 0; k < found.size() && missing > 0; ++k) {
                LocalSize size = Further::sizeOf(drawn.regions[k]);
                if (belongs(found[k].center, drawn.regions[k]))
                    size = samplers.local().at(found[k].center);
                const auto radius = static_cast<float>(drawn.radii[k] * size.factor);
                pack.spheres.push_back({found[k].center, static_cast<double>(radius)});
                pack.classes.push_back(Further::classOf(size));
                pack.relative.push_back(drawn.radii[k]);
                missing -= Measure<Dim>::ball(pack.spheres.back().radius);
            }
        }
        if (paces_.areEqualCircles()) stir(pack.spheres, {});
    }

    /// The same over ranks.
    /// @param labels, homes  of the spheres; those that are added are, too.
    void insertOverRanks(double fraction, std::vector<Sphere<Dim>>& spheres,
                         std::vector<std::uint32_t>& labels, LabelHomes& homes) const {
        const std::uint64_t stage = stage_;
        RandomStream random(options_.seed ^ 0x64656e73696679ull, stage);
        const auto radii =
            sizes_.draw((fraction - reachedFraction()) * volume_, random).radii;  // the same on all
        if (radii.empty()) return;
        Relaxation<Dim> present(*domain_, withShell(spheres), *ranks_, labels,
                                *std::max_element(radii.begin(), radii.end()), options_.seed);
        auto found = present.vacanciesHere(radii, stage);
        const std::uint32_t first = homes.add(radii.size());
        found = homes.delivered(*ranks_, found, [&](const auto& vacancy) {
            return first + static_cast<std::uint32_t>(vacancy.number);
        });
        std::sort(found.begin(), found.end(),
                  [](const auto& a, const auto& b) { return a.number < b.number; });
        for (const auto& vacancy : found) {
            spheres.push_back({vacancy.center, radii[vacancy.number]});
            labels.push_back(first + static_cast<std::uint32_t>(vacancy.number));
        }
        if (paces_.areEqualCircles()) stir(spheres, labels);
    }

    /// Relaxes at one pace. @return whether no overlap is left.
    bool isRelaxed(Relaxation<Dim>& relaxation, const RelaxationPace& pace, double fraction,
                   std::size_t count) {
        const int steps = mostSteps(pace);
        Jam jam(pace);
        const auto goOn = [&](int step, double worst) {
            if (step % 10 == 0 && callbacks_.progress)
                callbacks_.progress(
                    {fmt::format("densify to {:.4f}, overlap {:.2g}", fraction, worst),
                     static_cast<double>(step) / steps, static_cast<double>(count)});
            return !jam.add(step, worst);
        };
        const auto outcome = relaxation.run(pace, steps, callbacks_, goOn);
        result_.steps += static_cast<std::uint64_t>(outcome.steps);
        result_.interrupted = outcome.interrupted;
        return outcome.apart;
    }

    /// Draws near spheres together. Where that leaves overlaps, the pack stays as it is.
    void drawTogether() {
        std::vector<Sphere<Dim>> spheres = result_.spheres;
        const auto onStep = [&](double done) {
            callbacks_.report("densify, contacts", done, static_cast<double>(spheres.size()));
        };
        const bool apart = relax(
            spheres, result_.regions, result_.labels, homes_, [&](Relaxation<Dim>& relaxation) {
                const auto outcome = relaxation.drawTogether(callbacks_, onStep);
                result_.steps += static_cast<std::uint64_t>(outcome.steps);
                result_.interrupted = outcome.interrupted;
                return outcome.apart;
            });
        if (apart) result_.spheres = std::move(spheres);
    }

    /// Moves spheres by `work(relaxation)`, which returns whether no overlap is left. If so,
    /// @return true, and `spheres` have moved.
    template <class Work>
    bool relax(std::vector<Sphere<Dim>>& spheres, const std::vector<std::int32_t>& regions,
               const std::vector<std::uint32_t>& labels, const std::optional<LabelHomes>& homes,
               const Work& work) {
        return ranks_ ? relaxOverRanks(spheres, labels, *homes, work)
                      : relaxHere(spheres, regions, work);
    }

    template <class Work>
    bool relaxOverRanks(std::vector<Sphere<Dim>>& spheres, const std::vector<std::uint32_t>& labels,
                        const LabelHomes& homes, const Work& work) {
        Relaxation<Dim> relaxation(*domain_, withShell(spheres), *ranks_, labels, 0,
                                   options_.seed + stage_);
        if (!work(relaxation)) return false;
        const auto settled =
            homes.delivered(*ranks_, relaxation.settled(), [](const auto& s) { return s.label; });
        std::vector<std::uint32_t> places(spheres.size());
        for (const auto& s : settled) {
            const std::size_t i = LabelHomes::indexOf(labels, s.label);
            spheres[i].center = s.center;
            places[i] = s.place;
        }
        // Those that were there at first: known where the spheres there have their homes.
        places_.insert(places_.end(), labels.begin() + static_cast<std::ptrdiff_t>(places_.size()),
                       labels.end());
        places_ = homes.valuesAt(*ranks_, places, labels, places_);
        return true;
    }

    template <class Work>
    bool relaxHere(std::vector<Sphere<Dim>>& spheres, const std::vector<std::int32_t>& regions,
                   const Work& work) {
        Relaxation<Dim> relaxation(*domain_, withShell(spheres), options_.fixed, regions,
                                   options_.seed + stage_, local_ != nullptr);
        if (boundary_) relaxation.keepTo(*boundary_, isInside_);
        if (!work(relaxation)) return false;
        const auto moved = relaxation.spheres();
        for (std::size_t i = 0; i < moved.size(); ++i) spheres[i].center = moved[i].center;
        for (std::size_t i = places_.size(); i < moved.size(); ++i)
            places_.push_back(static_cast<std::uint32_t>(i));
        std::vector<std::uint32_t> places = relaxation.places();
        for (std::uint32_t& place : places) place = places_[place];
        places_ = std::move(places);
        return true;
    }

    /// Orders the result such that each sphere is near where the one of its number was: it is the
    /// sizes that are exchanged.
    void sortByPlace() {
        const std::vector<Sphere<Dim>> spheres = result_.spheres;
        const std::vector<std::int32_t> regions = result_.regions;
        for (std::size_t i = 0; i < places_.size(); ++i) {
            result_.spheres[places_[i]] = spheres[i];
            if (!regions.empty()) result_.regions[places_[i]] = regions[i];
        }
    }

    /// The same as `sortByPlace`, over ranks.
    void sortOverRanks() {
        struct Sorted {
            std::uint32_t place;
            Sphere<Dim> sphere;
        };
        std::vector<Sorted> all;
        for (std::size_t i = 0; i < places_.size(); ++i)
            all.push_back({places_[i], result_.spheres[i]});
        all = homes_->delivered(*ranks_, all, [](const Sorted& s) { return s.place; });
        for (const Sorted& s : all)
            result_.spheres[LabelHomes::indexOf(result_.labels, s.place)] = s.sphere;
    }

    const DensifyOptions& options_;
    const Domain<Dim>& outer_;
    const Callbacks& callbacks_;
    double volume_;
    double shell_;
    std::unique_ptr<Domain<Dim>> inset_;
    const Domain<Dim>* domain_ = nullptr;
    Ranks* ranks_;
    FurtherSizes<Dim> sizes_;
    std::unique_ptr<LocalFurther<Dim>> local_;    ///< null: the same sizes everywhere
    std::vector<double> relative_;                ///< as in LocalPack, of the spheres of the result
    std::optional<GroupBoundary<Dim>> boundary_;  ///< of the shell, if it has sizes of its own
    const std::function<bool(std::int32_t)> isInside_ = [](std::int32_t number) {
        return LocalFurther<Dim>::sizeOf(number).group == 0;
    };
    Paces paces_;
    std::uint64_t moving_;             ///< spheres that move, of all ranks
    std::optional<LabelHomes> homes_;  ///< over ranks: of the spheres of the result
    bool moved_ = false;               ///< whether the result is no longer the input pack
    std::uint64_t stage_ = 0;          ///< insertions on the way to the result; part of the seed
    DensifyResult<Dim> result_;
    std::vector<std::uint32_t> places_;  ///< numbers of the spheres that were there at first
};

}  // namespace

template <int Dim>
DensifyResult<Dim> densify(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                           const DensifyOptions& options, const Callbacks& callbacks) {
    checkOptions<Dim>(options, spheres.size(), domain.volume());
    if (const PeriodicCell<Dim> cell = domain.cell(); cell.any()) {
        double largest = options.sizes ? options.sizes->max() : 0;
        for (const auto& s : spheres) largest = std::max(largest, s.radius);
        requireLongCell(cell, largest + 0.5 * options.gap);
    }
    // Images of spheres, and sizes by place, are known to one rank alone.
    if (options.ranks && (domain.cell().any() || options.local))
        return densifyOnFirstRank<Dim>(spheres, options, [&](const auto& all, const auto& own) {
            return Densifier<Dim>(domain, all, own, callbacks).run();
        });
    return Densifier<Dim>(domain, spheres, options, callbacks).run();
}

template DensifyResult<2> densify(const Domain<2>&, const std::vector<Sphere<2>>&,
                                  const DensifyOptions&, const Callbacks&);
template DensifyResult<3> densify(const Domain<3>&, const std::vector<Sphere<3>>&,
                                  const DensifyOptions&, const Callbacks&);

}  // namespace vdbpack
