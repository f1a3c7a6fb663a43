#include "vdbpack/options/recipes.h"

namespace vdbpack {

BondOptions bondOptionsOf(const RunSettings& settings) {
    BondOptions bonds = settings.bonds;
    bonds.tolerance = settings.contactTolerance;
    return bonds;
}

std::string withOption(std::string text, const std::string& option, const std::string& value) {
    const std::string mark = '{' + option + '}';
    for (std::size_t at = text.find(mark); at != std::string::npos;
         at = text.find(mark, at + value.size()))
        text.replace(at, mark.size(), value);
    return text;
}

std::string withSeed(const std::string& name, std::uint64_t seed) {
    return withOption(name, "seed", std::to_string(seed));
}

void setSeed(RunSettings& settings, std::uint64_t seed) {
    settings.seed = seed;
    for (auto& output : settings.outputs) output = withSeed(output.text, seed);
    settings.reportFile = withSeed(settings.reportFile, seed);
    settings.preview.file = withSeed(settings.preview.file, seed);
}

std::string recipeFileFor(const std::vector<OutputTarget>& outputs) {
    if (outputs.empty()) return {};
    std::string name = outputs.front().file;
    const auto slash = name.rfind('/');
    const auto dot = name.rfind('.');
    if (dot != std::string::npos && dot > 0 && (slash == std::string::npos || dot > slash + 1))
        name.resize(dot);
    return name + ".recipe.toml";
}

}  // namespace vdbpack
