// Estimates of the memory and the disk space that a run will take.
#pragma once

#include "vdbpack/run/domain_source.h"
#include "vdbpack/run/settings.h"
#include "vdbpack/run/void_plan.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace vdbpack {

struct PackRecipe;

/// What is known of a run, or expected, from which its memory follows. Lengths in mm.
struct Extent {
    int dim = 3;
    double count = 0;         ///< spheres, with those of an input pack; 0: none
    bool placing = false;     ///< they are placed, not read
    bool searching = false;   ///< for a target count: two packs are held at a time
    bool densifying = false;  ///< they are moved, and further ones added
    double domainVolume = 0;  ///< mm^dim
    double domainArea = 0;    ///< of its wall, mm^(dim - 1)
    FieldPlan field;          ///< `triangles` 0: the domain is a shape
    PlannedVoids voids;
    double imageVoxels = 0;  ///< of the image in which a solid is measured
    std::vector<std::string> outputs;
    PreviewRecipe preview;
    std::string reportFile;
    int threads = 1;
};

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
        double bytes = 0;
    };
    std::vector<Part> parts;
    std::vector<File> files;
    Extent extent;  ///< from which they follow

    double memory() const;
};

/// The estimate for a run of this extent; its accuracy is tested against measured peaks.
Estimate estimate(const Extent& extent);

/// The extent of a domain whose field `DomainSource::build` is to make for such radii.
Extent extentOf(const DomainSource& source, double detail, double reach, double voxelSize = 0);

/// The extent of a pack to come, without trials: from the domain's volume and wall, the mean ball,
/// and how densely spheres of such sizes fill such domains.
Extent extentOf(const PackRecipe& recipe, const DomainSource& source);

/// @param limit  bytes that the process may hold; 0: as much as is available now.
double memoryLimit(double limit);

/// Refuses memory beyond `limit` bytes, and files larger than the free space of their disks.
/// @throws ResourceError with the parts of the estimate, what is available, and a remedy.
void requireResources(const Estimate& estimate, double limit);

/// The same for a run with these settings, which complete `extent`. @throws ResourceError
void requireRoom(const RunSettings& settings, Extent extent);

/// The same for a pack to come. @throws ResourceError
void requireResources(const PackRecipe& recipe, const DomainSource& source);

/// "memory" and "files", for the report of a dry run.
nlohmann::ordered_json toJson(const Estimate& estimate);
/// For people: lines of memory and files; ends with a newline.
std::string summary(const Estimate& estimate);

}  // namespace vdbpack
