#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/run/run.h"

#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

/// The least and the largest value.
std::pair<double, double> rangeOf(const Image& image) {
    using Range = std::pair<double, double>;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const Range numbers = image.visit([&](const auto* at) {
        return tbb::parallel_reduce(
            IndexRange(0, image.values(), 65536), Range{kInfinity, -kInfinity},
            [&](const IndexRange& block, Range range) {
                for (std::size_t i = block.begin(); i < block.end(); ++i) {
                    const auto value = static_cast<double>(at[i]);
                    range.first = std::min(range.first, value);
                    range.second = std::max(range.second, value);
                }
                return range;
            },
            [](const Range& a, const Range& b) {
                return Range{std::min(a.first, b.first), std::max(a.second, b.second)};
            });
    });
    const double a = image.slope * numbers.first + image.intercept;
    const double b = image.slope * numbers.second + image.intercept;
    return std::minmax(a, b);
}

}  // namespace

ImageResult runImage(const ImageRecipe& recipe, const Callbacks& caller) {
    const DomainRecipe& domain = recipe.domain;
    if (!isImage(domain))
        throw ParameterError(domain.source +
                             ": is no image by its name; images are .nii, .nii.gz, "
                             ".nrrd, .nhdr, .mha, .mhd, .dcm, .tif, and folders");
    ImageResult result;
    const Callbacks callbacks =
        keepingWarnings(withinMemory(caller, recipe.memoryLimit), result.warnings);
    withThreads(recipe.threads, [&] {
        const Image image = readDomainImage(domain, callbacks);
        result.source = domain.source;
        result.space = domain.space;
        result.format = image.format;
        result.type = nameOf(image.type);
        result.grid = image.grid;
        result.layers = image.layers;
        std::tie(result.lowest, result.highest) = rangeOf(image);
        callbacks.stopIfCancelled();
        result.labels = labelsOf(image);
        if (result.labels) result.relations = labelRelations(image, *result.labels);
    });
    return result;
}

}  // namespace vdbpack
