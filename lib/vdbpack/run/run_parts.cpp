#include "vdbpack/run/run_parts.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/preview/drawn_wall.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/run/interfaces.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/run/shared_radii.h"
#include "vdbpack/verify/overlap.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// The packs of all parts.
struct PackedParts {
    std::vector<std::unique_ptr<Run<3>>> runs;  ///< null: interrupted before
    bool interrupted = false;
    double measuring = 0;  ///< seconds
    double searching = 0;  ///< seconds of rounds that are not kept
    std::string chosen;    ///< radii that were found for all
    Clock clock{};
};

/// Removes the sentence about the radii of one part: `packToTarget` states the radii of all parts.
void forgetShare(Report& report) {
    auto& chosen = report.chosen;
    chosen.erase(std::remove_if(chosen.begin(), chosen.end(),
                                [](const std::string& text) {
                                    return text.find(", for about ") != std::string::npos;
                                }),
                 chosen.end());
}

PackedParts packInTurn(SharedRadii& radii, Parts& parts, const Report& begun, const Clock& clock,
                       const Callbacks& callbacks) {
    PackedParts packed;
    packed.runs.resize(parts.size());
    packed.clock = clock;
    for (const std::size_t k : radii.order()) {
        if (packed.interrupted) break;
        PackRecipe& recipe = parts[k].recipe;
        radii.prepare(recipe, k);
        Callbacks own = callbacks;
        // Where radii are sought, only the round that is kept warns.
        own.warning = [&](const std::string& text) {
            if (!(radii.target() > 0)) callbacks.warn(recipe.name + ": " + text);
        };
        try {
            packed.runs[k] = packPart(recipe, parts[k].source, begun, packed.clock, own);
        } catch (const Interrupted&) {
            if (k == radii.order().front()) throw;  // none is complete
            packed.interrupted = true;
            break;
        } catch (const InputError& error) {
            throw withPart(parts[k], error);
        }
        const Run<3>& run = *packed.runs[k];
        packed.clock = run.clock;
        packed.measuring += packed.clock.lap();
        if (radii.leads(k)) forgetShare(packed.runs[k]->report);
        radii.take(run.sizes->all, k);
        packed.interrupted = run.report.interrupted;
    }
    return packed;
}

/// Seconds of a round that is not kept.
double secondsOf(const PackedParts& packed) {
    double sum = packed.measuring + packed.searching;
    for (const auto& run : packed.runs)
        if (run) {
            const Report::Seconds& s = run->report.seconds;
            sum += s.domain + s.pack + s.settle + s.densify + s.voids;
        }
    return sum;
}

/// All parts, again with scaled radii until about the target count is met.
PackedParts packToTarget(SharedRadii& radii, Parts& parts, const Report& begun, const Clock& clock,
                         const Callbacks& callbacks) {
    constexpr int kMostRounds = 5;
    constexpr double kNear = 0.018;
    const double target = radii.target();
    const auto miss = [&](const PackedParts& p) { return std::fabs(radii.count(p.runs) - target); };
    PackedParts best = packInTurn(radii, parts, begun, clock, callbacks);
    if (!(target > 0)) return best;
    best.chosen = radii.chosen();
    double count = radii.count(best.runs);
    for (int round = 1; round < kMostRounds && count > 0 && !best.interrupted; ++round) {
        if (miss(best) <= std::max(kNear * target, 0.5)) break;
        radii.scaleFor(count);
        try {
            PackedParts next = packInTurn(radii, parts, begun, best.clock, callbacks);
            best.clock = next.clock;
            best.interrupted = next.interrupted;
            if (next.interrupted) break;
            count = radii.count(next.runs);
            next.chosen = radii.chosen();
            if (miss(next) < miss(best)) std::swap(best, next);
            best.searching += secondsOf(next);
        } catch (const Interrupted&) {
            best.interrupted = true;
        }
    }
    for (const std::size_t k : radii.order()) {
        if (!best.runs[k]) continue;
        const auto& warnings = best.runs[k]->report.warnings;
        for (std::size_t w = begun.warnings.size(); w < warnings.size(); ++w)
            callbacks.warn(parts[k].recipe.name + ": " + warnings[w]);
    }
    return best;
}

