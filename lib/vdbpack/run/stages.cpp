#include "vdbpack/run/stages.h"

#include "vdbpack/core/error.h"
#include "vdbpack/distributed/rank_measures.h"
#include "vdbpack/distributed/rank_outputs.h"
#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/options/recipe_file.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/report/measured_pack.h"
#include "vdbpack/run/densify_stage.h"
#include "vdbpack/run/image_domain.h"
#include "vdbpack/run/pack_warnings.h"
#include "vdbpack/run/rank_stages.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/view/pack_view.h"
#include "vdbpack/voids/shell_field.h"
#include "vdbpack/voids/void_families.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/info.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <fstream>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// BV/TV of a solid that is taken for none.
constexpr double kLeastBvtv = 1e-6;

}  // namespace

void checkSettings(const RunSettings& settings, RunKind kind, const VoidRecipe& voids,
                   const std::vector<std::string>& inputs) {
    auto all = inputs;
    if (settings.ranks && !settings.grey.empty())
        throw ParameterError(
            "`samples`: are not taken over several processes; take them from a file");
    for (auto& file : checkGrey(settings.grey, settings.density)) all.push_back(std::move(file));
    requireVoidFields(voids);
    checkOutputKinds(settings.outputs, kind, voids);
    checkDensity(settings.density);
    requireContactTolerance(settings.contactTolerance);
    checkPreview(settings.preview, settings.reportFile);
    checkFiles(settings.outputs, settings.reportFile, all, {settings.preview.file});
    if (kind == RunKind::pack) checkInterruptedFiles(settings.outputs, all);
}

void beginOn(const std::vector<const DomainSource*>& sources, const RunSettings& settings,
             const VoidRecipe& voids, Report& report, const Callbacks& callbacks, bool hasPack) {
    for (const DomainSource* source : sources) {
        if (!source->isPeriodic()) continue;
        const std::string& name = source->recipe().source;
        if (sources.size() > 1)
            throw ParameterError(name + ": a periodic cell is packed alone, not as a part");
        for (const OutputTarget& output : settings.outputs) switch (output.kind) {
                case OutputKind::labels:
                    throw ParameterError(output.text +
                                         ": label maps of a periodic cell are not available; write "
                                         "the spheres, or fog: of the solid beside voids");
                case OutputKind::contour:
                case OutputKind::levelSets:
                case OutputKind::fog:
                    if (voids.makesVoids()) break;
                    throw ParameterError(output.text +
                                         ": a periodic cell without voids has no surface; write "
                                         "the spheres");
                default:
                    break;
            }
    }
    if (settings.images && std::none_of(sources.begin(), sources.end(),
                                        [](const DomainSource* s) { return s->isPeriodic(); }))
        throw ParameterError(
            "`images` are those of a periodic cell, and there is none; leave them out");
    labelGridOf(settings.outputs, sources, settings.memoryLimit);
    for (const OutputTarget& output : settings.outputs)
        if (sources.size() == 1 && !hasPack && output.labels == "parts")
            throw ParameterError(output.text + ": there is one part alone; leave it out");
    for (const DomainSource* source : sources)
        if (source->imageGrid())
            report.axes = source->recipe().space == ImageSpace::ras ? "RAS" : "LPS";
    if (sources.size() == 1) warnOfUnusedSpacing(settings.outputs, *sources.front(), callbacks);
}

Report begunReport(const RunSettings& settings, const char* task, const std::string& subject) {
    Report report;
    report.version = VDBPACK_VERSION;
    report.task = task;
    report.command =
        settings.command.empty() ? std::string(task) + " " + subject : settings.command;
    report.threads = effectiveThreads(settings.threads);
    return report;
}

int effectiveThreads(int threads) {
    return threads > 0 ? threads : tbb::info::default_concurrency();
}

