// Spheres and solids as label maps.
#pragma once

#include "vdbpack/domain/domain_source.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/image/image_grid.h"
#include "vdbpack/image/label_map.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// Makes, for one thread, what tells whether a point belongs to a solid.
using SolidTest = std::function<std::function<bool(const Vec<3>&)>()>;

SolidTest solidTest(const std::shared_ptr<const Domain<3>>& domain);
SolidTest solidTest(const std::shared_ptr<const VdbGrid>& levelSet);

/// What label maps of a run are made on and from.
struct LabelSource {
    std::optional<ImageGrid> grid;       ///< nothing: no output is a label map
    ImageSpace space = ImageSpace::lps;  ///< the axes of its world
    std::vector<SolidTest> solids;       ///< one a part; of several at a point the last counts
};

/// The grid of the label maps among the outputs of a run on such domains: the grid of the image
/// that they come from, in its own voxels or in those that `voxelSpacing` says; else voxels along
/// the axes. Nothing if there are none.
/// @throws ParameterError where nothing says how large voxels are, ResourceError
/// @param memoryLimit  bytes, as of a run.
std::optional<ImageGrid> labelGridOf(const std::vector<OutputTarget>& outputs,
                                     const std::vector<const DomainSource*>& sources,
                                     double memoryLimit);

/// Warns of a `voxelSpacing` with which a run on such domains makes nothing.
void warnOfUnusedSpacing(const std::vector<OutputTarget>& outputs,
                         const std::vector<const DomainSource*>& sources,
                         const Callbacks& callbacks);

/// Writes one label map.
/// @param pack  null: there is none.
/// @throws ParameterError (no such thing to write, ids that are no labels), IoError, ResourceError
void writeLabels(const OutputTarget& target, const Pack<3>* pack, const LabelSource& source,
                 const std::string& generator);

}  // namespace vdbpack
