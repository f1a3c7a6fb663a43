#include "vdbpack/domain/domain_recipe.h"

#include "vdbpack/image/image_file.h"

namespace vdbpack {

bool isImage(const DomainRecipe& recipe) {
    return recipe.image || (!isInMemory(recipe) && namesImage(recipe.source));
}

std::string describe(const DomainRecipe& recipe) {
    return recipe.source + (recipe.label.empty() ? "" : ", label " + recipe.label);
}

}  // namespace vdbpack
