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

/// Densifies the spheres of all ranks on the first one.
/// @param spheres  of this rank.
/// @param alone    densifies a whole pack with options that know no ranks; called by the first one.
/// @return as `densify` over ranks
template <int Dim>
DensifyResult<Dim> densifyOnFirstRank(
    const std::vector<Sphere<Dim>>& spheres, const DensifyOptions& options,
    const std::function<DensifyResult<Dim>(const std::vector<Sphere<Dim>>&, const DensifyOptions&)>&
        alone) {
    struct Labelled {
        std::uint32_t label;
        Sphere<Dim> sphere;
    };
    const auto sorted = [](std::vector<Labelled> all) {
        std::sort(all.begin(), all.end(),
                  [](const Labelled& a, const Labelled& b) { return a.label < b.label; });
        return all;
    };
    Ranks& ranks = *options.ranks;
    LabelHomes homes(ranks, options.labels, options.pieces);
    std::vector<Labelled> all;
    for (std::size_t i = 0; i < spheres.size(); ++i) all.push_back({options.labels[i], spheres[i]});
    std::vector<Ranks::Bytes> toEach(static_cast<std::size_t>(ranks.count()));
    toEach.front() = bytesOf(all);
    all.clear();
    for (const auto& bytes : ranks.exchange(std::move(toEach))) {
        const auto some = valuesOf<Labelled>(bytes);
        all.insert(all.end(), some.begin(), some.end());
    }

    /// What all are to know of the result.
    struct Facts {
        double before, after;
        std::uint64_t steps, added;
        std::int32_t stages;
        std::uint8_t apart, reached, interrupted;
    };
    std::vector<Facts> facts;
    if (ranks.isFirst()) {
        all = sorted(std::move(all));
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
    all = sorted(homes.delivered(ranks, all, [](const Labelled& l) { return l.label; }));

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