std::uint64_t peakMemory() {
    // What getrusage tells goes back to before the program was started, by one that may hold more.
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (std::uint64_t kibibytes = 0; word == "VmHWM:" && status >> kibibytes)
            return kibibytes * 1024;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

void requireShell(double shell, const DomainSource& source) {
    if (!(shell > 0) || !source.isFile()) return;  // a shape has no field to be made
    const Vec<3> size = source.fileBounds().size();
    const double thin = *std::min_element(size.c.begin(), size.c.begin() + source.dim());
    if (2 * shell < thin) return;
    throw InputError(fmt::format(
        "`shell` {} mm: no part of the domain lies deeper, it is at most {:.4g} mm thick; give a "
        "thinner shell, or check the unit of the domain",
        shell, thin));
}

void requireRepeating(const DomainSource& source, const VoidRecipe& voids) {
    if (!source.isPeriodic()) return;
    const std::string& name = source.recipe().source;
    if (voids.hasShell())
        throw ParameterError(
            name +
            ": a shell lies along a wall, which a periodic cell has not on all sides; leave "
            "`shell` out");
    if (voids.as<FrontHoles>())
        throw ParameterError(fmt::format(
            "{}: `voids` {} are not available in a periodic cell; use boolean, overlay, "
            "foam, grid or list:FILE",
            name, nameOf(voids)));
    if (voids.fill == Fill::solid)
        throw ParameterError(name +
                             ": `fill` solid is not available in a periodic cell; leave it out");
    if (const BvtvField* field = bvtvFieldOf(voids))
        throw ParameterError(
            fmt::format("{}: BV/TV by place (`bvtvField` {}) does not repeat with a periodic cell; "
                        "leave it out",
                        name, field->file));
}

template <int Dim>
void domainStage(Run<Dim>& run, const Extent& extent, double detail, double reach,
                 double voxelSize) {
    if (run.voidRecipe) requireShell(shellRange(*run.voidRecipe).first, run.source);
    if (run.cuts()) requireRepeating(run.source, *run.voidRecipe);
    requireResources(extent, run.settings);
    run.built = run.source.build(detail, reach, run.callbacks, voxelSize);
    run.report.seconds.domain = run.clock.lap();
    run.callbacks.stopIfCancelled();
    if (run.voidRecipe)
        run.shell = shellOver(*run.voidRecipe, run.domain().bounds(), run.built.sliceHeight);
    if (run.cuts()) checkRoom(run.voidSetting(), false);
    if (run.voidRecipe)
        run.bvtv = bvtvField<Dim>(*run.voidRecipe, run.source.recipe(), run.domain().bounds(),
                                  run.built.sliceHeight, run.callbacks);
    checkPreview<Dim>(run.settings.preview, run.domain(), run.hasPack ? &run.pack : nullptr);
}

template <int Dim>
void densifyStage(Run<Dim>& run, DensifyOptions options) {
    if (!run.goesOn() || sumOver(run.ranks(), std::uint64_t{run.pack.spheres.size()}) == 0) return;
    if (run.sizes) options.sizes = *run.sizes;
    options.seed = run.settings.seed;
    options.fixed = run.fixed;
    options.ranks = run.ranks();
    options.local = run.local;
    densifyPack(run.filled(), std::move(options), run.pieces, run.pack, run.report, run.callbacks);
    run.report.seconds.densify += run.clock.lap();
}

void solidStage(Run<3>& run, double detail, double reach) {
    run.voids = makeVoids(run.voidSetting());
    measureVoids(run.voidSetting(), run.settings.contactTolerance, static_cast<Pack<3>*>(nullptr),
                 run.voids);
    run.report.seconds.voids += run.clock.lap();
    // A field of its exact distances: those of a level set made by CSG are not.
    const VdbGrid& solid = *run.voids.solid.grid;
    DomainSource source(levelSetMesh(solid, "solid"), "solid", voxelSizeOf(solid));
    run.callbacks.stopIfCancelled();
    const auto built = source.build(detail, reach, run.callbacks);
    auto space = partDomain(built.space, run.built.space);
    run.solid.emplace(SolidFill<3>{std::move(source), std::move(space)});
    run.report.seconds.domain += run.clock.lap();
    run.callbacks.stopIfCancelled();
}

namespace {

/// The regions that spheres came with, beside those of this run, by which voids are cut: a further
/// column, so that removed spheres take theirs with them.
constexpr const char* kGivenRegion = "given region";

void setRegionsAside(PackAttributes& pack, std::size_t labelled) {
    if (labelled == 0) return;
    Column given;
    given.name = kGivenRegion;
    given.numbers.assign(pack.region.size(), std::numeric_limits<double>::quiet_NaN());
    std::copy_n(pack.region.begin(), labelled, given.numbers.begin());
    pack.columns.push_back(std::move(given));
}

void takeRegionsBack(PackAttributes& pack) {
    if (pack.columns.empty() || pack.columns.back().name != kGivenRegion) return;
    const std::vector<double> given = std::move(pack.columns.back().numbers);
    pack.columns.pop_back();
    for (std::size_t i = 0; i < given.size(); ++i)
        if (!std::isnan(given[i])) pack.region[i] = static_cast<std::int32_t>(given[i]);
}

}  // namespace

namespace {

/// What this rank has of the pack.
template <int Dim>
RankPack<Dim> rankPack(Run<Dim>& run) {
    return {run.ranks(), run.pack, run.filled(), run.fixed};
}

}  // namespace

template <int Dim>
void cutStage(Run<Dim>& run, bool made) {
    if (run.cuts()) {
        // Compared with the requested sizes before any sphere is removed.
        if (run.ranks())
            compareSizes(rankPack(run), *run.sizes, run.local, run.report);
        else if (run.hasPack && run.sizes)
            measureSizes(run.pack, *run.sizes, run.report, run.local, &run.filled());
        if (!made) run.unlessInterrupted([&] { run.voids = makeVoids(run.voidSetting()); });
        const auto& chosen = run.voids.report.chosen;
        run.report.chosen.insert(run.report.chosen.end(), chosen.begin(), chosen.end());
    }
    if (run.cuts()) warnOfSmallVoids(run);
    setRegionsAside(run.pack, run.labelled);
    if (run.hasPack) {
        const std::size_t before = run.pack.spheres.size();
        cullPack(run.voidSetting(), run.connectionTolerance(), run.fixed, run.voids, run.pack);
        if (run.cuts()) requireSpheresLeft(run, before);
    } else if (run.voids.report.bvtv && !(*run.voids.report.bvtv > kLeastBvtv)) {
        run.callbacks.warn(
            fmt::format("the voids leave no solid: BV/TV is {:.2g}. Give fewer or smaller voids",
                        *run.voids.report.bvtv));
    }
    run.report.seconds.voids += run.clock.lap();
}

namespace {

template <int Dim>
void describeDomain(const Domain<Dim>& domain, Report& report) {
    report.dim = Dim;
    report.domain = domain.facts();
    report.volume = domain.volume();
    report.area = domain.wallArea();
}

}  // namespace

template <int Dim>
void measureStage(Run<Dim>& run) {
    const double tolerance = run.settings.contactTolerance;
    run.callbacks.report("measure", 0, 0);
    if (run.cuts()) {
        run.unlessInterrupted([&] {
            measureVoids(run.voidSetting(), run.connectionTolerance(),
                         run.hasPack && !run.ranks() ? &run.pack : nullptr, run.voids);
        });
        run.report.voids = run.voids.report;
        run.report.seconds.voids += run.clock.lap();
    }
    if (run.labelled > 0) takeRegionsBack(run.pack);
    if (!run.hasPack) return describeDomain(run.domain(), run.report);
    if (run.ranks()) {
        run.spans = rowSpans(*run.ranks(), run.pack.order, run.fixed, run.pieces);
        std::vector<const DomainSource*> walls{&run.filledSource()};
        if (run.solid) walls.push_back(&run.source);
        run.named = measureOverRanks(rankPack(run), rowsOf(run), walls, tolerance, run.report);
        if (run.sizes && !run.cuts())
            compareSizes(rankPack(run), *run.sizes, run.local, run.report);
    } else {
        measurePack(run.pack, &run.filledSource(), &run.filled(), run.cuts() ? nullptr : run.sizes,
                    tolerance, run.report, run.callbacks, run.local);
    }
    if (run.solid && !run.ranks()) {
        // The contour of a level set may leave the domain by its error; no sphere does.
        const ProtrusionCheck wall = run.source.protrusion(run.pack.spheres);
        ProtrusionCheck& worst = *run.report.protrusion;
        if (wall.max > worst.max) worst = wall;
    }
    if (run.solid) run.report.domain.kind = "solid";
    warnOfLooseSpheres(run);
    warnOfThinSolid(run);
    if (run.report.interrupted && !run.keepsPack) throw Interrupted();
}

namespace {

/// What a run leaves of its domain.
SolidTest solidOf(const Run<3>& run) {
    return run.voids.solid.grid ? solidTest(run.voids.solid.grid) : solidTest(run.built.space);
}

LabelSource labelsOf(const Run<3>& run) {
    LabelSource labels;
    std::vector<const DomainSource*> sources;
    if (run.partRuns.empty()) {
        sources.push_back(&run.source);
        labels.solids.push_back(solidOf(run));
    }
    for (const Run<3>* part : run.partRuns) {
        sources.push_back(&part->source);
        labels.solids.push_back(solidOf(*part));
    }
    labels.grid = labelGridOf(run.settings.outputs, sources, run.settings.memoryLimit);
    for (const DomainSource* source : sources)
        if (source->recipe().space == ImageSpace::ras) labels.space = ImageSpace::ras;
    return labels;
}

template <int Dim>
RunOutputs<Dim> outputsOf(const Run<Dim>& run) {
    RunOutputs<Dim> have;
    have.pack = run.hasPack ? &run.pack : nullptr;
    have.domain = &run.domain();
    if (run.built.mesh) have.wall = &run.built.mesh->wall();
    if (!run.partWalls.triangles.empty()) have.wall = &run.partWalls;
    have.voidList = &run.voids.list;
    have.sliceHeight = run.built.sliceHeight;
    PackWriteOptions& write = have.options;
    write.contactTolerance = run.settings.contactTolerance;
    write.unit = run.settings.outUnit;
    write.images = run.settings.images;
    write.generator = "vdb_pack " + run.report.version +
                      (run.report.interrupted ? ", interrupted" : "") +
                      (run.report.axes.empty() ? "" : "; axes " + run.report.axes);
    const SphereDensity density =
        particleDensity(run.settings.density, run.report.solidFractionTotal);
    write.particleDensity = density.all;
    if (run.settings.grey.calibration.empty())
        write.materialDensity = run.partDensity.empty() ? density.ofRegions : run.partDensity;
    write.levelSets = run.partLevelSets.empty() ? run.voids.levelSets() : run.partLevelSets;
    const auto& outputs = run.settings.outputs;
    if (write.levelSets.empty() && run.built.mesh &&
        std::any_of(outputs.begin(), outputs.end(),
                    [](const OutputTarget& output) { return output.usesLevelSets(); }))
        write.levelSets = {run.built.mesh->grid()};
    if constexpr (Dim == 2)
        write.frame = run.domain().bounds();
    else
        have.labels = labelsOf(run);
    // 25 bits of a voxel's edge are exact in the file: no coarser than the positions.
    if (run.positionStep > 0)
        write.pointVoxel = std::min(
            pointVoxelSize(static_cast<double>(run.report.count), run.filled().volume(), Dim),
            run.positionStep * 0x1p25);
    return have;
}

/// Removes those outputs that an interrupted run has not made: voids and what they leave.
template <int Dim>
void leaveOutIncomplete(const Run<Dim>& run, std::vector<OutputTarget>& outputs) {
    if (!run.partRuns.empty()) {
        // Parts may be missing, and voids of those that are there.
        outputs.erase(
            std::remove_if(outputs.begin(), outputs.end(),
                           [](const OutputTarget& output) { return output.labels == "solid"; }),
            outputs.end());
        return;
    }
    if (!run.cuts() || !run.voids.levelSets().empty()) return;
    const auto isMissing = [&](const OutputTarget& output) {
        const OutputKind kind = output.kind;
        const bool missing = kind == OutputKind::contour || kind == OutputKind::levelSets ||
                             kind == OutputKind::fog ||
                             (kind == OutputKind::labels && output.labels == "solid") ||
                             (kind == OutputKind::voidList && run.voids.list.empty());
        if (missing)
            run.callbacks.warn(output.text +
                               ": is not written; the run was interrupted before its "
                               "voids were complete");
        return missing;
    };
    outputs.erase(std::remove_if(outputs.begin(), outputs.end(), isMissing), outputs.end());
}

/// Writes the outputs and the recipe that repeats the run.
template <int Dim>
void write(Run<Dim>& run) {
    const RunSettings& settings = run.settings;
    Report& report = run.report;
    report.seconds.measure += run.clock.lap();
    std::vector<OutputTarget> outputs = settings.outputs;
    if (report.interrupted) {
        if (report.count == 0) return;
        leaveOutIncomplete(run, outputs);
        for (OutputTarget& output : outputs) output = interruptedName(output.text);
    }
    report.files = run.ranks() ? writeOverRanks(outputs, outputsOf(run),
                                                PackShare<Dim>{run.ranks(), run.pack, run.spans,
                                                               run.pieces.size() + 1},
                                                run.callbacks)
                               : writeOutputs(outputs, outputsOf(run), run.callbacks);
    if (!report.files.empty() && run.isFirst())
        leaveRecipe(settings.optionsText, outputs, report, run.callbacks);
}

/// Draws the preview, or the picture of the report page.
template <int Dim>
void draw(Run<Dim>& run) {
    const RunSettings& settings = run.settings;
    if (run.ranks() || (settings.preview.file.empty() && !isPage(settings.reportFile))) return;
    if (run.hasPack && run.pack.spheres.empty()) return;
    if (run.report.interrupted) return;
    run.callbacks.report("write", 0, 0);
    try {
        const TriangleMesh* wall = run.partWalls.triangles.empty() ? nullptr : &run.partWalls;
        run.picture =
            drawPreview(settings.preview, settings.reportFile, run.source, run.built, run.voids,
                        run.hasPack ? &run.pack : nullptr, run.callbacks, wall);
        if (run.hasPack && isPage(settings.reportFile))
            addView(settings.preview, &run.source, run.built, run.pack, wall, false, run.picture);
        if (!settings.preview.file.empty()) run.report.files.push_back(settings.preview.file);
    } catch (const Interrupted&) {
        // All else is complete, and written.
        run.callbacks.warn("the picture is left out, since the run was interrupted");
    }
}

}  // namespace

template <int Dim>
RunResult finishStage(Run<Dim>& run) {
    // The pack is written whatever happens to the images.
    std::exception_ptr greyFailure;
    try {
        addGreyValues(run.settings.grey, run.source.recipe(), {run.partDensity, run.partModulus},
                      run.pack, run.uncancelled);
    } catch (const Error&) {
        greyFailure = std::current_exception();
    }
    write(run);
    if (greyFailure) {
        run.callbacks.warn("the pack is written without the columns of grey values");
        std::rethrow_exception(greyFailure);
    }
    draw(run);
    Report& report = run.report;
    report.seconds.write = run.clock.lap();
    report.seconds.total = run.clock.total();
    report.peakMemoryBytes =
        static_cast<std::uint64_t>(maxOver(run.ranks(), static_cast<double>(peakMemory())));
    RunResult result;
    result.passed = !failedChecks(report).any();
    const std::string reportFile = reportFileOf(run.settings, report);
    if (!reportFile.empty()) report.files.push_back(reportFile);
    result.report = std::move(report);
    result.picture = std::move(run.picture);
    result.levelSets = run.voids.levelSets();
    result.voids = std::move(run.voids.list);
    if (run.hasPack) result.pack = std::move(run.ranks() ? run.named : run.pack);
    return result;
}

#define VDBPACK_INSTANTIATE(Dim)                                                 \
    template void domainStage(Run<Dim>&, const Extent&, double, double, double); \
    template void densifyStage(Run<Dim>&, DensifyOptions);                       \
    template void cutStage(Run<Dim>&, bool);                                     \
    template void measureStage(Run<Dim>&);                                       \
    template RunResult finishStage(Run<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
