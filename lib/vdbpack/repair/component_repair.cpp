#include "vdbpack/repair/component_repair.h"

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/mesh/edge_table.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/welding.h"
#include "vdbpack/repair/facing.h"
#include "vdbpack/repair/sheets.h"
#include "vdbpack/repair/solid_relations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
/// Fewer triangles enclose nothing.
constexpr std::size_t kFewest = 4;
/// Points at which the volumes of a component are counted, at least.
constexpr double kFewestPoints = 2000;

/// The component of each triangle. Fragments that enclose nothing are one component.
/// @param mesh  without collapsed triangles, consistently oriented.
std::vector<std::uint32_t> componentOfTriangle(const TriangleMesh& mesh) {
    ShellAnalysis shells = analyzeShells(manifoldOf(mesh));
    DisjointSets sets(shells.shells.size());
    std::vector<std::uint32_t> openAt(mesh.vertices.size(), kNone);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const std::uint32_t s = shells.shellOfTriangle[i];
        if (shells.shells[s].boundaryEdges == 0) continue;
        for (const std::uint32_t v : mesh.triangles[i]) {
            if (openAt[v] == kNone) openAt[v] = s;
            sets.join(openAt[v], s);
        }
    }
    for (auto& s : shells.shellOfTriangle) s = sets.find(s);
    const std::vector<char> closed = nearlyClosed(mesh, shells);
    for (auto& s : shells.shellOfTriangle)
        if (closed[s] == 0) s = kNone;
    return std::move(shells.shellOfTriangle);
}

/// The components of a mesh, in the order of their first triangles.
std::vector<TriangleMesh> componentsOf(const TriangleMesh& mesh, NestedShells nested) {
    TriangleMesh clean;
    clean.vertices = mesh.vertices;
    for (const auto& t : mesh.triangles)
        if (!isCollapsed(t)) clean.triangles.push_back(t);
    TriangleMesh oriented = clean;
    turnOutward(oriented, nested);
    std::vector<std::uint32_t> component = componentOfTriangle(oriented);
    for (auto& c : component)
        if (c == kNone) c = static_cast<std::uint32_t>(component.size());
    std::vector<std::uint32_t> number(component.size() + 1, kNone);
    std::vector<TriangleMesh> parts;
    for (std::size_t i = 0; i < component.size(); ++i) {
        auto& part = number[component[i]];
        if (part == kNone) {
            part = static_cast<std::uint32_t>(parts.size());
            parts.emplace_back();
        }
        parts[part].triangles.push_back(clean.triangles[i]);
    }
    std::vector<std::uint32_t> local(clean.vertices.size(), kNone);
    for (TriangleMesh& part : parts) {
        std::vector<std::uint32_t> used;
        for (auto& t : part.triangles)
            for (auto& v : t) {
                if (local[v] == kNone) {
                    local[v] = static_cast<std::uint32_t>(used.size());
                    used.push_back(v);
                }
                v = local[v];
            }
        for (const std::uint32_t v : used) {
            part.vertices.push_back(clean.vertices[v]);
            local[v] = kNone;
        }
    }
    return parts;
}

/// Adds what a further repair did. @param triangles  of its surface
void add(RepairReport& sum, const RepairReport& part, std::size_t triangles) {
    // A sum over triangles at first.
    sum.bridgedShare += part.bridgedShare * static_cast<double>(triangles);
    sum.method = std::max(sum.method, part.method);
    sum.duplicates += part.duplicates;
    sum.turned += part.turned;
    sum.holesFilled += part.holesFilled;
    sum.filledArea += part.filledArea;
    sum.dropped += part.dropped;
    sum.piecesDropped += part.piecesDropped;
    sum.voxelSize = std::max(sum.voxelSize, part.voxelSize);
    sum.thinArea += part.thinArea;
    sum.doubtfulVolume += part.doubtfulVolume;
    sum.overlapVolume += part.overlapVolume;
    sum.invertedVolume += part.invertedVolume;
}

/// A component that encloses a volume.
struct Part {
    const TriangleMesh* source = nullptr;  ///< its triangles in the file
    std::unique_ptr<Solid> solid;
    RepairReport report;
    std::uint32_t group = 0;  ///< of parts that intersect or lie inside each other
    bool intersects = false;
    std::size_t depth = 0;  ///< number of parts around it
};

/// Sets groups, depths, and whether parts intersect.
void relate(std::vector<Part>& parts) {
    std::vector<std::uint32_t> order(parts.size());
    std::iota(order.begin(), order.end(), std::uint32_t{0});
    const auto lowest = [&](std::uint32_t i) { return parts[i].solid->bounds().lo[0]; };
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t k) {
        return lowest(i) != lowest(k) ? lowest(i) < lowest(k) : i < k;
    });
    DisjointSets groups(parts.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t k = i + 1; k < order.size(); ++k) {
            Part& a = parts[order[i]];
            Part& b = parts[order[k]];
            if (b.solid->bounds().lo[0] > a.solid->bounds().hi[0]) break;
            const SolidRelation relation = relationOf(*a.solid, *b.solid);
            if (relation == SolidRelation::apart) continue;
            groups.join(order[i], order[k]);
            if (relation == SolidRelation::intersect) a.intersects = b.intersects = true;
            a.depth += relation == SolidRelation::inside;
            b.depth += relation == SolidRelation::around;
        }
    for (std::uint32_t i = 0; i < parts.size(); ++i) parts[i].group = groups.find(i);
}

