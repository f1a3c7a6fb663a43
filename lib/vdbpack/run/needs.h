// What a run will take of memory and space, told before the work.
#pragma once

#include "vdbpack/run/domain_source.h"
#include "vdbpack/run/settings.h"
#include "vdbpack/voids/void_recipe.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

struct PackRecipe;

/// What is known of a run, or expected, from which its needs follow. Lengths in mm.
struct Extent {
    int dim = 3;
    double count = 0;         ///< spheres, with those that stand already; 0: none
    bool placing = false;     ///< they are placed, not read
    bool searching = false;   ///< for --target-count: two packs are held at a time
    bool densifying = false;  ///< they are moved, and further ones added
    double domainVolume = 0;  ///< mm^dim
    double domainArea = 0;    ///< of its wall, mm^(dim - 1)
    FieldPlan field;          ///< `triangles` 0: the domain is a shape
    double voids = 0;         ///< number of them; 0: none
    double voidRadius = 0;    ///< mean half-axes, b and a
    double voidLength = 0;
    double voidVoxel = 0;    ///< of their level sets
    double imageVoxels = 0;  ///< of the image in which a solid is measured
    std::vector<std::string> outputs;
    PreviewRecipe preview;
    std::string reportFile;
    int threads = 1;
};

/// Bytes of memory at the peak of a run by what takes them, and of each file it writes.
struct Needs {
    double program = 0, mesh = 0, field = 0, spheres = 0, voids = 0, picture = 0, image = 0;
    double memory() const { return program + mesh + field + spheres + voids + picture + image; }
    struct File {
        std::string name;  ///< as it was given to -o
        double bytes = 0;
    };
    std::vector<File> files;
    Extent extent;  ///< what they follow from
};

/// The needs of a run of this extent. What was measured and how near it comes: see the source.
Needs needsOf(const Extent& extent);

/// What can be told of a domain whose field `DomainSource::build` is to make for such radii.
Extent extentOf(const DomainSource& source, double detail, double reach, double voxelSize = 0);

/// What can be told of a pack to come without any trial: from the domain's volume and wall, the
/// mean ball, and how densely spheres of such a size lie between such walls.
Extent extentOf(const PackRecipe& recipe, const DomainSource& source);

/// Sets what `extent` says of voids: as many as the recipe asks for, or as its target needs.
/// @param largest  radius of the largest sphere; 0: none.
void addVoids(Extent& extent, const VoidRecipe& recipe, double largest);

/// @param limit  bytes that the process may hold; 0: as much as there is now.
double memoryLimit(double limit);

/// Refuses what is not to be had: memory beyond `limit` bytes, or files for which their file system
/// has no room.
/// @throws ResourceError with what is needed, what there is, which part takes it and a remedy.
void requireResources(const Needs& needs, double limit);

/// The same of a run with these settings; sets what they decide in `extent`. @throws ResourceError
void requireRoom(const RunSettings& settings, Extent extent);

/// The same of a pack to come. @throws ResourceError
void requireResources(const PackRecipe& recipe, const DomainSource& source);

/// "memory" and "files", for the report of a dry run.
nlohmann::ordered_json toJson(const Needs& needs);
/// For people: lines of memory and files; ends with a newline.
std::string summary(const Needs& needs);

}  // namespace vdbpack