/// Puts the figures of all parts together in one report.
class JoinedReport {
public:
    JoinedReport(Report& all, std::size_t begun) : all_(all), begun_(begun) {
        all_.domain = {};
        all_.domain.kind = "parts";
        all_.protrusion = ProtrusionCheck{};
    }
    /// @param firstSphere  of the part in the pack of all.
    void add(const Run<3>& run, const PackRecipe& recipe, std::size_t firstSphere) {
        const Report& r = run.report;
        const PartReport& one = all_.parts.emplace_back(partReport(r, recipe));
        all_.count += r.count;
        all_.hash += r.hash;
        all_.volume += r.volume;
        all_.area += r.area;
        addDomain(r.domain);
        covered_ += one.solidFraction * r.volume;
        if (const double deep = 3 * r.radius.max;
            one.interior && deep <= run.filled().fieldDepth()) {
            const double volume = run.filled().volumeDeeperThan(deep);
            deepCovered_ += *one.interior * volume;
            deepVolume_ += volume;
        }
        if (r.protrusion) {
            ProtrusionCheck own = *r.protrusion;
            for (ProtrudingSphere& sphere : own.worst) sphere.i += firstSphere;
            all_.protrusion = joined(*all_.protrusion, own);
        }
        all_.interrupted = all_.interrupted || r.interrupted;
        all_.requestedGap = std::max(all_.requestedGap, r.requestedGap);
        for (FoundValue found : r.found) {
            found.part = recipe.name;
            all_.found.push_back(std::move(found));
        }
        for (const std::string& text : r.chosen) chosen_[text].push_back(recipe.name);
        // The first ones were there before.
        for (std::size_t w = begun_; w < r.warnings.size(); ++w)
            all_.warnings.push_back(recipe.name + ": " + r.warnings[w]);
        addSeconds(r.seconds);
    }
    void finish() {
        if (all_.volume > 0) all_.solidFractionTotal = covered_ / all_.volume;
        if (deepVolume_ > 0) all_.solidFractionInterior = deepCovered_ / deepVolume_;
        const auto& first = all_.parts.front().requested;
        const bool same = std::all_of(all_.parts.begin(), all_.parts.end(),
                                      [&](const PartReport& p) { return p.requested == first; });
        all_.requested = same ? first : "by part";
        for (const auto& [text, names] : chosen_)
            all_.chosen.push_back(names.size() == all_.parts.size()
                                      ? text
                                      : fmt::format("{}: {}", fmt::join(names, ", "), text));
    }

private:
    static PartReport partReport(const Report& r, const PackRecipe& recipe) {
        PartReport one;
        one.name = recipe.name;
        one.source = describe(recipe.domain);
        one.requested = r.requested;
        one.count = r.count;
        one.volume = r.volume;
        one.area = r.area;
        one.solidFraction = r.solidFractionTotal.value_or(0);
        one.interior = r.solidFractionInterior;
        if (r.voids) one.bvtv = r.voids->bvtv;
        one.ks = r.ks;
        if (r.protrusion) one.protrusion = r.protrusion->max;
        const SphereDensity density = particleDensity(recipe.density, r.solidFractionTotal);
        one.density = density.all;
        one.densities = density.ofRegions;
        return one;
    }
    void addDomain(const DomainFacts& domain) {
        all_.domain.triangles += domain.triangles;
        all_.domain.meshVolume += domain.meshVolume;
        all_.domain.activeVoxels += domain.activeVoxels;
        all_.domain.boundaryEdges += domain.boundaryEdges;
        all_.domain.nonManifoldEdges += domain.nonManifoldEdges;
        all_.domain.voxelSize = std::max(all_.domain.voxelSize, domain.voxelSize);
    }
    void addSeconds(const Report::Seconds& s) {
        all_.seconds.domain += s.domain;
        all_.seconds.pack += s.pack;
        all_.seconds.settle += s.settle;
        all_.seconds.densify += s.densify;
        all_.seconds.voids += s.voids;
    }

    Report& all_;
    std::size_t begun_;  ///< warnings that each part begins with
    double covered_ = 0, deepCovered_ = 0, deepVolume_ = 0;
    std::map<std::string, std::vector<std::string>> chosen_;  ///< parts by what was chosen for them
};

