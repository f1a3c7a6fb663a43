// Domains, clips and slices as texts of the command line.
#pragma once

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/verify/verify.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// A domain given by a formula, and the same shape for checks; those of its dimension are set.
struct NamedShape {
    std::shared_ptr<const Domain<3>> space;
    std::shared_ptr<const Domain<2>> plane;
    std::optional<Shape<3>> shape3;
    std::optional<Shape<2>> shape2;
};

/// box:LX,LY,LZ  box:x0,y0,z0,x1,y1,z1  ball:R  cylinder:R,H  rect:W,H  rect:x0,y0,x1,y1  disc:R,
/// lengths in mm. Nothing for a text that begins with none of these words: the name of a file.
/// @throws ParameterError if the numbers are malformed or make no shape
std::optional<NamedShape> parseShape(const std::string& text);

/// box:x0,y0,z0,x1,y1,z1 or box:LX,LY,LZ (six half-spaces), or plane:nx,ny,nz,d (one: what has
/// n.x <= d stays), mm. @throws ParameterError
std::vector<HalfSpace<3>> parseClip(const std::string& text);

/// The height in z=V, mm. @throws ParameterError
double parseSlice(const std::string& text);

}  // namespace vdbpack
