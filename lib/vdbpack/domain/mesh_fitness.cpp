#include "vdbpack/domain/mesh_fitness.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/domain/mesh_requirements.h"
#include "vdbpack/repair/mesh_repair.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace vdbpack {

namespace {

/// About the solid volume of a sphere, as a share of the domain, in a pack by default.
constexpr double kSphereShare = 0.6 / 100000;
/// Smallest radius of such a pack in radii of a sphere of the mean volume.
constexpr double kSmallestRadius = 0.65;

/// Why no field can be made of the mesh for a pack by default; empty if it can.
std::string refusalOf(const TriangleMesh& mesh, const MeshHealth& health,
                      const DomainRecipe& recipe, const Callbacks& callbacks) {
    FieldOptions options;
    options.name = recipe.source;
    options.detail = kSmallestRadius * std::cbrt(kSphereShare * std::fabs(health.enclosedVolume) /
                                                 Measure<3>::ball(1));
    // Its remarks on voxels are of the run that is not made.
    Callbacks silent = callbacks;
    silent.warning = nullptr;
    try {
        meshDomain(mesh, options, silent);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

/// Whether the repair changed nothing that a run minds: it accepts components of any orientation.
bool wasFit(const RepairReport& report) {
    using Method = RepairReport::Method;
    return report.method == Method::none ||
           (report.method == Method::triangles && isClean(report.before) && report.dropped == 0 &&
            report.duplicates == 0);
}

/// What is wrong with a mesh that needs the repair.
std::string flawsBefore(const RepairReport& report, const std::string& name) {
    const std::string flaws = flawsOf(report.before);
    if (!flaws.empty()) return name + ": " + flaws;
    if (report.overlapVolume > 0)
        return fmt::format("{}: components overlap in about {:.3g} mm³", name,
                           report.overlapVolume);
    return fmt::format("{}: the surface intersects itself, or has parts inside the solid", name);
}

}  // namespace

MeshFitness fitnessOf(const TriangleMesh& repaired, const RepairReport& report,
                      const DomainRecipe& recipe, const Callbacks& callbacks) {
    MeshFitness fitness;
    fitness.repair = report;
    fitness.verdict = MeshFitness::Verdict::yes;
    if (!wasFit(report)) {
        fitness.verdict = MeshFitness::Verdict::withRepair;
        fitness.reasons.push_back(flawsBefore(report, recipe.source));
    }
    const std::string refusal = refusalOf(repaired, checkMesh(repaired), recipe, callbacks);
    if (!refusal.empty()) {
        fitness.verdict = MeshFitness::Verdict::no;
        fitness.reasons.push_back(refusal);
    }
    return fitness;
}

MeshFitness fitnessOf(const TriangleMesh& mesh, const MeshHealth& health,
                      const DomainRecipe& recipe, const Callbacks& callbacks) {
    MeshFitness fitness;
    try {
        checkSize(mesh.bounds(), recipe, callbacks);
        std::string refusal;
        // What lies in two components is lost without a repair, whatever the field says.
        if (!health.enclosesNothing() && health.intersections == 0) {
            refusal = refusalOf(mesh, health, recipe, callbacks);
            if (refusal.empty()) {
                fitness.verdict = MeshFitness::Verdict::yes;
                if (!flawsOf(health).empty())
                    fitness.reasons.push_back(fmt::format(
                        "{}: {}; its field is sound, and a run takes it with a warning; set "
                        "`repair` to mend it",
                        recipe.source, flawsOf(health)));
                return fitness;
            }
            if (!isSound(health)) refusal.clear();
        }
        RepairedMesh repaired = repairMesh(mesh, repairOptions(recipe), callbacks);
        fitness = fitnessOf(repaired.mesh, repaired.report, recipe, callbacks);
        // The repair may find nothing to do where the field is refused: walls that are too thin.
        if (fitness.verdict == MeshFitness::Verdict::yes && !refusal.empty())
            fitness.verdict = MeshFitness::Verdict::no;
        if (!refusal.empty() && fitness.reasons.empty()) fitness.reasons.push_back(refusal);
    } catch (const InputError& e) {
        fitness.verdict = MeshFitness::Verdict::no;
        if (!isClean(health)) fitness.reasons.push_back(recipe.source + ": " + flawsOf(health));
        fitness.reasons.emplace_back(e.what());
    }
    return fitness;
}

const char* nameOf(MeshFitness::Verdict verdict) {
    switch (verdict) {
        case MeshFitness::Verdict::yes:
            return "yes";
        case MeshFitness::Verdict::withRepair:
            return "with repair";
        case MeshFitness::Verdict::no:
            return "no";
    }
    return "";
}

void addJson(nlohmann::json& json, const MeshFitness& fitness, const std::string& name) {
    json["fit"] = nameOf(fitness.verdict);
    json["reasons"] = fitness.reasons;
    if (json.contains("repair")) return;
    json["withRepair"] = nullptr;
    if (!fitness.repair) return;
    json["withRepair"] = toJson(*fitness.repair);
    json["withRepair"]["warnings"] = repairWarnings(*fitness.repair, name);
}

}  // namespace vdbpack