/// Grids of a part under the part's name.
void addLevelSets(const Run<3>& part, const std::string& name, JoinedParts& all) {
    auto grids = part.voids.made.levelSets();
    if (grids.empty() && part.built.mesh) {
        all.levelSets.push_back(renamed(*part.built.mesh->grid(), name));
        return;
    }
    for (const auto& grid : grids)
        all.levelSets.push_back(renamed(*grid, name + " " + levelSetName(*grid)));
}

/// Says what later parts have of a part; a warning where one of them is larger than the part.
void noteLoss(const Parts& parts, std::size_t k, Run<3>& all) {
    constexpr double kNoted = 0.01, kMuch = 0.1;
    const DomainSource& source = *parts[k].source;
    const double own = source.left(false).volume, lost = 1 - source.left().volume / own;
    if (!(lost > kNoted)) return;
    const std::string text = fmt::format("{}: {:.2g} % of its volume left to later parts",
                                         parts[k].recipe.name, 100 * lost);
    for (std::size_t l = k + 1; l < parts.size(); ++l) {
        const DomainSource& later = *parts[l].source;
        if (lost < kMuch || later.left(false).volume < own ||
            intersection(source.domainBounds(), later.domainBounds()).empty())
            continue;
        all.callbacks.warn(fmt::format(
            "{}, such as {}, which is larger: if {} shall have the space, list it after {}", text,
            parts[l].recipe.name, parts[k].recipe.name, parts[l].recipe.name));
        return;
    }
    all.report.chosen.push_back(text);
}

/// Joins the packs, their reports and what they leave of their domains.
void joinParts(const Parts& parts, PackedParts& packed, std::size_t warnings, Run<3>& all) {
    JoinedReport joined(all.report, warnings);
    double step = std::numeric_limits<double>::infinity();  // 0: any position
    for (std::size_t k = 0; k < parts.size(); ++k) {
        if (!packed.runs[k]) continue;
        Run<3>& run = *packed.runs[k];
        const DomainSource& source = *parts[k].source;
        const std::string& name = parts[k].recipe.name;
        joined.add(run, parts[k].recipe, all.pack.spheres.size());
        noteLoss(parts, k, all);
        appendPart(all.pack, std::move(run.pack), static_cast<std::int32_t>(k));
        step = std::min(step, run.facts.positionStep);
        addLevelSets(run, name, all.parts);
        if (const auto& mesh = source.mesh()) append(all.parts.walls, *mesh);
        if (!all.settings.preview.file.empty() || isPage(all.settings.reportFile))
            append(all.parts.drawn, *WallMesh(source, run.built, nullptr).get());
        all.parts.sources.push_back(parts[k].source);
        all.parts.solids.push_back(solidOf(run));
    }
    std::vector<std::string> names;
    for (const Part& part : parts) names.push_back(part.recipe.name);
    setPartNames(all.pack, std::move(names));
    all.facts.positionStep = step;
    joined.finish();
    all.report.interrupted = packed.interrupted;
}

/// Contacts and overlaps, also between parts.
void measureJoined(Run<3>& all) {
    Report& report = all.report;
    const std::vector<Sphere<3>>& spheres = all.pack.spheres;
    const double tolerance = all.settings.contactTolerance;
    report.dim = 3;
    report.seed = all.settings.seed;
    report.radius = radiusStatistics(spheres);
    report.overlap = checkOverlap(spheres);
    report.contactTolerance = tolerance;
    if (report.interrupted) return;
    if (report.count > 0) {
        ContactCheck contacts = countContacts(spheres, tolerance, all.pack.depth);
        all.pack.contacts = std::move(contacts.counts);
        report.contacts = contacts;
        report.contactsBetweenParts = contactsBetweenParts(all.pack, tolerance);
        report.smallestGap = smallestGap(spheres);
    }
}

