// Voids as options request them: texts and numbers, whatever the method.
#pragma once

#include "vdbpack/voids/void_recipe.h"

#include <optional>
#include <string>

namespace vdbpack {

/// What the options of voids were given; documented by their help. An empty text was not given.
struct VoidRequest {
    std::string method;  ///< grid, overlay, ..., or list:FILE
    double shell = 0;
    std::string shellField;
    Fill fill = Fill::domain;
    Cull cull = Cull::center;
    bool keepConnected = false, measureSolid = false;
    std::optional<double> targetBvtv, targetTbth, targetTbsp, targetDa, targetConnd;
    std::string bvtvField, bvtvRange;  ///< "MARROW,BONE"
    std::string trabecular;            ///< name of a preset
    std::string like, likeDomain;
    std::optional<Threshold> likeThreshold;
    double voxelSize = 0;
    std::string radius, aspect;  ///< SPEC
    std::optional<double> jitter, blend, strut, strutShare, count, probability, deleteFraction;
    std::string matrix, cell;  ///< "S" or "X,Y,Z"
    OrientationRecipe orientation;
};

/// The typed recipe. A preset sets the targets that are not given; targets or a sample without a
/// method are met by a foam.
/// @throws ParameterError for texts that are malformed, and for options that the method does not
/// use, with the methods that use them; IoError, InputError for tables of sizes
VoidRecipe voidsOf(const VoidRequest& request);

}  // namespace vdbpack
