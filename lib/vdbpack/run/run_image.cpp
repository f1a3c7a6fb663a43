#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/report/image_result.h"
#include "vdbpack/run/run.h"

#include <tuple>

namespace vdbpack {

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
        result.layers = image.layers;
        std::tie(result.lowest, result.highest) = valueRange(image);
        callbacks.stopIfCancelled();
        result.labels = labelsOf(image);
        if (result.labels) result.relations = labelRelations(image, *result.labels);
    });
    return result;
}

}  // namespace vdbpack
