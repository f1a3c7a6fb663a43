#include "vdbpack/report/mesh_result.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace vdbpack {

nlohmann::json toJson(const MeshResult& result) {
    nlohmann::json json = toJson(result.health);
    if (result.repair) {
        json["repair"] = toJson(*result.repair);
        json["repair"]["warnings"] = repairWarnings(*result.repair, result.source);
    }
    addJson(json, result.fitness, result.source);
    if (!result.files.empty()) json["files"] = result.files;
    return json;
}

namespace {

std::string row(const char* name, const std::string& value) {
    return fmt::format("{:<22}{}\n", name, value);
}

/// What a repair did, or would do.
std::string repairRows(const RepairReport& r) {
    std::string text;
    for (const auto& line : repairLines(r)) text += row(text.empty() ? "repair" : "", line);
    return text;
}

std::string fitnessRows(const MeshResult& result) {
    const MeshFitness& fitness = result.fitness;
    using Verdict = MeshFitness::Verdict;
    std::string text = row("fit to be packed", fitness.verdict == Verdict::yes  ? "yes"
                                               : fitness.verdict == Verdict::no ? "no"
                                               : result.repair                  ? "yes, as repaired"
                                                               : "with `repair`; not as it is");
    for (const auto& reason : fitness.reasons) text += row("", reason);
    if (result.repair || fitness.verdict != Verdict::withRepair || !fitness.repair) return text;
    text += "\nwith `repair`\n" + repairRows(*fitness.repair);
    for (const auto& warning : repairWarnings(*fitness.repair, result.source))
        text += row("warning", warning);
    return text;
}

}  // namespace

std::string summary(const MeshResult& result) {
    std::string text;
    if (result.repair)
        text +=
            toText(result.repair->before) + "\n" + repairRows(*result.repair) + "\nrepaired mesh\n";
    text += toText(result.health) + fitnessRows(result);
    for (const auto& file : result.files) text += row("written", file);
    return text;
}

std::string failures(const MeshResult& result) {
    if (result.passed) return "";
    const bool repairable = result.fitness.verdict == MeshFitness::Verdict::withRepair;
    std::string text =
        fmt::format("{}: not fit to be packed{}\n", result.source,
                    repairable ? " as it is. Set `repair`, and check what that changes" : "");
    for (const auto& reason : result.fitness.reasons) text += "  " + reason + "\n";
    return text;
}

}  // namespace vdbpack
