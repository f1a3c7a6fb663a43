#include "cli/required_result.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/command_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>
#include <variant>

using namespace vdbpack;

namespace {

/// A file that the run could write: NAME of its input, and what it does.
std::string offeredFile(const std::string& input, const std::string& suffix, bool circles) {
    const std::string name = input.substr(input.find_last_of('/') + 1);
    const auto end = name.find_first_of(".:");
    return (end == 0 || end == std::string::npos ? std::string("pack") : name.substr(0, end)) +
           suffix + (circles ? ".csv" : ".vdb");
}

/// What tells the files of the runs of a study apart.
std::string seedPart(const Study& study) {
    return study.seeds.size() > 1 ? "_{seed}" : "";
}

/// The same for a recipe; empty for commands that print their result.
template <class Recipe>
std::string offeredFile(const Recipe& recipe) {
    const std::string& domain = recipe.domain.source;
    const bool plane =
        recipe.domain.slice || startsWith(domain, "rect:") || startsWith(domain, "disc:") ||
        (startsWith(domain, "periodic:") && std::count(domain.begin(), domain.end(), ',') == 1);
    if constexpr (std::is_same_v<Recipe, PackJob>)
        return offeredFile(
            domain, (extensionOf(domain) == ".vdb" ? "_pack" : "") + seedPart(recipe.study), plane);
    else if constexpr (std::is_same_v<Recipe, VoidsJob>)
        return (plane ? "list:" : "") +
               offeredFile(domain, "_voids" + seedPart(recipe.study), plane);
    else if constexpr (std::is_same_v<Recipe, CarveJob>)
        return offeredFile(recipe.pack, "_carved", plane);
    else if constexpr (std::is_same_v<Recipe, DensifyRecipe>)
        return offeredFile(recipe.pack, "_denser", plane);
    else
        return {};
}

template <class Recipe>
void requireResult(const Recipe& recipe, const PrintOptions& print) {
    const std::string file = offeredFile(recipe);
    if (file.empty() || !recipe.outputs.empty() || !recipe.reportFile.empty() ||
        !recipe.preview.file.empty() || print.json)
        return;
    if constexpr (std::is_same_v<Recipe, PackJob>)
        if (recipe.dryRun) return;
    if constexpr (std::is_same_v<Recipe, PackJob> || std::is_same_v<Recipe, VoidsJob>)
        if (!recipe.study.table.empty()) return;
    throw ParameterError(fmt::format(
        "nothing would be written. Name a file: vdb_pack {} -o {}{}; or ask for a picture "
        "(--preview FILE.png), a report (--report FILE.html) or its numbers (--json)",
        recipe.command, shellQuoted(file),
        std::is_same_v<Recipe, PackJob> ? "; or see what to expect (--dry-run)" : ""));
}

}  // namespace

void requireResult(const CliOptions& options) {
    std::visit([&](const auto& job) { requireResult(job, options.print); }, options.job);
}
