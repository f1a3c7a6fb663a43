// Private to runs: the stages of a run, in their order. Each command is a list of those that it
// needs; `pack` reads and builds its domain once for all of its runs (`prepare` in run_pack.cpp).
//
//   checkSettings   outputs, report, picture and texts, before anything is read
//   (command)       domain and input pack are read
//   domainStage     estimate of memory and disk space, field, checks against the domain
//   (command)       pack
//   densifyStage    spheres are moved and added
//   cutStage        voids are made, spheres in them removed
//   measureStage    voids, spheres, checks
//   finishStage     outputs, picture, recipe file
//   writeReport     report_file.h
#pragma once

#include "vdbpack/core/clock.h"
#include "vdbpack/core/progress.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/formats/row_spans.h"
#include "vdbpack/pack/local_sizes.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/run.h"
#include "vdbpack/voids/make_voids.h"
#include "vdbpack/voids/void_checks.h"
#include "vdbpack/voids/void_families.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// What voids left of a domain, to be filled with spheres.
template <int Dim>
struct SolidFill {
    DomainSource source;                       ///< the contour of the level set `solid`
    std::shared_ptr<const Domain<Dim>> space;  ///< inside the contour and the domain
};

/// What is known of the spheres of a run.
struct PackFacts {
    std::size_t fixed = 0;     ///< the first spheres are neither moved nor removed
    std::size_t labelled = 0;  ///< the first spheres keep the regions that they came with
    double positionStep = 0;   ///< coordinates are multiples of it, mm; 0: unknown
};

/// The sizes that spheres were packed with, or are compared with.
struct PackSizes {
    SizeDistribution all;
    LocalSizes local{};  ///< what differs by place in them
};

/// The voids of a run.
template <int Dim>
struct RunVoids {
    VoidRecipe recipe{};                            ///< without a method and a shell: none are cut
    double largestRadius = 0;                       ///< of the spheres there are or will be, mm
    std::function<double(const Vec<Dim>&)> bvtv{};  ///< by place; empty: the same everywhere
    ShellThickness shell{};                         ///< by place; uniform: thickness of the recipe
    FoundValues found{};                            ///< for words of the recipe
    MadeVoids<Dim> made{};

    bool areCut() const { return !recipe.empty() || recipe.hasShell(); }
};

/// The share of a rank in the spheres of a run.
template <int Dim>
struct RankShare {
    std::vector<std::int64_t> pieces;  ///< as in PackResult, with the orders of the pack
    std::vector<RowSpan> spans;        ///< rows of the spheres in the pack of all
    Pack<Dim> named;                   ///< spheres of any rank that a check names
};

/// What a run on several parts writes in place of the domain and the solid of one.
struct JoinedParts {
    std::vector<std::shared_ptr<const DomainSource>> sources;  ///< empty: there is one domain
    std::vector<SolidTest> solids;                             ///< what is left of each
    std::vector<std::shared_ptr<const VdbGrid>> levelSets;
    TriangleMesh walls;  ///< all triangles of the files
    TriangleMesh drawn;  ///< what clips leave of these, if a picture is drawn
    PartProperties properties;
};

/// A run under way: what its stages pass on to one another.
template <int Dim>
struct Run {
    /// @param begun    with the warnings so far.
    /// @param limited  callbacks of the caller, within the limit of memory.
    Run(const RunSettings& ofRun, std::shared_ptr<const DomainSource> ofDomain, Report begun,
        const Clock& running, const Callbacks& limited)
        : settings(ofRun),
          source(std::move(ofDomain)),
          report(std::move(begun)),
          clock(running),
          callbacks(keepingWarnings(limited, report.warnings)) {}
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    RunSettings settings;
    std::shared_ptr<const DomainSource> source;
    Report report;
    Clock clock;
    Callbacks callbacks;  ///< of the caller; `report` keeps the warnings
    /// Whether an interrupt ends the run with what is complete; else it throws Interrupted.
    bool keepsPack = false;
    DomainSource::Built built;
    bool hasPack = true;  ///< or voids alone
    Pack<Dim> pack;       ///< over ranks: the share of this one
    PackFacts facts;
    std::optional<PackSizes> sizes;  ///< requested; nothing: none
    RunVoids<Dim> voids;
    std::optional<SolidFill<Dim>> solid;  ///< what the spheres fill; nothing: the domain
    RankShare<Dim> share;                 ///< over ranks
    JoinedParts parts;                    ///< of several parts

