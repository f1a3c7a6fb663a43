// What a run prints beside its report: the spheres that failed a check, vacancies.
#include "vdbpack/run/run.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

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

}  // namespace vdbpack
