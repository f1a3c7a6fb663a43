// A recipe in, a result out: the order of a whole run, in one place.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/structure.h"
#include "vdbpack/report/report.h"
#include "vdbpack/run/recipe.h"
#include "vdbpack/verify/verify.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace vdbpack {

/// What a search for empty places found.
struct PlacesLeft {
    double largest = 0;         ///< largest clearance of a sample point to wall and spheres, mm
    double radius = 0;          ///< 1.02 mean radii, mm
    std::uint64_t count = 0;    ///< sample points with a clearance of `radius` or more
    std::uint64_t samples = 0;  ///< points asked for, spread over the domain
};

/// A picture as the bytes of a PNG file.
struct PreviewPicture {
    std::string png;  ///< empty: none
    int width = 0, height = 0;
    std::string words;  ///< what it shows
};

struct RunResult {
    Report report;
    PreviewPicture picture;            ///< of --preview, or of the report page
    std::optional<PlacesLeft> places;  ///< if asked for
    std::variant<Pack<3>, Pack<2>> pack;
    bool passed = false;  ///< the checks found no overlap and no protrusion
};

/// The report as JSON; where a check failed, the spheres at fault under `worst`
/// of the check.
nlohmann::ordered_json toJson(const RunResult& run);
/// For people: what failed and which spheres are at fault, a line each; empty if all passed.
std::string failures(const RunResult& run);

/// Domain, pack, measure, check, write: the whole of `vdb_pack pack`.
///
/// Outputs are checked before the work and written whole or not at all; a pack that fails its own
/// check is written all the same (nothing is lost) and `passed` is false. Cancelled, it stops
/// within half a second of packing; what stands is checked and written, without voids that are not
/// all cut yet, the measures and pictures that were still to come; where nothing stands, nothing is
/// written. All other runs throw Interrupted then.
/// @throws ParameterError, InputError, IoError, ResourceError
RunResult runPack(const PackRecipe& recipe, const Callbacks& callbacks = {});

struct StudyResult {
    std::vector<Report> reports;  ///< one a seed, in their order
    bool passed = true;           ///< no check failed in any run
    bool interrupted = false;     ///< `reports` are of the runs before that
    std::string failures;         ///< of all runs
};

/// A pack for each seed, as `runPack` makes it, with the domain made once.
/// @param recipe  names of outputs and of the report may hold {seed}, and must with several seeds.
/// @param table   .csv with a row a run (`studyTable`); empty: none.
/// @throws as runPack; ParameterError for names that runs would share.
StudyResult runStudy(const PackRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks = {});

/// `name` with each {seed} replaced.
std::string withSeed(std::string name, std::uint64_t seed);

/// CSV: a line of names, then a line a report; empty cells where there is no value.
std::string studyTable(const std::vector<Report>& reports);
/// For people: a line a run, then mean and standard deviation over the runs.
std::string summary(const StudyResult& study);

/// A pack from a file, whoever made it, and what to hold it against.
struct GivenPack {
    std::string pack;  ///< file, any format that readPack knows
    Unit packUnit = Unit::millimeter;
    std::string packGrid;  ///< point grid in a .vdb; empty: the first
    DomainRecipe domain;   ///< `source` empty: what needs no domain
    std::string radius;    ///< SPEC to hold the radii against; empty: none
    WeightBy weightBy = WeightBy::count;
    double contactTolerance = 1e-3;
    double memoryLimit = 0;  ///< as that of PackRecipe
    int threads = 0;
    std::string command;  ///< for the report; empty: what is done to which file
};

struct VerifyRecipe : GivenPack {
    double gap = 0;                  ///< least distance that the spheres must keep, mm
    std::uint64_t placeSamples = 0;  ///< points at which to look for places left; 0: none
};

/// Checks any pack with code that the packer has no part in: the whole of `vdb_pack verify`.
RunResult runVerify(const VerifyRecipe& recipe, const Callbacks& callbacks = {});

