#include "vdbpack/voids/shell_field.h"

#include "vdbpack/voids/field_points.h"
#include "vdbpack/voids/scalar_field.h"

#include <fmt/format.h>

#include <memory>

namespace vdbpack {

namespace {

std::shared_ptr<const ScalarField> readShell(const VoidRecipe& recipe) {
    const ScalarMeaning meaning{
        "thickness", {"value", "thickness", "shell"}, [](double v) {
            return v >= 0 ? std::string()
                          : fmt::format("the thickness {:g} mm must not be negative", v);
        }};
    return readScalarField(recipe.shellField, meaning);
}

}  // namespace

std::pair<double, double> shellRange(const VoidRecipe& recipe) {
    if (recipe.shellField.empty()) return {recipe.shell, recipe.shell};
    const auto field = readShell(recipe);
    return {field->least(), field->most()};
}

template <int Dim>
ShellThickness shellOver(const VoidRecipe& recipe, const Box<Dim>& bounds, double sliceHeight) {
    if (recipe.shellField.empty()) return recipe.shell;
    const auto field = readShell(recipe);
    requireCovered("`shellField` " + recipe.shellField + ": the field of thickness",
                   field->bounds(), bounds, sliceHeight);
    return {[field](const Vec<3>& x) { return field->at(x); }, field->least(), field->most(),
            sliceHeight};
}

template ShellThickness shellOver(const VoidRecipe&, const Box<2>&, double);
template ShellThickness shellOver(const VoidRecipe&, const Box<3>&, double);

}  // namespace vdbpack
