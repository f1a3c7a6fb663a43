// Private to voids: a foam with the thickness, spacing, anisotropy and connectivity asked for.
#pragma once

#include "vdbpack/voids/void_families.h"
#include "vdbpack/voids/void_recipe.h"
#include "vdbpack/voids/void_report.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

struct Morphometry;

/// A foam found for the targets of a recipe.
struct StructureFit {
    /// As requested, with the parameters of the foam in place of the targets, apart from BV/TV.
    VoidRecipe recipe;
    std::vector<TargetReport> targets;
    /// Kolmogorov-Smirnov distances of local thickness and spacing to those of the sample; absent:
    /// there is none.
    std::optional<double> thicknessDistance, separationDistance;
    double specimen = 0;  ///< side of the cube, or shortest of the box, that was measured, mm
};

/// Finds radii and their spread, aspect, jitter, blend and struts of a foam, and its BV/TV if no
/// target says it, by Gauss-Newton steps on measured specimens, with a Jacobian from differences
/// that each further specimen corrects (Broyden (1965), doi:10.1090/S0025-5718-1965-0198670-6):
/// first on a small, coarse one, then on one of eight trabecular periods (Tb.Th + Tb.Sp), or on the
/// domain itself if this is a box of at least three and a half. There too most steps are taken on
/// specimens of few voxels, whose errors the few measurements of the specimen itself correct. All
/// of one size are cut from one pack, so that small changes of the parameters change little else.
/// What the targets leave open stays near values that look like bone, in one piece, and near the
/// distributions of a sample.
///
/// @param packs  receives the packs that were made, for the voids themselves.
/// @throws ParameterError if a target is not reachable, with the range that is; Interrupted,
/// ResourceError
StructureFit fitStructure(const VoidSetting<3>& setting, FoamPacks<3>& packs);

/// Sets the targets of a foam to the structure of a specimen, where it has no targets of its own:
/// BV/TV, Tb.Th, Tb.Sp, DA, Conn.D, the distributions of thickness and spacing, and the main
/// direction.
/// @param name  of the specimen, for messages. @throws InputError for one without solid or pores
void aimAt(const Morphometry& specimen, const std::string& name, FoamVoids& foam,
           const Callbacks& callbacks);

/// The recipe with a foam that usual bone with about those targets has, in place of the targets
/// but BV/TV; unchanged without such targets. For predictions.
VoidRecipe usualFoam(const VoidRecipe& recipe);

/// Voxels of the largest specimen that such a fit is expected to measure; 0 without such targets.
/// @param box  volume of the domain if this is a box, mm³; 0: it is none.
double specimenVoxels(const VoidRecipe& recipe, double box);

}  // namespace vdbpack
