#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/report/image_result.h"
#include "vdbpack/run/run.h"

#include <fmt/format.h>

#include <tuple>

namespace vdbpack {

namespace {

/// Adds what the requested threshold takes of an image, and of a grey one its histogram and what
/// Otsu's method finds, with and without air.
void addThresholds(const DomainRecipe& domain, const Image& image, ImageResult& result,
                   const Callbacks& callbacks) {
    constexpr std::size_t kBins = 20;
    const auto take = [&](const Threshold& threshold, const Callbacks& told) {
        const Threshold found = threshold.of(image, domain.source, told);
        result.taken.push_back({found, solidFrom(image, *found.value)});
    };
    result.isRequested = domain.threshold.has_value();
    if (domain.threshold) {
        take(*domain.threshold, callbacks);
        warnOfBorder(image, *result.taken.front().threshold.value, domain.source, callbacks);
    }
    if (result.labels) return;
    result.histogram = histogramOf(image).coarser(kBins);
    for (const Threshold& threshold : {Threshold::otsu(), Threshold::otsu(kTissueHu)}) {
        const double from = *threshold.otsuFrom;
        const bool isTaken = domain.threshold && domain.threshold->otsuFrom == from;
        const bool hasAir = result.lowest < kAirHu && result.highest > kTissueHu;
        if (!isTaken && !result.histogram.counts.empty() && (from < kAirHu || hasAir))
            take(threshold, {});
    }
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
        if (image.isSpaced) warnOfSpacing(domain, true, callbacks);
        result.source = domain.source;
        result.space = domain.space;
        result.format = image.format;
        result.type = nameOf(image.type);
        result.grid = image.grid;
        result.isSided = image.isSided;
        result.layers = image.layers;
        std::tie(result.lowest, result.highest) = valueRange(image);
        callbacks.stopIfCancelled();
        result.labels = labelsOf(image);
        if (result.labels) {
            std::vector<LabelPart> parts;
            for (const LabelCount& label : *result.labels)
                parts.push_back({fmt::format("{}", label.value), {label}});
            if (!domain.threshold) warnOfBorder(parts, image.grid, domain.source, callbacks);
            result.relations = labelRelations(image, *result.labels);
            result.solids = labelSolids(image, *result.labels);
        }
        addThresholds(domain, image, result, callbacks);
    });
    return result;
}

}  // namespace vdbpack
