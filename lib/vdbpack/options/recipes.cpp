#include "vdbpack/options/recipes.h"

namespace vdbpack {

std::string withSeed(std::string name, std::uint64_t seed) {
    const std::string mark = "{seed}";
    for (std::size_t at = name.find(mark); at != std::string::npos; at = name.find(mark, at))
        name.replace(at, mark.size(), std::to_string(seed));
    return name;
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
