// Domains, clips and slices as texts of the command line.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/domain_recipe.h"

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
/// @param periodic  axes along which a box or rectangle repeats.
/// @throws ParameterError if the numbers are malformed or make no shape, or the axes are none of it
std::optional<NamedShape> parseShape(const std::string& text,
                                     const std::array<bool, 3>& periodic = {});

/// Whether a text reads as a shape, a word and numbers ("cube:10"), though none that there is.
bool namesUnknownShape(const std::string& text);
/// The shapes that there are, for messages.
extern const char* const kShapeForms;

/// box:x0,y0,z0,x1,y1,z1 or box:LX,LY,LZ (six half-spaces), or plane:nx,ny,nz,d (one: n.x <= d
/// is kept), mm. @throws ParameterError
Clip parseClip(const std::string& text);

/// The height in z=V, mm. @throws ParameterError
double parseSlice(const std::string& text);

/// The axes in a text such as "x" or "yz". @throws ParameterError
std::array<bool, 3> parseAxes(const std::string& text);
std::string textOf(const std::array<bool, 3>& axes);

/// keep, fill, inner=FILE or outer=FILE,inner=FILE. @throws ParameterError
Cavities parseCavities(const std::string& text);
std::string textOf(const Cavities& cavities);

/// The numbers of a list, of which there must be as many as one of `counts`. @param form  of the
/// list, for messages. @throws ParameterError
std::vector<double> parseCounted(const std::string& setting, const std::string& text,
                                 const char* form, std::initializer_list<std::size_t> counts);
/// @return axis, degrees and point, the origin where it is left out. @throws ParameterError
std::vector<double> parseRotation(const std::string& text);
/// @return 12 numbers. @throws ParameterError
std::vector<double> parseMatrix(const std::string& text);

/// The distances of voxels in X,Y,Z, or in D for all three, mm. @throws ParameterError
Vec<3> parseVoxelSpacing(const std::string& text);
std::string textOf(const Vec<3>& spacing);

}  // namespace vdbpack
