#include "vdbpack/densify/densify.h"

#include "vdbpack/core/ball_share.h"
#include "vdbpack/densify/ascent.h"
#include "vdbpack/densify/further_spheres.h"
#include "vdbpack/densify/group_boundary.h"
#include "vdbpack/densify/input_check.h"
#include "vdbpack/densify/label_homes.h"
#include "vdbpack/densify/local_further.h"
#include "vdbpack/densify/on_first_rank.h"
#include "vdbpack/densify/random_start.h"
#include "vdbpack/densify/relaxation.h"
#include "vdbpack/densify/stir.h"
#include "vdbpack/domain/inset_domain.h"
#include "vdbpack/pack/local_sizes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

template <int Dim>
class Densifier : private Stages {
public:
    Densifier(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
              const DensifyOptions& options, const Callbacks& callbacks)
        : options_(options),
          callbacks_(callbacks),
          volume_(domain.volume()),
          shell_(0.5 * options.gap),
          ranks_(options.ranks),
          sizes_(spheres, options),
          local_(options.local ? std::make_unique<LocalFurther<Dim>>(domain, spheres, options)
                               : nullptr),
          paces_(Dim,
                 options.random ? someRadii(*options.sizes)
                 : local_       ? local_->radii()
                                : sizes_.radii(),
                 ranks_),
          moving_(options.random ? aboutCount<Dim>(*options.sizes, options.fraction, volume_)
                                 : sumOver(ranks_, std::uint64_t{sizes_.radii().size()})) {
        if (shell_ > 0) inset_ = insetDomain(domain, shell_);
        domain_ = inset_ ? inset_.get() : &domain;
        result_.spheres = spheres;
        result_.regions = local_ ? local_->classes() : options.regions;
        if (local_) relative_ = local_->relative();
        if (local_ && options.local->shellSizes) boundary_.emplace(domain, options.local->shell);
        result_.before = options.random ? 0 : reached();
        places_.resize(spheres.size());
        std::iota(places_.begin(), places_.end(), 0u);
        if (!ranks_)
            device_ = StepDevice::open(options.device, moving_,
                                       [this](const std::string& text) { callbacks_.warn(text); });
        if (!ranks_) return;
        places_ = result_.labels = options.labels;
        homes_.emplace(*ranks_, options.labels, options.pieces);
    }

    DensifyResult<Dim> run() {
        result_.apart =
            moving_ == 0 || ranks_ || options_.settle || (!options_.random && isApart());
        if (moving_ > 0 && options_.settle) {
            settle();
        } else if (moving_ > 0) {
            const PeriodicCell<Dim> cell = domain_->cell();
            const double front = options_.random ? likeFront(*domain_, options_) : reached();
            Ascent ascent(
                *this, paces_,
                {front, kMostFraction<Dim>, Dim == 3 && cell.any(), !cell.all(), Dim == 3});
            if (std::isinf(options_.fraction))
                ascent.reachMost();
            else if (options_.random || options_.fraction > result_.before)
                ascent.reach(options_.fraction);
            else if (!result_.apart)
                attempt(result_.before, paces_.all());  // adds no sphere: any pace may succeed
        }
        if (moved_ && options_.contacts && !options_.settle && !result_.interrupted) drawTogether();
        if (local_ && result_.apart && !result_.interrupted) fitSettled();
        if (device_) result_.device = device_->use();
        result_.after = reached();
        result_.reached = result_.apart && result_.after >= options_.fraction - kFractionRounding;
        if (ranks_) {
            homes_->sort(*ranks_, result_.labels, places_, result_.spheres);
            result_.pieces = homes_->pieces();
        } else {  // it is the sizes that are exchanged
            sortByPlace(places_, result_.spheres);
            sortByPlace(places_, result_.regions);
        }
        return std::move(result_);
    }

private:
    double fractionOf(const std::vector<Sphere<Dim>>& spheres) const {
        return ballShare(spheres, volume_, ranks_);
    }
    double strain() const override { return strain_; }
    double reached() const override { return fractionOf(result_.spheres); }
    bool isInterrupted() const override { return result_.interrupted; }

    /// Whether no two spheres of the input pack overlap and none of the moving ones protrudes.
    bool isApart() const {
        return isAccepted(grownBy(shell_, result_.spheres), options_.fixed, *domain_);
    }

