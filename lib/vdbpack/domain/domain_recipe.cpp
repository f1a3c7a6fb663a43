#include "vdbpack/domain/domain_recipe.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/image_file.h"

namespace vdbpack {

bool isImage(const DomainRecipe& recipe) {
    return recipe.image || (!isInMemory(recipe) && namesImage(recipe.source));
}

std::string describe(const DomainRecipe& recipe) {
    return recipe.source + (recipe.label.empty() ? "" : ", label " + recipe.label);
}

CavityChoice parseCavities(const std::string& text) {
    CavityChoice choice;
    if (text.empty() || text == "keep") return choice;
    if (text == "fill") {
        choice.fill = true;
        return choice;
    }
    const std::string outer = "outer=", inner = "inner=";
    std::string rest = text;
    if (rest.rfind(outer, 0) == 0) {
        const auto end = rest.find("," + inner);
        choice.outer =
            rest.substr(outer.size(), end == std::string::npos ? end : end - outer.size());
        rest = end == std::string::npos ? "" : rest.substr(end + 1);
    }
    if (rest.rfind(inner, 0) == 0) choice.inner = rest.substr(inner.size());
    if (choice.inner.empty() || (text.rfind(outer, 0) == 0 && choice.outer.empty()))
        throw ParameterError("`cavities` " + text +
                             ": write keep, fill, inner=FILE or outer=FILE,inner=FILE");
    return choice;
}

}  // namespace vdbpack
