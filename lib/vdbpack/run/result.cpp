// What a run prints beside its report: the spheres that failed a check, vacancies.
#include "vdbpack/run/run.h"

#include <nlohmann/json.hpp>

#include <variant>

namespace vdbpack {

namespace {

VerifyResult checksOf(const Report& report) {
    VerifyResult checks;
    checks.count = report.count;
    checks.radius = report.radius;
    checks.hash = report.hash;
    if (report.overlap) checks.overlap = *report.overlap;
    checks.protrusion = report.protrusion;
    return checks;
}

}  // namespace

nlohmann::ordered_json toJson(const RunResult& run) {
    nlohmann::ordered_json json = toJson(run.report);
    if (run.places)
        json["places"] = {{"largest", run.places->largest},
                          {"radius", run.places->radius},
                          {"count", run.places->count},
                          {"samples", run.places->samples}};
    if (!run.passed)
        std::visit(
            [&](const auto& pack) {
                const auto checks = toJson(checksOf(run.report), pack);
                for (const char* check : {"overlap", "protrusion"})
                    if (checks[check].contains("worst"))
                        json[check]["worst"] = checks[check]["worst"];
            },
            run.pack);
    return json;
}

std::string failures(const RunResult& run) {
    if (run.passed) return {};
    return std::visit([&](const auto& pack) { return describe(checksOf(run.report), pack); },
                      run.pack);
}

}  // namespace vdbpack
