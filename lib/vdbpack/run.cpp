#include "vdbpack/run.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/output_file.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/export/pack_file.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/run_stages.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include <cmath>

namespace vdbpack {

namespace {

std::uint64_t peakMemory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

bool passed(const Report& report) {
    return (!report.overlap || report.overlap->pairs == report.givenOverlaps) &&
           (!report.protrusion || report.protrusion->spheres == report.givenProtrusions) &&
           keepsGap(report);
}

template <int Dim>
RunResult packDomain(const PackRecipe& recipe, const DomainSource& source, Report report,
                     Clock& clock, const Callbacks& callbacks) {
    RequestedSizes requested = requestedSizes(recipe, Dim);
    const SizeDistribution& sizes = requested.sizes;
    const double target = requested.targetCount;
    report.chosen = std::move(requested.chosen);
    double scale = 1;
    if (target > 0) {
        // Half full is the lowest that is to be expected: the field is deep and fine enough.
        const double guess = source.measure() / (target * sizes.meanBall(Dim));
        scale = std::pow((Dim == 3 ? 0.58 : 0.8) * guess, 1.0 / Dim);
    }
    clock.lap();
    const auto built = source.build(fieldDetail(sizes.min(), sizes.mean()) * scale,
                                    sizes.max() * scale * 1.05 + recipe.gap, callbacks);
    const std::shared_ptr<const Domain<Dim>>& domain = ofDim<Dim>(built);
    report.seconds.domain = clock.lap();

    Pack<Dim> existing = readExisting<Dim>(recipe, built.sliceHeight);
    const std::size_t standing = existing.spheres.size();
    PackOptions options = packOptions(recipe, sizes);
    PackResult<Dim> result;
    if (target > 0) {
        result = packToCount(*domain, options, target, callbacks, existing.spheres);
        report.chosen.push_back(fmt::format("radii {} mm, so that about {:.0f} {} fill the domain",
                                            options.sizes.spec(), target, Measure<Dim>::kSpheres));
    } else {
        result = packSpheres(*domain, options, callbacks, existing.spheres);
    }
    result.pack.sliceHeight = built.sliceHeight;
    result.pack.region.assign(result.pack.spheres.size(), 0);  // all compact: no voids are cut
    report.interrupted = result.interrupted;
    if (!recipe.existing.empty()) {
        if (result.pack.spheres.empty() && !result.interrupted)
            callbacks.warn(recipe.existing + ": leaves no room for spheres of these radii");
        report.existing = standing;
        // What they do among themselves is not this run's doing.
        report.givenOverlaps = checkOverlap(existing.spheres).pairs;
        report.givenProtrusions = source.protrusion(existing.spheres).spheres;
        if (report.givenOverlaps > 0)
            callbacks.warn(
                fmt::format("{}: pairs of its {} that overlap one another: {}; they stay "
                            "as they are",
                            recipe.existing, Measure<Dim>::kSpheres, report.givenOverlaps));
        if (report.givenProtrusions > 0)
            callbacks.warn(
                fmt::format("{}: {} that are not wholly inside the domain: {}; they stay "
                            "as they are",
                            recipe.existing, Measure<Dim>::kSpheres, report.givenProtrusions));
        result.pack = joined(std::move(existing), result.pack);
    }
    report.gapAsked = recipe.gap;
    report.seconds.pack = clock.lap();

    callbacks.report("measure", 0, 0);
    measurePack(result.pack, &source, domain.get(), &options.sizes, recipe.contactTolerance,
                report);
    report.seconds.measure = clock.lap();

    PackWriteOptions write;
    write.unit = recipe.outUnit;
    write.generator = "vdb_pack " + report.version;
    if (built.mesh) write.surface = built.mesh->grid();
    // 25 bits of a voxel's edge are exact in the file: no coarser than the positions.
    write.pointVoxel =
        std::min(pointVoxelSize(static_cast<double>(report.count), domain->measure(), Dim),
                 result.quantum * 0x1p25);
    for (const auto& output : recipe.outputs) {
        // Interrupted before the first block was complete: nothing is worth replacing a file.
        if (report.interrupted && report.count == 0) break;
        callbacks.report("write", 0, 0);
        writePack(result.pack, output, write);
        report.files.push_back(filePart(output));
    }
    report.seconds.write = clock.lap();
    report.seconds.total = clock.total();
    report.peakMemoryBytes = peakMemory();
    RunResult run;
    run.passed = passed(report);
    if (!recipe.reportFile.empty()) report.files.push_back(recipe.reportFile);
    run.report = std::move(report);
    run.pack = std::move(result.pack);
    if (!recipe.reportFile.empty()) {
        OutputFile file(recipe.reportFile);
        file.write(toJson(run).dump(2) + "\n");
        file.commit();
    }
    return run;
}

int effectiveThreads(int threads) {
    return threads > 0 ? threads : tbb::info::default_concurrency();
}

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
                if (checks.contains("worst")) json["worst"] = checks["worst"];
            },
            run.pack);
    return json;
}

