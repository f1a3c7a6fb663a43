#include "vdbpack/repair/repair_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace vdbpack {

namespace {

const char* nameOf(RepairReport::Method method) {
    switch (method) {
        case RepairReport::Method::none:
            return "none";
        case RepairReport::Method::triangles:
            return "triangles";
        case RepairReport::Method::resurfaced:
            return "resurfaced";
    }
    return "";
}

}  // namespace

nlohmann::json toJson(const RepairReport& report) {
    return {
        {"method", nameOf(report.method)},
        {"components", report.components == RepairComponents::separate ? "separate" : "together"},
        {"changes", report.changes ? toJson(*report.changes) : nlohmann::json()},
        {"before", toJson(report.before)},
        {"duplicates", report.duplicates},
        {"turned", report.turned},
        {"holesFilled", report.holesFilled},
        {"filledArea", report.filledArea},
        {"dropped", report.dropped},
        {"piecesDropped", report.piecesDropped},
        {"voxelSize", report.voxelSize > 0 ? nlohmann::json(report.voxelSize) : nlohmann::json()},
        {"bridgedShare", report.bridgedShare},
        {"thinArea", report.thinArea},
        {"volume", report.volume},
        {"doubtfulVolume", report.doubtfulVolume},
        {"overlapVolume", report.overlapVolume},
        {"invertedVolume", report.invertedVolume}};
}

std::string describe(const RepairReport& report) {
    if (report.method == RepairReport::Method::none) return "not needed, the mesh is unchanged";
    std::string text;
    const auto add = [&](std::size_t count, const char* one, const char* many) {
        if (count > 0)
            text +=
                fmt::format("{}{} {}", text.empty() ? "" : ", ", count, count == 1 ? one : many);
    };
    add(report.duplicates, "duplicate triangle removed", "duplicate triangles removed");
    add(report.turned, "triangle flipped", "triangles flipped");
    if (report.method == RepairReport::Method::triangles) {
        add(report.holesFilled, "hole filled", "holes filled");
        if (report.holesFilled > 0) text += fmt::format(" ({:.3g} mm²)", report.filledArea);
        add(report.dropped, "triangle inside the solid removed",
            "triangles inside the solid removed");
        return text.empty() ? "surface split at edges with more than two triangles" : text;
    }
    text += fmt::format("{}surface remeshed with voxels of {:.3g} mm", text.empty() ? "" : ", ",
                        report.voxelSize);
    if (report.bridgedShare > 0)
        text += fmt::format(", {:.2g} % of it over holes", 100 * report.bridgedShare);
    add(report.piecesDropped, "component below ten voxels removed",
        "components below ten voxels removed");
    if (report.thinArea > 0)
        text +=
            fmt::format(", walls thinner than a voxel lost (about {:.3g} mm²)", report.thinArea);
    return text;
}

namespace {

/// Ambiguous volumes above this share of the repaired volume cause a warning.
constexpr double kDoubtful = 0.01;

std::string text(const Vec<3>& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p[0], p[1], p[2]);
}

std::string plural(std::size_t n, const char* one) {
    return fmt::format("{} {}{}", n, one, n == 1 ? "" : "s");
}

std::string fusedWarning(const RepairReport& report) {
    const RepairChanges& changes = *report.changes;
    const auto& largest = changes.fused.front();
    return fmt::format(
        "the repair fused {} components into {}; one of them, of {:.4g} mm³, lies about {}. {}",
        changes.fusedComponents(), changes.fused.size(), largest.volume, text(largest.at),
        report.components == RepairComponents::separate
            ? "They intersect each other: move them apart in the mesh to keep them separate"
            : "Set `repairComponents` separate to keep apart those that do not intersect");
}

/// What helps where details were lost.
std::string remedy(const RepairReport& report) {
    return report.method == RepairReport::Method::resurfaced
               ? fmt::format("; set a `repairVoxel` smaller than {:.3g} mm to keep more",
                             report.voxelSize)
               : "";
}

std::string removedWarning(const RepairReport& report) {
    const RepairChanges& changes = *report.changes;
    std::string message = "the repair removed ";
    if (changes.removed > 0)
        message += fmt::format("{} that enclosed {:.4g} mm³, the largest at {}",
                               plural(changes.removed, "surface component"), changes.removedVolume,
                               text(changes.removedAt));
    if (changes.fragmentsRemoved > 0)
        message += fmt::format("{}{}", changes.removed > 0 ? ", and " : "",
                               plural(changes.fragmentsRemoved, "open fragment"));
    return message +
           ". They were below ten voxels, inside the solid, or without a volume; check them, or "
           "set "
           "a smaller `repairVoxel`";
}

std::string holesWarning(const RepairReport& report) {
    const MeshLeak& leak = *report.before.leak;
    return fmt::format(
        "the repair closed {}, the largest {:.4g} mm around at {}. Check that no opening of the "
        "bone is among them",
        plural(leak.loops, "hole"), leak.largest.length, text(leak.largest.center));
}

/// Holes are closed on purpose: the others make the topology of the solid.
bool changesTopology(const RepairChanges& changes) {
    return changes.before.components != changes.after.components ||
           changes.before.cavities != changes.after.cavities ||
           changes.before.handles != changes.after.handles;
}

}  // namespace

std::vector<std::string> repairWarnings(const RepairReport& report, const std::string& name) {
    std::vector<std::string> warnings;
    const auto add = [&](const std::string& text) { warnings.push_back(name + ": " + text); };
    if (report.doubtfulVolume > kDoubtful * report.volume)
        add(fmt::format(
            "inside and outside are ambiguous for {:.3g} mm³, {:.2g} % of the repaired volume; the "
            "cause: {}",
            report.doubtfulVolume, 100 * report.doubtfulVolume / report.volume,
            report.before.leak ? report.before.describeLeak()
                               : "components that end inside others"));
    if (report.before.leak) add(holesWarning(report));
    if (!report.changes) return warnings;
    const RepairChanges& changes = *report.changes;
    if (!changes.fused.empty()) add(fusedWarning(report));
    if (changes.removed + changes.fragmentsRemoved > 0) add(removedWarning(report));
    if (changesTopology(changes))
        add("the repair changed the topology of the surface: " + describe(changes) +
            remedy(report));
    return warnings;
}

}  // namespace vdbpack
