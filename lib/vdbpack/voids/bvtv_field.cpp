#include "vdbpack/voids/bvtv_field.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/image/ball_means.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/voids/scalar_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace vdbpack {

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

}  // namespace vdbpack
