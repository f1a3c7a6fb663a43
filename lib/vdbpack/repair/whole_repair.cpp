#include "vdbpack/repair/whole_repair.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/mesh/edge_table.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/repair/facing.h"
#include "vdbpack/repair/hole_filling.h"
#include "vdbpack/repair/resurface.h"
#include "vdbpack/repair/sheets.h"
#include "vdbpack/repair/winding_number.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// The triangles of the file are kept if the winding numbers with and without filled holes agree on
/// at least this share of the area.
constexpr double kAgreement = 0.995;
/// Loose triangles have points behind them where the winding number happens to be 1/2: less than
/// this share of their bounds.
constexpr double kNothing = 1e-3;
/// Buried triangles are kept if their share of the area is no more than this: a surface folded in a
/// few positions has some.
constexpr double kFolded = 1e-4;
/// Components of a remeshed surface with a smaller volume are removed, in voxels.
constexpr double kLeastComponent = 10;
/// Volumes of components that are flat up to rounding, compared with the cube of the extent.
constexpr double kFlatVolume = 1e-15;

/// Whether as many triangles pass each edge in one direction as in the other.
bool isBalanced(const TriangleMesh& mesh) {
    bool balanced = true;
    const EdgeTable edges(mesh);
    edges.forEach(
        [&](std::uint32_t, std::uint32_t, const EdgeTable::Use* first, const EdgeTable::Use* last) {
            balanced = balanced && edges.surplus(first, last) == 0;
        });
    return balanced;
}

/// Winding numbers of a mesh: of a balanced one, whole numbers counted along lines, which takes a
/// fraction of the time of generalized ones.
class Windings {
public:
    explicit Windings(const TriangleMesh& mesh) {
        if (isBalanced(mesh))
            counted_.emplace(mesh, true);
        else
            general_.emplace(mesh);
    }
    double operator()(const Vec<3>& x) const {
        return counted_ ? counted_->winding(x) : (*general_)(x);
    }
    const WindingNumber& general(const TriangleMesh& mesh) {
        if (!general_) general_.emplace(mesh);
        return *general_;
    }

private:
    std::optional<MeshSides> counted_;
    std::optional<WindingNumber> general_;
};

/// Which triangles of a mesh are buried: both their sides are inside, or both outside.
struct Buried {
    std::vector<char> is;
    double area = 0, buriedArea = 0;
    double agreeing = 0, checked = 0;  // areas; agreeing: as the winding number of the open mesh
};

/// Computes winding numbers on both sides of each triangle of `filled`. `open` has only the first
/// `own` triangles; null: it has all.
Buried findBuried(const TriangleMesh& filled, std::size_t own, const Windings& winding,
                  const Windings* open) {
    const std::size_t n = filled.triangles.size();
    Buried buried;
    buried.is.resize(n, 0);
    struct Sum {
        double area = 0;
        bool agrees = true;
    };
    std::vector<Sum> sums(n);
    parallelFor(IndexRange(0, n, 256), [&](const auto& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
            const auto& t = filled.triangles[i];
            const Vec<3>& a = filled.vertices[t[0]];
            const Vec<3>& b = filled.vertices[t[1]];
            const Vec<3>& c = filled.vertices[t[2]];
            const Vec<3> normal = cross(b - a, c - a);
            const double twice = length(normal);
            const double longest =
                std::max({squaredLength(b - a), squaredLength(c - b), squaredLength(a - c)});
            if (!(twice > 1e-6 * longest)) continue;  // flat: part of its neighbors' edges
            // Close compared with the triangle's height, far compared with rounding.
            const Vec<3> aside = normal * (1e-3 / std::sqrt(longest));
            const Vec<3> center = (a + b + c) * (1.0 / 3);
            const bool back = winding(center - aside) >= 0.5;
            const bool front = winding(center + aside) >= 0.5;
            buried.is[i] = back == front;
            sums[i].area = 0.5 * twice;
            if (open != nullptr && i < own)
                sums[i].agrees = back == ((*open)(center - aside) >= 0.5) &&
                                 front == ((*open)(center + aside) >= 0.5);
        }
    });
    for (std::size_t i = 0; i < n; ++i) {
        buried.area += sums[i].area;
        if (buried.is[i] != 0) buried.buriedArea += sums[i].area;
        if (i >= own) continue;
        buried.checked += sums[i].area;
        if (sums[i].agrees) buried.agreeing += sums[i].area;
    }
    return buried;
}

/// Removes vertices that no triangle uses.
void dropUnusedVertices(TriangleMesh& mesh) {
    constexpr auto kUnused = static_cast<std::uint32_t>(-1);
    std::vector<std::uint32_t> number(mesh.vertices.size(), kUnused);
    std::vector<Vec<3>> kept;
    for (auto& t : mesh.triangles)
        for (auto& v : t) {
            if (number[v] == kUnused) {
                number[v] = static_cast<std::uint32_t>(kept.size());
                kept.push_back(mesh.vertices[v]);
            }
            v = number[v];
        }
    mesh.vertices = std::move(kept);
}

