// The run that checks any pack: `vdb_pack verify`.
#include "vdbpack/core/error.h"
#include "vdbpack/measure/vacancies.h"
#include "vdbpack/run/input_pack.h"

#include <optional>
#include <utility>

namespace vdbpack {

RunResult runVerify(const VerifyRecipe& recipe, const Callbacks& caller) {
    const Callbacks callbacks = withinMemory(caller, recipe.memoryLimit);
    if (recipe.placeSamples > 0 && recipe.domain.source.empty())
        throw ParameterError("`placeSamples` are points of a domain; set `domain`");
    Report report = begunReport(recipe, "verify", recipe.pack);
    report.gapAsked = recipe.gap;
    return withThreads(recipe.threads, [&] {
        Clock clock;
        Pack<3> given = readInputPack(recipe, callbacks);
        report.seconds.mesh = clock.lap();
        std::optional<PlacesLeft> places;
        RunResult run = measureInputPack(
            recipe, std::move(given), std::move(report),
            [](const RadiusStatistics& r) { return 3 * r.max; }, callbacks,
            [&](const auto& pack, const auto* domain, const Report& measured) {
                if (recipe.placeSamples == 0) return;
                PlacesLeft left;
                left.radius = 1.02 * measured.radius.mean;
                left.samples = recipe.placeSamples;
                const auto found =
                    findVacancies(pack.spheres, *domain, left.radius, recipe.placeSamples);
                left.largest = found.largest;
                left.count = found.points;
                places = left;
            });
        run.places = places;
        run.report.seconds.total = clock.total();
        return run;
    });
}

}  // namespace vdbpack
