// The parameters of voids.
#pragma once

#include "vdbpack/voids/orientation.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// Ways to make voids; the numbers are those of the paper that assets/figures/README.md names.
enum class VoidMethod {
    none,
    grid,        ///< 1: an ellipsoid in each box of a lattice that a matrix or chance selects
    overlay,     ///< 2: an ellipsoid in each sphere of a pack of large spheres
    concentric,  ///< 3: removes all spheres that meet balls about some of them
    threshold,   ///< 4: removes the largest spheres
    mixed,       ///< 5: spheres of the front that were packed as holes
    ellipses,    ///< 6: an ellipsoid about each hole of the front
    boolean,     ///< ellipsoids at random positions, which may overlap
    foam,        ///< the dilated spheres or ellipsoids of a dense pack
    list         ///< ellipsoids from a file
};

/// Which spheres a void removes: those with their centers inside it, or all that meet it.
enum class Cull { center, touch };

/// What the spheres of a pack fill.
enum class Fill {
    domain,  ///< the domain; voids are cut into the pack
    solid    ///< what the voids leave of the domain
};

/// All parameters of voids. Lengths in mm.
struct VoidRecipe {
    std::string method;  ///< name as in VoidMethod, or list:FILE; empty: none
    double shell = 0;    ///< thickness of the layer along the wall that is kept free of voids
    /// The same by place, in place of `shell`: a file that `readScalarField` reads, in mm; empty:
    /// it is the same everywhere.
    std::string shellField;
    Fill fill = Fill::domain;
    Cull cull = Cull::center;
    bool keepConnected = false;        ///< remove spheres that are not connected to the shell
    std::optional<double> targetBvtv;  ///< BV/TV to reach deeper than the shell, 0 to 1
    /// boolean, foam: how BV/TV varies by place: an image, or a file that `readScalarField` reads;
    /// empty: it does not.
    std::string bvtvField;
    /// "MARROW,BONE": grey values, or numbers of the file, at BV/TV 0 and 1; empty: a file holds
    /// BV/TV itself (an image needs it).
    std::string bvtvRange;
    std::optional<double> targetTbth;   ///< boolean, foam: mean Tb.Th to reach by the size of voids
    std::optional<double> targetTbsp;   ///< foam: mean Tb.Sp to reach
    std::optional<double> targetDa;     ///< foam: DA to reach, 1 - (short / long)^2
    std::optional<double> targetConnd;  ///< foam: Conn.D to reach, 1/mm^3
    /// foam: standard deviations of the local thickness and spacing to come near to, in their
    /// means; taken from a sample.
    std::optional<double> thicknessScatter, separationScatter;
    /// Quantiles of these distributions in the sample, 0 to 100 %, mm; empty: there is none.
    std::vector<double> thicknessQuantiles, separationQuantiles;
    /// An image, level set or mesh of a specimen, whose structure is the target; empty: none.
    std::string like;
    std::string likeDomain;  ///< its total volume; empty: all of the image, or the box around it
    std::optional<double> likeThreshold;  ///< of an image: solid from this grey value on
    std::string trabecular;  ///< name of a preset whose numbers are the targets; empty: none
    double voxelSize = 0;    ///< of the level sets; 0: chosen by the program
    std::string radius;      ///< SPEC of the half-axis b; empty: chosen by the program
    double radiusScale = 1;  ///< factor on these half-axes, as a target needs it
    std::string aspect;      ///< SPEC of a / b; empty: 2
    /// foam: largest displacement of a void, in its radii; empty: a quarter.
    std::optional<double> jitter;
    /// Length over which voids run into one another; empty: of foam a tenth of the mean b, else 0.
    std::optional<double> blend;
    /// Thickness of struts between voids that overlap, mm; empty: of foam a fifth of the mean b
    /// (2D: 0.08), else 0.
    std::optional<double> strut;
    std::optional<double> strutShare;  ///< of the lines between voids that have one; empty: all
    std::optional<double> count;  ///< boolean, overlay: voids with centers deeper than the shell
    std::optional<double> probability;     ///< grid: of a void in a box; mixed, ellipses: of a hole
    std::optional<double> deleteFraction;  ///< D of concentric and threshold, 0 to 1
    std::string matrix;                    ///< file of 0 and 1 for `grid`
    std::string cell;                      ///< "S" or "X,Y,Z": sides of the boxes of `grid`
    OrientationRecipe orientation;

    bool empty() const { return method.empty(); }
    bool hasShell() const { return shell > 0 || !shellField.empty(); }
};

/// Whether the knobs of a foam are to be found for a structure, beside its BV/TV.
bool hasStructureTargets(const VoidRecipe& recipe);
/// Whether a target sets the lengths of the voids, so that `radius` says how they spread alone.
bool scalesVoids(const VoidRecipe& recipe);

/// Grey values at BV/TV 0 and 1. @throws ParameterError if they are malformed or equal
std::pair<double, double> parseBvtvRange(const std::string& text);

/// The method that a recipe names. @throws ParameterError with the known names.
VoidMethod methodOf(const VoidRecipe& recipe);
/// FILE of list:FILE; empty for other methods.
std::string listFile(const VoidRecipe& recipe);

/// Whether a method removes spheres without making voids: concentric and threshold.
bool isThinning(VoidMethod method);
/// Whether voids are made by the front while packing: mixed and ellipses.
bool needsFront(VoidMethod method);

/// Refuses values out of range, parameters that the method does not use, and missing ones.
/// @param hasSpheres  whether there is a pack to cut voids into.
/// @param hasFront    whether that pack is made in this run.
/// @throws ParameterError
void checkVoids(const VoidRecipe& recipe, bool hasSpheres, bool hasFront);

}  // namespace vdbpack
