// Private to runs: packs that are read, and the runs that work on them.
#pragma once

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/report/found_value.h"
#include "vdbpack/report/measured_pack.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/view/pack_view.h"

#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

/// The spheres of a run's pack; warns of shared ids and of a size that is unlikely for a bone.
/// @throws as readPack; InputError if there are none
Pack<3> readInputPack(const InputPack& recipe, const Callbacks& callbacks);

/// The same, or nothing if the file is a solid: a mesh, or a .vdb of level sets.
std::optional<Pack<3>> readInputPackUnlessSolid(const InputPack& recipe,
                                                const Callbacks& callbacks);

/// Refuses settings of a domain that is not there. @throws ParameterError
/// @param ofFile  whether unit, scale and repair belong to the file itself, a solid.
void requireDomain(const InputPack& recipe, bool ofFile = false);

/// Refuses a pack of parts of which one protrudes from the domain: its walls are others.
/// @param setting  that the run that packs the parts takes instead. @throws InputError
template <int Dim>
void requireOneBody(const Pack<Dim>& pack, const Domain<Dim>& domain, const std::string& file,
                    const char* setting);

/// The domain of a pack: that of the recipe, or else the periodic cell that its file states.
DomainRecipe domainOf(const InputPack& recipe, const Pack<3>& pack);

/// The domain of a pack, read; nothing if `recipe` names none.
/// @throws as DomainSource; ParameterError for one of another dimension than `dim`
std::optional<DomainSource> domainAround(const DomainRecipe& recipe, int dim,
                                         const Callbacks& callbacks);

/// Refuses a domain that is read in other axes than those that the file of a pack states.
/// @throws InputError
void requireSameAxes(const std::string& file, const PackOrigin& origin, const DomainSource& source);

/// Warns where pairs are listed up to smaller gaps than those with which the pack's own contacts
/// were counted.
void warnOfTolerance(const std::string& file, const PackOrigin& origin, const BondOptions& options,
                     const Callbacks& callbacks);

template <int Dim>
std::vector<Vec<Dim>> centersOf(const Pack<Dim>& pack) {
    std::vector<Vec<Dim>> centers;
    for (const auto& s : pack.spheres) centers.push_back(s.center);
    return centers;
}

/// Warns of a domain that is another body's than the spheres': centers lie outside of it.
/// @return whether it did
/// @param parts  names of the parts that they are all of; empty: of any.
bool warnOfOutside(std::uint64_t outside, std::size_t count, const std::string& domain,
                   const Callbacks& callbacks, const std::string& parts = {});
/// @param depths  signed distances of all centers.
bool warnOfOutside(const std::vector<double>& depths, const PackAttributes& pack,
                   const std::string& domain, const Callbacks& callbacks);

/// Warns of spheres at one height in a domain of space.
void warnOfPlane(const std::string& file, const Pack<3>& pack, const Callbacks& callbacks);

/// Builds the domain of a pack of so many spheres, if there is one and memory suffices.
/// @param reach  as in DomainSource::build. @throws ResourceError, and as DomainSource::build
DomainSource::Built buildAround(const std::optional<DomainSource>& source, int dim,
                                const RadiusStatistics& radius, std::size_t count, double reach,
                                const RunSettings& settings, const Callbacks& callbacks);

/// The files that a run on a pack reads.
std::vector<std::string> inputFiles(const InputPack& recipe);

