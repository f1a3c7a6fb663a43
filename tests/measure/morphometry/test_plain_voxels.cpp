// Morphometry beside BoneJ's definitions on plain voxels, written for clarity.
#include "measure/morphometry/voxel_images.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/measure/morphometry/mean_intercept.h"
#include "vdbpack/measure/morphometry/morphometry.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace {

/// The squared distances of the voxels of a phase, in voxels, to the nearest of the other phase.
std::vector<float> squaredDistances(const VoxelImage& image, bool solid) {
    const std::int64_t n = image.size[0];
    constexpr float kFar = 1e9f;
    std::vector<float> square(image.voxels());
    for (std::size_t i = 0; i < square.size(); ++i)
        square[i] = (image.distance[i] < 0) == solid ? kFar : 0.0f;
    const std::int64_t stride[3] = {1, n, n * n};
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t a = stride[(axis + 1) % 3], b = stride[(axis + 2) % 3];
        tbb::parallel_for(std::int64_t{0}, n, [&](std::int64_t i) {
            std::vector<float> line(static_cast<std::size_t>(n));
            for (std::int64_t j = 0; j < n; ++j) {
                float* first = &square[static_cast<std::size_t>(i * a + j * b)];
                for (std::int64_t k = 0; k < n; ++k)
                    line[static_cast<std::size_t>(k)] = first[k * stride[axis]];
                for (std::int64_t k = 0; k < n; ++k) {
                    float best = kFar;
                    for (std::int64_t l = 0; l < n; ++l) {
                        const auto d = static_cast<float>(k - l);
                        best = std::min(best, line[static_cast<std::size_t>(l)] + d * d);
                    }
                    first[k * stride[axis]] = best;
                }
            }
        });
    }
    return square;
}

/// BoneJ's definitions on plain voxels, written for clarity: the distance of a voxel is that of its
/// center to the nearest center of the other phase (so that a slab of n voxels has n or n + 1),
/// balls are centered on voxels and cover the centers within, and a voxel's thickness is the
/// diameter of the largest ball that covers it. Beyond the image there is nothing.
double plainThickness(const VoxelImage& image, bool solid) {
    const std::int64_t n = image.size[0];
    const auto at = [n](std::int64_t x, std::int64_t y, std::int64_t z) {
        return static_cast<std::size_t>((z * n + y) * n + x);
    };
    const std::vector<float> square = squaredDistances(image, solid);
    // Balls inside the ball of a neighbor cover nothing of their own.
    struct Center {
        std::int64_t x, y, z;
        float square;
    };
    std::vector<Center> centers;
    for (std::int64_t z = 0; z < n; ++z)
        for (std::int64_t y = 0; y < n; ++y)
            for (std::int64_t x = 0; x < n; ++x) {
                const float s = square[at(x, y, z)];
                bool own = s > 0;
                for (int d = 0; d < 27 && own; ++d) {
                    const std::int64_t i = x + d % 3 - 1, j = y + d / 3 % 3 - 1, k = z + d / 9 - 1;
                    if (d == 13 || std::min({i, j, k}) < 0 || std::max({i, j, k}) >= n) continue;
                    const double step = std::sqrt(std::abs(d % 3 - 1) + std::abs(d / 3 % 3 - 1) +
                                                  std::abs(d / 9 - 1));
                    own =
                        std::sqrt(double{square[at(i, j, k)]}) < std::sqrt(double{s}) + step - 1e-4;
                }
                if (own) centers.push_back({x, y, z, s});
            }
    std::vector<float> largest(image.voxels(), 0.0f);
    tbb::parallel_for(std::int64_t{0}, n, [&](std::int64_t z) {
        for (const Center& c : centers) {
            const auto dz = static_cast<float>(z - c.z);
            if (dz * dz > c.square) continue;
            const auto reach = static_cast<std::int64_t>(std::sqrt(c.square - dz * dz));
            for (std::int64_t y = std::max<std::int64_t>(0, c.y - reach);
                 y <= std::min(n - 1, c.y + reach); ++y) {
                const auto dy = static_cast<float>(y - c.y);
                const auto half = static_cast<std::int64_t>(
                    std::sqrt(std::max(c.square - dz * dz - dy * dy, 0.0f)));
                float* row = &largest[at(0, y, z)];
                const std::int64_t last = std::min(n - 1, c.x + half);
                for (std::int64_t x = std::max<std::int64_t>(0, c.x - half); x <= last; ++x)
                    row[x] = std::max(row[x], c.square);
            }
        }
    });
    double sum = 0;
    std::int64_t count = 0;
    for (std::size_t i = 0; i < largest.size(); ++i) {
        if ((image.distance[i] < 0) != solid) continue;
        sum += 2 * std::sqrt(double{largest[i]});
        ++count;
    }
    return sum / static_cast<double>(count) * image.voxelSize;
}

