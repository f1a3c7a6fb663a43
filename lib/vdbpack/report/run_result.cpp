#include "vdbpack/report/run_result.h"

#include "vdbpack/core/memory.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/core/version.h"
#include "vdbpack/report/axes_report.h"
#include "vdbpack/report/found_value.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <variant>

namespace vdbpack {

nlohmann::ordered_json toJson(const RunResult& run) {
    const Report& report = run.report;
    nlohmann::ordered_json json = toJson(report);
    if (run.vacancies)
        json["places"] = {{"largest", run.vacancies->largest},
                          {"radius", run.vacancies->radius},
                          {"count", run.vacancies->count},
                          {"samples", run.vacancies->samples}};
    const FailedChecks failed = failedChecks(report);
    std::visit(
        [&](const auto& pack) {
            if (failed.overlap) json["overlap"]["worst"] = worstJson(*report.overlap, pack);
            if (failed.protrusion)
                json["protrusion"]["worst"] = worstJson(*report.protrusion, pack);
        },
        run.pack);
    return json;
}

std::string summary(const RunResult& run) {
    std::string text = summary(run.report);
    if (run.vacancies)
        text += fmt::format(
            "vacancies  {} of {} points have room for {:.5g} mm (1.02 mean radii); largest {:.5g} "
            "mm\n",
            run.vacancies->count, run.vacancies->samples, run.vacancies->radius,
            run.vacancies->largest);
    return text;
}

std::string failures(const RunResult& run) {
    const Report& report = run.report;
    const FailedChecks failed = failedChecks(report);
    std::string text;
    std::visit(
        [&](const auto& pack) {
            if (failed.overlap) text += describe(*report.overlap, pack);
            if (failed.protrusion) text += describe(*report.protrusion, pack);
        },
        run.pack);
    if (failed.gap)
        text += fmt::format("{:<12}FAILED: smallest {:.6g} mm, requested {:.6g} mm\n", "gap",
                            *report.smallestGap, report.requestedGap);
    return text;
}

nlohmann::ordered_json toJson(const MeasureResult& result) {
    if (!result.morphometry) {
        auto json = toJson(result.run);
        addTo(json, result.structure);
        if (result.spheres) {
            auto solid = toJson(result.spheres->morphometry);
            solid["of"] = "spheres";
            solid["dilation"] = result.spheres->dilation;
            solid["dilationOfMeanRadius"] = result.spheres->dilationOfMeanRadius;
            json["morphometry"] = std::move(solid);
        }
        return json;
    }
    const Report& report = result.run.report;
    return {{"version", report.version},
            {"command", report.command},
            {"threads", report.threads},
            {"domain",
             {{"kind", report.domain.kind.empty() ? nlohmann::ordered_json()
                                                  : nlohmann::ordered_json(report.domain.kind)}}},
            {"found", toJson(report.found)},
            {"morphometry", toJson(*result.morphometry)},
            {"seconds",
             {{"mesh", report.seconds.mesh},
              {"domain", report.seconds.domain},
              {"measure", report.seconds.measure},
              {"total", report.seconds.total}}},
            {"peakMemoryBytes", report.peakMemoryBytes}};
}

std::string summary(const MeasureResult& result) {
    const Report& report = result.run.report;
    if (!result.morphometry) {
        std::string text = summary(report) + summary(result.structure);
        if (!result.spheres) return text;
        return text +
               fmt::format(
                   "union of the spheres as a solid, radii increased by {:.4g} mm ({:.3g} of "
                   "the mean):\n",
                   result.spheres->dilation, result.spheres->dilationOfMeanRadius) +
               summary(result.spheres->morphometry);
    }
    return (report.domain.kind.empty()
                ? fmt::format("{:<11}none: TV is {}\n", "domain",
                              result.ofImage ? "the whole image" : "the bounding box of the solid")
                : fmt::format("{:<11}{}\n", "domain", report.domain.kind)) +
           foundRows(report.found) + summary(*result.morphometry) +
           fmt::format(
               "{:<11}read {:.2f}, domain {:.2f}, measure {:.2f}, total {:.2f} on {} "
               "threads\n{:<11}{:.0f} MiB at most\n",
               "seconds", report.seconds.mesh, report.seconds.domain, report.seconds.measure,
               report.seconds.total, report.threads, "memory",
               static_cast<double>(report.peakMemoryBytes) / (1 << 20));
}

nlohmann::ordered_json toJson(const ConvertResult& result) {
    nlohmann::ordered_json json{{"version", version()}, {"kind", result.kind}};
    if (result.count > 0) json["count"] = result.count;
    if (result.hash != 0) json["hash"] = hashText(result.hash);
    if (result.pairs) json["pairs"] = *result.pairs;
    if (result.density) json["density"] = *result.density;
    if (result.modulus) json["modulus"] = *result.modulus;
    json["found"] = toJson(result.found);
    json["files"] = result.files;
    json["warnings"] = result.warnings;
    return json;
}

std::string summary(const ConvertResult& result) {
    const char* const a = result.kind == "image" ? "an" : "a";
    std::string text = result.hash != 0   ? fmt::format("read       {} {}, hash {}\n", result.count,
                                                        result.kind, hashText(result.hash))
                       : result.count > 0 ? fmt::format("read       {} {} of {} triangles\n", a,
                                                        result.kind, result.count)
                                          : fmt::format("read       {} {}\n", a, result.kind);
    text += foundRows(result.found);
    if (result.pairs)
        text +=
            fmt::format("pairs      {} with gaps up to {:g} of the smaller radius{}\n",
                        *result.pairs, result.tolerance,
                        result.interfaceTolerance > result.tolerance
                            ? fmt::format(", between parts up to {:g}", result.interfaceTolerance)
                            : "");
    if (result.density)
        text += fmt::format("density    {:g} kg/m³, as none is stated\n", *result.density);
    if (result.modulus)
        text += fmt::format("bonds      {:g} MPa, as spheres have no modulus of their own\n",
                            *result.modulus);
    for (const std::string& file : result.files) text += fmt::format("written    {}\n", file);
    return text;
}

nlohmann::ordered_json toJson(const ViewResult& result) {
    return {{"version", version()},          {"kind", result.kind}, {"count", result.count},
            {"found", toJson(result.found)}, {"file", result.file}, {"bytes", result.bytes},
            {"warnings", result.warnings}};
}

std::string summary(const ViewResult& result) {
    return fmt::format("{:<11}{} {}\n{}{:<11}{} ({:.3g} MB)\n", "read", grouped(result.count),
                       result.kind, foundRows(result.found), "written", result.file,
                       static_cast<double>(result.bytes) / 1e6);
}

nlohmann::json toJson(const MeshResult& result) {
    nlohmann::json json = toJson(result.health);
    json["principalAxes"] = result.axes ? toJson(*result.axes) : nlohmann::json();
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
    std::string text =
        row("fit to be packed", fitness.verdict == Verdict::yes  ? "yes"
                                : fitness.verdict == Verdict::no ? "no"
                                : result.repair
                                    ? "yes, as repaired"
                                    : "with `repair`; as it is, a pack by default is refused");
    // Of a mesh that was repaired, what was wrong is stated above.
    if (!result.repair || fitness.verdict == Verdict::no)
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
    text += toText(result.health);
    const char* name = "principal axes";
    if (result.axes)
        for (const std::string& line : linesOf(*result.axes))
            text += row(std::exchange(name, ""), line);
    text += fitnessRows(result);
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

namespace {

/// Usual errors, as measured (assets/guides/reliability.md).
constexpr double kCountError = 0.05, kMemoryError = 0.25, kTimeError = 0.5;
constexpr double kListedShare = 0.02;  ///< of memory; smaller parts are not listed

}  // namespace

double Estimate::memory() const {
    double sum = 0;
    for (const Part& part : parts) sum += part.bytes;
    return sum;
}

std::string Estimate::memoryText() const {
    std::string text;
    for (const Part& part : parts)
        if (part.bytes > kListedShare * memory())
            text += (text.empty() ? "" : ", ") + bytesText(part.bytes) + " for " + part.what;
    return text;
}

nlohmann::ordered_json toJson(const DryRun& f) {
    using Json = nlohmann::ordered_json;
    const auto whole = [](double amount) { return std::llround(std::min(amount, 9e18)); };
    const Report::Seconds& s = f.seconds;
    Json json;
    json["dryRun"] = true;
    json["threads"] = f.threads;
    json["domain"] = {{"volume", f.volume},
                      {"voxelSize", f.voxelSize > 0 ? Json(f.voxelSize) : Json()}};
    json["spheres"] = {
        {"count", whole(f.count)}, {"existing", whole(f.existing)}, {"requested", f.sizes}};
    json["solidFraction"] = {{"total", f.solidFraction}};
    json["seconds"] = {{"mesh", s.mesh},       {"domain", s.domain},   {"pack", s.pack},
                       {"settle", s.settle},   {"densify", s.densify}, {"voids", s.voids},
                       {"measure", s.measure}, {"total", s.total}};
    json["peakMemoryBytes"] = whole(f.estimate.memory());
    for (const auto& part : f.estimate.parts) json["memory"][part.name] = whole(part.bytes);
    json["files"] = Json::array();
    for (const auto& file : f.estimate.files)
        json["files"].push_back({{"name", file.name}, {"bytes", whole(file.bytes)}});
    json["errors"] = {{"count", kCountError}, {"memory", kMemoryError}, {"seconds", kTimeError}};
    return json;
}

std::string summary(const DryRun& f) {
    std::string text = "dry run    nothing is packed or written; expect about\n";
    const auto row = [&text](const char* name, const std::string& value) {
        text += fmt::format("{:<11}{}\n", name, value);
    };
    const Report::Seconds& s = f.seconds;
    row(f.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres,
        fmt::format("{:.0f}, radii {} mm", f.count, f.sizes) +
            (f.existing > 0 ? fmt::format("; {} of them exist already", f.existing) : ""));
    row("solid", fmt::format("{:.3f} of the domain{}", f.solidFraction,
                             f.densified ? "" : "; denser packs are not reached"));
    if (f.voxelSize > 0) row("field", fmt::format("voxels of {:.4g} mm", f.voxelSize));
    row("seconds",
        fmt::format(
            "mesh {:.2f}, domain {:.2f}, pack {:.2f}, settle {:.2f}, densify {:.2f}, voids {:.2f}, "
            "measure {:.2f}, total {:.2f} on {} thread{}",
            s.mesh, s.domain, s.pack, s.settle, s.densify, s.voids, s.measure, s.total, f.threads,
            f.threads == 1 ? "" : "s"));
    row("memory", fmt::format("about {} at most: {}", bytesText(f.estimate.memory()),
                              f.estimate.memoryText()));
    for (const auto& file : f.estimate.files)
        row("file", fmt::format("{} about {}", file.name, bytesText(file.bytes)));
    row("errors", fmt::format("usually up to {:.0f} % in the count, {:.0f} % in memory, {:.0f} % "
                              "in time",
                              100 * kCountError, 100 * kMemoryError, 100 * kTimeError));
    return text;
}

}  // namespace vdbpack
