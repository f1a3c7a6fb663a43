#include "vdbpack/run/structure_sample.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/run.h"
#include "vdbpack/voids/trabecular_presets.h"

#include <fmt/format.h>

#include <optional>
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

Morphometry measuredSample(const VoidRecipe& r, const Callbacks& callbacks) {
    MeasureRecipe recipe;
    recipe.pack = r.like;
    recipe.domain.threshold = r.likeThreshold;
    recipe.domain.source = r.likeDomain;
    const std::string extension = extensionOf(r.like);
    if (extension == ".vdb") {
        try {
            recipe.solid = levelSetGrid(r.like, "solid", 1);
        } catch (const InputError&) {  // no grid of that name
            recipe.solid = levelSetGrid(r.like, "", 1);
        }
        if (r.likeDomain.empty()) recipe.domain.source = boxText(solidBounds(*recipe.solid));
    } else if (!namesImage(r.like) && r.likeDomain.empty()) {
        DomainRecipe mesh;
        mesh.source = r.like;
        recipe.domain.source = boxText(DomainSource(mesh, callbacks).fileBounds());
    }
    const MeasureResult result = runMeasure(recipe, callbacks);
    if (!result.morphometry)
        throw InputError(r.like +
                         ": is a pack; `like` needs a solid: an image, a level set, or a "
                         "mesh");
    const Morphometry& m = *result.morphometry;
    if (!m.thickness || !m.separation || !m.anisotropy)
        throw InputError(
            fmt::format("{}: BV/TV is {:g}, so that there is no structure to be like; check what "
                        "is solid in it "
                        "(`likeThreshold`) and its total volume (`likeDomain`)",
                        r.like, m.solidFraction));
    return m;
}

}  // namespace

VoidRecipe withSample(VoidRecipe r, const Callbacks& callbacks) {
    r = withPreset(std::move(r));
    if (r.like.empty()) return r;
    const Morphometry m = measuredSample(r, callbacks);
    const auto fill = [](std::optional<double>& target, double value) {
        if (!target) target = value;
    };
    fill(r.targetBvtv, m.solidFraction);
    fill(r.targetTbth, m.thickness->mean);
    fill(r.targetTbsp, m.separation->mean);
    fill(r.targetDa, m.anisotropy->degree);
    if (m.connectivityDensity > 0) {
        fill(r.targetConnd, m.connectivityDensity);
    } else {
        callbacks.warn(fmt::format("{}: Conn.D is {:.3g} /mm³, so that it is no target", r.like,
                                   m.connectivityDensity));
    }
    fill(r.thicknessScatter, m.thickness->sd / m.thickness->mean);
    fill(r.separationScatter, m.separation->sd / m.separation->mean);
    r.thicknessQuantiles = m.thickness->quantiles;
    r.separationQuantiles = m.separation->quantiles;
    const OrientationRecipe& o = r.orientation;
    if (o.axis.empty() && o.field.empty() && o.angles.empty()) {
        const Vec<3>& axis = m.anisotropy->axes[0];
        r.orientation.axis = fmt::format("{:.6g},{:.6g},{:.6g}", axis[0], axis[1], axis[2]);
    }
    r.like.clear();
    r.likeDomain.clear();
    r.likeThreshold.reset();
    return r;
}

}  // namespace vdbpack
