#include "vdbpack/run/stages.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/version.h"
#include "vdbpack/distributed/rank_measures.h"
#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/domain/long_axis.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/bonded_pack.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/options/recipe_file.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/report/densified_pack.h"
#include "vdbpack/report/found_value.h"
#include "vdbpack/report/measured_pack.h"
#include "vdbpack/voids/local_values.h"
#include "vdbpack/voids/shell_field.h"
#include "vdbpack/voids/void_families.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// BV/TV of a solid that is taken for none.
constexpr double kLeastBvtv = 1e-6;

}  // namespace

void refuseBraces(const std::string& name) {
    for (std::size_t open = name.find('{'); open != std::string::npos;
         open = name.find('{', open + 1)) {
        const std::size_t close = name.find_first_not_of("abcdefghijklmnopqrstuvwxyz-", open + 1);
        if (close == open + 1 || close == std::string::npos || name[close] != '}') continue;
        const std::string word = name.substr(open, close + 1 - open);
        throw ParameterError(
            name + ": nothing replaces " + word +
            (word == "{part}" ? " here: one file holds all parts. `vdb_pack convert` writes the "
                                "surface of each label to a file of its own"
                              : "; {seed} and the names of options with several values are "
                                "replaced in a study"));
    }
}

void refuseInterfaces(const RunSettings& settings) {
    for (const OutputTarget& output : settings.outputs)
        if (output.kind == OutputKind::interfaces)
            throw ParameterError(output.text +
                                 ": interfaces are between the parts of a pack that `pack` "
                                 "makes; leave it out, or set `partsFile`, `partsBy` or several "
                                 "labels there");
}

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
    if (kind != RunKind::convert)
        for (const OutputTarget& output : settings.outputs) refuseBraces(output.text);
    requireContactTolerance(settings.contactTolerance);
    for (const OutputTarget& output : settings.outputs)
        if (output.kind == OutputKind::bondCoefficients)
            checkBondClasses(output.text, settings.bonds);
    checkPreview(settings.preview, settings.reportFile);
    checkFiles(settings.outputs, settings.reportFile, all, {settings.preview.file});
    if (kind != RunKind::pack) refuseInterfaces(settings);
    if (kind == RunKind::pack) checkInterruptedFiles(settings.outputs, all);
}

void beginOn(const std::vector<const DomainSource*>& sources, const RunSettings& settings,
             const VoidRecipe& voids, Report& report, const Callbacks& callbacks, bool hasPack,
             const std::string& sizeField) {
    warnOfDensity(settings.density, "", callbacks);
    warnOfUnusedBonds(settings, callbacks);
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
    for (const DomainSource* source : sources) {
        FoundValues found;
        addThreshold(found, source->recipe());
        for (FoundValue& each : found) {
            if (sources.size() > 1) each.part = source->recipe().source;
            report.found.push_back(std::move(each));
        }
    }
    for (const DomainSource* source : sources)
        if (source->imageGrid()) report.axes = axesOf(*source);
    // Files that are read beside the domains have its distances of voxels.
    const auto files = voidInputs(voids);
    if (settings.grey.samples.empty() && sizeField.empty() &&
        std::none_of(files.begin(), files.end(), namesImage))
        warnOfUnusedSpacing(settings.outputs, sources, callbacks);
}

std::string axesOf(const DomainSource& source) {
    if (!source.imageGrid()) return "";
    return source.recipe().space == ImageSpace::ras ? "RAS" : "LPS";
}

void warnOfUnusedBonds(const RunSettings& settings, const Callbacks& callbacks) {
    const BondOptions& bonds = settings.bonds;
    const BondLaw& law = bonds.law;
    const BondOptions usual;
    const bool isSet = law.modulus != usual.law.modulus || law.isHinged || law.breakingStrain ||
                       law.radiusFactor != usual.law.radiusFactor ||
                       law.shearStrength != usual.law.shearStrength ||
                       bonds.classes != usual.classes;
    if (isSet && std::none_of(settings.outputs.begin(), settings.outputs.end(),
                              [](const OutputTarget& output) { return output.listsBonds(); }))
        callbacks.warn(
            "what bonds are made of has no effect, as no output lists them; write bonds:FILE.csv, "
            "or leave it out");
}

Callbacks namingRun(const RunSettings& settings, std::uint64_t seed, std::size_t seeds,
                    const Callbacks& callbacks) {
    std::string name;
    for (const auto& [option, value] : settings.varied) name += option + ' ' + value + ", ";
    if (seeds > 1) name += fmt::format("seed {}, ", seed);
    if (name.empty()) return callbacks;
    name.replace(name.size() - 2, 2, ": ");
    Callbacks own = callbacks;
    own.warning = [name, &callbacks](const std::string& text) { callbacks.warn(name + text); };
    return own;
}

