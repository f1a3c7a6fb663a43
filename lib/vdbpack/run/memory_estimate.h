// Estimates of the memory and the disk space that a run will take.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/run/void_plan.h"

#include <string>
#include <vector>

namespace vdbpack {

/// What is known of a run, or expected, from which its memory follows. Lengths in mm.
struct Extent {
    int dim = 3;
    double count = 0;         ///< spheres, with those of an input pack
    bool searching = false;   ///< for a target count: two packs are held at a time
    bool densifying = false;  ///< spheres are moved, and further ones added
    bool solid = false;       ///< the spheres fill what the voids leave, inside its contour
    double volume = 0;        ///< of the domain, mm^dim
    double area = 0;          ///< of its wall, mm^(dim-1)
    FieldPlan field;          ///< without triangles: the domain is a shape
    VoidExtent voids;
    bool isBox = false;      ///< the domain, a box along the axes
    double shapeVoxel = 0;   ///< of the level set of a shape, mm, if one is written; 0: a file
    double imageVoxels = 0;  ///< of the image in which a solid is measured
    double labelVoxels = 0;  ///< of the label maps that are written
};

/// The extent of a domain whose field `DomainSource::build` is to make for such radii.
Extent extentOf(const DomainSource& source, double detail, double reach, double voxelSize = 0);

/// Bytes of memory at the peak of a run by what takes them, and of each file that it writes.
struct Estimate {
    struct Part {
        const char* name;    ///< key in reports
        double bytes;        ///< at the peak
        std::string what;    ///< for messages: "4e+05 spheres"
        const char* remedy;  ///< what makes it smaller
    };
    struct File {
        std::string name;  ///< as in the outputs
        double bytes;
    };
    std::vector<Part> parts;
    std::vector<File> files;

    double memory() const;
    /// The parts that matter, for people: "820 MiB for about 4e+05 spheres, ...".
    std::string memoryText() const;
};

/// The estimate for a run of this extent with the outputs and the picture of `settings`; a test
/// compares it with measured peaks.
Estimate estimate(const Extent& extent, const RunSettings& settings);

/// Refuses memory beyond `limit` bytes (as `memoryLimit`), and any file larger than the free space
/// of its disk. @throws ResourceError with the parts of the estimate, what is available, a remedy.
void requireResources(const Estimate& estimate, double limit);

/// The same for a run of this extent with these settings.
void requireResources(const Extent& extent, const RunSettings& settings);

}  // namespace vdbpack