    Ranks* ranks() const { return settings.ranks; }
    /// Whether this rank speaks for all.
    bool isFirst() const { return !ranks() || ranks()->isFirst(); }
    const Domain<Dim>& domain() const { return *ofDim<Dim>(built); }
    /// What the spheres fill, and where it comes from.
    const Domain<Dim>& filled() const { return solid ? *solid->space : domain(); }
    const DomainSource& filledSource() const { return solid ? solid->source : *source; }
    bool cuts() const { return voids.areCut(); }
    const SizeDistribution* requested() const { return sizes ? &sizes->all : nullptr; }
    const LocalSizes* local() const {
        return sizes && sizes->local.any() ? &sizes->local : nullptr;
    }
    /// Gap up to which spheres count as connected, as a share of the smaller radius: those that
    /// were densified nearly touch.
    double connectionTolerance() const {
        constexpr double kDensified = 0.01;
        return report.densified ? std::max(settings.contactTolerance, kDensified)
                                : settings.contactTolerance;
    }
    /// Callbacks of a stage that ranks do each for itself: none may end before the others.
    Callbacks own() const {
        Callbacks all = callbacks;
        if (ranks()) all.cancelled = nullptr;
        return all;
    }
    /// Whether to continue with stages that an interrupted run skips. @throws Interrupted
    bool goesOn() {
        if (!report.interrupted && anyOver(ranks(), callbacks.isCancelled())) {
            if (!keepsPack) throw Interrupted();
            report.interrupted = true;
        }
        return !report.interrupted;
    }
    /// Does what an interrupted run does without.
    template <class Work>
    void unlessInterrupted(const Work& work) {
        if (!goesOn()) return;
        try {
            work();
        } catch (const Interrupted&) {
            if (!keepsPack) throw;
            report.interrupted = true;
        }
    }
};

/// What makes voids for a run. @param callbacks  must outlive it.
template <int Dim>
VoidSetting<Dim> voidSetting(const Run<Dim>& run, const Callbacks& callbacks) {
    return {run.voids.recipe,        run.domain(), run.built.sliceHeight, run.settings.seed,
            run.voids.largestRadius, callbacks,    run.ranks(),           run.voids.bvtv,
            run.voids.shell};
}

/// Refuses a name with a word in braces that nothing has replaced. @throws ParameterError
void refuseBraces(const std::string& name);

/// Refuses a list of interfaces, for runs without parts. @throws ParameterError
void refuseInterfaces(const RunSettings& settings);
/// Refuses before the work what would fail after it.
/// @param inputs  files that no output may replace.
/// @throws ParameterError, IoError
void checkSettings(const RunSettings& settings, RunKind kind, const VoidRecipe& voids,
                   const std::vector<std::string>& inputs);

/// Checks what is to be written against the domains of a run, and records their axes in its report.
/// @param sources  one, or the sources of several parts.
/// @param voids    that are cut; only what they leave of a periodic cell has a surface.
/// @param hasPack  whether spheres are read from a file, with columns of its own.
/// @param sizeField  as in a PackRecipe.
/// @throws as `labelGridOf`
void beginOn(const std::vector<const DomainSource*>& sources, const RunSettings& settings,

             const VoidRecipe& voids, Report& report, const Callbacks& callbacks,
             bool hasPack = false, const std::string& sizeField = {});

/// The axes of the world of an image, "LPS" or "RAS"; of other domains empty.
std::string axesOf(const DomainSource& source);

/// Warns of bonds that no output lists.
void warnOfUnusedBonds(const RunSettings& settings, const Callbacks& callbacks);

/// Callbacks whose warnings name a run of several: its seed, and the options that vary.
Callbacks namingRun(const RunSettings& settings, std::uint64_t seed, std::size_t seeds,
                    const Callbacks& callbacks);