/// What a repair of all components does, step by step.
class ComponentRepair {
public:
    ComponentRepair(const WholeRepairOptions& options, const Callbacks& callbacks)
        : options_(options), callbacks_(callbacks) {}

    WholeRepair run(TriangleMesh mesh, const std::vector<TriangleMesh>& components) {
        result_.report.before = checkMesh(mesh);
        options_.leastVoxelSize = std::sqrt(2 * result_.report.before.area / kMostRemeshed);
        for (std::size_t i = 0; i < components.size(); ++i) {
            const double share = static_cast<double>(i) / static_cast<double>(components.size());
            callbacks_.report("repair", 0.8 * share, 0);
            repairOne(components[i], mesh.triangles.size());
        }
        relate(parts_);
        for (std::uint32_t g = 0; g < parts_.size(); ++g)
            if (parts_[g].group == g) assemble(g);
        RepairReport& report = result_.report;
        report.volume = analyzeShells(result_.mesh).enclosedVolume();
        const auto collapsed =
            static_cast<std::size_t>(std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                                                   [](const auto& t) { return isCollapsed(t); }));
        report.duplicates += collapsed;
        if (removed_ || !report.before.isWatertight() || collapsed > 0)
            report.method = std::max(report.method, kTriangles);
        if (!(report.volume > 0))
            result_.mesh = {};
        else if (report.method == RepairReport::Method::none)
            result_.mesh = std::move(mesh);
        if (!result_.mesh.triangles.empty())
            report.bridgedShare /= static_cast<double>(result_.mesh.triangles.size());
        return std::move(result_);
    }

private:
    static constexpr auto kTriangles = RepairReport::Method::triangles;

    void repairOne(const TriangleMesh& component, std::size_t triangles) {
        if (component.triangles.size() < kFewest) {
            append(result_.oriented, component);
            removed_ = true;
            return;
        }
        WholeRepairOptions options = options_;
        options.volumePoints = std::max(
            kFewestPoints, options_.volumePoints * static_cast<double>(component.triangles.size()) /
                               static_cast<double>(triangles));
        WholeRepair done = repairWhole(component, options, callbacks_);
        append(result_.oriented, done.oriented);
        if (done.mesh.triangles.empty()) {
            removed_ = true;
            return;
        }
        Part part;
        part.source = &component;
        part.solid = std::make_unique<Solid>(std::move(done.mesh));
        part.report = std::move(done.report);
        parts_.push_back(std::move(part));
    }

    /// Adds the parts of a group to the result.
    void assemble(std::uint32_t group) {
        std::vector<Part*> members;
        bool intersects = false;
        for (Part& part : parts_) {
            if (part.group != group) continue;
            members.push_back(&part);
            intersects = intersects || part.intersects;
        }
        if (intersects) return fuse(members);
        for (Part* part : members) {
            if (part->depth > 0 && options_.nested == NestedShells::solid) {
                removed_ = true;
                continue;
            }
            TriangleMesh mesh = part->solid->mesh();
            if (part->depth % 2 == 1) turnInward(*part, mesh);
            append(result_.mesh, mesh);
            add(result_.report, part->report, mesh.triangles.size());
        }
    }

    /// Repairs the triangles of several parts together.
    void fuse(const std::vector<Part*>& members) {
        TriangleMesh together;
        for (const Part* part : members) append(together, *part->source);
        WholeRepair fused = repairWhole(welded(std::move(together)), options_, callbacks_);
        append(result_.mesh, fused.mesh);
        add(result_.report, fused.report, fused.mesh.triangles.size());
        result_.report.method = std::max(result_.report.method, kTriangles);
    }

    /// Turns the wall of a cavity inward, as it may have been in the file.
    static void turnInward(Part& part, TriangleMesh& mesh) {
        for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
        RepairReport& report = part.report;
        report.turned = report.before.triangles - report.duplicates - report.turned;
        const bool asBefore = report.turned + report.duplicates + report.dropped == 0 &&
                              report.holesFilled == 0 && report.before.isWatertight();
        if (report.method != RepairReport::Method::resurfaced)
            report.method = asBefore ? RepairReport::Method::none : kTriangles;
    }

    WholeRepairOptions options_;
    const Callbacks& callbacks_;
    WholeRepair result_;
    std::vector<Part> parts_;
    bool removed_ = false;
};

}  // namespace

WholeRepair repairComponents(TriangleMesh mesh, const WholeRepairOptions& options,
                             const Callbacks& callbacks) {
    const std::vector<TriangleMesh> components = componentsOf(mesh, options.nested);
    if (components.size() < 2) return repairWhole(std::move(mesh), options, callbacks);
    return ComponentRepair(options, callbacks).run(std::move(mesh), components);
}

}  // namespace vdbpack
