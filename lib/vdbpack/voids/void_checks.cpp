#include "vdbpack/voids/void_checks.h"

#include "vdbpack/core/error.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/voids/scalar_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace vdbpack {

void requireVoidFields(const VoidRecipe& voids) {
    if (!voids.shellField.empty()) {
        if (!namesScalarField(voids.shellField))
            throw ParameterError("`shellField`: " + voids.shellField +
                                 " is no field by its name; give a .vdb or a .csv");
        requireThere(voids.shellField);
    }
    const BvtvField* const field = bvtvFieldOf(voids);
    if (!field) return;
    if (!namesScalarField(field->file) && !namesImage(field->file))
        throw ParameterError("`bvtvField`: " + field->file +
                             " is no field by its name; give an image (.nii, .nii.gz, .nrrd, .mha "
                             "or a folder of DICOM), a .vdb or a .csv");
    requireThere(field->file);
}

void requireShell(double shell, const DomainSource& source, bool closer) {
    constexpr double kCoarse = 1.1;                // the field below is coarse
    if (!(shell > 0) || !source.isFile()) return;  // a shape has no field to be made
    const Vec<3> size = source.fileBounds().size();
    const double thin = *std::min_element(size.c.begin(), size.c.begin() + source.dim());
    if (2 * shell < thin && !closer) return;
    const auto built = source.build(thin / 40, thin / 6);
    const double deepest =
        built.space ? largestBall(*built.space).radius : largestBall(*built.plane).radius;
    if (shell < kCoarse * deepest) return;
    throw InputError(fmt::format(
        "`shell` {} mm: no part of the domain lies deeper than the shell; its deepest point lies "
        "{:.4g} mm below the wall; give a thinner shell, or check the unit of the domain",
        shell, deepest));
}

void requireRepeating(const DomainSource& source, const VoidRecipe& voids) {
    if (!source.isPeriodic()) return;
    const std::string& name = source.recipe().source;
    if (voids.hasShell())
        throw ParameterError(
            name +
            ": a shell lies along a wall, which a periodic cell has not on all sides; leave "
            "`shell` out");
    if (voids.as<FrontHoles>())
        throw ParameterError(fmt::format(
            "{}: `voids` {} are not available in a periodic cell; use boolean, overlay, "
            "foam, grid or list:FILE",
            name, nameOf(voids)));
    if (voids.fill == Fill::solid)
        throw ParameterError(name +
                             ": `fill` solid is not available in a periodic cell; leave it out");
    if (const BvtvField* field = bvtvFieldOf(voids))
        throw ParameterError(
            fmt::format("{}: BV/TV by place (`bvtvField` {}) does not repeat with a periodic cell; "
                        "leave it out",
                        name, field->file));
}

}  // namespace vdbpack
