// Private to runs: one pack, cut and measured.
#pragma once

#include "vdbpack/run/stages.h"

#include <cstdint>
#include <memory>

namespace vdbpack {

/// The part that the packs of all seeds of a recipe share.
template <int Dim>
struct Prepared {
    RequestedSizes requested;
    FieldRadii radii;
    DomainSource::Built built{};
    Pack<Dim> existing{};
    std::uint64_t inputOverlaps = 0, inputProtrusions = 0;
    RunVoids<Dim> voids{};
    LocalSizes local{};  ///< what differs by place in the sizes
};

/// A pack, cut and measured: the stages of `pack` after those that the seeds share.
/// @param begun  the report and the warnings so far. @throws as `runPack`
template <int Dim>
std::unique_ptr<Run<Dim>> packMeasured(const PackRecipe& recipe,
                                       const std::shared_ptr<const DomainSource>& source,
                                       const Prepared<Dim>& prepared, const Report& begun,
                                       const Clock& clock, const Callbacks& callbacks);

}  // namespace vdbpack