    bool attempt(double fraction, const std::vector<RelaxationPace>& paces) override {
        if (local_) return attemptLocally(fraction, paces);
        std::vector<Sphere<Dim>> spheres = result_.spheres;
        std::vector<std::int32_t> regions = result_.regions;
        std::vector<std::uint32_t> labels = result_.labels;
        std::optional<LabelHomes> homes = homes_;
        const std::vector<std::uint32_t> places = places_;
        if (options_.mixSizes && !moved_ && domain_->cell().any() && fraction > result_.before)
            mixSizes(options_.seed, stage, options_.fixed, regions, spheres, places_);
        if (ranks_)
            insertOverRanks(fraction, spheres, labels, *homes);
        else if (options_.random && spheres.empty())
            spheres = randomStart(*domain_, *options_.sizes, fraction * volume_, shell_,
                                  options_.seed + stage);
        else
            insert(fraction, spheres, regions);
        ++result_.stages;
        ++stage;
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

    void insert(double fraction, std::vector<Sphere<Dim>>& spheres,
                std::vector<std::int32_t>& regions) const {
        RandomStream random = furtherStream(options_.seed, stage);
        const FurtherSpheres added = sizes_.draw((fraction - reached()) * volume_, random);
        if (added.radii.empty()) return;
        Relaxation<Dim> present(*domain_, grownBy(shell_, spheres), options_.fixed, regions,
                                options_.seed);
        const auto placed = present.vacancies(added.radii, added.regions, stage);
        spheres.insert(spheres.end(), placed.begin(), placed.end());
        regions.insert(regions.end(), added.regions.begin(), added.regions.end());
        if (paces_.areEqualCircles()) stir(options_.seed, *domain_, options_.fixed, {}, spheres);
    }

    bool attemptLocally(double fraction, const std::vector<RelaxationPace>& paces) {
        ++result_.stages;
        ++stage;
        const std::vector<std::uint32_t> places = places_;
        for (const RelaxationPace& pace : paces) {
            LocalPack<Dim> pack{result_.spheres, result_.regions, relative_};
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
    /// added first, then radii follow the field again, and the others are added.
    bool reachLocally(double fraction, const RelaxationPace& pace, LocalPack<Dim>& pack) {
        constexpr double kFirst = 0.4;
        const double begin = reached();
        for (std::uint64_t turn = 1;; ++turn) {
            const bool isFirst = turn == 1 && !pace.isProbe;
            const double next = isFirst ? begin + kFirst * (fraction - begin) : fraction;
            local_->insert((next - fractionOf(pack.spheres)) * volume_, *domain_,
                           stage ^ (turn << 48), pack);
            if (paces_.areEqualCircles())
                stir(options_.seed, *domain_, options_.fixed, {}, pack.spheres);
            if (!relaxLocally(next, pace, pack, true)) return false;
            if (turn > 1 && fractionOf(pack.spheres) >= fraction - kFractionRounding) break;
            local_->fit(pack);
        }
        fitLocally(pack, fraction, [&](LocalPack<Dim>& fitted) {
            return relaxLocally(fraction, pace, fitted, false);
        });
        return !result_.interrupted;
    }

    /// Spheres take the radii that are requested where they are, as often as that halves what they
    /// are off. @param relax  removes the overlaps of a pack; no spheres exchange positions
    template <class Relax>
    void fitLocally(LocalPack<Dim>& pack, double fraction, const Relax& relax) {
        constexpr double kClose = 1e-4;
        double before = std::numeric_limits<double>::infinity();
        for (double misfit = local_->misfit(pack); misfit > kClose && misfit < 0.5 * before;
             misfit = local_->misfit(pack)) {
            before = misfit;
            LocalPack<Dim> fitted = pack;
            local_->fit(fitted);
            local_->insert((fraction - fractionOf(fitted.spheres)) * volume_, *domain_,
                           ++stage ^ (1ull << 60), fitted);
            if (!relax(fitted)) return;
            pack = std::move(fitted);
        }
    }

    bool relaxLocally(double fraction, const RelaxationPace& pace, LocalPack<Dim>& pack,
                      bool exchange) {
        return relaxHere(pack.spheres, pack.classes, [&](Relaxation<Dim>& relaxation) {
            if (!exchange) relaxation.exchangeNone();
            return isRelaxed(relaxation, pace, fraction, pack.spheres.size());
        });
    }

    /// As `insert`, over ranks; gives labels and homes to those that are added.
    void insertOverRanks(double fraction, std::vector<Sphere<Dim>>& spheres,
                         std::vector<std::uint32_t>& labels, LabelHomes& homes) const {
        RandomStream random = furtherStream(options_.seed, stage);
        const auto radii = sizes_.draw((fraction - reached()) * volume_, random).radii;
        if (radii.empty()) return;
        Relaxation<Dim> present(*domain_, grownBy(shell_, spheres), *ranks_, labels,
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
        if (paces_.areEqualCircles()) stir(options_.seed, *domain_, 0, labels, spheres);
    }

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
        if (!outcome.apart && !outcome.interrupted) strain_ = relaxation.strain();
        return outcome.apart;
    }

    void settle() {
        // In radii along each axis. Less, where a few spheres in a narrow place did not find room.
        constexpr std::array<double, 3> kWays{0.15, 0.05, 0.015};
        for (const double way : kWays) {
            std::vector<Sphere<Dim>> spheres = result_.spheres;
            stir(options_.seed + stage++, *domain_, options_.fixed, result_.labels, spheres, way);
            result_.apart = relaxOnce(std::move(spheres), "settle",
                                      [&](Relaxation<Dim>& relaxation, const auto& onStep) {
                                          return relaxation.settle(callbacks_, onStep);
                                      });
            if (result_.apart || result_.interrupted) return;
        }
    }

    /// Fits the sizes by place of a pack whose spheres were drawn together.
    void fitSettled() {
        LocalPack<Dim> pack{result_.spheres, result_.regions, relative_};
        fitLocally(pack, std::min(reached(), options_.fraction), [&](LocalPack<Dim>& fitted) {
            return relaxHere(fitted.spheres, fitted.classes, [&](Relaxation<Dim>& relaxation) {
                relaxation.exchangeNone();
                return relaxation.drawTogether(false, callbacks_).apart;
            });
        });
        result_.spheres = std::move(pack.spheres);
        result_.regions = std::move(pack.classes);
    }

    /// Draws near spheres together. Where that leaves overlaps, the pack stays as it is.
    void drawTogether() {
        relaxOnce(result_.spheres, "densify, contacts",
                  [&](Relaxation<Dim>& relaxation, const auto& onStep) {
                      return relaxation.drawTogether(options_.random, callbacks_, onStep);
                  });
    }

    /// The result is what `work` makes of spheres, unless that leaves overlaps. @return whether it
    /// is
    template <class Work>
    bool relaxOnce(std::vector<Sphere<Dim>> spheres, const char* name, const Work& work) {
        const auto onStep = [&](double done) {
            callbacks_.report(name, done, static_cast<double>(spheres.size()));
        };
        const bool apart = relax(spheres, result_.regions, result_.labels, homes_,
                                 [&](Relaxation<Dim>& relaxation) {
                                     const auto outcome = work(relaxation, onStep);
                                     result_.steps += static_cast<std::uint64_t>(outcome.steps);
                                     result_.interrupted = outcome.interrupted;
                                     return outcome.apart;
                                 });
        if (apart) result_.spheres = std::move(spheres);
        return apart;
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
        Relaxation<Dim> relaxation(*domain_, grownBy(shell_, spheres), *ranks_, labels, 0,
                                   options_.seed + stage);
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
        Relaxation<Dim> relaxation(*domain_, grownBy(shell_, spheres), options_.fixed, regions,
                                   options_.seed + stage, local_ != nullptr);
        relaxation.useDevice(device_.get());
        if (boundary_) relaxation.keepTo(*boundary_, isInside_);
        if (!work(relaxation)) return false;
        relaxation.move(spheres);
        for (std::size_t i = places_.size(); i < spheres.size(); ++i)
            places_.push_back(static_cast<std::uint32_t>(i));
        std::vector<std::uint32_t> places = relaxation.places();
        for (std::uint32_t& place : places) place = places_[place];
        places_ = std::move(places);
        return true;
    }

    const DensifyOptions& options_;
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
    std::uint64_t moving_;                ///< spheres that move, of all ranks
    std::unique_ptr<StepDevice> device_;  ///< null: the processor alone
    std::optional<LabelHomes> homes_;     ///< over ranks: of the spheres of the result
    double strain_ = 0;                   ///< as `Stages::strain`
    bool moved_ = false;                  ///< whether the result is no longer the input pack
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
