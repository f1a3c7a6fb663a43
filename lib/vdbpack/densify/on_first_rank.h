// Private to densify: packs that only one rank can densify, which all share.
#pragma once

#include "vdbpack/densify/densify.h"
#include "vdbpack/densify/label_homes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace vdbpack {

template <int Dim>
struct LabelledSphere {
    std::uint32_t label;
    Sphere<Dim> sphere;
};

template <int Dim>
std::vector<LabelledSphere<Dim>> sortedByLabel(std::vector<LabelledSphere<Dim>> all) {
    std::sort(all.begin(), all.end(),
              [](const auto& a, const auto& b) { return a.label < b.label; });
    return all;
}

/// The spheres of all ranks on the first one, by label; none on the others.
template <int Dim>
std::vector<LabelledSphere<Dim>> gatheredOnFirst(Ranks& ranks,
                                                 const std::vector<std::uint32_t>& labels,
                                                 const std::vector<Sphere<Dim>>& spheres) {
    std::vector<std::vector<LabelledSphere<Dim>>> toEach(static_cast<std::size_t>(ranks.count()));
    for (std::size_t i = 0; i < spheres.size(); ++i)
        toEach.front().push_back({labels[i], spheres[i]});
    return sortedByLabel(joined(exchanged(ranks, std::move(toEach))));
}

/// Densifies the spheres of all ranks on the first one.
/// @param spheres  of this rank.
/// @param alone    densifies a whole pack with options that know no ranks; called by the first one.
/// @return as `densify` over ranks
template <int Dim>
DensifyResult<Dim> densifyOnFirstRank(
    const std::vector<Sphere<Dim>>& spheres, const DensifyOptions& options,
    const std::function<DensifyResult<Dim>(const std::vector<Sphere<Dim>>&, const DensifyOptions&)>&
        alone) {
    using Labelled = LabelledSphere<Dim>;
    Ranks& ranks = *options.ranks;
    LabelHomes homes(ranks, options.labels, options.pieces);
    std::vector<Labelled> all = gatheredOnFirst(ranks, options.labels, spheres);

    /// What all are to know of the result.
    struct Facts {
        double before, after;
        std::uint64_t steps, added;
        std::int32_t stages;
        std::uint8_t apart, reached, interrupted;
    };
    std::vector<Facts> facts;
    if (ranks.isFirst()) {
        std::vector<Sphere<Dim>> whole;
        for (const Labelled& l : all) whole.push_back(l.sphere);
        DensifyOptions own = options;
        own.ranks = nullptr;
        own.labels = {};
        own.pieces = {};
        const auto done = alone(whole, own);
        facts.push_back({done.before, done.after, done.steps, done.spheres.size() - whole.size(),
                         done.stages, done.apart, done.reached, done.interrupted});
        auto next = static_cast<std::uint32_t>(options.pieces.back());
        for (std::size_t i = 0; i < done.spheres.size(); ++i)
            if (i < all.size())
                all[i].sphere = done.spheres[i];
            else
                all.push_back({next++, done.spheres[i]});
    }
    const Facts told = gathered(&ranks, facts).front().front();
    homes.add(told.added);
    all = sortedByLabel(homes.delivered(ranks, all, [](const Labelled& l) { return l.label; }));

    DensifyResult<Dim> result;
    for (const Labelled& l : all) {
        result.labels.push_back(l.label);
        result.spheres.push_back(l.sphere);
    }
    result.pieces = homes.pieces();
    result.before = told.before;
    result.after = told.after;
    result.steps = told.steps;
    result.stages = told.stages;
    result.apart = told.apart != 0;
    result.reached = told.reached != 0;
    result.interrupted = told.interrupted != 0;
    return result;
}

}  // namespace vdbpack