/// Mean intercept lengths by lines: changes of phase between samples on parallel lines, by the
/// nearest voxel or interpolated between the eight around.
double plainAnisotropy(const VoxelImage& image, double step, bool interpolated) {
    const std::int64_t n = image.size[0];
    const auto directions = halfSphereDirections(100);
    std::vector<double> rates(directions.size());
    const double half = 0.5 * static_cast<double>(n - 1), reach = 0.87 * static_cast<double>(n);
    const auto at = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
        return double{image.distance[static_cast<std::size_t>((z * n + y) * n + x)]};
    };
    const auto isSolid = [&](const Vec<3>& p) {
        if (!interpolated)
            return at(std::llround(p[0]), std::llround(p[1]), std::llround(p[2])) < 0;
        double value = 0;
        for (int corner = 0; corner < 8; ++corner) {
            double share = 1;
            std::array<std::int64_t, 3> k{};
            for (int j = 0; j < 3; ++j) {
                const auto low = std::min(static_cast<std::int64_t>(p[j]), n - 2);
                const double t = p[j] - static_cast<double>(low);
                share *= (corner >> j & 1) != 0 ? t : 1 - t;
                k[static_cast<std::size_t>(j)] = low + (corner >> j & 1);
            }
            value += share * at(k[0], k[1], k[2]);
        }
        return value < 0;
    };
    tbb::parallel_for(std::size_t{0}, directions.size(), [&](std::size_t i) {
        const Vec<3>& u = directions[i];
        const auto [e, g] = across(u);
        std::int64_t steps = 0, changes = 0;
        for (double a = -reach; a <= reach; a += 2.3)
            for (double b = -reach; b <= reach; b += 2.3) {
                bool before = false, started = false;
                for (double t = -reach; t <= reach; t += step) {
                    const Vec<3> p = e * a + g * b + u * t + Vec<3>{{half, half, half}};
                    if (!Box<3>{{}, {{2 * half, 2 * half, 2 * half}}}.contains(p)) {
                        started = false;
                        continue;
                    }
                    const bool now = isSolid(p);
                    if (started) {
                        ++steps;
                        changes += now != before;
                    }
                    before = now;
                    started = true;
                }
            }
        rates[i] = static_cast<double>(changes) / (step * static_cast<double>(steps));
    });
    return fitAnisotropy(directions, rates, image.voxelSize).value().degree;
}

void compareWithPlainVoxels(std::int64_t n) {
    // 30 to 50 voxels thick and apart: from center to center a wall reads 0 to 1 voxels too thick
    // and balls on voxels up to 1 too thin, so that the plain figures are good to 1 % or so.
    Voids voids;
    voids.semiAxes = {0.75, 0.5, 0.45};
    voids.perVolume = -std::log(0.4) / voids.volume();
    voids.stretch = 4;
    voids.seed = 3;
    const auto image = voidsImage(n, 0.02, voids);
    const auto m = measureMorphometry(image);
    double solid = 0;
    for (const float d : image.distance) solid += d < 0;
    REQUIRE(m.solidFraction == solid / static_cast<double>(image.voxels()));
    const double thickness = plainThickness(image, true);
    const double separation = plainThickness(image, false);
    REQUIRE(m.thickness);
    REQUIRE(m.separation);
    REQUIRE(m.anisotropy);
    const double da = m.anisotropy->degree, lines = plainAnisotropy(image, 0.5, true);
    const double voxelLines = plainAnisotropy(image, 2.3, false);
    CAPTURE(n, m.thickness->mean, thickness, m.separation->mean, separation, da, lines, voxelLines);
    REQUIRE(thickness > 30 * image.voxelSize);
    REQUIRE(separation > 30 * image.voxelSize);
    REQUIRE(m.thickness->mean == within(thickness, 0.02));
    REQUIRE(m.separation->mean == within(separation, 0.02));
    REQUIRE(da == Approx(lines).margin(0.02));
    // Lines from voxel to voxel count the steps of a staircase: one along a wall crosses it again
    // and again. At any resolution that hides anisotropy, here 0.08 of it for steps of half a
    // voxel and 0.04 for steps of 2.3, BoneJ's.
    REQUIRE(da > voxelLines);
    REQUIRE(m.voxelAnisotropy);
    REQUIRE(m.voxelAnisotropy->degree == Approx(voxelLines).margin(0.02));
    REQUIRE(std::fabs(dot(m.voxelAnisotropy->axes[0], m.anisotropy->axes[0])) > 0.99);
    if (n > 120)
        WARN(
            fmt::format("Tb.Th {:.4f} mm, plain {:.4f}; Tb.Sp {:.4f}, plain {:.4f}; DA {:.4f}, "
                        "by lines {:.4f}; from voxel to voxel {:.4f}, plain {:.4f}",
                        m.thickness->mean, thickness, m.separation->mean, separation, da, lines,
                        m.voxelAnisotropy->degree, voxelLines));
}

}  // namespace

TEST_CASE("the figures are those of BoneJ's definitions on plain voxels", "[long]") {
    compareWithPlainVoxels(80);
}

TEST_CASE("the figures are those of BoneJ's definitions on more plain voxels", "[.slow]") {
    compareWithPlainVoxels(160);
}
