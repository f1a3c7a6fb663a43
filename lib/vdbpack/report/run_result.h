// What runs return, and print.
#pragma once

#include "vdbpack/bonds/bonds.h"
#include "vdbpack/core/ellipsoid.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/domain/mesh_fitness.h"
#include "vdbpack/measure/morphometry/morphometry.h"
#include "vdbpack/measure/structure.h"
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
template <int Dim>
struct PrincipalAxes;

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
    bool ofImage = false;                      ///< its total volume is that of the whole image
    std::optional<SphereMorphometry> spheres;  ///< of a pack, if requested
};

nlohmann::ordered_json toJson(const MeasureResult& result);
/// For people; ends with a newline.
std::string summary(const MeasureResult& result);

/// The apparent stiffness of a bonded pack.
struct StiffnessResult {
    std::uint64_t spheres = 0, bonds = 0;
    std::uint64_t boundary = 0;  ///< spheres that moved as the strain had it
    double volume = 0;           ///< over which stresses are averaged, mm³
    std::string body;            ///< what it is the volume of
    BondLaw law;                 ///< of the bonds; `moduli` are left out
    bool ownModuli = false;      ///< whether the spheres had moduli of their own
    ApparentStiffness apparent;
    std::optional<Elasticity> elasticity;  ///< nothing: some strain meets no resistance
    /// Between two grips, in place of the others.
    struct Pressed {
        int axis = 2;
        double modulus = 0;              ///< force by area and strain of the gauge, MPa
        double stiffness = 0;            ///< force by shortening, N/mm
        double gauge = 0, grip = 0;      ///< lengths between the grips and of each, mm
        double area = 0;                 ///< mean cross-section of the domain, mm²
        double low = 0, high = 0;        ///< ends of the pack along the axis, mm
        std::uint64_t held[2] = {0, 0};  ///< spheres in the lower and the upper grip
        double covers[2] = {0, 0};       ///< of the cross-section, by these spheres

        /// Whether an end's grip holds a sphere, by its center along the axis.
        bool holds(int end, double at) const {
            return end == 0 ? at < low + grip : at > high - grip;
        }
    };
    std::optional<Pressed> pressed;
    double modulusFactor = 1;            ///< by which moduli were changed to reach a wanted one
    std::vector<std::string> keptParts;  ///< whose moduli were not
    Report::Seconds seconds;
    std::vector<std::string> files, warnings;
};

nlohmann::ordered_json toJson(const StiffnessResult& result);
/// For people; ends with a newline.
std::string summary(const StiffnessResult& result);

struct ConvertResult {
    std::string kind;         ///< "spheres", "circles", "level set", "mesh", "image" or "shape"
    std::uint64_t count = 0;  ///< spheres, circles or triangles; of level sets and shapes 0
    std::uint64_t hash = 0;   ///< of a pack, in mm
    /// Pairs that outputs list, and the gaps up to which they are bonded, in smaller radii.
    std::optional<std::uint64_t> pairs;
    double tolerance = 0, interfaceTolerance = 0;
    /// Of spheres in files for LAMMPS, kg/m³, where neither the run nor the pack states one.
    std::optional<double> density;
    std::optional<double> modulus;  ///< the same of bonds, MPa
    FoundValues found;
    std::vector<std::string> files, warnings;
};

nlohmann::ordered_json toJson(const ConvertResult& result);
/// For people; ends with a newline.
std::string summary(const ConvertResult& result);

struct ViewResult {
    std::string kind;         ///< "spheres", "circles", or "triangles" of a surface
    std::uint64_t count = 0;  ///< of them
    FoundValues found;
    std::string file;         ///< the page
    std::uint64_t bytes = 0;  ///< of it
    std::vector<std::string> warnings;
};

nlohmann::ordered_json toJson(const ViewResult& result);
/// For people; ends with a newline.
std::string summary(const ViewResult& result);

struct MeshResult {
    TriangleMesh mesh;                             ///< as it was read, or repaired; mm
    std::shared_ptr<const PrincipalAxes<3>> axes;  ///< of what it encloses; null: it is open
    MeshHealth health;                   ///< of the mesh; with `repair`, of the repaired mesh
    std::optional<RepairReport> repair;  ///< contains the health before the repair
    MeshFitness fitness;
    bool passed = true;  ///< false: `check` was requested, and the mesh cannot be packed
    std::string source;  ///< its file
    std::vector<std::string> files;
};

/// The members of the health, `principalAxes`, `fit` and `reasons`; `repair` and `files` where
/// there are any; without a repair `withRepair`, what it would do, null if it is not needed.
nlohmann::json toJson(const MeshResult& result);
std::string summary(const MeshResult& result);
/// Why a mesh did not pass, a line each.
std::string failures(const MeshResult& result);

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

/// What to expect of a run.
struct DryRun {
    int dim = 3, threads = 1;
    double volume = 0;         ///< of the domain, mm^dim
    double voxelSize = 0;      ///< of its field, mm; 0: it is a shape
    double count = 0;          ///< spheres, with the existing ones
    double existing = 0;       ///< of these
    double solidFraction = 0;  ///< of the domain, with existing spheres
    bool densified = true;     ///< whether `densify` reaches its solid fraction
    std::string sizes;         ///< radii as they would be packed
    Report::Seconds seconds;   ///< on `threads` threads
    Estimate estimate;
};

/// The keys of a report, where they apply, `dryRun`, and the usual errors.
nlohmann::ordered_json toJson(const DryRun& dryRun);
/// For people; ends with a newline.
std::string summary(const DryRun& dryRun);

}  // namespace vdbpack