Report begunReport(const RunSettings& settings, const char* task, const std::string& subject) {
    Report report;
    report.version = version();
    report.task = task;
    report.command =
        settings.command.empty() ? std::string(task) + " " + subject : settings.command;
    report.threads = effectiveThreads(settings.threads);
    report.varied = settings.varied;
    if (!settings.outputs.empty()) report.filesUnit = settings.outUnit;
    return report;
}

template <int Dim>
void takeLongAxis(RunVoids<Dim>& voids, const DomainSource& source,
                  const DomainSource::Built& built) {
    VoidShapeRecipe* const shape = shapeOf(voids.recipe);
    if (!shape || !shape->orientation.axis || !shape->orientation.axis->isLong) return;
    const Vec<Dim> axis = longAxis<Dim>(source, built);
    std::string text;
    for (const double component : axis.c)
        text += fmt::format("{}{:.6g}", text.empty() ? "" : ",",
                            std::round(1e6 * component) / 1e6 + 0.0);
    voids.found.push_back({"void-axis", shape->orientation.axis->text, text});
    shape->orientation.axis = VoidAxis::parse(text);
}

template <int Dim>
void domainStage(Run<Dim>& run, const Extent& extent, double detail, double reach,
                 double voxelSize) {
    const VoidRecipe& voids = run.voids.recipe;
    requireShell(shellRange(voids).first, *run.source);
    if (run.cuts()) requireRepeating(*run.source, voids);
    requireResources(extent, run.settings);
    run.built = run.source->build(detail, reach, run.callbacks, voxelSize);
    run.report.seconds.domain = run.clock.lap();
    run.callbacks.stopIfCancelled();
    takeLongAxis(run.voids, *run.source, run.built);
    for (const FoundValue& found : run.voids.found) run.report.found.push_back(found);
    const Box<Dim> bounds = run.domain().bounds();
    run.voids.shell = shellOver(voids, bounds, run.built.sliceHeight);
    if (run.cuts()) checkRoom(voidSetting(run, run.callbacks), false);
    run.voids.bvtv =
        bvtvField<Dim>(voids, run.source->recipe(), bounds, run.built.sliceHeight, run.callbacks);
    checkPreview<Dim>(run.settings.preview, run.domain(), run.hasPack ? &run.pack : nullptr);
}

namespace {

template <int Dim>
void completeOptions(const Run<Dim>& run, DensifyOptions& options) {
    if (run.sizes) options.sizes = run.sizes->all;
    options.seed = run.settings.seed;
    options.fixed = run.facts.fixed;
    options.ranks = run.ranks();
    options.local = run.local();
}

}  // namespace

template <int Dim>
void densifyStage(Run<Dim>& run, DensifyOptions options) {
    const std::uint64_t count = sumOver(run.ranks(), std::uint64_t{run.pack.spheres.size()});
    if (!run.goesOn() || (count == 0 && !options.random)) return;
    completeOptions(run, options);
    densifyPack(run.filled(), std::move(options), run.share.pieces, run.pack, run.report,
                run.callbacks);
    run.report.seconds.densify += run.clock.lap();
}

template <int Dim>
void settleStage(Run<Dim>& run, double gap, const DeviceChoice& device) {
    if (!run.goesOn() || sumOver(run.ranks(), std::uint64_t{run.pack.spheres.size()}) == 0) return;
    DensifyOptions options;
    completeOptions(run, options);
    options.settle = true;
    options.gap = gap;
    options.device = device;
    if (options.ranks) {
        options.labels.assign(run.pack.order.begin(), run.pack.order.end());
        options.pieces = run.share.pieces;
    } else if (!options.local) {
        options.regions = run.pack.region;
    }
    auto result = densify(run.filled(), run.pack.spheres, options, run.callbacks);
    run.report.device = std::move(result.device);
    run.pack.spheres = std::move(result.spheres);
    if (!options.ranks && !options.local && !options.regions.empty())
        run.pack.region = std::move(result.regions);
    run.report.interrupted = run.report.interrupted || result.interrupted;
    if (!result.apart && !result.interrupted)
        run.callbacks.warn(fmt::format(
            "`settle`: overlaps were left after {} steps; the pack is the front's. Give another "
            "seed, or smaller radii",
            result.steps));
    run.report.seconds.settle += run.clock.lap();
}

void solidStage(Run<3>& run, double detail, double reach) {
    const Callbacks own = run.own();
    MadeVoids<3>& made = run.voids.made;
    made = makeVoids(voidSetting(run, own));
    measureVoids(voidSetting(run, own), run.settings.contactTolerance,
                 static_cast<Pack<3>*>(nullptr), made);
    run.report.seconds.voids += run.clock.lap();
    // A field of its exact distances: those of a level set made by CSG are not.
    const VdbGrid& solid = *made.solid.grid;
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

/// What this rank has of the pack.
template <int Dim>
RankPack<Dim> rankPack(Run<Dim>& run) {
    return {run.ranks(), run.pack, run.filled(), run.facts.fixed};
}

}  // namespace

