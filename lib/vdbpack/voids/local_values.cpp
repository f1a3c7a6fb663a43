#include "vdbpack/voids/local_values.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/image/ball_means.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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

void checkFactorField(const std::string& file) {
    if (file.empty()) return;
    if (!namesScalarField(file) && !namesImage(file))
        throw ParameterError("`sizeField`: " + file +
                             " is no field by its name; give a .vdb, a .csv or an image (.nii, "
                             ".nii.gz, .nrrd, .mha or a folder of DICOM)");
    requireThere(file);
}

std::shared_ptr<const ScalarField> readFactors(const std::string& file,
                                               const DomainRecipe& domain) {
    if (file.empty()) return nullptr;
    std::shared_ptr<const ScalarField> field;
    if (namesScalarField(file))
        field = readScalarField(file, meaningOf());
    else
        field = std::make_shared<ImageNumbers>(readGreyImage(file, domain, {}), file);
    if (field->most() > kMostFactors * field->least())
        throw InputError(fmt::format(
            "`sizeField` {}: its factors on radii span {:g} to {:g}, a ratio of {:.3g}; the limit "
            "is {:g}: raise the smallest or lower the largest",
            file, field->least(), field->most(), field->most() / field->least(), kMostFactors));
    return field;
}

template <int Dim>
std::shared_ptr<const SizeField> factorsOver(const std::shared_ptr<const ScalarField>& factors,
                                             const std::string& file, const Box<Dim>& bounds,
                                             double sliceHeight) {
    const auto at =
        valuesOver<Dim>(factors, "`sizeField` " + file, meaningOf(), bounds, sliceHeight);
    Box<3> box{{{0, 0, sliceHeight}}, {{0, 0, sliceHeight}}};
    for (int d = 0; d < Dim; ++d) {
        box.lo[d] = bounds.lo[d];
        box.hi[d] = bounds.hi[d];
    }
    const auto [node, step] = factors->lattice();
    // A lookup in a table takes a hundred times as long as one in a grid.
    const bool table = namesScalarField(file) && extensionOf(file) != ".vdb";
    const double mostNodes = table ? 2e6 : 3.2e7;
    return std::make_shared<const SizeField>(
        box, node, step,
        [&](const Vec<3>& x) {
            Vec<Dim> here;
            for (int d = 0; d < Dim; ++d) here[d] = x[d];
            return at(here);
        },
        mostNodes);
}

template std::shared_ptr<const SizeField> factorsOver(const std::shared_ptr<const ScalarField>&,
                                                      const std::string&, const Box<2>&, double);
template std::shared_ptr<const SizeField> factorsOver(const std::shared_ptr<const ScalarField>&,
                                                      const std::string&, const Box<3>&, double);

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
    Image grey = readGreyImage(field->file, domain, callbacks);
    if (const std::size_t filled = fillFromNearest(grey); filled > 0)
        callbacks.warn(
            fmt::format("`bvtvField` {}: {} of {} voxels are not numbers (nan); they "
                        "have the value of the nearest number",
                        field->file, filled, grey.values()));
    const auto image = std::make_shared<const ImageSampler>(std::move(grey));
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

}  // namespace vdbpack
