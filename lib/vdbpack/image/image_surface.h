// Surfaces of labels and of grey values above a threshold.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/image/image.h"
#include "vdbpack/image/surface_net.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// A value of a label map and how often it occurs.
struct LabelCount {
    std::int64_t value = 0;
    std::size_t layer = 0;
    std::size_t voxels = 0;
    std::size_t stretches = 0;  ///< of voxels that follow one another along x
    Box<3> voxelBox;            ///< of their indices
    std::string name;           ///< empty: none in the file
};

/// Takes values for labels that are whole numbers but for rounding, as after a scale of 8 bits: at
/// most 1,000 different ones, each off by at most 1/510 of their range and by at most 0.1. Sets
/// `image.isRounded`, with a warning that says how far they are off.
void roundLabels(Image& image, const std::string& path, const Callbacks& callbacks);

/// The labels of an image, but for 0, by layer and value; nothing if its values are not whole
/// numbers or more than 65,000 different ones, or seem to be grey values: several that are rescaled
/// or below -1, or more than 20 most of which seldom follow one another along x, or lie scattered
/// through half of the image. Names of labels in the file, or `asked`, decide for labels.
/// Cost: about 1 ns a voxel on two threads.
std::optional<std::vector<LabelCount>> labelsOf(const Image& image, bool asked = false);

/// The least and the largest value, of those that are numbers.
std::pair<double, double> valueRange(const Image& image);

/// Labels that are one solid together.
struct LabelPart {
    std::string name;                ///< of its labels in the file, else as requested
    std::vector<LabelCount> labels;  ///< of one layer

    std::size_t voxels() const {
        std::size_t sum = 0;
        for (const LabelCount& label : labels) sum += label.voxels;
        return sum;
    }
};

/// The first 40 labels with their names, and how many more there are.
std::string listOf(const std::vector<LabelCount>& labels);

/// What a request means: labels by value, by value@layer or by name, joined to one part by "+",
/// parts separated by
/// ","; "all": each label is a part. @param path  of the image, for messages.
/// @throws ParameterError for labels that do not occur, with the labels of the image.
std::vector<LabelPart> parseLabels(const std::string& text, const std::vector<LabelCount>& labels,
                                   const std::string& path);

/// The surfaces of parts, mm: closed, smooth, and where parts touch, with the same triangles on
/// both sides. Labels that belong to no part have surfaces of their own there.
/// @param labels  of the image. @param parts  of one layer. @throws ResourceError
std::vector<TriangleMesh> labelSurfaces(const Image& image, const std::vector<LabelCount>& labels,
                                        const std::vector<LabelPart>& parts);

/// Warns of a surface whose volume differs by more than 10 % from the volume of its voxels, as
/// around thin parts. @param what  has the surface
void warnOfVolume(const TriangleMesh& mesh, const ImageGrid& grid, std::size_t voxels,
                  const std::string& what, const Callbacks& callbacks);

/// The surface around the values of at least `threshold`, mm, placed between voxels by their
/// values; an image of two values has the surface of a label. Values that are not numbers are
/// outside, with a warning that counts them; `warnOfVolume` adds another.
/// @throws InputError if all values or none are that high; ResourceError
TriangleMesh thresholdSurface(const Image& image, double threshold, const std::string& path,
                              const Callbacks& callbacks = {});

}  // namespace vdbpack