template <int Dim>
void cutStage(Run<Dim>& run, bool made) {
    const Callbacks own = run.own();
    MadeVoids<Dim>& voids = run.voids.made;
    if (run.cuts()) {
        // Compared with the requested sizes before any sphere is removed.
        if (run.ranks())
            compareSizes(rankPack(run), run.sizes->all, run.local(), run.report);
        else if (run.hasPack && run.sizes)
            measureSizes(run.pack, run.sizes->all, run.report, run.local(), &run.filled());
        if (!made) run.unlessInterrupted([&] { voids = makeVoids(voidSetting(run, own)); });
        const auto& chosen = voids.report.chosen;
        run.report.chosen.insert(run.report.chosen.end(), chosen.begin(), chosen.end());
        warnOfSmallVoids(run);
    }
    setRegionsAside(run.pack, run.facts.labelled);
    if (run.hasPack) {
        const std::size_t before = run.pack.spheres.size();
        cullPack(voidSetting(run, own), run.connectionTolerance(), run.facts.fixed, voids,
                 run.pack);
        if (run.cuts()) requireSpheresLeft(run, before);
    } else if (voids.report.bvtv && !(*voids.report.bvtv > kLeastBvtv)) {
        run.callbacks.warn(
            fmt::format("the voids leave no solid: BV/TV is {:.2g}. Give fewer or smaller voids",
                        *voids.report.bvtv));
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
SphereRows rowsOf(const Run<Dim>& run) {
    if (!run.ranks()) return {};
    SphereRows all{run.ranks(), std::vector<std::int64_t>(run.pack.spheres.size())};
    for (const RowSpan& span : run.share.spans)
        for (std::size_t i = span.begin; i < span.end; ++i)
            all.rows[i] = static_cast<std::int64_t>(span.row + (i - span.begin));
    return all;
}

template <int Dim>
void measureStage(Run<Dim>& run) {
    const double tolerance = run.settings.contactTolerance;
    run.callbacks.report("measure", 0, 0);
    if (run.cuts()) {
        const Callbacks own = run.own();
        run.unlessInterrupted([&] {
            measureVoids(voidSetting(run, own), run.connectionTolerance(),
                         run.hasPack && !run.ranks() ? &run.pack : nullptr, run.voids.made);
        });
        run.report.voids = run.voids.made.report;
        run.report.seconds.voids += run.clock.lap();
    }
    if (run.facts.labelled > 0) takeRegionsBack(run.pack);
    if (!run.hasPack) return describeDomain(run.domain(), run.report);
    const DomainSource& source = run.filledSource();
    if (run.ranks()) {
        run.share.spans = rowSpans(*run.ranks(), run.pack.order, run.facts.fixed, run.share.pieces);
        std::vector<const DomainSource*> walls{&source};
        if (run.solid) walls.push_back(run.source.get());
        run.share.named =
            measureOverRanks(rankPack(run), rowsOf(run), walls, tolerance, run.report);
        if (run.sizes && !run.cuts())
            compareSizes(rankPack(run), run.sizes->all, run.local(), run.report);
    } else {
        measurePack(run.pack, &source, &run.filled(), run.cuts() ? nullptr : run.requested(),
                    tolerance, run.report, run.callbacks, run.local());
    }
    if (run.solid && !run.ranks()) {
        // The contour of a level set may leave the domain by its error; no sphere does.
        const ProtrusionCheck wall = run.source->protrusion(run.pack.spheres);
        ProtrusionCheck& worst = *run.report.protrusion;
        if (wall.max > worst.max) worst = wall;
    }
    if (run.solid) run.report.domain.kind = "solid";
    warnOfLooseSpheres(run);
    warnOfThinSolid(run);
    if (run.report.interrupted && !run.keepsPack) throw Interrupted();
}

#define VDBPACK_INSTANTIATE(Dim)                                                                 \
    template void takeLongAxis(RunVoids<Dim>&, const DomainSource&, const DomainSource::Built&); \
    template void domainStage(Run<Dim>&, const Extent&, double, double, double);                 \
    template void densifyStage(Run<Dim>&, DensifyOptions);                                       \
    template void settleStage(Run<Dim>&, double, const DeviceChoice&);                           \
    template void cutStage(Run<Dim>&, bool);                                                     \
    template SphereRows rowsOf(const Run<Dim>&);                                                 \
    template void measureStage(Run<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
