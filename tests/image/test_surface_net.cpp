#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/image/surface_net.h"
#include "vdbpack/mesh/mesh_check.h"

namespace {

LabelVoxels labelled(const ImageGrid& grid, const std::function<int(const Vec<3>&)>& labelAt) {
    LabelVoxels voxels;
    voxels.size = grid.size;
    voxels.labels = Voxels<std::uint16_t>::of(grid, labelAt).values;
    return voxels;
}

TriangleMesh surfaceOfLabel(const SurfaceNet& net, const ImageGrid& grid, int label) {
    return surfaceOf(net, grid, [label](std::uint16_t l) { return l == label; });
}

SurfaceNet smoothNet(const LabelVoxels& voxels) {
    SurfaceNet net = surfaceNet(voxels);
    smooth(net, voxels.size);
    return net;
}

struct Shape {
    const char* name;
    std::function<double(const Vec<3>&)> distance;  // mm, negative inside
    double volume, halfWidth;
};

/// Shapes whose least radius is ten of the largest steps of a grid.
std::vector<Shape> shapes(double unit) {
    const double r = 10 * unit, a = 25 * unit, pi = std::acos(-1.0);
    return {{"ball", [=](const Vec<3>& p) { return length(p) - 1.7 * r; },
             4 * pi / 3 * std::pow(1.7 * r, 3), 1.8 * r},
            {"standing torus",
             [=](const Vec<3>& p) { return std::hypot(std::hypot(p[1], p[2]) - a, p[0]) - r; },
             2 * pi * pi * a * r * r, a + 1.1 * r},
            // Of steps of 3 mm, its top is a terrace nineteen voxels wide.
            {"flat torus",
             [=](const Vec<3>& p) { return std::hypot(std::hypot(p[0], p[1]) - a, p[2]) - r; },
             2 * pi * pi * a * r * r, a + 1.1 * r},
            {"nested shells",
             [=](const Vec<3>& p) { return std::max(length(p) - 2 * r, 1.1 * r - length(p)); },
             4 * pi / 3 * (8 - std::pow(1.1, 3)) * r * r * r, 2.1 * r}};
}

/// Distance of a point to a surface in steps of the grid.
double inVoxels(const Shape& shape, const Vec<3>& p, const Vec<3>& spacing) {
    Vec<3> slope;
    for (int d = 0; d < 3; ++d) {
        Vec<3> lo = p, hi = p;
        lo[d] -= 0.01 * spacing[d];
        hi[d] += 0.01 * spacing[d];
        slope[d] = (shape.distance(hi) - shape.distance(lo)) / 0.02;
    }
    return shape.distance(p) / length(slope);
}

}  // namespace

TEST_CASE("surfaces of digitized shapes lie where the shapes' do") {
    const double across = GENERATE(1.0, 3.0);
    const Vec<3> spacing{{1, 1, across}};
    RandomStream random(9, 4);
    for (const Shape& shape : shapes(across)) {
        const Vec<3> shift{{random.uniform(), random.uniform(), random.uniform()}};
        CAPTURE(shape.name, across, shift.c);
        const ImageGrid grid = gridAround(shape.halfWidth, spacing, shift);
        const auto voxels =
            labelled(grid, [&](const Vec<3>& p) { return shape.distance(p) < 0 ? 1 : 0; });
        const TriangleMesh mesh = surfaceOfLabel(smoothNet(voxels), grid, 1);
        const MeshHealth health = checkMesh(mesh);
        CHECK(health.isWatertight());
        CHECK(health.inconsistentEdges == 0);
        CHECK(health.signedVolume == Approx(shape.volume).epsilon(0.005));
        double squares = 0, largest = 0;
        for (const auto& v : mesh.vertices) {
            const double off = inVoxels(shape, v, spacing);
            squares += off * off;
            largest = std::max(largest, std::fabs(off));
        }
        CHECK(std::sqrt(squares / static_cast<double>(mesh.vertices.size())) < 0.1);
        CHECK(largest < 0.5);
    }
}

