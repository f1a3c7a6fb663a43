// Warnings of domains that are unlikely, and of settings that have no effect on them.
#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/coordinate_step.h"

#include <fmt/format.h>

#include <cmath>

namespace vdbpack {

namespace {

/// Diagonal below which voxels in 32-bit floats have no digits left, mm.
constexpr double kSmallestExtent = 1e-3;
/// Diagonal above which absolute tolerances are no longer small against the digits, mm.
constexpr double kLargestExtent = 1e7;
/// Steps between coordinates larger than this share of an edge are steps in the surface; those of a
/// mesh about the origin (within so many of its lengths) are how it was made.
constexpr double kStepOfEdge = 0.02, kFarOff = 20;

}  // namespace

void warnOfLostDigits(const TriangleMesh& mesh, const DomainRecipe& recipe,
                      const Callbacks& callbacks) {
    const Box<3> box = mesh.bounds();
    const double extent = length(box.size()), away = length(box.center());
    if (!(away > kFarOff * extent)) return;
    const double step = coordinateStep(mesh, recipe.scale * millimetersPer(recipe.unit));
    const double edge = medianEdge(mesh);
    if (!(step > kStepOfEdge * edge)) return;
    callbacks.warn(fmt::format(
        "{}: lies {:.3g} mm from the origin, and its coordinates come in steps of {:.2g} mm, with "
        "edges of {:.2g} mm: the file itself has lost digits of the shape; move the mesh to the "
        "origin where it was made, and export it again",
        recipe.source, away, step, edge));
}

void checkSize(const Box<3>& bounds, const DomainRecipe& recipe, const Callbacks& callbacks) {
    const double extent = length(bounds.size());
    if (!(extent > kSmallestExtent && extent < kLargestExtent))
        throw InputError(fmt::format(
            "{}: is {:.3g} mm across, too {} to compute with ({:g} to {:g} mm); the file is read "
            "in {}: check `unit` and `scale`",
            recipe.source, extent, extent < 1 ? "small" : "large", kSmallestExtent, kLargestExtent,
            unitName(recipe.unit)));
    if (recipe.voxelSpacing) return;  // given on purpose, as for micro-CT
    // A long bone of a large animal is a meter long; who sets m or cm has no sample of a few mm.
    const bool large = recipe.unit == Unit::meter || recipe.unit == Unit::centimeter;
    if (extent < (large ? 5 : 2) || extent > 1200)
        callbacks.warn(fmt::format(
            "{}: is {:.3g} mm across, which is unlikely for a bone; the file is read in {}: give "
            "`unit` m, cm, mm or um if that is wrong",
            recipe.source, extent, unitName(recipe.unit)));
}

void warnOfUnused(const DomainRecipe& recipe, const DomainSource& source,
                  const Callbacks& callbacks) {
    const std::string& text = recipe.source;
    const bool levelSet = extensionOf(text) == ".vdb" || recipe.levelSet;
    if (!recipe.gridName.empty() && !levelSet)
        callbacks.warn("`gridName` " + recipe.gridName + " has no effect: " + text + " is no .vdb");
    const bool image = source.isFile() && isImage(recipe);
    if (recipe.threshold && !levelSet && !image)
        callbacks.warn(fmt::format("`threshold` {} has no effect: {} is no .vdb and no image",
                                   recipe.threshold->text(), text));
    for (const auto& [name, value] : {std::pair("label", recipe.label), {"mask", recipe.mask}})
        if (!image && !value.empty())
            callbacks.warn(fmt::format("`{}` {} has no effect: {} is no image", name, value, text));
    if (!recipe.repair &&
        (recipe.repairVoxel > 0 || recipe.repairComponents != DomainRecipe().repairComponents))
        callbacks.warn("`repairVoxel` and `repairComponents` have no effect without `repair`");
    if ((levelSet || image) && (recipe.repair || recipe.cavities.any()))
        callbacks.warn("`repair` and `cavities` have no effect: " + text +
                       (image ? " is an image" : " is a level set"));
    if (recipe.shellFrom == ShellFrom::outer && source.isWhole() && !source.hasCavities())
        callbacks.warn("`shellFrom` outer changes nothing: " + text +
                       " has neither cavities nor clips");
    if (source.isFile()) return;
    if (recipe.repair || recipe.cavities.any())
        callbacks.warn("`repair` and `cavities` have no effect: " + text + " is a shape");
    if (recipe.unit != Unit::millimeter)
        callbacks.warn("`unit` has no effect: " + text + " is a shape, in mm");
    if (recipe.voxelSize > 0)
        callbacks.warn(
            fmt::format("`voxelSize` {:g} has no effect: {} is a shape, whose distances are exact",
                        recipe.voxelSize, text));
    if (recipe.scale != 1) callbacks.warn("`scale` has no effect: " + text + " is a shape, in mm");
}

void warnOfSpacing(const DomainRecipe& recipe, bool isImage, const Callbacks& callbacks) {
    if (!recipe.voxelSpacing) return;
    callbacks.warn("`voxelSpacing` " + textOf(*recipe.voxelSpacing) +
                   " has no effect: " + recipe.source +
                   (isImage ? " states the distances of its voxels" : " is no image") +
                   ", and no label map is written. `scale` makes a domain larger or smaller");
}

template <int Dim>
void warnOfOtherCell(const std::string& pack, const PeriodicCell<Dim>& stated,
                     const DomainRecipe& recipe, const Domain<Dim>& domain,
                     const Callbacks& callbacks) {
    constexpr double kSame = 1e-6;  // of its length: files round
    const PeriodicCell<Dim> cell = domain.cell();
    if (!stated.any()) return;
    if (!cell.any()) {
        callbacks.warn(fmt::format(
            "{}: states a periodic cell, but `domain` {} has walls, which count; leave `domain` "
            "out for the cell of the file",
            pack, recipe.source));
        return;
    }
    bool same = true;
    for (int d = 0; d < Dim; ++d)
        same = same && stated.isAlong(d) == cell.isAlong(d) &&
               (!cell.isAlong(d) ||
                std::fabs(stated.length(d) - cell.length(d)) <= kSame * cell.length(d));
    if (!same)
        callbacks.warn(fmt::format(
            "{}: states another periodic cell than `domain` {}, which counts; leave `domain` out "
            "for the cell of the file",
            pack, recipe.source));
}

template void warnOfOtherCell(const std::string&, const PeriodicCell<2>&, const DomainRecipe&,
                              const Domain<2>&, const Callbacks&);
template void warnOfOtherCell(const std::string&, const PeriodicCell<3>&, const DomainRecipe&,
                              const Domain<3>&, const Callbacks&);

}  // namespace vdbpack
