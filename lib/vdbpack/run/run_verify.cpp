// The run that checks any pack: `vdb_pack verify`.
#include "vdbpack/core/error.h"
#include "vdbpack/measure/vacancies.h"
#include "vdbpack/run/input_pack.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

RunResult runVerify(const VerifyRecipe& recipe, const Callbacks& caller) {
    std::vector<std::string> warnings;
    const Callbacks callbacks = keepingWarnings(withinMemory(caller, recipe.memoryLimit), warnings);
    if (recipe.vacancySamples > 0 && recipe.domain.source.empty())
        throw ParameterError("`vacancySamples` are points of a domain; set `domain`");
    Report report = begunReport(recipe, "verify", recipe.pack);
    report.requestedGap = recipe.gap;
    return withThreads(recipe.threads, [&] {
        Clock clock;
        Pack<3> given = readInputPack(recipe, callbacks);
        report.seconds.mesh = clock.lap();
        std::optional<VacancySearch> vacancies;
        RunResult run = measureInputPack(
            recipe, std::move(given), std::move(report),
            [](const RadiusStatistics& r) { return 3 * r.max; }, callbacks,
            [&](const auto& pack, const auto* domain, const Report& measured) {
                if (recipe.vacancySamples == 0) return;
                VacancySearch all;
                all.radius = 1.02 * measured.radius.mean;
                all.samples = recipe.vacancySamples;
                const auto found =
                    findVacancies(pack.spheres, *domain, all.radius, recipe.vacancySamples);
                all.largest = found.largest;
                all.count = found.points;
                vacancies = all;
            });
        run.vacancies = vacancies;
        run.report.seconds.total = clock.total();
        run.report.warnings = std::move(warnings);
        return run;
    });
}

}  // namespace vdbpack
