#include "vdbpack/repair/mesh_repair.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <utility>

namespace vdbpack {

namespace {

/// Ambiguous volumes above this share of the repaired volume cause a warning.
constexpr double kDoubtful = 0.01;

using Method = RepairReport::Method;

/// One thing that a repair did or found.
struct Fact {
    std::string key;  ///< its path in the JSON report
    nlohmann::json value;
    std::string line = {};     ///< for a reader; empty: nothing
    std::string warning = {};  ///< what a user must know; empty: nothing
};

std::string text(const Vec<3>& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p[0], p[1], p[2]);
}

/// "3 holes filled" of "hole{} filled"; empty for none.
std::string counted(std::size_t n, const char* what) {
    if (n == 0) return {};
    return fmt::format("{} ", n) + fmt::format(what, n == 1 ? "" : "s");
}

template <class... Values>
std::string textIf(bool applies, const char* form, const Values&... values) {
    return applies ? fmt::format(form, values...) : std::string();
}
/// A text about a measure; empty where that is 0.
std::string measured(double value, const char* form) {
    return textIf(value > 0, form, value);
}

const char* nameOf(Method method) {
    return method == Method::none        ? "none"
           : method == Method::triangles ? "triangles"
                                         : "resurfaced";
}

/// What the repair did to the triangles, and the volumes that it found.
std::vector<Fact> surfaceFacts(const RepairReport& r) {
    const double doubtful = r.volume > 0 ? r.doubtfulVolume / r.volume : 0;
    const std::string cause =
        r.before.leak ? r.before.describeLeak() : "components that end inside others";
    return {
        {"/method", nameOf(r.method),
         r.method == Method::none        ? "not needed, the mesh is unchanged"
         : r.method == Method::triangles ? "triangles of the file kept"
                                         : ""},
        {"/components", r.components == RepairComponents::separate ? "separate" : "together"},
        {"/before", toJson(r.before)},
        {"/duplicates", r.duplicates, counted(r.duplicates, "duplicate triangle{} removed")},
        {"/turned", r.turned, counted(r.turned, "triangle{} flipped")},
        {"/holesFilled", r.holesFilled, counted(r.holesFilled, "hole{} filled by triangles")},
        {"/filledArea", r.filledArea, measured(r.filledArea, "{:.3g} mm² of triangles added")},
        {"/dropped", r.dropped, counted(r.dropped, "triangle{} inside the solid removed")},
        {"/piecesDropped", r.piecesDropped,
         counted(r.piecesDropped, "component{} of the new surface below ten voxels removed")},
        {"/voxelSize", r.voxelSize > 0 ? nlohmann::json(r.voxelSize) : nlohmann::json(),
         measured(r.voxelSize, "surface remeshed with voxels of {:.3g} mm")},
        {"/bridgedShare", r.bridgedShare,
         textIf(r.bridgedShare > 0, "{:.2g} % of the surface over holes", 100 * r.bridgedShare)},
        {"/thinArea", r.thinArea,
         measured(r.thinArea, "about {:.3g} mm² of walls thinner than a voxel lost")},
        {"/volume", r.volume},
        {"/doubtfulVolume", r.doubtfulVolume,
         fmt::format("ambiguous volume {:.4g} mm³, {:.2g} % of the repaired volume",
                     r.doubtfulVolume, 100 * doubtful),
         textIf(doubtful > kDoubtful,
                "inside and outside are ambiguous for {:.3g} mm³, {:.2g} % of the repaired volume; "
                "the cause: {}",
                r.doubtfulVolume, 100 * doubtful, cause)},
        {"/overlapVolume", r.overlapVolume,
         measured(r.overlapVolume, "{:.4g} mm³ enclosed more than once")},
        {"/invertedVolume", r.invertedVolume,
         measured(r.invertedVolume, "{:.4g} mm³ enclosed by inverted triangles, now outside")}};
}

std::string holesWarning(const RepairReport& r) {
    if (!r.before.leak) return {};
    const BoundaryLoop& largest = r.before.leak->largest;
    return fmt::format(
        "the repair closed {} (loops of boundary edges), the largest {:.4g} mm around at {}. Check "
        "that no opening of the bone is among them",
        counted(r.before.leak->loops, "hole{}"), largest.length, text(largest.center));
}

/// The remedy against fusing. Components that intersect need another mesh.
std::string apartAgain(const RepairReport& r) {
    const std::size_t joins = r.changes->fusedComponents - r.changes->fusedInto;
    const std::size_t pairs = r.before.intersections;
    if (r.components == RepairComponents::separate || pairs >= joins)
        return "They intersect each other: move them apart in the mesh to keep them separate";
    return "Set `repairComponents` separate to keep " +
           (pairs == 0 ? "them apart"
                       : fmt::format("apart all but {} that intersect{}", counted(pairs, "pair{}"),
                                     pairs == 1 ? "s" : ""));
}

std::string fusedWarning(const RepairReport& r) {
    const RepairChanges& c = *r.changes;
    return textIf(
        c.fusedInto > 0,
        "the repair fused {} components into {}; one of them, of {:.4g} mm³, lies about {}. {}",
        c.fusedComponents, c.fusedInto, c.fusedVolume, text(c.fusedAt), apartAgain(r));
}

std::string removedWarning(const RepairChanges& c) {
    if (c.removed + c.fragmentsRemoved == 0) return {};
    const std::string volumes =
        textIf(c.removed > 0, " that enclosed {:.4g} mm³, the largest at {}", c.removedVolume,
               text(c.removedAt));
    return fmt::format(
        "the repair removed {}{}{}{}. They were below ten voxels, inside the solid, or without a "
        "volume; check them, or set a smaller `repairVoxel`",
        counted(c.removed, "surface component{}"), volumes,
        c.removed > 0 && c.fragmentsRemoved > 0 ? ", and " : "",
        counted(c.fragmentsRemoved, "open fragment{}"));
}

/// The numbers of a topology: key and name for a reader. The first three make the solid; holes are
/// closed on purpose.
struct TopologyNumber {
    const char *key, *name;
    std::int64_t SurfaceTopology::*number;
};
constexpr TopologyNumber kTopology[]{
    {"components", "closed components", &SurfaceTopology::components},
    {"cavities", "cavities", &SurfaceTopology::cavities},
    {"handles", "handles", &SurfaceTopology::handles},
    {"holes", "holes", &SurfaceTopology::holes},
    {"fragments", "open fragments", &SurfaceTopology::fragments},
    {"eulerNumber", "Euler number", &SurfaceTopology::eulerNumber}};

/// What became of the components, and of the topology of the surface.
std::vector<Fact> changeFacts(const RepairReport& r) {
    const RepairChanges& c = *r.changes;
    std::vector<Fact> facts{{"/changes/fusedComponents", c.fusedComponents, "", fusedWarning(r)},
                            {"/changes/fusedInto", c.fusedInto},
                            {"/changes/removed", c.removed, "", removedWarning(c)},
                            {"/changes/removedVolume", c.removedVolume},
                            {"/changes/fragmentsRemoved", c.fragmentsRemoved}};
    std::string differences;
    bool warn = false;
    for (const TopologyNumber& n : kTopology) {
        const std::int64_t before = c.before.*n.number, after = c.after.*n.number;
        facts.push_back({std::string("/changes/before/") + n.key, before});
        facts.push_back({std::string("/changes/after/") + n.key, after});
        if (before == after) continue;
        differences +=
            fmt::format("{}{} {}, then {}", differences.empty() ? "" : "; ", n.name, before, after);
        warn = warn || &n < kTopology + 3;
    }
    if (differences.empty()) return facts;
    const std::size_t cuts = r.before.nonManifoldEdges;
    differences = textIf(cuts > 0, ", cut apart at {}", counted(cuts, "non-manifold edge{}")) +
                  ": " + differences;
    facts.back().line = "topology of the surface" + differences;
    if (warn)
        facts.back().warning =
            "the repair changed the topology of the surface" + differences +
            textIf(r.method == Method::resurfaced,
                   "; set a `repairVoxel` smaller than {:.3g} mm to keep more", r.voxelSize);
    return facts;
}

std::vector<Fact> factsOf(const RepairReport& r) {
    std::vector<Fact> facts = surfaceFacts(r);
    facts.push_back(
        {"/holesClosed", r.before.leak ? r.before.leak->loops : 0, "", holesWarning(r)});
    if (!r.changes) return facts;
    for (Fact& fact : changeFacts(r)) facts.push_back(std::move(fact));
    return facts;
}

}  // namespace

nlohmann::json toJson(const RepairReport& report) {
    nlohmann::json json;
    for (Fact& fact : factsOf(report))
        json[nlohmann::json::json_pointer(fact.key)] = std::move(fact.value);
    return json;
}

std::vector<std::string> repairLines(const RepairReport& report) {
    std::vector<std::string> lines;
    for (Fact& fact : factsOf(report)) {
        if (!fact.line.empty()) lines.push_back(std::move(fact.line));
        if (report.method == Method::none) break;
    }
    return lines;
}

std::vector<std::string> repairWarnings(const RepairReport& report, const std::string& name) {
    std::vector<std::string> warnings;
    for (const Fact& fact : factsOf(report))
        if (!fact.warning.empty()) warnings.push_back(name + ": " + fact.warning);
    return warnings;
}

}  // namespace vdbpack
