// What is asked of voids.
#pragma once

#include "vdbpack/voids/orientation.h"

#include <optional>
#include <string>

namespace vdbpack {

/// Ways to make voids; the numbers are those of the paper that assets/figures/README.md names.
enum class VoidMethod {
    none,
    grid,        ///< 1: an ellipse in each box of a lattice that a matrix or chance selects
    overlay,     ///< 2: an ellipse in each sphere of a pack of large ones
    concentric,  ///< 3: all spheres that meet balls about some of them
    threshold,   ///< 4: the largest spheres
    mixed,       ///< 5: spheres that took part in the front as holes
    ellipses,    ///< 6: an ellipse about each of those
    boolean,     ///< ellipses at random places that may overlap
    list         ///< ellipses from a file
};

/// Which spheres voids remove: those with centers inside, or all that reach into one.
enum class Cull { center, touch };

/// Everything that decides voids. Lengths in mm.
struct VoidRecipe {
    std::string method;  ///< name as in VoidMethod, or list:FILE; empty: none
    double shell = 0;    ///< thickness of the layer along the wall that stays whole
    Cull cull = Cull::center;
    bool keepConnected = false;  ///< drop what does not hang together with the shell
    std::optional<double> targetBvtv, targetTbth;
    double voxelSize = 0;         ///< of the level sets; 0: chosen
    std::string radius;           ///< SPEC of the shorter half-axis b; empty: chosen
    std::string aspect;           ///< SPEC of a / b; empty: 2
    std::optional<double> count;  ///< voids with centers deeper than the shell
    std::optional<double> probability;
    std::optional<double> deleteFraction;
    std::string matrix;  ///< file of 0 and 1 for `grid`
    std::string cell;    ///< "S" or "X,Y,Z": sides of the boxes of `grid`
    OrientationRecipe orientation;

    bool empty() const { return method.empty(); }
};

/// The method that a recipe names. @throws ParameterError with the names there are.
VoidMethod methodOf(const VoidRecipe& recipe);
/// The file of list:FILE.
std::string listFile(const VoidRecipe& recipe);

/// Whether a method decides on spheres without any void: concentric and threshold.
bool isThinning(VoidMethod method);
/// Whether voids come out of the front itself: mixed and ellipses.
bool needsFront(VoidMethod method);

/// Refuses what cannot be meant: values out of range, options that the method does not use, and
/// what it needs and is not given.
/// @param hasSpheres  there is a pack to cut into; @param hasFront  and it is made in this run.
/// @throws ParameterError
void checkVoids(const VoidRecipe& recipe, bool hasSpheres, bool hasFront);

}  // namespace vdbpack
