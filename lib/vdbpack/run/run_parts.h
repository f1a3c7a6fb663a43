// Private to runs: packs of several parts, each in a domain of its own.
#pragma once

#include "vdbpack/pack/packer.h"
#include "vdbpack/run/stages.h"

#include <memory>
#include <vector>

namespace vdbpack {

/// A part before it is packed.
struct Part {
    PackRecipe recipe;  ///< with its name
    DomainSource source;
};
using Parts = std::vector<std::unique_ptr<Part>>;

/// The parts of a recipe, with surfaces that later ones cut from earlier ones; none if it has one
/// domain. @throws as `runPack`
Parts partsOf(const PackRecipe& recipe, const Callbacks& callbacks);

/// A pack of one part, cut and measured.
struct PackedPart {
    std::unique_ptr<PackOptions> options;  ///< with the radii that were packed
    std::unique_ptr<Run<3>> run;
};

/// Packs one part (run_pack.cpp). `recipe`, `source` and `clock` must outlive the result.
/// @throws as `runPack`
PackedPart packPart(const PackRecipe& recipe, const DomainSource& source, const Report& begun,
                    Clock& clock, const Callbacks& callbacks);

/// Packs all parts, joins and writes them: what `runPack` does for them.
RunResult packParts(const PackRecipe& recipe, const Parts& parts, const Report& begun, Clock& clock,
                    const Callbacks& callbacks);

}  // namespace vdbpack