TEST_CASE("the wide terrace on top of a ball is rounded") {
    // The next layer of voxels lies just past the top: its own terrace has a radius of 23 voxels.
    const Vec<3> spacing{{1, 1, 3}};
    const Shape ball{"ball", [](const Vec<3>& p) { return length(p) - 90; }, 0, 92};
    const ImageGrid grid = gridAround(ball.halfWidth, spacing, {{0, 0, 0.01}});
    const auto voxels =
        labelled(grid, [&](const Vec<3>& p) { return ball.distance(p) < 0 ? 1 : 0; });
    const TriangleMesh mesh = surfaceOfLabel(smoothNet(voxels), grid, 1);
    double largest = 0;
    for (const auto& v : mesh.vertices)
        largest = std::max(largest, std::fabs(inVoxels(ball, v, spacing)));
    CHECK(largest < 0.42);
}

TEST_CASE("a digitized box keeps its flat sides") {
    const double across = GENERATE(1.0, 3.0);
    // About the axis across, in radians.
    const double turn = GENERATE(0.0, 0.3);
    CAPTURE(across, turn);
    const double half = 10 * across;
    const ImageGrid grid = gridAround(1.5 * half, {{1, 1, across}});
    const auto inBox = [&](const Vec<3>& p) {
        return Vec<3>{{std::fabs(std::cos(turn) * p[0] - std::sin(turn) * p[1]),
                       std::fabs(std::sin(turn) * p[0] + std::cos(turn) * p[1]), std::fabs(p[2])}};
    };
    const auto voxels = labelled(grid, [&](const Vec<3>& p) {
        const Vec<3> a = inBox(p);
        return std::max({a[0], a[1], a[2]}) < half;
    });
    const TriangleMesh mesh = surfaceOfLabel(smoothNet(voxels), grid, 1);
    CHECK(checkMesh(mesh).signedVolume == Approx(std::pow(2 * half, 3)).epsilon(0.005));
    double squares = 0, count = 0, largest = 0;
    for (const auto& v : mesh.vertices) {
        const Vec<3> a = inBox(v);
        Vec<3> sorted = a;
        std::sort(sorted.c.begin(), sorted.c.end());
        if (sorted[1] > half - 2.5 * across) continue;
        const double off = (sorted[2] - half) / (a[2] == sorted[2] ? across : 1);
        squares += off * off;
        largest = std::max(largest, std::fabs(off));
        ++count;
    }
    CHECK(std::sqrt(squares / count) < 0.1);
    CHECK(largest < 0.3);
}

TEST_CASE("labels that touch share the triangles between them") {
    const ImageGrid grid = gridAround(13, {{1, 1, 1}}, {{0.2, 0.1, 0.4}});
    const auto voxels = labelled(
        grid, [](const Vec<3>& p) { return length(p) < 12 ? (p[0] + 0.4 * p[1] < 0 ? 1 : 2) : 0; });
    const SurfaceNet net = smoothNet(voxels);
    using Corners = std::array<std::array<double, 3>, 3>;
    const auto trianglesOf = [&](int label, bool flipped) {
        std::set<Corners> all;
        const TriangleMesh mesh = surfaceOfLabel(net, grid, label);
        for (const auto& t : mesh.triangles) {
            Corners c;
            for (std::size_t k = 0; k < 3; ++k) c[k] = mesh.vertices[t[k]].c;
            if (flipped) std::swap(c[1], c[2]);
            std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
            all.insert(c);
        }
        return all;
    };
    const auto first = trianglesOf(1, false), second = trianglesOf(2, true);
    const auto shared = static_cast<double>(std::count_if(
        first.begin(), first.end(), [&](const Corners& c) { return second.count(c); }));
    // Two a voxel face, of a disk of radius 12 cut askew.
    CHECK(shared > 2 * 3.1 * 144);
    double sum = 0;
    for (const int label : {1, 2}) sum += checkMesh(surfaceOfLabel(net, grid, label)).signedVolume;
    const TriangleMesh both = surfaceOf(net, grid, [](std::uint16_t label) { return label > 0; });
    CHECK(sum == Approx(checkMesh(both).signedVolume).epsilon(1e-9));
    CHECK(sum == Approx(4.0 / 3 * std::acos(-1.0) * 1728).epsilon(0.005));
}

