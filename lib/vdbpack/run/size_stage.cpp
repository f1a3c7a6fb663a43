#include "vdbpack/run/size_stage.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/image/ball_means.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

namespace vdbpack {

namespace {

/// Largest ratio of the factors of a field.
constexpr double kMostFactors = 20;

std::string faultOf(double factor) {
    if (factor > 0 && std::isfinite(factor)) return {};
    return fmt::format("the factor {:g} on radii must be positive and finite, such as 0.5 to 2",
                       factor);
}

ScalarMeaning meaningOf() {
    return {"factors on radii", {"value", "factor", "size"}, faultOf};
}

/// The values of a grey image as a field.
class ImageNumbers : public ScalarField {
public:
    ImageNumbers(Image grey, const std::string& file) : sampler_(std::move(grey)) {
        const Image& image = sampler_.image();
        const std::size_t voxels = image.grid.voxels();
        bool first = true;
        image.visit([&](const auto* numbers) {
            for (std::size_t i = 0; i < voxels; ++i) {
                const double value =
                    image.slope * static_cast<double>(numbers[i]) + image.intercept;
                if (const std::string wrong = faultOf(value); !wrong.empty())
                    throw InputError(fmt::format(
                        "`sizeField` {}: voxel ({}, {}, {}): {}", file, i % image.grid.size[0],
                        i / image.grid.size[0] % image.grid.size[1],
                        i / image.grid.size[0] / image.grid.size[1], wrong));
                least_ = first ? value : std::min(least_, value);
                most_ = first ? value : std::max(most_, value);
                first = false;
            }
        });
    }
    Box<3> bounds() const override { return sampler_.image().grid.bounds(); }
    double at(const Vec<3>& x) const override { return std::clamp(sampler_.at(x), least_, most_); }
    std::pair<Vec<3>, double> lattice() const override {
        const ImageGrid& grid = sampler_.image().grid;
        const Vec<3> spacing = grid.spacing();
        return {grid.origin, *std::min_element(spacing.c.begin(), spacing.c.end())};
    }

private:
    ImageSampler sampler_;
};

}  // namespace

void checkLocalSizes(const PackRecipe& recipe) {
    if (!recipe.shellRadius.empty()) {
        if (!recipe.voids.hasShell())
            throw ParameterError(
                "`shellRadius` " + recipe.shellRadius.spec() +
                ": there is no shell; set its thickness by `shell`, such as 3, or `shellField`");
        if (recipe.voids.fill == Fill::solid)
            throw ParameterError(
                "`fill` solid and `shellRadius` cannot be combined; leave one out");
    }
    if ((!recipe.shellRadius.empty() || !recipe.sizeField.empty()) && recipe.voids.as<FrontHoles>())
        throw ParameterError(
            "`voids` " + nameOf(recipe.voids) +
            " cannot be combined with sizes by place; use voids that are cut afterwards, such as "
            "boolean");
    if (recipe.sizeField.empty()) return;
    if (!namesScalarField(recipe.sizeField) && !namesImage(recipe.sizeField))
        throw ParameterError("`sizeField`: " + recipe.sizeField +
                             " is no field by its name; give a .vdb, a .csv or an image (.nii, "
                             ".nii.gz, .nrrd, .mha or a folder of DICOM)");
    if (namesScalarField(recipe.sizeField) && !std::ifstream(recipe.sizeField))
        throw IoError("`sizeField`: " + recipe.sizeField + ": cannot be opened for reading");
}

std::shared_ptr<const ScalarField> readFactors(const PackRecipe& recipe) {
    if (recipe.sizeField.empty()) return nullptr;
    std::shared_ptr<const ScalarField> field;
    if (namesScalarField(recipe.sizeField))
        field = readScalarField(recipe.sizeField, meaningOf());
    else
        field = std::make_shared<ImageNumbers>(readGreyImage(recipe.sizeField, recipe.domain, {}),
                                               recipe.sizeField);
    if (field->most() > kMostFactors * field->least())
        throw InputError(fmt::format(
            "`sizeField` {}: its factors on radii span {:g} to {:g}, a ratio of {:.3g}; the limit "
            "is {:g}: raise the smallest or lower the largest",
            recipe.sizeField, field->least(), field->most(), field->most() / field->least(),
            kMostFactors));
    return field;
}

template <int Dim>
LocalSizes localSizes(const PackRecipe& recipe, const RequestedSizes& requested,
                      const Domain<Dim>& domain, double sliceHeight, const ShellThickness& shell) {
    LocalSizes sizes;
    sizes.shell = shell;
    sizes.shellSizes = requested.shellSizes;
    if (!requested.factor) return sizes;
    const Box<Dim> bounds = domain.bounds();
    const auto at = valuesOver<Dim>(requested.factor, "`sizeField` " + recipe.sizeField,
                                    meaningOf(), bounds, sliceHeight);
    Box<3> box{{{0, 0, sliceHeight}}, {{0, 0, sliceHeight}}};
    for (int d = 0; d < Dim; ++d) {
        box.lo[d] = bounds.lo[d];
        box.hi[d] = bounds.hi[d];
    }
    const auto [node, step] = requested.factor->lattice();
    // A lookup in a table takes a hundred times as long as one in a grid.
    const bool table =
        namesScalarField(recipe.sizeField) && extensionOf(recipe.sizeField) != ".vdb";
    const double mostNodes = table ? 2e6 : 3.2e7;
    sizes.factor = std::make_shared<SizeField>(
        box, node, step,
        [&](const Vec<3>& x) {
            Vec<Dim> here;
            for (int d = 0; d < Dim; ++d) here[d] = x[d];
            return at(here);
        },
        mostNodes);
    return sizes;
}

template LocalSizes localSizes(const PackRecipe&, const RequestedSizes&, const Domain<2>&, double,
                               const ShellThickness&);
template LocalSizes localSizes(const PackRecipe&, const RequestedSizes&, const Domain<3>&, double,
                               const ShellThickness&);

}  // namespace vdbpack