/// The head of a report. @param subject  what the run works on.
Report begunReport(const RunSettings& settings, const char* task, const std::string& subject);

/// Builds the field for radii from `detail` to `reach` (mm), if memory and disks suffice for
/// `extent`, and checks that voids and picture suit the domain.
/// @param voxelSize  as in DomainSource::build.
template <int Dim>
void domainStage(Run<Dim>& run, const Extent& extent, double detail, double reach,
                 double voxelSize = 0);

/// Gives voids along the long axis of the domain their direction. @throws as `longAxis`
template <int Dim>
void takeLongAxis(RunVoids<Dim>& voids, const DomainSource& source,
                  const DomainSource::Built& built);

/// @param options  fraction, gap and mixSizes; the others follow from the run.
template <int Dim>
void densifyStage(Run<Dim>& run, DensifyOptions options);
/// Leaves nothing in the pack that tells where the front began (`DensifyOptions::settle`).
template <int Dim>
void settleStage(Run<Dim>& run, double gap, const DeviceChoice& device);

/// What a run leaves of its domain.
SolidTest solidOf(const Run<3>& run);

/// Makes the voids before there are spheres, and what they leave the domain of the spheres.
/// @param detail, reach  radii that its field is made for, mm.
/// @throws InputError if they leave nothing
void solidStage(Run<3>& run, double detail, double reach);

/// @param made  whether the voids were made already.
template <int Dim>
void cutStage(Run<Dim>& run, bool made = false);

/// The rows of the spheres, of a run over ranks, by its spans.
template <int Dim>
SphereRows rowsOf(const Run<Dim>& run);

template <int Dim>
void measureStage(Run<Dim>& run);

/// Writes the outputs, the picture and the recipe file, and takes the result out of the run.
template <int Dim>
RunResult finishStage(Run<Dim>& run);

// Warnings of packs that can hardly be used (pack_warnings.cpp).

/// Warns if contacts connect few of the spheres with one another or, with voids, with the shell.
/// Not of packs with a gap; of densified ones by voids alone.
template <int Dim>
void warnOfLooseSpheres(const Run<Dim>& run);

/// Warns if the spheres fill little of a solid that they are packed into (`Fill::solid`), deeper
/// than the shell: its trabeculae are hardly thicker than they are.
template <int Dim>
void warnOfThinSolid(const Run<Dim>& run);

/// Warns if a pack is nearly empty, because its radii hardly fit into the domain, or if so few of
/// the larger ones did that its radii are not those requested.
/// @param largest  radius, mm.
template <int Dim>
void warnOfSizes(const Run<Dim>& run, double largest);

/// Warns if the `count` spheres that are left of those that were packed are by far not `target`.
/// @param largest  radius, mm; 0: the domain is not asked whether it is too thin.
template <int Dim>
void warnOfCount(const Run<Dim>& run, double target, double count, double largest = 0);

/// Warns if the spheres are larger than the voids that are cut into their pack: BV/TV belongs to
/// the level set, which such a pack cannot show.
template <int Dim>
void warnOfSmallVoids(const Run<Dim>& run);

/// @param before  spheres of the pack (of this rank) before the voids were cut.
/// @throws ParameterError if none of them remains
template <int Dim>
void requireSpheresLeft(const Run<Dim>& run, std::uint64_t before);

// Several runs in one domain.

/// Packs for each of the recipes, which differ in seed and outputs alone; the domain is made once.
/// Interrupted before the first pack, the result is one without spheres.
/// @param done  receives each result and returns whether to continue.
/// @throws as runPack.
void packEach(const std::vector<PackRecipe>& recipes, const Callbacks& callbacks,
              const std::function<bool(RunResult&&)>& done);

/// Voids for each of the recipes, which differ in seed and outputs alone; the domain is read once.
/// @param done  receives each result and returns whether to continue.
/// @throws as runVoids.
void voidsEach(const std::vector<VoidsRecipe>& recipes, const Callbacks& callbacks,
               const std::function<bool(RunResult&&)>& done);

}  // namespace vdbpack
