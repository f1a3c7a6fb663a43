// Private to runs: packs of several parts, each in a domain of its own.
#pragma once

#include "vdbpack/core/error.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/stages.h"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

namespace vdbpack {

/// A part before it is packed.
struct Part {
    PackRecipe recipe;  ///< with its name
    std::shared_ptr<DomainSource> source;
};
using Parts = std::vector<Part>;

/// The parts of a recipe, with surfaces that later ones cut from earlier ones; none if it has one
/// domain. @throws as `runPack`
Parts partsOf(const PackRecipe& recipe, const Callbacks& callbacks);

/// Does something for one part; where parts are listed, errors name it and their file.
template <class Work>
auto inPart(const PackRecipe& all, const PackRecipe& part, const Work& work) {
    const auto named = [&](const std::string& text) {
        if (all.parts.empty() || startsWith(text, part.name + ": ")) return text;
        return fmt::format("{}part '{}': {}", all.partsFile.empty() ? "" : all.partsFile + ": ",
                           part.name, text);
    };
    try {
        return work();
    } catch (const ParameterError& error) {
        throw ParameterError(named(error.what()));
    } catch (const InputError& error) {
        throw InputError(named(error.what()));
    } catch (const IoError& error) {
        throw IoError(named(error.what()));
    }
}

/// The error of a part, with its name and, where later parts have (almost) all of its space, that.
InputError withPart(const Part& part, const InputError& error);

/// Makes the labels of a recipe with `PartsBy::center` one domain, and returns the parts that they
/// are; none for other recipes. @throws as `partsOf`; ParameterError without several labels
Parts partsByCenter(PackRecipe& recipe, const Callbacks& callbacks);
/// Gives each sphere the part that its center lies in, and reports the parts with their interfaces.
void takeCenters(const Parts& parts, Run<3>& run);

/// Packs, cuts and measures one part (run_pack.cpp). @throws as `runPack`
std::unique_ptr<Run<3>> packPart(const PackRecipe& recipe,
                                 const std::shared_ptr<const DomainSource>& source,
                                 const Report& begun, Clock clock, const Callbacks& callbacks);

/// Packs all parts, joins and writes them: what `runPack` does for them.
RunResult packParts(const PackRecipe& recipe, Parts parts, const Report& begun, Clock clock,
                    const Callbacks& callbacks);

}  // namespace vdbpack
