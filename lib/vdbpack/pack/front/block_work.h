// Private to the front: what a block's front works with.
#pragma once

#include "vdbpack/pack/front/block_front.h"
#include "vdbpack/pack/front/front.h"
#include "vdbpack/pack/front/placement.h"
#include "vdbpack/pack/front/vacancy_search.h"

#include <algorithm>
#include <vector>

namespace vdbpack {

template <int Dim>
class BlockFront<Dim>::Work {
public:
    explicit Work(const FrontSettings<Dim>& settings) : front_(settings), placement_(front_) {}

    void fill(const Place& place, const BlockSpheres<Dim>& around, std::vector<RadiusPool>& pools,
              SpeciesQueue* further, DomainSampler<Dim>& sampler,
              const std::function<bool()>& cancelled, BlockSpheres<Dim>& placed);

    std::size_t seeds_ = 0;

private:
    using Placer = Placement<Dim>;

    void addExisting(const BlockSpheres<Dim>& around);
    void searchVacancies();
    void collect(BlockSpheres<Dim>& placed);
    void runFront();
    void grow(std::uint32_t site);
    bool growAs(std::uint32_t site, const LocalSize& size);
    bool restLocally(std::uint32_t site, const LocalSize& size, double drawn, double& radius,
                     Vec<Dim>& center);
    bool isOnBroadWall(std::uint32_t site, double common);
    bool placeDrawn(std::uint32_t site, const LocalSize& size, const FrontLengths& lengths,
                    bool onWall);
    void countOnWall(double drawn, const RadiusPool& pool);
    bool placeWide(std::uint32_t site, const LocalSize& size);
    bool placeFurther(std::uint32_t site);
    void countElement(const Vec<Dim>& center);
    bool placePending(const Vec<Dim>& center, const LocalSize& size, std::size_t k);
    void fillVacancy(Vec<Dim> x);

    /// What is requested where the largest sphere at a site would be.
    LocalSize sizeAtSite(std::uint32_t site) const {
        return front_.block.local ? front_.block.sizeAt(front_.sites.center(site)) : LocalSize{};
    }
    /// A radius of a pool where it has this factor, mm.
    double radiusOf(const LocalSize& size, double drawn) const {
        if (!front_.block.local) return drawn;
        return static_cast<double>(static_cast<float>(drawn * size.factor)) +
               front_.block.local->layer();
    }
    /// The same of the `k`-th smallest that a group has pending.
    double pendingRadius(const LocalSize& size, std::size_t k) const {
        return radiusOf(size, (*pools_)[size.group][k]);
    }
    /// How many of the pending radii of a group are <= `r` (mm) where they have this factor.
    std::size_t fitting(const LocalSize& size, double r) const {
        if (const auto* local = front_.block.local)
            r = (std::min(r, front_.block.settings.maxRadius) - local->layer()) / size.factor;
        return (*pools_)[size.group].countUpTo(r);
    }

    /// Looks now and then whether the pack is to be stopped: a step takes microseconds, next to
    /// clusters of existing spheres milliseconds.
    void askToStop(std::size_t step) {
        if (step % 16 == 0 && *cancelled_ && (*cancelled_)()) stop_ = true;
    }

    Front<Dim> front_;
    Placer placement_;
    VacancySearch<Dim> search_;
    std::vector<RadiusPool>* pools_ = nullptr;
    SpeciesQueue* further_ = nullptr;
    std::vector<std::uint8_t> species_;  ///< beside the block's spheres where there are several
    const std::function<bool()>* cancelled_ = nullptr;
    bool stop_ = false;
    double wallBalance_ = 0;            ///< sum of radii on broad walls, less what it is to be, mm
    int wideWait_ = 0, widePause_ = 1;  ///< sites to pass before the next of the largest
};

}  // namespace vdbpack
