// Domains, clips and slices as texts of the command line.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/domain/domain.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// A domain given by a formula, with the numbers of its text.
struct NamedShape {
    enum class Kind { box, ball, cylinder, rect, disc };

    Kind kind = Kind::box;
    Box<3> box;                              ///< kind box
    Box<2> rect;                             ///< kind rect
    std::array<bool, 3> wraps{};             ///< kind box, rect: axes along which it repeats
    double radius = 0;                       ///< kind ball, cylinder, disc; mm
    double height = 0;                       ///< kind cylinder, centered at the origin; mm
    std::shared_ptr<const Domain<3>> space;  ///< null: `plane` is set
    std::shared_ptr<const Domain<2>> plane;
};

/// box:LX,LY,LZ  box:x0,y0,z0,x1,y1,z1  ball:R  cylinder:R,H  rect:W,H  rect:x0,y0,x1,y1  disc:R
/// periodic:LX,LY,LZ (a box) periodic:LX,LY (a rectangle), lengths in mm. Nothing for a text that
/// begins with none of these words: it is the name of a file.
/// @param periodic  axes along which a box or rectangle repeats: "x", "yz", ...; empty: none.
/// @throws ParameterError if the numbers are malformed or make no shape, or the axes are none of it
std::optional<NamedShape> parseShape(const std::string& text, const std::string& periodic = {});

/// Whether a text reads as a shape, a word and numbers ("cube:10"), though none that there is.
bool namesUnknownShape(const std::string& text);
/// The shapes that there are, for messages.
extern const char* const kShapeForms;

/// box:x0,y0,z0,x1,y1,z1 or box:LX,LY,LZ (six half-spaces), or plane:nx,ny,nz,d (one: n.x <= d
/// is kept), mm. @throws ParameterError
std::vector<HalfSpace<3>> parseClip(const std::string& text);

/// The height in z=V, mm. @throws ParameterError
double parseSlice(const std::string& text);

/// The distances of voxels in X,Y,Z, or in D for all three, mm. @throws ParameterError
Vec<3> parseVoxelSpacing(const std::string& text);

}  // namespace vdbpack