/// Reads pack and domain, with the tolerance between parts that the pack states unless `recipe`
/// sets one, and returns what `stages(run)` makes of the run of their dimension.
/// @param voids  that will be cut; without a method, none are.
template <class Stages>
RunResult runOnInputPack(const InputPack& recipe, const char* task, const VoidRecipe& voids,
                         const Callbacks& caller, const Stages& stages) {
    const Callbacks limited = withinMemory(caller, recipe.memoryLimit);
    Report report = begunReport(recipe, task, recipe.pack);
    report.seed = recipe.seed;
    return withThreads(recipe.threads, [&] {
        Clock clock;
        const Callbacks heard = keepingWarnings(limited, report.warnings);
        const Pack<3> pack = readInputPack(recipe, heard);
        const DomainRecipe domain = domainOf(recipe, pack);
        if (domain.source.empty())
            throw ParameterError("the spheres lie in a domain; set the `domain` of the pack");
        const auto source = std::make_shared<const DomainSource>(domain, heard);
        report.seconds.mesh = clock.lap();
        requireSameAxes(recipe.pack, pack.origin, *source);
        beginOn({source.get()}, recipe, voids, report, heard, true);
        RunSettings settings = recipe;
        if (!(settings.bonds.interfaceTolerance > 0))
            settings.bonds.interfaceTolerance = pack.origin.interfaceTolerance;
        warnOfTolerance(recipe.pack, pack.origin, bondOptionsOf(settings), heard);
        if (report.axes.empty()) report.axes = pack.origin.axes;
        warnOfUnused(domain, *source, heard);
        checkOutputKinds(recipe.outputs, RunKind::pack, voids, source->dim());
        if (source->dim() == 2) {
            Run<2> run(settings, source, report, clock, limited);
            run.pack = asCircles(pack);
            return stages(run);
        }
        warnOfPlane(recipe.pack, pack, heard);
        Run<3> run(settings, source, report, clock, limited);
        run.pack = pack;
        return stages(run);
    });
}

/// Reads the domain of a pack and takes the measures that every report has; then calls
/// `further(pack, domain or null, report)`.
/// @param inSpace   spheres at one height are no circles, either.
/// @param depthFor  depth up to which the field must know distances for such radii, mm.
template <class Further>
RunResult measureInputPack(const InputPack& recipe, Pack<3> given, Report report,
                           const std::function<double(const RadiusStatistics&)>& depthFor,
                           const Callbacks& callbacks, const Further& further,
                           bool inSpace = false) {
    Clock clock;
    requireDomain(recipe);
    std::optional<DomainSource> source;
    if (DomainRecipe domain = domainOf(recipe, given); !domain.source.empty()) {
        source.emplace(domain, callbacks);
        requireSameAxes(recipe.pack, given.origin, *source);
        domain.voxelSize = 0;  // `measure` also takes voxels of spheres from it
        warnOfUnused(domain, *source, callbacks);
        addThreshold(report.found, source->recipe());
        warnOfUnusedSpacing(recipe.outputs, {&*source}, callbacks);
    }
    report.axes = source && source->imageGrid() ? axesOf(*source) : given.origin.axes;
    report.seconds.mesh += clock.lap();
    RunResult run;
    const auto measure = [&](auto& pack, auto dim) {
        constexpr int Dim = decltype(dim)::value;
        const std::optional<SizeDistribution> sizes = recipe.sizes(Dim);
        const auto radius = radiusStatistics(pack.spheres);
        const auto built = buildAround(source, Dim, radius, pack.spheres.size(),
                                       depthFor(radius) / 3, recipe, callbacks);
        report.seconds.domain = clock.lap();
        const Domain<Dim>* domain = ofDim<Dim>(built).get();
        if (domain) warnOfOtherCell(recipe.pack, pack.cell, recipe.domain, *domain, callbacks);
        measurePack(pack, source ? &*source : nullptr, domain, sizes ? &*sizes : nullptr,
                    recipe.contactTolerance, report, callbacks);
        if (report.interrupted) throw Interrupted();
        warnOfUnion(recipe.pack, pack, report, callbacks);
        further(pack, domain, report);
        report.seconds.measure = clock.lap();
        if (isPage(recipe.reportFile)) {
            const DomainSource* wall = source ? &*source : nullptr;
            run.picture = drawPack(recipe.preview, recipe.pack, pack, wall, built, callbacks);
            addView(recipe.preview, wall, built, pack, nullptr, false, run.picture);
        }
    };
    const bool plane = isPlane(given);
    if (source && source->dim() == 3) warnOfPlane(recipe.pack, given, callbacks);
    if (!source && plane && !inSpace)
        callbacks.warn(recipe.pack +
                       ": all its spheres lie at one height and are measured as circles of a "
                       "plane. Set `domain` to a box around them to measure them as spheres");
    if (source ? source->dim() == 2 : plane && !inSpace) {
        Pack<2> circles = asCircles(given);
        measure(circles, std::integral_constant<int, 2>());
        run.pack = std::move(circles);
    } else {
        measure(given, std::integral_constant<int, 3>());
        run.pack = std::move(given);
    }
    report.seconds.total = clock.total();
    report.peakMemoryBytes = peakMemory();
    run.passed = !failedChecks(report).any();
    run.report = std::move(report);
    return run;
}

}  // namespace vdbpack