/// What voids are cut into a pack that exists.
struct CarveRecipe : GivenPack {
    VoidRecipe voids;
    std::uint64_t seed = 1;
    std::string density;  ///< as `particleDensity` takes it
    std::vector<std::string> outputs;
    std::string reportFile;
    std::string optionsText;  ///< as that of PackRecipe
    PreviewRecipe preview;
    Unit outUnit = Unit::millimeter;
};

/// Reads a pack, cuts voids into it, measures and writes what is left: the whole of `vdb_pack
/// carve`. Overlaps and protrusions of the pack are reported, not judged: `passed` is true.
/// @throws ParameterError, InputError, IoError, ResourceError
RunResult runCarve(const CarveRecipe& recipe, const Callbacks& callbacks = {});

/// A pack that exists, made denser, or freed of its overlaps.
struct DensifyRecipe : GivenPack {
    double fraction = 0;  ///< solid fraction, as that of DensifyOptions; 0: overlaps alone
    double gap = 0;       ///< least distance between spheres and to the wall, mm
    std::uint64_t seed = 1;
    std::string density;  ///< as `particleDensity` takes it
    std::vector<std::string> outputs;
    std::string reportFile;
    std::string optionsText;  ///< as that of PackRecipe
    PreviewRecipe preview;
    Unit outUnit = Unit::millimeter;
};

/// Reads a pack of any program, moves its spheres and adds further ones, of the sizes of `radius`
/// or of its own; measures and writes it: the whole of `vdb_pack densify`. Ids, columns and radii
/// are kept. What does not come apart is written as it was, and `passed` is false.
/// @throws ParameterError, InputError, IoError, ResourceError
RunResult runDensify(const DensifyRecipe& recipe, const Callbacks& callbacks = {});

/// Voids and what they leave of a domain, without a pack.
struct VoidsRecipe {
    DomainRecipe domain;
    VoidRecipe voids;
    std::uint64_t seed = 1;
    double memoryLimit = 0;            ///< as that of PackRecipe
    int threads = 0;                   ///< 0: all cores
    std::vector<std::string> outputs;  ///< .vdb and list:FILE.csv
    std::string reportFile;
    PreviewRecipe preview;
    std::string command;
    std::string optionsText;  ///< as that of PackRecipe
    Unit outUnit = Unit::millimeter;
};

/// The whole of `vdb_pack voids`. @throws as `runPack`.
RunResult runVoids(const VoidsRecipe& recipe, const Callbacks& callbacks = {});

struct MeasureRecipe : GivenPack {
    double shell = 0;  ///< thickness of the layer along the wall that is told apart, mm; 0: none
    std::vector<std::string> outputs;  ///< contact lists of a pack: "contacts:FILE.csv"
    Unit outUnit = Unit::millimeter;   ///< of those
    std::string reportFile;            ///< .json or .html; empty: none
};

struct MeasureResult {
    RunResult run;                           ///< of a level set: its report has no spheres
    Structure structure;                     ///< of a pack
    std::optional<Morphometry> morphometry;  ///< of a level set
};

nlohmann::ordered_json toJson(const MeasureResult& result);
/// For people; ends with a newline.
std::string summary(const MeasureResult& result);

/// All that can be told of any pack, or of a solid as a level set (.vdb) or mesh (.stl .obj .off
/// .ply): the whole of `vdb_pack measure`. Overlaps and spheres outside are reported, and no
/// failure.
///
/// A .vdb that holds points is a pack, unless `domain.gridName` names a level set in it. Of a
/// solid, the total volume is the domain, else the bounding box of the solid; `shell` parts it
/// into label 1 (the shell) and 2. A box as domain cuts the solid: it goes on beyond.
/// `domain.voxelSize`: voxels to measure in, mm; 0: those of the level set, of a mesh 1/256 of its
/// longest side.
/// @throws ParameterError, InputError, IoError, ResourceError
MeasureResult runMeasure(const MeasureRecipe& recipe, const Callbacks& callbacks = {});

}  // namespace vdbpack
