// bench_pack lookups: time of the signed distances of a domain, of CGAL's AABB tree and of a loop
// over all triangles. One thread, the same random points, one run.
#include "bench_lookups.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/mesh_domain.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

using namespace vdbpack;

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;
using Tree =
    CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_face_graph_triangle_primitive<Surface>>>;

/// Seconds per lookup of the first `count` points; `ask` is called with the index of each.
template <class Ask>
double secondsEach(std::size_t count, const Ask& ask) {
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < count; ++i) ask(i);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
           static_cast<double>(count);
}

Surface surfaceOf(const TriangleMesh& mesh) {
    namespace processing = CGAL::Polygon_mesh_processing;
    std::vector<Point> points;
    for (const auto& v : mesh.vertices) points.emplace_back(v[0], v[1], v[2]);
    std::vector<std::vector<std::size_t>> faces;
    for (const auto& t : mesh.triangles)
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) faces.push_back({t[0], t[1], t[2]});
    processing::orient_polygon_soup(points, faces);
    Surface surface;
    processing::polygon_soup_to_polygon_mesh(points, faces, surface);
    return surface;
}

/// By a loop: the nearest of all triangles, and the parity of those above.
double signedDistanceByLoop(const TriangleMesh& mesh, const Vec<3>& x) {
    double least = std::numeric_limits<double>::infinity();
    bool inside = false;
    for (const auto& t : mesh.triangles) {
        const Vec<3>&a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        const Point p(x[0], x[1], x[2]);
        const Kernel::Triangle_3 triangle(Point(a[0], a[1], a[2]), Point(b[0], b[1], b[2]),
                                          Point(c[0], c[1], c[2]));
        least = std::min(least, CGAL::squared_distance(p, triangle));
        // Signed areas in the xy plane: equal signs if the vertical line through x meets the
        // triangle.
        const auto area = [&](const Vec<3>& u, const Vec<3>& v) {
            return (u[0] - x[0]) * (v[1] - x[1]) - (v[0] - x[0]) * (u[1] - x[1]);
        };
        const double ab = area(a, b), bc = area(b, c), ca = area(c, a);
        if (!((ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0))) continue;
        const double height = (bc * a[2] + ca * b[2] + ab * c[2]) / (ab + bc + ca);
        inside = inside != (height > x[2]);
    }
    return inside ? -std::sqrt(least) : std::sqrt(least);
}

std::vector<Vec<3>> pointsIn(const Box<3>& bounds, std::size_t count) {
    RandomStream random(1, 0);
    std::vector<Vec<3>> points(count);
    for (auto& x : points)
        for (int d = 0; d < 3; ++d)
            x[d] = bounds.lo[d] + random.uniform() * (bounds.hi[d] - bounds.lo[d]);
    return points;
}

}  // namespace

void benchLookups(const TriangleMesh& mesh, const std::string& name, double detail) {
    FieldOptions options;
    options.name = name;
    options.detail = detail;
    options.depth = 6 * detail;  // three largest radii
    const auto domain = meshDomain(mesh, options);
    const auto sampler = domain->sampler();
    constexpr std::size_t kPoints = 2000000, kSides = 400000, kExact = 20000, kLoops = 10;
    const std::vector<Vec<3>> points = pointsIn(domain->bounds(), kPoints);
    std::vector<Point> same;
    for (std::size_t i = 0; i < kSides; ++i)
        same.emplace_back(points[i][0], points[i][1], points[i][2]);

    std::vector<double> field(kPoints);
    const double ours =
        secondsEach(kPoints, [&](std::size_t i) { field[i] = sampler->signedDistance(points[i]); });

    const Surface surface = surfaceOf(mesh);
    Tree tree(faces(surface).first, faces(surface).second, surface);
    tree.build();
    const CGAL::Side_of_triangle_mesh<Surface, Kernel> sideOf(tree);
    sideOf(same[0]);
    std::vector<bool> inside(kSides);
    const double side = secondsEach(
        kSides, [&](std::size_t i) { inside[i] = sideOf(same[i]) == CGAL::ON_BOUNDED_SIDE; });
    tree.accelerate_distance_queries();
    double sum = 0;
    const double exact = secondsEach(kExact, [&](std::size_t i) {
        sum += sideOf(same[i]) == CGAL::ON_BOUNDED_SIDE ? 1 : 0;
        sum += tree.squared_distance(same[i]);
    });
    std::vector<double> byLoop(kLoops);
    const double loop = secondsEach(
        kLoops, [&](std::size_t i) { byLoop[i] = signedDistanceByLoop(mesh, points[i]); });
    if (!(sum > 0)) throw std::runtime_error("the AABB tree found no distance");

    // All describe one surface: signs may differ only next to it, where the error of the field is
    // up to a voxel.
    const double voxel = domain->facts().voxelSize;
    std::size_t wrong = 0, near = 0;
    for (std::size_t i = 0; i < kSides; ++i)
        if ((field[i] < 0) != inside[i]) ++(std::fabs(field[i]) > voxel ? wrong : near);
    for (std::size_t i = 0; i < kLoops; ++i)
        if (std::fabs(byLoop[i]) > voxel && (byLoop[i] < 0) != (field[i] < 0)) ++wrong;
    const std::vector<std::pair<const char*, double>> rows{
        {"domain, clearance", ours},
        {"CGAL Side_of_triangle_mesh, sign only", side},
        {"CGAL Side_of_triangle_mesh and distance", exact},
        {"loop over all triangles, both", loop}};
    for (const auto& [what, seconds] : rows)
        fmt::print("{:<24} {:<42} {:>12.0f} {:>10.1f}\n", name.substr(name.find_last_of('/') + 1),
                   what, 1 / seconds, seconds / ours);
    fmt::print(
        "{:<24} {} triangles, voxels of {:.3g} mm; of {} signs, {} differ from CGAL's within a "
        "voxel of the wall, {} elsewhere\n",
        "", mesh.triangles.size(), voxel, kSides, near, wrong);
    std::fflush(stdout);
}