/// The densities and moduli that parts have of their own.
void setProperties(const Parts& parts, const PackedParts& packed, Run<3>& all) {
    constexpr double kHarderThanBone = 3e4;  // MPa
    const std::string& modulus = all.settings.grey.modulus;
    const Materials materials(all.pack);
    const bool anyImage = std::any_of(parts.begin(), parts.end(),
                                      [](const Part& part) { return isImage(part.recipe.domain); });
    for (std::size_t k = 0; k < parts.size(); ++k) {
        if (!packed.runs[k]) continue;
        const auto number = static_cast<std::int32_t>(k);
        const PackRecipe& part = parts[k].recipe;
        double own = 0;
        if (part.density.empty() && !all.settings.grey.calibration.empty() &&
            parseNumber(part.grey.modulus, own) && own > kHarderThanBone)
            all.callbacks.warn(fmt::format(
                "{}: its density follows from the grey values, but no bone has its `modulus` {}; "
                "set `density` in the part to the density of its material, kg/m³",
                part.name, part.grey.modulus));
        const bool sharesModulus = part.grey.modulus.empty() || part.grey.modulus == modulus;
        if (part.density.empty() && sharesModulus && anyImage && !isImage(part.domain) &&
            !all.settings.grey.calibration.empty())
            all.callbacks.warn(part.name +
                               ": has the densities of the grey values where it is, as bone has; "
                               "if it is an implant, set `density` and `modulus` in the part");
        if (!sharesModulus)
            all.parts.properties.modulus[number] = part.grey.modulus;
        else if (!part.density.empty() && !modulus.empty())
            all.callbacks.warn(fmt::format(
                "{}: its modulus follows from `modulus` {} and its density; set `modulus` in the "
                "part to the modulus of its material, MPa",
                part.name, modulus));
        const SphereDensity density =
            particleDensity(part.density, packed.runs[k]->report.solidFractionTotal);
        warnOfDensity(part.density, part.name, all.callbacks);
        const bool hasRegions =
            materials.withoutClass(number, 0) != materials.withoutClass(number, 1);
        for (const std::int32_t region : {0, 1}) {
            if (region == 1 && !hasRegions) continue;
            const auto found = density.ofRegions.find(region);
            const double value = found != density.ofRegions.end() ? found->second : density.all;
            if (value > 0)
                all.parts.properties.density[materials.withoutClass(number, region)] = value;
        }
    }
}

/// Refuses a cut that misses the parts.
void checkCut(const PackRecipe& recipe, const std::vector<const DomainSource*>& sources) {
    if (!recipe.preview.cut) return;
    Box<3> box;
    for (const DomainSource* source : sources) {
        box.add(source->domainBounds().lo);
        box.add(source->domainBounds().hi);
    }
    checkPreviewCut(*recipe.preview.cut, box);
}

}  // namespace

RunResult packParts(const PackRecipe& recipe, Parts parts, const Report& begun, Clock clock,
                    const Callbacks& callbacks) {
    std::vector<const DomainSource*> sources;
    for (const Part& part : parts) sources.push_back(part.source.get());
    Report first = begun;
    beginOn(sources, recipe, recipe.voids, first, callbacks, false, recipe.sizeField);
    checkCut(recipe, sources);
    SharedRadii radii(recipe, parts);
    PackedParts packed = packToTarget(radii, parts, begun, clock, callbacks);
    Run<3> all(recipe, parts.front().source, first, packed.clock, callbacks);
    all.keepsPack = true;
    radii.warnOfUnused(recipe, all.callbacks);
    joinParts(parts, packed, begun.warnings.size(), all);
    // Whatever is filled is the first part's for what needs one domain, such as a picture's frame.
    all.built = packed.runs[radii.order().front()]->built;
    all.built.mesh = nullptr;
    all.report.seconds.measure = packed.measuring;
    all.report.seconds.pack += packed.searching;
    if (!packed.chosen.empty()) all.report.chosen.push_back(packed.chosen);
    warnOfCount(all, radii.target(), radii.count(packed.runs));
    measureJoined(all);
    measureInterfaces(parts, all);
    setProperties(parts, packed, all);
    PageDetails details;
    if (isPage(recipe.reportFile)) details.radii = radiiOf(all.pack, 0, nullptr);
    RunResult result = finishStage(all);
    writeReport(result, recipe.partsFile.empty() ? recipe.domain.source : recipe.partsFile, recipe,
                details);
    return result;
}

}  // namespace vdbpack
