// Whole runs: a recipe in, a result out.
#pragma once

#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/mesh_fitness.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/structure.h"
#include "vdbpack/mesh/mesh_check.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/repair/mesh_repair.h"
#include "vdbpack/report/report.h"
#include "vdbpack/verify/verify.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace vdbpack {

class VdbGrid;

/// What a search for vacancies at sample points found.
struct VacancySearch {
    double largest = 0;         ///< largest clearance of a sample point to wall and spheres, mm
    double radius = 0;          ///< 1.02 mean radii, mm
    std::uint64_t count = 0;    ///< sample points with a clearance of `radius` or more
    std::uint64_t samples = 0;  ///< requested points, distributed over the domain
};

struct RunResult {
    Report report;
    PagePicture picture;  ///< as requested, or of the report page; the view of the page
    std::optional<VacancySearch> vacancies;  ///< if requested
    std::variant<Pack<3>, Pack<2>> pack;
    std::variant<std::vector<Ellipsoid<3>>, std::vector<Ellipsoid<2>>> voids;
    /// Of runs in space with voids: `surface`, `voids` and `solid`.
    std::vector<std::shared_ptr<const VdbGrid>> levelSets;
    bool passed = false;  ///< no check failed (`failedChecks`)
};

/// The report as JSON; where a check failed, the spheres at fault under `worst`
/// of the check.
nlohmann::ordered_json toJson(const RunResult& run);
/// For people: the summary of the report, and the vacancies; ends with a newline.
std::string summary(const RunResult& run);
/// For people: each check that failed, and the spheres at fault, a line each; empty if all passed.
std::string failures(const RunResult& run);

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

/// The spheres of a pack as one solid.
struct SphereMorphometry {
    double dilation = 0;              ///< mm added to the radii
    double dilationOfMeanRadius = 0;  ///< the same in mean radii
    Morphometry morphometry;
};

struct MeasureResult {
    RunResult run;                             ///< of a level set: its report has no spheres
    Structure structure;                       ///< of a pack
    std::optional<Morphometry> morphometry;    ///< of a level set
    std::optional<SphereMorphometry> spheres;  ///< of a pack, if requested
};

nlohmann::ordered_json toJson(const MeasureResult& result);
/// For people; ends with a newline.
std::string summary(const MeasureResult& result);

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
/// mesh) become level sets, fog or surfaces, and a mesh as .stl stays the mesh that it is.
/// @throws ParameterError (no output, an output that is an input or that there is nothing for),
/// InputError, IoError, ResourceError
ConvertResult runConvert(const ConvertRecipe& recipe, const Callbacks& callbacks = {});

nlohmann::ordered_json toJson(const ConvertResult& result);
/// For people; ends with a newline.
std::string summary(const ConvertResult& result);

struct StudyResult {
    std::vector<Report> reports;  ///< one a seed, in their order
    bool passed = true;           ///< no check failed in any run
    bool interrupted = false;     ///< `reports` are of the runs before that
    std::string failures;         ///< of all runs
};

/// A pack for each seed, as `runPack` makes it; the domain is made once.
/// @param recipe  names of outputs and of the report may hold {seed}, and must with several seeds.
/// @param table   .csv with a row a run (`studyTable`); empty: none.
/// @throws as runPack; ParameterError for names that runs would share.
StudyResult runStudy(const PackRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks = {});
/// The same of voids, as `runVoids` makes them; the domain is read once.
StudyResult runStudy(const VoidsRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks = {});

/// For people: a line a run, then mean and standard deviation over the runs.
std::string summary(const StudyResult& study);

struct MeshResult {
    TriangleMesh mesh;                   ///< as it was read, or repaired; mm
    MeshHealth health;                   ///< of the mesh; with `repair`, of the repaired mesh
    std::optional<RepairReport> repair;  ///< contains the health before the repair
    MeshFitness fitness;
    bool passed = true;  ///< false: `check` was requested, and the mesh cannot be packed
    std::string source;  ///< its file
    std::vector<std::string> files;
};

/// Checks a mesh, decides whether it can be packed, repairs it if `domain.repair` is set, and
/// writes it.
/// @throws ParameterError (an output that is no .stl, or the input itself), InputError, IoError,
/// ResourceError
MeshResult runMesh(const MeshRecipe& recipe, const Callbacks& callbacks = {});

/// The members of the health, `fit` and `reasons`; `repair` and `files` where there are any;
/// without a repair `withRepair`, what it would do, null if it is not needed.
nlohmann::json toJson(const MeshResult& result);
std::string summary(const MeshResult& result);
/// Why a mesh did not pass, a line each.
std::string failures(const MeshResult& result);

}  // namespace vdbpack
