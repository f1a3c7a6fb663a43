#include "vdbpack/run/part_space.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/core/weyl.h"
#include "vdbpack/run/stiffness_warnings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::size_t kPoints = 1'000'000, kBlock = 10'000;
/// How far the space of a sphere reaches, in its radii; length of segments, and the first distance
/// within which surfaces are sought, in mean radii.
constexpr double kReach = 0.5, kSegment = 0.5, kNearest = 0.1;

Vec<3> randomDirection(RandomStream& random) {
    const double z = 2 * random.uniform() - 1, across = std::sqrt(1 - z * z);
    const double turn = 2 * 3.14159265358979323846 * random.uniform();
    return {{across * std::cos(turn), across * std::sin(turn), z}};
}

}  // namespace

PartSpace spaceOfParts(const Pack<3>& pack, const Materials& materials) {
    constexpr std::int32_t kNone = -1;
    double largest = 0, sum = 0;
    for (const Sphere<3>& s : pack.spheres) largest = std::max(largest, s.radius), sum += s.radius;
    const double mean = sum / static_cast<double>(pack.spheres.size()), segment = kSegment * mean;
    const auto all = withImages(pack.spheres, pack.cell, kReach * largest + segment);
    const CellLevels<3> cells(all.spheres);
    Box<3> box = boxAround(pack);
    for (int d = 0; d < 3; ++d)
        if (pack.cell.isAlong(d)) box.lo[d] = pack.cell.box.lo[d], box.hi[d] = pack.cell.box.hi[d];
    const auto partAt = [&](const Vec<3>& x) {
        double least = std::numeric_limits<double>::infinity(), reach = kNearest * mean;
        std::int32_t part = kNone;
        for (bool last = false; least >= reach && !last; reach *= 2) {
            last = reach >= kReach * largest;
            cells.forEachNear(x, reach, [&](std::uint32_t i, const Sphere<3>& s) {
                const double away = length(x - s.center) - s.radius;
                if (away < std::min(least, kReach * s.radius))
                    least = away, part = materials.partOf(all.source[i]);
                return true;
            });
        }
        return part;
    };
    std::vector<PartPair> found(kPoints);
    parallelFor(IndexRange(0, kPoints / kBlock, 1), [&](const IndexRange& blocks) {
        for (std::size_t b = blocks.begin(); b < blocks.end(); ++b) {
            RandomStream random(0, b);
            for (std::size_t n = b * kBlock; n < (b + 1) * kBlock; ++n) {
                const Vec<3> x = weylPoint(n, box), to = randomDirection(random);
                const std::int32_t part = partAt(x);
                found[n] = {part, part == kNone ? kNone : partAt(x + to * segment)};
            }
        }
    });
    PartSpace space;
    const double each = box.volume() / kPoints;
    for (const auto& [part, end] : found) {
        if (part == kNone) continue;
        space.volume[part] += each;
        if (end != kNone && end != part) space.area[std::minmax(part, end)] += 2 / segment * each;
    }
    return space;
}

}  // namespace vdbpack
