// Runs on what exists already: verify and measure.
#include "vdbpack/run/run_given.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/label_voxels.h"
#include "vdbpack/field/voxel_image.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/run/needs.h"
#include "vdbpack/run/outputs.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/run_stages.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <functional>
#include <type_traits>
#include <vector>

namespace vdbpack {

namespace {

/// Warns of ids that several spheres have: contacts name spheres by them.
void warnOfSharedIds(const Pack<3>& pack, const std::string& file, const Callbacks& callbacks) {
    std::vector<std::int64_t> ids = pack.id;
    if (!std::is_sorted(ids.begin(), ids.end())) std::sort(ids.begin(), ids.end());
    const auto shared = std::adjacent_find(ids.begin(), ids.end());
    if (shared == ids.end()) return;
    const std::int64_t first = *shared;
    const auto different = std::unique(ids.begin(), ids.end()) - ids.begin();
    callbacks.warn(fmt::format(
        "{}: {} spheres have {} different ids, {} among those that several share; contacts name "
        "spheres by them, so number them anew or leave the ids out",
        file, pack.id.size(), different, first));
}

}  // namespace

Pack<3> readGiven(const GivenPack& recipe, const Callbacks& callbacks) {
    callbacks.stopIfCancelled();
    PackReadOptions read;
    read.unit = recipe.packUnit;
    read.gridName = recipe.packGrid;
    Pack<3> pack = readPack(recipe.pack, read);
    if (pack.spheres.empty()) throw InputError(recipe.pack + ": holds no spheres");
    warnOfSharedIds(pack, recipe.pack, callbacks);
    Box<3> box{pack.spheres[0].center, pack.spheres[0].center};
    for (const auto& s : pack.spheres)
        for (int d = 0; d < 3; ++d) {
            box.lo[d] = std::min(box.lo[d], s.center[d] - s.radius);
            box.hi[d] = std::max(box.hi[d], s.center[d] + s.radius);
        }
    const double extent = length(box.size());
    if (extent < 2 || extent > 5000)
        callbacks.warn(fmt::format(
            "{}: the pack is {:.3g} mm across, which is no size for a bone; give --pack-unit m, "
            "cm, mm or um if its lengths are not in mm",
            recipe.pack, extent));
    return pack;
}

void requireDomain(const GivenPack& recipe) {
    const DomainRecipe& d = recipe.domain;
    if (!d.source.empty()) return;
    const char* option = d.unit != Unit::millimeter ? "--unit"
                         : d.scale != 1             ? "--scale"
                         : !d.slices.empty()        ? "--slice"
                         : !d.clips.empty()         ? "--clip"
                                                    : nullptr;
    if (option)
        throw ParameterError(fmt::format(
            "{} is about the domain, and none is given; give one with --domain (the unit of the "
            "file itself is --pack-unit)",
            option));
}

bool isPlane(const Pack<3>& pack) {
    const double z = pack.spheres.front().center[2];
    return pack.spheres.size() > 2 &&
           std::all_of(pack.spheres.begin(), pack.spheres.end(),
                       [z](const Sphere<3>& s) { return s.center[2] == z; });
}

namespace {

/// Reads the domain of a pack and takes all measures that every report has; then calls
/// `further(pack, domain or null, report)`.
/// @param depthFor  depth up to which the field must know distances for such radii, mm.
template <class Further>
RunResult measureGiven(const GivenPack& recipe, Pack<3> given, Report report,
                       const std::function<double(const RadiusStatistics&)>& depthFor,
                       const Callbacks& callbacks, const Further& further) {
    Clock clock;
    requireDomain(recipe);
    std::optional<DomainSource> source;
    if (!recipe.domain.source.empty()) source.emplace(recipe.domain, callbacks);
    report.seconds.mesh += clock.lap();
    RunResult run;
    const auto measure = [&](auto& pack, auto dim) {
        constexpr int Dim = decltype(dim)::value;
        std::optional<SizeDistribution> sizes;
        if (!recipe.radius.empty())
            sizes = SizeDistribution::parse(recipe.radius, Dim, recipe.weightBy);
        DomainSource::Built built;
        Extent extent;
        extent.dim = Dim;
        extent.count = static_cast<double>(pack.spheres.size());
        extent.threads = report.threads;
        if (!source) requireResources(needsOf(extent), memoryLimit(recipe.memoryLimit));
        if (source) {
            const auto radius = radiusStatistics(pack.spheres);
            const double detail = fieldDetail(radius.min, radius.mean);
            Extent inDomain = extentOf(*source, detail, depthFor(radius) / 3);
            inDomain.count = extent.count;
            inDomain.threads = extent.threads;
            requireResources(needsOf(inDomain), memoryLimit(recipe.memoryLimit));
            built = source->build(detail, depthFor(radius) / 3, callbacks);
        }
        report.seconds.domain = clock.lap();
        const Domain<Dim>* domain = ofDim<Dim>(built).get();
        measurePack(pack, source ? &*source : nullptr, domain, sizes ? &*sizes : nullptr,
                    recipe.contactTolerance, report, callbacks);
        if (report.interrupted) throw Interrupted();
        further(pack, domain, report);
        report.seconds.measure = clock.lap();
    };
    const bool plane = isPlane(given);
    if (source && source->dim() == 3 && plane)
        callbacks.warn(recipe.pack +
                       ": all its spheres lie at one height; give --slice z=V to "
                       "measure them as circles of a plane");
    if (source ? source->dim() == 2 : plane) {
        Pack<2> circles = asCircles(given);
        measure(circles, std::integral_constant<int, 2>());
        run.pack = std::move(circles);
    } else {
        measure(given, std::integral_constant<int, 3>());
        run.pack = std::move(given);
    }
    report.seconds.total = clock.total();
    report.peakMemoryBytes = peakMemory();
    run.passed = passed(report);
    run.report = std::move(report);
    return run;
}

}  // namespace

RunResult runVerify(const VerifyRecipe& recipe, const Callbacks& caller) {
    const Callbacks callbacks = withinMemory(caller, memoryLimit(recipe.memoryLimit));
    if (recipe.placeSamples > 0 && recipe.domain.source.empty())
        throw ParameterError("--places looks in a domain; give one with --domain");
    Report report;
    report.task = "verify";
    report.command = recipe.command.empty() ? "verify " + recipe.pack : recipe.command;
    report.gapAsked = recipe.gap;
    report.version = VDBPACK_VERSION;
    report.threads = effectiveThreads(recipe.threads);
    return withThreads(recipe.threads, [&] {
        Clock clock;
        Pack<3> given = readGiven(recipe, callbacks);
        report.seconds.mesh = clock.lap();
        std::optional<PlacesLeft> places;
        RunResult run = measureGiven(
            recipe, std::move(given), std::move(report),
            [](const RadiusStatistics& r) { return 3 * r.max; }, callbacks,
            [&](const auto& pack, const auto* domain, const Report& measured) {
                if (recipe.placeSamples == 0) return;
                PlacesLeft left;
                left.radius = 1.02 * measured.radius.mean;
                left.samples = recipe.placeSamples;
                const auto found =
                    findPlaces(pack.spheres, *domain, left.radius, recipe.placeSamples);
                left.largest = found.largest;
                left.count = found.places;
                places = left;
            });
        run.places = places;
        run.report.seconds.total = clock.total();
        return run;
    });
}

namespace {

/// An image narrower than this is warned about.
constexpr std::int64_t kFewVoxels = 16;

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool isMesh(const std::string& file) {
    return endsWith(file, ".stl") || endsWith(file, ".obj") || endsWith(file, ".off");
}

/// Whether a file is measured as a solid; `pack` is set to what was read if not.
bool isSolid(const MeasureRecipe& recipe, std::optional<Pack<3>>& pack,
             const Callbacks& callbacks) {
    if (isMesh(recipe.pack)) return true;
    const bool vdb = endsWith(recipe.pack, ".vdb");
    if (vdb && !recipe.domain.gridName.empty() && !endsWith(recipe.domain.source, ".vdb"))
        return true;
    try {
        pack = readGiven(recipe, callbacks);
        return false;
    } catch (const InputError&) {
        if (endsWith(recipe.pack, ".ply")) return true;  // without radii: a mesh
        // Without points it may be a level set; if it is neither, the first message is the better.
        if (!vdb || !recipe.packGrid.empty() || !holdsLevelSet(recipe.pack)) throw;
        return true;
    }
}

/// How far beyond the total volume the solid is looked at, mm, so that balls do not grow through
/// the faces of a box cut from a larger sample: a tenth of its shortest side, if the sample reaches
/// that far on all sides. Else 0: what ends at those faces was cut there.
double marginFor(const VdbGrid& grid, const std::optional<Box<3>>& bounds) {
    if (!bounds) return 0;
    const Vec<3> size = bounds->size();
    const double margin = 0.1 * *std::min_element(size.c.begin(), size.c.end());
    const Box<3> band = bandBounds(grid);
    for (int d = 0; d < 3; ++d)
        if (band.lo[d] > bounds->lo[d] - margin || band.hi[d] < bounds->hi[d] + margin) return 0;
    return margin;
}

MeasureResult measureSolid(const MeasureRecipe& recipe, Report report, const Callbacks& callbacks) {
    if (!recipe.outputs.empty())
        throw ParameterError(recipe.outputs.front() +
                             ": a solid has no contacts to list; measure "
                             "a pack, or leave the output out");
    Clock clock;
    requireDomain(recipe);
    const double voxel = recipe.domain.voxelSize;
    const bool boxed = recipe.domain.source.rfind("box:", 0) == 0 && recipe.domain.clips.empty();
    std::shared_ptr<const VdbGrid> grid;
    double imageVoxel = voxel;
    const bool mesh = !endsWith(recipe.pack, ".vdb");
    if (mesh) {
        DomainRecipe solid;
        solid.source = recipe.pack;
        solid.unit = recipe.packUnit;
        const Vec<3> size = DomainSource(solid, callbacks).fileBounds().size();
        if (!(voxel > 0)) imageVoxel = *std::max_element(size.c.begin(), size.c.end()) / 256;
        solid.voxelSize = imageVoxel;
        Extent extent = extentOf(DomainSource(solid), imageVoxel, imageVoxel);
        extent.imageVoxels = size[0] * size[1] * size[2] / (imageVoxel * imageVoxel * imageVoxel);
        extent.threads = report.threads;
        requireResources(needsOf(extent), memoryLimit(recipe.memoryLimit));
        grid = DomainSource(solid).build(imageVoxel, imageVoxel, callbacks).mesh->grid();
    } else {
        grid = levelSetGrid(recipe.pack, recipe.domain.gridName, millimetersPer(recipe.packUnit));
    }
    report.seconds.mesh = clock.lap();
    std::optional<DomainSource> source;
    DomainSource::Built built;
    std::optional<Box<3>> bounds;
    if (!recipe.domain.source.empty()) {
        DomainRecipe total = recipe.domain;
        total.voxelSize = 0;
        if (mesh || !endsWith(total.source, ".vdb")) total.gridName.clear();
        source.emplace(total, callbacks);
        if (source->dim() != 3)
            throw ParameterError(total.source + ": is plane; a solid needs a domain of space");
        // Its wall need not be known as well as that of the solid.
        const double fine = 2 * (imageVoxel > 0 ? imageVoxel : voxelSizeOf(*grid));
        built = source->build(fine, std::max(recipe.shell * 1.05, fine) / 3, callbacks);
        bounds = built.space->bounds();
    }
    report.seconds.domain = clock.lap();
    callbacks.stopIfCancelled();
    VoxelImage image = sampleLevelSet(*grid, bounds, imageVoxel, marginFor(*grid, bounds));
    grid.reset();
    if (built.space && (!boxed || recipe.shell > 0)) labelVoxels(image, *built.space, recipe.shell);
    callbacks.stopIfCancelled();
    const auto fewest = *std::min_element(image.size.begin(), image.size.end());
    if (fewest < kFewVoxels)
        callbacks.warn(
            fmt::format("{}: the total volume is {} voxels of {:.3g} mm across; figures "
                        "are coarse: give a larger domain or a smaller --voxel",
                        recipe.pack, fewest, image.voxelSize));
    MeasureResult result;
    result.morphometry = measureMorphometry(image);
    // One region is the whole.
    if (result.morphometry->regions.size() == 1) result.morphometry->regions.clear();
    if (result.morphometry->solidFraction == 0)
        callbacks.warn(recipe.pack + ": no solid lies in the total volume");
    report.seconds.measure = clock.lap();
    report.seconds.total = clock.total();
    report.peakMemoryBytes = peakMemory();
    result.run.report = std::move(report);
    result.run.passed = true;
    return result;
}

template <int Dim>
std::vector<std::string> writeMeasured(const Pack<Dim>& pack, const MeasureRecipe& recipe,
                                       const Callbacks& callbacks) {
    RunOutputs<Dim> have;
    have.pack = &pack;
    have.options.contactTolerance = recipe.contactTolerance;
    have.options.unit = recipe.outUnit;
    return writeOutputs(recipe.outputs, have, callbacks);
}

}  // namespace

MeasureResult runMeasure(const MeasureRecipe& recipe, const Callbacks& callbacks) {
    if (recipe.shell > 0 && recipe.domain.source.empty())
        throw ParameterError("--shell lies along the wall of a domain; give one with --domain");
    checkOutputKinds(recipe.outputs, RunKind::measure, {});
    requireContactTolerance(recipe.contactTolerance);
    auto inputs = domainInputs(recipe.domain);
    inputs.push_back(recipe.pack);
    inputs.push_back(recipe.radius);  // table:FILE
    checkFiles(recipe.outputs, recipe.reportFile, inputs);
    Report report;
    report.version = VDBPACK_VERSION;
    report.task = "measure";
    report.command = recipe.command.empty() ? "measure " + recipe.pack : recipe.command;
    report.threads = effectiveThreads(recipe.threads);
    std::vector<std::string> warnings;
    const Callbacks heard =
        keepingWarnings(withinMemory(callbacks, memoryLimit(recipe.memoryLimit)), warnings);
    MeasureResult result = withThreads(recipe.threads, [&] {
        Clock clock;
        std::optional<Pack<3>> pack;
        if (isSolid(recipe, pack, heard)) return measureSolid(recipe, std::move(report), heard);
        report.seconds.mesh = clock.lap();
        const auto depthFor = [&](const RadiusStatistics& r) {
            return structureDepth(r, recipe.shell);
        };
        MeasureResult found;
        found.run = measureGiven(
            recipe, std::move(*pack), std::move(report), depthFor, heard,
            [&](const auto& spheres, const auto* domain, const Report& measured) {
                found.structure = measureStructure(spheres, domain, measured, recipe.shell, heard);
                if (recipe.shell > 0 && found.structure.regions.size() == 1)
                    heard.warn(fmt::format(
                        "--shell {:g} mm: nothing of the domain lies deeper; all of it is shell",
                        recipe.shell));
            });
        clock.lap();
        found.run.report.files = std::visit(
            [&](const auto& p) { return writeMeasured(p, recipe, heard); }, found.run.pack);
        found.run.report.seconds.write = clock.lap();
        found.run.report.seconds.total = clock.total();
        return found;
    });
    result.run.report.warnings = std::move(warnings);
    if (!recipe.reportFile.empty()) {
        result.run.report.files.push_back(recipe.reportFile);
        writeReport(result, recipe);
    }
    return result;
}

nlohmann::ordered_json toJson(const MeasureResult& result) {
    if (!result.morphometry) {
        auto json = toJson(result.run);
        addTo(json, result.structure);
        return json;
    }
    const Report& report = result.run.report;
    return {{"version", report.version},
            {"command", report.command},
            {"threads", report.threads},
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
    if (!result.morphometry) return summary(report) + summary(result.structure);
    return summary(*result.morphometry) +
           fmt::format(
               "{:<11}read {:.2f}, domain {:.2f}, measure {:.2f}, total {:.2f} on {} "
               "threads\n{:<11}{:.0f} MiB at most\n",
               "seconds", report.seconds.mesh, report.seconds.domain, report.seconds.measure,
               report.seconds.total, report.threads, "memory",
               static_cast<double>(report.peakMemoryBytes) / (1 << 20));
}

}  // namespace vdbpack