TEST_CASE("any label map has closed surfaces with two triangles at each edge") {
    const int labels = GENERATE(1, 3);
    const double share = GENERATE(0.1, 0.4, 0.8);
    CAPTURE(labels, share);
    ImageGrid grid;
    grid.size = {17, 14, 15};
    RandomStream random(3, static_cast<std::uint64_t>(labels));
    const auto voxels = labelled(grid, [&](const Vec<3>&) {
        return random.uniform() < share ? 1 + static_cast<int>(random.uniform() * labels) : 0;
    });
    const SurfaceNet net = smoothNet(voxels);
    for (int label = 1; label <= labels; ++label) {
        const MeshHealth health = checkMesh(surfaceOfLabel(net, grid, label));
        CHECK(health.isWatertight());
        CHECK(health.inconsistentEdges == 0);
        CHECK(health.degenerateTriangles == 0);
    }
}

TEST_CASE("the border of an image closes what it cuts with a flat wall") {
    ImageGrid grid;
    grid.size = {20, 30, 25};
    const auto voxels =
        labelled(grid, [](const Vec<3>& p) { return std::hypot(p[1] - 15, p[2] - 12) < 9; });
    const TriangleMesh mesh = surfaceOfLabel(smoothNet(voxels), grid, 1);
    CHECK(checkMesh(mesh).isWatertight());
    const Box<3> box = mesh.bounds();
    CHECK(box.lo[0] == -0.5);
    CHECK(box.hi[0] == 19.5);
    const auto count = std::count(voxels.labels.begin(), voxels.labels.end(), 1);
    CHECK(checkMesh(mesh).signedVolume == Approx(static_cast<double>(count)).epsilon(0.001));
}

TEST_CASE("structures one voxel thick have the volume of their voxels") {
    ImageGrid grid;
    grid.size = {24, 25, 40};
    const auto isStrut = [](const Vec<3>& p) { return p[0] == 12 && p[1] == 12 && p[2] > 4; };
    const auto isPlate = [](const Vec<3>& p) { return p[0] == 12 && p[1] > 4 && p[2] > 4; };
    const auto isSingle = [](const Vec<3>& p) { return p == Vec<3>{{12, 12, 12}}; };
    const auto isMixed = [&](const Vec<3>& p) {
        return isStrut(p) || length(p - Vec<3>{{12, 12, 15}}) < 8;
    };
    for (const auto& inside :
         std::vector<std::function<bool(const Vec<3>&)>>{isStrut, isPlate, isSingle, isMixed}) {
        const auto voxels = labelled(grid, inside);
        const double count =
            static_cast<double>(std::count(voxels.labels.begin(), voxels.labels.end(), 1));
        CAPTURE(count);
        const TriangleMesh mesh = surfaceOfLabel(smoothNet(voxels), grid, 1);
        CHECK(checkMesh(mesh).signedVolume == Approx(count).epsilon(0.006));
    }
}

TEST_CASE("mirrored and oblique axes turn a surface and nothing else") {
    const ImageGrid plain = gridAround(11, {{1, 0.8, 1.5}}, {{0.3, 0, 0.1}});
    const auto voxels = labelled(plain, [](const Vec<3>& p) { return length(p) < 10; });
    const SurfaceNet net = smoothNet(voxels);
    ImageGrid mirrored = turned(plain, 0.3, -1.1);
    mirrored.step[0] = -mirrored.step[0];
    const double volume = checkMesh(surfaceOfLabel(net, plain, 1)).signedVolume;
    CHECK(volume > 0);
    CHECK(checkMesh(surfaceOfLabel(net, mirrored, 1)).signedVolume == Approx(volume));
}

TEST_CASE("interpolated surfaces are as exact as the values") {
    const ImageGrid grid = gridAround(13, {{1, 1, 1.5}}, {{0.3, 0.2, 0.1}});
    const auto values =
        Voxels<float>::of(grid, [](const Vec<3>& p) { return 12 - length(p); }).values;
    LabelVoxels voxels;
    voxels.size = grid.size;
    for (const float v : values) voxels.labels.push_back(v >= 2);
    SurfaceNet net = surfaceNet(voxels);
    interpolate(net, voxels, [&](std::size_t a, std::size_t b) {
        return (2 - static_cast<double>(values[a])) / static_cast<double>(values[b] - values[a]);
    });
    const TriangleMesh mesh = surfaceOfLabel(net, grid, 1);
    CHECK(checkMesh(mesh).isWatertight());
    CHECK(checkMesh(mesh).signedVolume == Approx(4.0 / 3 * std::acos(-1.0) * 1000).epsilon(0.02));
    for (const auto& v : mesh.vertices) CHECK(length(v) == Approx(10).margin(0.06));
}