std::string failures(const RunResult& run) {
    if (run.passed) return {};
    return std::visit([&](const auto& pack) { return describe(checksOf(run.report), pack); },
                      run.pack);
}

RunResult runPack(const PackRecipe& recipe, const Callbacks& callbacks) {
    checkOutputs(recipe);
    Clock clock;
    Report report;
    report.version = VDBPACK_VERSION;
    report.command = "pack " + recipe.domain.source;
    report.seed = recipe.seed;
    report.threads = effectiveThreads(recipe.threads);
    // A malformed SPEC is found before a large mesh is read.
    if (!recipe.radius.empty()) SizeDistribution::parse(recipe.radius, 3, recipe.weightBy);
    return withThreads(recipe.threads, [&] {
        const DomainSource source(recipe.domain, callbacks);
        report.seconds.mesh = clock.lap();
        return source.dim() == 3
                   ? packDomain<3>(recipe, source, std::move(report), clock, callbacks)
                   : packDomain<2>(recipe, source, std::move(report), clock, callbacks);
    });
}

RunResult runVerify(const VerifyRecipe& recipe, const Callbacks& callbacks) {
    Clock clock;
    Report report;
    report.version = VDBPACK_VERSION;
    report.command = "verify " + recipe.pack;
    report.gapAsked = recipe.gap;
    report.threads = effectiveThreads(recipe.threads);
    return withThreads(recipe.threads, [&] {
        PackReadOptions read;
        read.unit = recipe.packUnit;
        read.gridName = recipe.packGrid;
        Pack<3> pack = readPack(recipe.pack, read);
        if (pack.spheres.empty()) throw InputError(recipe.pack + ": holds no spheres");
        std::optional<DomainSource> source;
        if (!recipe.domain.source.empty()) source.emplace(recipe.domain, callbacks);
        report.seconds.mesh = clock.lap();
        RunResult run;
        const auto check = [&](auto& shape, auto dim) {
            constexpr int Dim = decltype(dim)::value;
            std::optional<SizeDistribution> sizes;
            if (!recipe.radius.empty())
                sizes = SizeDistribution::parse(recipe.radius, Dim, recipe.weightBy);
            DomainSource::Built built;
            if (source) {
                const auto radius = radiusStatistics(shape.spheres);
                built = source->build(fieldDetail(radius.min, radius.mean), radius.max, callbacks);
            }
            report.seconds.domain = clock.lap();
            measurePack(shape, source ? &*source : nullptr, ofDim<Dim>(built).get(),
                        sizes ? &*sizes : nullptr, recipe.contactTolerance, report);
            if (recipe.placeSamples > 0) {
                if (!source)
                    throw ParameterError("--places looks in a domain; give one with --domain");
                PlacesLeft left;
                left.radius = 1.02 * report.radius.mean;
                left.samples = recipe.placeSamples;
                const auto found =
                    findPlaces(shape.spheres, *ofDim<Dim>(built), left.radius, recipe.placeSamples);
                left.largest = found.largest;
                left.count = found.places;
                run.places = left;
            }
            report.seconds.measure = clock.lap();
        };
        if (source && source->dim() == 2) {
            Pack<2> circles = asCircles(pack);
            check(circles, std::integral_constant<int, 2>());
            run.pack = std::move(circles);
        } else {
            check(pack, std::integral_constant<int, 3>());
            run.pack = std::move(pack);
        }
        report.seconds.total = clock.total();
        report.peakMemoryBytes = peakMemory();
        run.passed = passed(report);
        run.report = std::move(report);
        return run;
    });
}

}  // namespace vdbpack
