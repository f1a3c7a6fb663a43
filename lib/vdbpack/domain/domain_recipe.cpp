#include "vdbpack/domain/domain_recipe.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/image/value_histogram.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <cmath>

namespace vdbpack {

Threshold Threshold::otsu(double from) {
    Threshold threshold;
    threshold.otsuFrom = from;
    return threshold;
}

Threshold Threshold::parse(const std::string& text) {
    double number = 0;
    if (text == "otsu") return otsu();
    if (startsWith(text, "otsu:") && parseReal(text.substr(5), number) && std::isfinite(number))
        return otsu(number);
    throw ParameterError(fmt::format(
        "`threshold` {}: write a number, otsu, or otsu:LEAST with a number, such as otsu:-200",
        text));
}

std::string Threshold::text() const {
    if (!otsuFrom) return fmt::format("{:.10g}", *value);
    return std::isfinite(*otsuFrom) ? fmt::format("otsu:{:.10g}", *otsuFrom) : "otsu";
}

Threshold Threshold::of(const Image& image, const std::string& path,
                        const Callbacks& callbacks) const {
    if (value) return *this;
    const ValueHistogram histogram = histogramOf(image, *otsuFrom);
    if (histogram.counts.empty())
        throw InputError(fmt::format("{}: `threshold` {}: has no two different values{}", path,
                                     text(), std::isfinite(*otsuFrom) ? " from there on" : ""));
    Threshold found = *this;
    found.value = otsuThreshold(histogram);
    if (*found.value < kTissueHu / 2 && histogram.first < kAirHu)
        callbacks.warn(fmt::format(
            "{}: `threshold` {} is {:g}, where {:.3g} % of its values lie above: in HU it "
            "separates "
            "air from the body. otsu:{:g} leaves out air",
            path, text(), *found.value, 100 * histogram.shareFrom(*found.value), kTissueHu));
    return found;
}

bool isImage(const DomainRecipe& recipe) {
    return recipe.image || (!isInMemory(recipe) && namesImage(recipe.source));
}

std::string describe(const DomainRecipe& recipe) {
    return recipe.source + (recipe.label.empty() ? "" : ", label " + recipe.label) +
           (recipe.mask.empty() ? "" : ", mask " + recipe.mask);
}

}  // namespace vdbpack