/// The triangles of `filled` that are not buried; nothing if they form no closed surface.
std::optional<TriangleMesh> wallsOf(const TriangleMesh& filled, const Buried& buried,
                                    std::size_t& dropped) {
    TriangleMesh mesh;
    mesh.vertices = filled.vertices;
    dropped = 0;
    const bool folds = buried.buriedArea <= kFolded * buried.area;
    for (std::size_t i = 0; i < filled.triangles.size(); ++i)
        if (buried.is[i] != 0 && !folds)
            ++dropped;
        else
            mesh.triangles.push_back(filled.triangles[i]);
    if (mesh.triangles.empty() || !isBalanced(mesh)) return std::nullopt;
    partSheets(mesh);
    dropUnusedVertices(mesh);
    const MeshHealth health = checkMesh(mesh);
    if (!health.isWatertight() || health.inconsistentEdges > 0 || !(health.signedVolume > 0) ||
        std::fabs(health.signedVolume - health.enclosedVolume) > 1e-9 * health.enclosedVolume)
        return std::nullopt;
    return mesh;
}

/// Measures the ambiguous, overlapping and inverted volumes by winding numbers on a lattice.
/// @return share of its points that are inside.
double measureDoubt(const TriangleMesh& mesh, const Windings& winding, double points,
                    RepairReport& report) {
    const Box<3> box = mesh.bounds();
    const Vec<3> size = box.size();
    const double longest = *std::max_element(size.c.begin(), size.c.end());
    const double step = std::max(std::cbrt(size[0] * size[1] * size[2] / points), longest * 1e-3);
    std::array<int, 3> count;
    for (int d = 0; d < 3; ++d)
        count[static_cast<std::size_t>(d)] = std::max(1, static_cast<int>(size[d] / step + 0.5));
    std::vector<std::array<std::uint64_t, 4>> sums(static_cast<std::size_t>(count[2]),
                                                   {{0, 0, 0, 0}});
    parallelFor(0, count[2], [&](int k) {
        auto& sum = sums[static_cast<std::size_t>(k)];
        for (int j = 0; j < count[1]; ++j)
            for (int i = 0; i < count[0]; ++i) {
                const Vec<3> x{{box.lo[0] + (i + 0.5) / count[0] * size[0],
                                box.lo[1] + (j + 0.5) / count[1] * size[1],
                                box.lo[2] + (k + 0.5) / count[2] * size[2]}};
                const double w = winding(x);
                const double off = std::fabs(w - 0.5);
                sum[0] += off < 0.25;
                sum[1] += w > 1.5;
                sum[2] += w < -0.5;
                sum[3] += w >= 0.5;
            }
    });
    const double cell =
        size[0] * size[1] * size[2] / (static_cast<double>(count[0]) * count[1] * count[2]);
    std::uint64_t inside = 0;
    for (const auto& sum : sums) {
        inside += sum[3];
        report.doubtfulVolume += cell * static_cast<double>(sum[0]);
        report.overlapVolume += cell * static_cast<double>(sum[1]);
        report.invertedVolume += cell * static_cast<double>(sum[2]);
    }
    return static_cast<double>(inside) / (static_cast<double>(count[0]) * count[1] * count[2]);
}

/// Whether a component of the surface has an inside of its own.
bool anyNearlyClosed(const TriangleMesh& mesh) {
    const std::vector<char> closed = nearlyClosed(mesh, analyzeShells(mesh));
    return std::find(closed.begin(), closed.end(), char{1}) != closed.end();
}

/// Removes components, and cavities, of less than `least` mm³.
std::size_t dropSmallComponents(TriangleMesh& mesh, double least) {
    const ShellAnalysis shells = analyzeShells(mesh);
    std::size_t dropped = 0;
    for (const Shell& shell : shells.shells) dropped += std::fabs(shell.signedVolume) < least;
    if (dropped == 0) return 0;
    TriangleMesh kept;
    kept.vertices = std::move(mesh.vertices);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (std::fabs(shells.shells[shells.shellOfTriangle[i]].signedVolume) >= least)
            kept.triangles.push_back(mesh.triangles[i]);
    mesh = std::move(kept);
    dropUnusedVertices(mesh);
    return dropped;
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Turns the triangles of closed components that lie in no other and face inward.
/// @return the number of these triangles.
std::size_t turnOutermost(TriangleMesh& mesh) {
    const ShellAnalysis shells = analyzeShells(mesh);
    std::size_t turned = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Shell& shell = shells.shells[shells.shellOfTriangle[i]];
        if (shell.depth != 0 || shell.boundaryEdges != 0 || !(shell.signedVolume < 0)) continue;
        std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
        ++turned;
    }
    return turned;
}

