#include "vdbpack/run/structure_sample.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/run.h"
#include "vdbpack/voids/structure_fit.h"

#include <fmt/format.h>

#include <string>

namespace vdbpack {

namespace {

std::string boxText(const Box<3>& box) {
    return fmt::format("box:{},{},{},{},{},{}", box.lo[0], box.lo[1], box.lo[2], box.hi[0],
                       box.hi[1], box.hi[2]);
}

/// The box around the solid of a level set: its voxels inside.
Box<3> solidBounds(const VdbGrid& grid) {
    const VoxelImage image = sampleLevelSet(grid);
    const Vec<3> one{{1, 1, 1}};
    Vec<3> size;
    for (int d = 0; d < 3; ++d)
        size[d] = static_cast<double>(image.size[static_cast<std::size_t>(d)] - 2);
    const Vec<3> low = image.origin + one * (0.5 * image.voxelSize);
    return {low, low + size * image.voxelSize};
}

Morphometry measuredSample(const SpecimenRecipe& r, const std::optional<Vec<3>>& spacing,
                           const Callbacks& callbacks) {
    MeasureRecipe recipe;
    recipe.pack = r.file;
    recipe.domain.threshold = r.threshold;
    recipe.domain.source = r.domain;
    const std::string extension = extensionOf(r.file);
    if (namesImage(r.file)) {
        ImageReadOptions options;
        options.spacing = spacing;
        options.callbacks = callbacks;
        const auto image = std::make_shared<const Image>(readImage(r.file, options));
        recipe.solidImage = image;
        if (!image->isSpaced) recipe.domain.voxelSpacing = spacing;  // of its domain as well
    } else if (extension == ".vdb") {
        try {
            recipe.solid = levelSetGrid(r.file, "solid", 1);
        } catch (const InputError&) {  // no grid of that name
            recipe.solid = levelSetGrid(r.file, "", 1);
        }
        if (r.domain.empty()) recipe.domain.source = boxText(solidBounds(*recipe.solid));
    } else if (r.domain.empty()) {
        DomainRecipe mesh;
        mesh.source = r.file;
        recipe.domain.source = boxText(DomainSource(mesh, callbacks).fileBounds());
    }
    const MeasureResult result = runMeasure(recipe, callbacks);
    if (!result.morphometry)
        throw InputError(r.file +
                         ": is a pack; `like` needs a solid: an image, a level set, or a "
                         "mesh");
    return *result.morphometry;
}

}  // namespace

VoidRecipe withSample(VoidRecipe recipe, const DomainRecipe& domain, const Callbacks& callbacks) {
    auto* const foam = recipe.as<FoamVoids>();
    if (!foam || foam->like.file.empty()) return recipe;
    aimAt(measuredSample(foam->like, domain.voxelSpacing, callbacks), foam->like.file, *foam,
          callbacks);
    foam->like = {};
    return recipe;
}

}  // namespace vdbpack
