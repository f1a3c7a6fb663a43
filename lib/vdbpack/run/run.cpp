#include "vdbpack/run/run.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/run/densify_stage.h"
#include "vdbpack/run/needs.h"
#include "vdbpack/run/outputs.h"
#include "vdbpack/run/preview_stage.h"
#include "vdbpack/run/recipe_file.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/run_stages.h"
#include "vdbpack/run/void_stage.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbpack {

namespace {

/// What all packs of a recipe share, whatever their seed.
template <int Dim>
struct Prepared {
    RequestedSizes requested;
    DomainSource::Built built;
    Pack<Dim> existing;
    std::uint64_t givenOverlaps = 0, givenProtrusions = 0;

    const Domain<Dim>& domain() const { return *ofDim<Dim>(built); }
};

template <int Dim>
Prepared<Dim> prepare(const PackRecipe& recipe, const DomainSource& source,
                      const Callbacks& callbacks) {
    requireShell(recipe.voids.shell, source);
    requireResources(recipe, source);
    Prepared<Dim> prepared{requestedSizes(recipe, Dim), {}, {}};
    const SizeDistribution& sizes = prepared.requested.sizes;
    const FieldRadii radii = fieldRadii(recipe, prepared.requested, source);
    prepared.built =
        source.build(radii.detail, radii.reach, callbacks, plannedVoxel(recipe.voids, Dim));
    if (recipe.voids.shell > 0 || !recipe.voids.empty())
        checkRoom(VoidSetting<Dim>{recipe.voids, prepared.domain(), prepared.built.sliceHeight,
                                   recipe.seed, sizes.max() * radii.scale, callbacks},
                  true);
    checkPreview<Dim>(recipe.preview, prepared.domain(), nullptr);
    if (recipe.existing.empty()) return prepared;
    prepared.existing = readExisting<Dim>(recipe, prepared.built.sliceHeight);
    // What they do among themselves is not this run's doing.
    const auto& standing = prepared.existing.spheres;
    const OverlapCheck among = checkOverlap(standing);
    if (!among.complete)
        throw InputError(fmt::format(
            "{}: more than {} pairs of its {} {} overlap one another: no pack is like that; leave "
            "out those that lie in others",
            recipe.existing, among.pairs, standing.size(), Measure<Dim>::kSpheres));
    prepared.givenOverlaps = among.pairs;
    prepared.givenProtrusions = source.protrusion(standing).spheres;
    if (prepared.givenOverlaps > 0)
        callbacks.warn(
            fmt::format("{}: pairs of its {} that overlap one another: {}; they stay "
                        "as they are",
                        recipe.existing, Measure<Dim>::kSpheres, prepared.givenOverlaps));
    if (prepared.givenProtrusions > 0)
        callbacks.warn(
            fmt::format("{}: {} that are not wholly inside the domain: {}; they stay "
                        "as they are",
                        recipe.existing, Measure<Dim>::kSpheres, prepared.givenProtrusions));
    return prepared;
}

/// About what densifying adds to the solid fraction of a front at most.
template <int Dim>
constexpr double kMostGain = Dim == 3 ? 0.045 : 0.02;

template <int Dim>
std::vector<Sphere<Dim>> joinedSpheres(std::vector<Sphere<Dim>> spheres,
                                       const std::vector<Sphere<Dim>>& more) {
    spheres.insert(spheres.end(), more.begin(), more.end());
    return spheres;
}

/// Pack, measure, check, write, for the recipe's seed.
template <int Dim>
RunResult packPrepared(const PackRecipe& recipe, const DomainSource& source,
                       const Prepared<Dim>& prepared, Report report, Clock& clock,
                       const Callbacks& callbacks) {
    const Callbacks heard = keepingWarnings(callbacks, report.warnings);
    // Asked before what an interrupted run does without.
    const auto goesOn = [&] {
        report.interrupted = report.interrupted || callbacks.isCancelled();
        return !report.interrupted;
    };
    const Domain<Dim>& domain = prepared.domain();
    const double target = prepared.requested.targetCount;
    const std::vector<Sphere<Dim>>& standing = prepared.existing.spheres;
    report.seed = recipe.seed;
    report.chosen = prepared.requested.chosen;
    clock.lap();
    PackOptions options = packOptions(recipe, prepared.requested.sizes);
    PackResult<Dim> result;
    const bool holes = needsFront(methodOf(recipe.voids));
    if (target > 0) {
        result = packToCount(domain, options, target, heard, standing);
        if (recipe.densify > 0 && !result.interrupted) {
            // What is added counts as well: the front gets by with fewer, larger ones.
            const double front =
                solidFraction(joinedSpheres(standing, result.pack.spheres), domain);
            const double after =
                std::isfinite(recipe.densify) ? recipe.densify : front + kMostGain<Dim>;
            if (after > front)
                result = packToCount(domain, options, target * front / after, heard, standing);
        }
        report.chosen.push_back(fmt::format("radii {} mm, so that about {:.0f} {} fill the domain",
                                            options.sizes.spec(), target, Measure<Dim>::kSpheres));
    } else if (!holes) {
        result = packSpheres(domain, options, heard, standing);
    }
    const VoidSetting<Dim> setting{
        recipe.voids, domain, prepared.built.sliceHeight, recipe.seed, options.sizes.max(), heard};
    MadeVoids<Dim> voids;
    if (holes && !result.interrupted) result = packWithHoles(setting, options, standing, voids);
    result.pack.sliceHeight = prepared.built.sliceHeight;
    report.interrupted = result.interrupted;
    if (!recipe.existing.empty()) {
        if (result.pack.spheres.empty() && !result.interrupted)
            heard.warn(recipe.existing + ": leaves no room for spheres of these radii");
        report.existing = standing.size();
        report.givenOverlaps = prepared.givenOverlaps;
        report.givenProtrusions = prepared.givenProtrusions;
        result.pack = joined(prepared.existing, result.pack);
    }
    report.gapAsked = recipe.gap;
    report.seconds.pack = clock.lap();
    if (recipe.densify > 0 && goesOn() && !result.pack.spheres.empty()) {
        densifyPack(domain,
                    {recipe.densify, &options.sizes, recipe.gap, recipe.seed, standing.size()},
                    result.pack, report, heard);
        report.seconds.densify = clock.lap();
    }

    const bool cut = !recipe.voids.empty() || recipe.voids.shell > 0;
    if (cut) {
        // Held against what was asked for before any is removed.
        measureSizes(result.pack, options.sizes, report);
        if (!holes && goesOn()) {
            try {
                voids = makeVoids(setting);
            } catch (const Interrupted&) {  // the pack is complete, and stays as it is
                report.interrupted = true;
            }
        }
        report.chosen.insert(report.chosen.end(), voids.report.chosen.begin(),
                             voids.report.chosen.end());
    }
    cullPack(setting, recipe.contactTolerance, standing.size(), voids, result.pack);
    report.seconds.voids = clock.lap();

    callbacks.report("measure", 0, 0);
    if (cut) {
        try {
            if (goesOn()) measureVoids(setting, recipe.contactTolerance, &result.pack, voids);
        } catch (const Interrupted&) {
            report.interrupted = true;
        }
        report.voids = voids.report;
    }
    measurePack(result.pack, &source, &domain, cut ? nullptr : &options.sizes,
                recipe.contactTolerance, report, callbacks);
    PageDetails details;
    try {
        if (isPage(recipe.reportFile) && goesOn())
            details = pageDetails(result.pack, source, domain, options.sizes, report, callbacks);
    } catch (const Interrupted&) {
        report.interrupted = true;
    }
    report.seconds.measure = clock.lap();

    RunOutputs<Dim> have;
    have.pack = &result.pack;
    have.domain = &domain;
    if (prepared.built.mesh) have.wall = &prepared.built.mesh->wall();
    have.voidList = &voids.list;
    have.sliceHeight = setting.sliceHeight;
    have.options.contactTolerance = recipe.contactTolerance;
    PackWriteOptions& write = have.options;
    write.unit = recipe.outUnit;
    write.generator = "vdb_pack " + report.version;
    write.particleDensity = particleDensity(recipe.density, report.solidFractionTotal);
    write.levelSets = voids.levelSets();
    if (write.levelSets.empty() && prepared.built.mesh)
        write.levelSets = {prepared.built.mesh->grid()};
    if constexpr (Dim == 2) write.frame = domain.bounds();
    // 25 bits of a voxel's edge are exact in the file: no coarser than the positions.
    write.pointVoxel =
        std::min(pointVoxelSize(static_cast<double>(report.count), domain.volume(), Dim),
                 result.quantum * 0x1p25);
    // Interrupted before the first block was complete: nothing is worth replacing a file.
    if (!report.interrupted || report.count > 0)
        report.files = writeOutputs(recipe.outputs, have, callbacks);
    RunResult run;
    if (report.count > 0) {
        callbacks.report("write", 0, 0);
        const bool draws = !recipe.preview.file.empty() || isPage(recipe.reportFile);
        try {
            if (draws && goesOn()) {
                run.picture = drawPreview(recipe.preview, recipe.reportFile, source, prepared.built,
                                          voids, &result.pack, callbacks);
                if (!recipe.preview.file.empty()) report.files.push_back(recipe.preview.file);
            }
        } catch (const Interrupted&) {  // the pack is written
            report.interrupted = true;
        }
    }
    if (!report.files.empty()) leaveRecipe(recipe.optionsText, recipe.outputs, report, heard);
    report.seconds.write = clock.lap();
    report.seconds.total = clock.total();
    report.peakMemoryBytes = peakMemory();
    run.passed = passed(report);
    if (!recipe.reportFile.empty()) report.files.push_back(recipe.reportFile);
    run.report = std::move(report);
    run.pack = std::move(result.pack);
    if (!recipe.reportFile.empty()) writeReport(run, details, recipe);
    return run;
}

/// Packs for each recipe of `recipes`, which differ in seed and outputs alone; the domain is made
/// once. `done(run)` takes each result and says whether to go on.
template <int Dim>
void packDomain(const std::vector<PackRecipe>& recipes, const DomainSource& source,
                const Report& report, Clock clock, const Callbacks& callbacks,
                const std::function<bool(RunResult&&)>& done) {
    Report first = report;
    clock.lap();
    const Prepared<Dim> prepared =
        prepare<Dim>(recipes.front(), source, keepingWarnings(callbacks, first.warnings));
    first.seconds.domain = clock.lap();
    for (const PackRecipe& recipe : recipes) {
        if (!done(packPrepared(recipe, source, prepared, first, clock, callbacks))) return;
        // What was done once is told once.
        first.seconds = {};
        clock = Clock();
    }
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

namespace {

void packAll(const std::vector<PackRecipe>& recipes, const Callbacks& caller,
             const std::function<bool(RunResult&&)>& done) {
    const PackRecipe& recipe = recipes.front();
    const Callbacks callbacks = withinMemory(caller, memoryLimit(recipe.memoryLimit));
    for (const auto& r : recipes) checkOutputs(r);
    checkDensity(recipe.density);
    requireContactTolerance(recipe.contactTolerance);
    Clock clock;
    Report report;
    report.version = VDBPACK_VERSION;
    report.task = "pack";
    report.command = recipe.command.empty() ? "pack " + recipe.domain.source : recipe.command;
    report.threads = effectiveThreads(recipe.threads);
    // A malformed SPEC is found before a large mesh is read.
    if (!recipe.radius.empty()) SizeDistribution::parse(recipe.radius, 3, recipe.weightBy);
    checkVoids(recipe.voids, true, true);
    checkOutputKinds(recipe.outputs, RunKind::pack, recipe.voids);
    const auto work = [&] {
        const DomainSource source(recipe.domain, keepingWarnings(callbacks, report.warnings));
        report.seconds.mesh = clock.lap();
        warnOfUnused(recipe.domain, source, keepingWarnings(callbacks, report.warnings));
        checkOutputKinds(recipe.outputs, RunKind::pack, recipe.voids, source.dim());
        if (source.dim() == 3)
            packDomain<3>(recipes, source, report, clock, callbacks, done);
        else
            packDomain<2>(recipes, source, report, clock, callbacks, done);
    };
    try {
        withThreads(recipe.threads, work);
    } catch (const Interrupted&) {
        RunResult none;
        none.report = report;
        none.report.interrupted = true;
        none.passed = true;
        done(std::move(none));
    }
}

}  // namespace

RunResult runPack(const PackRecipe& recipe, const Callbacks& callbacks) {
    RunResult result;
    packAll({recipe}, callbacks, [&](RunResult&& run) {
        result = std::move(run);
        return true;
    });
    return result;
}

StudyResult runStudy(const PackRecipe& recipe, const std::vector<std::uint64_t>& seeds,
                     const std::string& table, const Callbacks& callbacks) {
    if (seeds.empty()) throw ParameterError("a study of no seeds has no rows; give one");
    std::vector<PackRecipe> recipes;
    for (const std::uint64_t seed : seeds) {
        PackRecipe r = recipe;
        r.seed = seed;
        for (auto& output : r.outputs) output = withSeed(output, seed);
        r.reportFile = withSeed(r.reportFile, seed);
        r.preview.file = withSeed(r.preview.file, seed);
        recipes.push_back(std::move(r));
    }
    if (seeds.size() > 1)
        for (const std::string& name : recipe.outputs)
            if (withSeed(name, 1) == name)
                throw ParameterError(name + ": each seed would replace it; name it with {seed}");
    if (seeds.size() > 1 && !recipe.reportFile.empty() &&
        withSeed(recipe.reportFile, 1) == recipe.reportFile)
        throw ParameterError("--report " + recipe.reportFile +
                             ": each seed would replace it; name it with {seed}, or ask for "
                             "--table FILE.csv");
    if (seeds.size() > 1 && !recipe.preview.file.empty() &&
        withSeed(recipe.preview.file, 1) == recipe.preview.file)
        throw ParameterError("--preview " + recipe.preview.file +
                             ": each seed would replace it; name it with {seed}");
    std::optional<OutputFile> file;
    if (!table.empty()) {
        if (table.size() < 5 || table.compare(table.size() - 4, 4, ".csv") != 0)
            throw ParameterError("--table " + table + ": tables are CSV; name it .csv");
        if (withSeed(table, 1) != table)
            throw ParameterError("--table " + table + ": one table holds all seeds; leave {seed}");
        for (const auto& r : recipes) {
            auto all = r.outputs;
            all.push_back("contacts:" + table);
            checkFiles(all, r.reportFile, {r.domain.source, r.existing}, r.preview.file);
        }
        file.emplace(table);
    }
    StudyResult study;
    const auto writeTable = [&] {
        if (!file || study.reports.empty()) return;
        file->write(studyTable(study.reports));
        file->commit();
    };
    try {
        packAll(recipes, callbacks, [&](RunResult&& run) {
            study.passed = study.passed && run.passed;
            study.interrupted = run.report.interrupted;
            // Of an interrupted run no figure would compare with the others.
            if (!study.interrupted) study.reports.push_back(std::move(run.report));
            if (!run.passed) study.failures += failures(run);
            return !study.interrupted;
        });
    } catch (...) {
        writeTable();  // the rows that are complete
        throw;
    }
    writeTable();
    return study;
}

std::string withSeed(std::string name, std::uint64_t seed) {
    const std::string mark = "{seed}";
    for (std::size_t at = name.find(mark); at != std::string::npos; at = name.find(mark, at))
        name.replace(at, mark.size(), std::to_string(seed));
    return name;
}

std::string studyTable(const std::vector<Report>& reports) {
    std::string text =
        "seed,hash,count,radius_mean,ks,ks_volume,solid_total,solid_interior,contacts_mean,"
        "few_contacts_share,largest_component,overlap_max,overlap_pairs,gap_min,protrusion_max,"
        "protrusion_spheres,seconds_pack,seconds_total\n";
    const auto number = [](const std::optional<double>& v) {
        return v ? fmt::format("{:.10g}", *v) : std::string();
    };
    for (const Report& r : reports) {
        const auto contacts = [&](double ContactNetwork::*value) {
            return r.contacts ? std::make_optional((*r.contacts).*value) : std::nullopt;
        };
        text += fmt::format(
            "{},{},{},{:.10g},{},{},{},{},{},{},{},{},{},{},{},{},{:.4f},{:.4f}\n", r.seed,
            hashText(r.hash), r.count, r.radius.mean, number(r.ks), number(r.ksByVolume),
            number(r.solidFractionTotal), number(r.solidFractionInterior),
            number(contacts(&ContactNetwork::mean)), number(contacts(&ContactNetwork::fewShare)),
            number(contacts(&ContactNetwork::largestComponent)),
            number(r.overlap ? std::make_optional(r.overlap->max) : std::nullopt),
            r.overlap ? std::to_string(r.overlap->pairs) : "", number(r.smallestGap),
            number(r.protrusion ? std::make_optional(r.protrusion->max) : std::nullopt),
            r.protrusion ? std::to_string(r.protrusion->spheres) : "", r.seconds.pack,
            r.seconds.total);
    }
    return text;
}

std::string summary(const StudyResult& study) {
    const char* form = "{:>8} {:>9} {:>7} {:>8} {:>8} {:>8} {:>7} {:>17}\n";
    std::string text = fmt::format(fmt::runtime(form), "seed", "spheres", "solid", "interior", "ks",
                                   "contacts", "pack, s", "hash");
    struct Sum {
        double n = 0, sum = 0, squares = 0;
        void add(double v) { n += 1, sum += v, squares += v * v; }
        std::string mean(const char* number) const {
            return n > 0 ? fmt::format(fmt::runtime(number), sum / n) : "-";
        }
        std::string sd(const char* number) const {
            if (n < 2) return "-";
            const double variance = std::max(0.0, (squares - sum * sum / n) / (n - 1));
            return fmt::format(fmt::runtime(number), std::sqrt(variance));
        }
    } count, total, interior, ks, contacts;
    for (const Report& r : study.reports) {
        const auto cell = [](const std::optional<double>& v, Sum& sum, const char* number) {
            if (v) sum.add(*v);
            return v ? fmt::format(fmt::runtime(number), *v) : std::string("-");
        };
        count.add(static_cast<double>(r.count));
        const auto mean = r.contacts ? std::make_optional(r.contacts->mean) : std::nullopt;
        text += fmt::format(fmt::runtime(form), r.seed, r.count,
                            cell(r.solidFractionTotal, total, "{:.4f}"),
                            cell(r.solidFractionInterior, interior, "{:.4f}"),
                            cell(r.ks, ks, "{:.5f}"), cell(mean, contacts, "{:.3f}"),
                            fmt::format("{:.2f}", r.seconds.pack), hashText(r.hash));
    }
    const auto row = [&](const char* name, std::string (Sum::*value)(const char*) const) {
        text += fmt::format(fmt::runtime(form), name, (count.*value)("{:.1f}"),
                            (total.*value)("{:.4f}"), (interior.*value)("{:.4f}"),
                            (ks.*value)("{:.5f}"), (contacts.*value)("{:.3f}"), "", "");
    };
    row("mean", &Sum::mean);
    row("sd", &Sum::sd);
    if (study.interrupted) text += fmt::format("interrupted after {} runs\n", study.reports.size());
    return text;
}

}  // namespace vdbpack
