// Whole runs: a recipe in, a result out.
#pragma once

#include "vdbpack/core/progress.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/report/run_result.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

struct ImageResult;

/// Domain, pack, measure, check, write: the whole of `vdb_pack pack`.
///
/// Outputs are checked before the work and written whole or not at all; a pack that fails its own
/// check is written all the same (nothing is lost) and `passed` is false. Cancelled, it stops
/// within half a second of packing; the completed spheres are checked and written, without voids
/// that are not all cut yet, and without the measures and pictures still to come; without spheres,
/// nothing is written. Other runs throw Interrupted then.
/// @throws ParameterError, InputError, IoError, ResourceError
RunResult runPack(const PackRecipe& recipe, const Callbacks& callbacks = {});

/// Checks any pack with code that the packer has no part in: the whole of `vdb_pack verify`.
RunResult runVerify(const VerifyRecipe& recipe, const Callbacks& callbacks = {});

/// Reads a pack, cuts voids into it, measures and writes the remaining spheres: the whole of
/// `vdb_pack carve`. Overlaps and protrusions of the input pack are reported, and `passed` is true.
/// @throws ParameterError, InputError, IoError, ResourceError
RunResult runCarve(const CarveRecipe& recipe, const Callbacks& callbacks = {});

/// Reads a pack of any program, moves its spheres and adds further ones, of the sizes of `radius`
/// or of its own; measures and writes it: the whole of `vdb_pack densify`. Ids, columns and radii
/// are kept. Spheres that cannot be separated are written as they were, and `passed` is false.
/// @throws ParameterError, InputError, IoError, ResourceError
RunResult runDensify(const DensifyRecipe& recipe, const Callbacks& callbacks = {});

/// The whole of `vdb_pack voids`. @throws as `runPack`.
RunResult runVoids(const VoidsRecipe& recipe, const Callbacks& callbacks = {});

/// All figures of any pack, or of a solid as a level set (.vdb) or mesh (.stl .obj .off
/// .ply): the whole of `vdb_pack measure`. Overlaps and spheres outside are reported, and no
/// failure.
///
/// A .vdb that holds points is a pack, unless `domain.gridName` names a level set in it. Of a
/// solid, the total volume is the domain, else the bounding box of the solid, of an image all of
/// it; `shell` parts it into label 1 (the shell) and 2. The faces of a box without a shell cut the
/// solid, and so does the wall of another domain beyond which most of the solid continues; else the
/// solid ends there. `domain.voxelSize`: voxels to measure in, mm; 0: those of the level set, of an
/// image its least step, of a mesh 1/256 of its longest side. Of an image, `domain.label` or
/// `domain.threshold` says what is solid, unless the domain is an image itself; without a domain it
/// is measured along its own axes.
/// @throws ParameterError, InputError, IoError, ResourceError
MeasureResult runMeasure(const MeasureRecipe& recipe, const Callbacks& callbacks = {});

/// The whole of `vdb_pack convert`. Packs are neither judged nor changed; solids (a level set, a
/// mesh, what `domain` takes of an image, a shape) become level sets, fog or surfaces, and a mesh
/// as .stl stays the mesh that it is. Where the label of an image names several parts, {part}
/// in the name of an output becomes the name of each part.
/// @throws ParameterError (no output, an output that is an input or that there is nothing for),
/// InputError, IoError, ResourceError
ConvertResult runConvert(const ConvertRecipe& recipe, const Callbacks& callbacks = {});

/// Bonds the spheres of a pack, and computes its apparent stiffness: `vdb_pack stiffness`.
/// @throws as `apparentStiffness`; ParameterError, InputError, IoError, ResourceError
StiffnessResult runStiffness(const StiffnessRecipe& recipe, const Callbacks& callbacks = {});

struct StudyResult {
    std::vector<Report> reports;  ///< one a seed of each case, in their order
    bool passed = true;           ///< no check failed in any run
    bool interrupted = false;     ///< `reports` are of the runs before that
    std::string failures;         ///< of all runs
};

/// A pack for each seed of each case, as `runPack` makes it; the domain of a case is made once.
/// @param cases  at least one; names of outputs and of the report may hold {seed}, and must with
///               several seeds. Several cases name in `varied` the options in which they differ.
/// @param table  .csv with a row a run (`studyTable`); empty: none.
/// @throws as runPack; ParameterError for names that runs would share.
StudyResult runStudy(const std::vector<PackRecipe>& cases, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks = {});
/// The same of voids, as `runVoids` makes them; the domain of a case is read once.
StudyResult runStudy(const std::vector<VoidsRecipe>& cases, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks = {});

/// For people: a line a run, then mean and standard deviation over the runs.
std::string summary(const StudyResult& study);

/// The whole of `vdb_pack view` but for opening the page. The pack is neither judged nor measured;
/// solids are shown as `runConvert` takes solids.
/// @throws ParameterError, InputError, IoError, ResourceError
ViewResult runView(const ViewRecipe& recipe, const Callbacks& callbacks = {});

/// Checks a mesh, decides whether it can be packed, repairs it if `domain.repair` is set, and
/// writes it.
/// @throws ParameterError (an output that is no .stl, or the input itself), InputError, IoError,
/// ResourceError
MeshResult runMesh(const MeshRecipe& recipe, const Callbacks& callbacks = {});

/// Reads an image, relates its labels, and says what thresholds take: the whole of `vdb_pack image`
/// (report/image_result.h).
/// @throws as `readImage`
ImageResult runImage(const ImageRecipe& recipe, const Callbacks& callbacks = {});

/// Reads the domain, and estimates; nothing is packed or written. Packs that exceed memory or disk
/// space are predicted, too: `requireResources(dryRun.estimate, recipe.memoryLimit)` throws what
/// `runPack` would. @throws as `runPack` for its recipe and its domain
DryRun dryRunPack(const PackRecipe& recipe, const Callbacks& callbacks = {});

/// Refuses memory beyond `limit` bytes (as `memoryLimit`), and any file larger than the free space
/// of its disk. @throws ResourceError with the parts of the estimate, what is available, a remedy.
void requireResources(const Estimate& estimate, double limit);

}  // namespace vdbpack