/// Where copies are the walls that solids have in common, without these walls.
TriangleMesh withoutCopies(const TriangleMesh& mesh, const MeshHealth& before,
                           std::size_t& turned) {
    constexpr double kSameVolume = 1e-6;
    if (before.duplicateTriangles > 0 && before.hasParity() && before.enclosedVolume > 0) {
        TriangleMesh outward = mesh;
        turned = turnOutermost(outward);
        TriangleMesh joined = withoutDuplicates(outward, false);
        const double volume = analyzeShells(joined).enclosedVolume();
        if (std::fabs(volume - before.enclosedVolume) <= kSameVolume * before.enclosedVolume)
            return joined;
        turned = 0;
    }
    return withoutDuplicates(mesh);
}

}  // namespace

double repairVoxelSize(const TriangleMesh& mesh) {
    std::vector<double> lengths;
    lengths.reserve(mesh.triangles.size());
    double area = 0;
    for (const auto& t : mesh.triangles) {
        const Vec<3>& a = mesh.vertices[t[0]];
        const Vec<3> ab = mesh.vertices[t[1]] - a, ac = mesh.vertices[t[2]] - a;
        const double twice = length(cross(ab, ac));
        area += 0.5 * twice;
        // The side of an equilateral triangle of the same area, so that slivers do not count as
        // small triangles.
        lengths.push_back(std::sqrt(twice * (2 / std::sqrt(3.0))));
    }
    const double wanted = 0.3 * median(std::move(lengths));
    const double volume = analyzeShells(mesh).enclosedVolume();
    const double thickness = area > 0 ? 2 * std::fabs(volume) / area : 0;
    const double finest = std::sqrt(2 * area / kMostRemeshed);
    double size = wanted;
    // Flat faces of few triangles: five voxels a wall keep their edges.
    if (thickness > 0) size = std::min(size, 0.2 * thickness);
    return std::max(size, finest);
}

TriangleMesh remesh(const TriangleMesh& mesh, const WindingNumber& winding, double voxelSize,
                    RepairReport& report, const Callbacks& callbacks) {
    report.method = RepairReport::Method::resurfaced;
    report.voxelSize = voxelSize;
    Resurfaced made = resurface(mesh, winding, voxelSize, callbacks);
    report.piecesDropped = dropSmallComponents(made.mesh, kLeastComponent * std::pow(voxelSize, 3));
    report.thinArea = made.thinArea;
    report.bridgedShare = made.bridgedShare;
    return std::move(made.mesh);
}

WholeRepair repairWhole(TriangleMesh mesh, const WholeRepairOptions& options,
                        const Callbacks& callbacks) {
    WholeRepair result;
    RepairReport& report = result.report;
    report.before = checkMesh(mesh);
    if (!(report.before.area > 0)) return result;

    const std::size_t given = mesh.triangles.size();
    TriangleMesh turned = withoutCopies(mesh, report.before, report.turned);
    report.duplicates = given - turned.triangles.size();
    report.turned += turnOutward(turned, options.nested);
    Windings winding(turned);
    callbacks.stopIfCancelled();
    // Loose triangles are refused before they are remeshed.
    const double inside = measureDoubt(turned, winding, options.volumePoints, report);
    if (inside < kNothing && !anyNearlyClosed(turned)) {
        result.oriented = std::move(turned);
        return result;
    }
    callbacks.stopIfCancelled();

    TriangleMesh filled = turned;
    const HoleFilling holes = fillHoles(filled);
    const bool wasOpen = filled.triangles.size() > turned.triangles.size();
    const Buried buried =
        wasOpen ? findBuried(filled, turned.triangles.size(), Windings(filled), &winding)
                : findBuried(filled, turned.triangles.size(), winding, nullptr);
    // Triangles that cross others are walls on one side alone.
    if (report.before.intersections == 0 && holes.left == 0 &&
        buried.agreeing >= kAgreement * buried.checked) {
        auto walls = wallsOf(filled, buried, report.dropped);
        if (walls) {
            const bool changed = report.duplicates + report.turned + report.dropped > 0 ||
                                 wasOpen || !report.before.isWatertight();
            report.method = changed ? RepairReport::Method::triangles : RepairReport::Method::none;
            report.holesFilled = holes.filled;
            report.filledArea = holes.area;
            // Two layers that a filled hole left enclose nothing.
            if (changed)
                dropSmallComponents(*walls,
                                    kFlatVolume * std::pow(length(report.before.bounds.size()), 3));
            result.mesh = changed ? std::move(*walls) : std::move(mesh);
        } else {
            report.dropped = 0;
        }
    }
    if (result.mesh.triangles.empty()) {
        const double voxelSize = options.voxelSize > 0
                                     ? options.voxelSize
                                     : std::max(repairVoxelSize(turned), options.leastVoxelSize);
        result.mesh = remesh(turned, winding.general(turned), voxelSize, report, callbacks);
    }
    result.oriented = std::move(turned);
    report.volume = analyzeShells(result.mesh).enclosedVolume();
    if (!(report.volume > 0)) result.mesh = {};
    return result;
}

}  // namespace vdbpack
