#include "vdbpack/run/image_domain.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/image/ball_means.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/voids/scalar_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

namespace vdbpack {

void warnOfBorder(const LabelPart& part, const ImageGrid& grid, const std::string& path,
                  const Callbacks& callbacks) {
    Box<3> box;
    for (const LabelCount& label : part.labels) {
        box.add(label.voxelBox.lo);
        box.add(label.voxelBox.hi);
    }
    for (int d = 0; d < 3; ++d)
        if (box.lo[d] < 0.5 ||
            box.hi[d] > static_cast<double>(grid.size[static_cast<std::size_t>(d)]) - 1.5) {
            callbacks.warn(
                fmt::format("{}: label {} reaches the border of the image, where a flat "
                            "wall closes it",
                            path, part.name));
            return;
        }
}

namespace {

/// The part that a recipe names, of an image without threshold.
LabelPart selectedPart(const DomainRecipe& recipe,
                       const std::optional<std::vector<LabelCount>>& labels) {
    const std::string& path = recipe.source;
    if (!labels)
        throw ParameterError(path +
                             ": is no label map, but has many different values; set "
                             "`threshold` to the lowest value of bone");
    const std::string text = recipe.label.empty() && labels->size() <= 1 ? "all" : recipe.label;
    if (!text.empty()) {
        const auto parts = parseLabels(text, *labels, path);
        if (parts.size() == 1) return parts.front();
        throw ParameterError(
            fmt::format("`label` {}: names {} parts, where a single domain is "
                        "needed; name one label, or join them by +",
                        text, parts.size()));
    }
    std::string list;
    for (const LabelCount& label : *labels)
        list += fmt::format("\n  {}{}{}", label.value, label.name.empty() ? "" : " ", label.name);
    throw ParameterError(
        fmt::format("{}: has {} labels; set `label` to the one to fill, or several joined by +:{}",
                    path, labels->size(), list));
}

}  // namespace

Image readDomainImage(const DomainRecipe& recipe, const Callbacks& callbacks) {
    ImageReadOptions options;
    options.callbacks = callbacks;
    if (!recipe.voxelSpacing.empty()) options.spacing = parseVoxelSpacing(recipe.voxelSpacing);
    Image image = recipe.image ? copyOf(*recipe.image) : readImage(recipe.source, options);
    const double scale = recipe.scale * millimetersPer(recipe.unit);
    image.grid.origin *= scale;
    for (Vec<3>& step : image.grid.step) step *= scale;
    if (recipe.space == ImageSpace::ras)
        for (int d = 0; d < 2; ++d) {
            image.grid.origin[d] *= -1;
            for (Vec<3>& step : image.grid.step) step[d] *= -1;
        }
    return image;
}

namespace {

void requireThere(const std::string& file) {
    std::error_code ignored;
    if (file.find('*') == std::string::npos && !std::filesystem::exists(file, ignored))
        throw IoError(file + ": there is no such file");
}

}  // namespace

void requireGreyImage(const std::string& setting, const std::string& file) {
    if (!namesImage(file))
        throw ParameterError(fmt::format(
            "{}: {} is no image by its name; give .nii, .nii.gz, .nrrd, .mha or a folder of DICOM",
            setting, file));
    requireThere(file);
}

void requireVoidFields(const VoidRecipe& voids) {
    if (!voids.shellField.empty()) {
        if (!namesScalarField(voids.shellField))
            throw ParameterError("`shellField`: " + voids.shellField +
                                 " is no field by its name; give a .vdb or a .csv");
        requireThere(voids.shellField);
    }
    const BvtvField* const field = bvtvFieldOf(voids);
    if (!field) return;
    if (!namesScalarField(field->file) && !namesImage(field->file))
        throw ParameterError("`bvtvField`: " + field->file +
                             " is no field by its name; give an image (.nii, .nii.gz, .nrrd, .mha "
                             "or a folder of DICOM), a .vdb or a .csv");
    requireThere(field->file);
}

Image readGreyImage(const std::string& file, const DomainRecipe& domain,
                    const Callbacks& callbacks) {
    DomainRecipe recipe;
    recipe.source = file;
    recipe.space = domain.space;
    recipe.voxelSpacing = domain.voxelSpacing;
    if (isImage(domain)) {  // of the same scan
        recipe.unit = domain.unit;
        recipe.scale = domain.scale;
    }
    Image image = readDomainImage(recipe, callbacks);
    if (image.layers != 1)
        throw InputError(file + ": has several values at each voxel; give one layer");
    return image;
}

namespace {

/// Beyond its image, a field has the values at the border.
template <int Dim>
void requireCovered(const ImageGrid& grid, const Box<Dim>& domain, double sliceHeight,
                    const std::string& file, const Callbacks& callbacks) {
    Box<3> box{{{0, 0, sliceHeight}}, {{0, 0, sliceHeight}}};
    for (int d = 0; d < Dim; ++d) {
        box.lo[d] = domain.lo[d];
        box.hi[d] = domain.hi[d];
    }
    const Box<3> covered = grid.bounds(), both = intersection(box, covered);
    if (both.empty())
        throw InputError(fmt::format(
            "`bvtvField` {}: lies elsewhere than the domain; check `space` and the unit of the "
            "domain",
            file));
    for (int d = 0; d < 3; ++d)
        if (both.lo[d] > box.lo[d] || both.hi[d] < box.hi[d]) {
            callbacks.warn("`bvtvField` " + file +
                           ": the domain reaches beyond this image, where BV/TV is that at its "
                           "border");
            return;
        }
}

/// BV/TV itself, or numbers mapped to it.
template <int Dim>
std::function<double(const Vec<Dim>&)> bvtvTable(const BvtvField& field, const Box<Dim>& bounds,
                                                 double sliceHeight) {
    ScalarMeaning meaning{"BV/TV", {"value", "bvtv"}, {}};
    if (!field.range)
        meaning.fault = [](double v) {
            if (v >= 0 && v <= 1) return std::string();
            return fmt::format(
                "BV/TV {:g} must lie between 0 and 1; of other values, such as grey values, "
                "`bvtvRange` says which are 0 and 1",
                v);
        };
    auto at = valuesOver<Dim>(readScalarField(field.file, meaning), field.file, meaning, bounds,
                              sliceHeight);
    if (!field.range) return at;
    const auto [marrow, bone] = *field.range;
    return [at = std::move(at), low = marrow, range = bone - marrow](const Vec<Dim>& x) {
        return std::clamp((at(x) - low) / range, 0.0, 1.0);
    };
}

}  // namespace

template <int Dim>
std::function<double(const Vec<Dim>&)> bvtvField(const VoidRecipe& voids,
                                                 const DomainRecipe& domain, const Box<Dim>& bounds,
                                                 double sliceHeight, const Callbacks& callbacks) {
    const BvtvField* const field = bvtvFieldOf(voids);
    if (!field) return {};
    if (namesScalarField(field->file)) return bvtvTable(*field, bounds, sliceHeight);
    const auto [marrow, bone] = *field->range;
    const auto image =
        std::make_shared<const ImageSampler>(readGreyImage(field->file, domain, callbacks));
    requireCovered(image->image().grid, bounds, sliceHeight, field->file, callbacks);
    return [image, sliceHeight, low = marrow, range = bone - marrow](const Vec<Dim>& x) {
        Vec<3> at{{0, 0, sliceHeight}};
        for (int d = 0; d < Dim; ++d) at[d] = x[d];
        return std::clamp((image->at(at) - low) / range, 0.0, 1.0);
    };
}

template std::function<double(const Vec<2>&)> bvtvField(const VoidRecipe&, const DomainRecipe&,
                                                        const Box<2>&, double, const Callbacks&);
template std::function<double(const Vec<3>&)> bvtvField(const VoidRecipe&, const DomainRecipe&,
                                                        const Box<3>&, double, const Callbacks&);

TriangleMesh imageMesh(const DomainRecipe& recipe, const Callbacks& callbacks,
                       std::optional<ImageGrid>& grid, bool& spaced) {
    const Image image = readDomainImage(recipe, callbacks);
    grid = image.grid;
    spaced = image.isSpaced;
    callbacks.stopIfCancelled();
    if (recipe.threshold) {
        if (!recipe.label.empty())
            throw ParameterError("`label` and `threshold`: a domain has one of them");
        if (const auto labels = labelsOf(image); labels && labels->size() > 1)
            callbacks.warn(fmt::format(
                "{}: seems to be a label map of {} labels, between whose values `threshold` has no "
                "meaning; set `label`",
                recipe.source, labels->size()));
        return thresholdSurface(image, *recipe.threshold, recipe.source);
    }
    const auto labels = labelsOf(image);
    const LabelPart part = selectedPart(recipe, labels);
    warnOfBorder(part, image.grid, recipe.source, callbacks);
    return std::move(labelSurfaces(image, *labels, {part}).front());
}

}  // namespace vdbpack
