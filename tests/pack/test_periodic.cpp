// Periodic cells: the front, densifying, checks and measures across their faces.
#include "support/test.h"

#include "vdbpack/densify/densify.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/measure/bond_order.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/measure/pair_correlation.h"
#include "vdbpack/pack/block_lattice.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/verify/verify.h"

namespace {

/// A cell with its lower corner anywhere. @param axes  along which it repeats.
template <int Dim>
PeriodicCell<Dim> cellOf(std::array<double, 3> lengths, const std::string& axes = "xyz") {
    PeriodicCell<Dim> cell;
    for (int d = 0; d < Dim; ++d) {
        cell.box.lo[d] = 1.7 - 0.45 * lengths[static_cast<std::size_t>(d)];
        cell.box.hi[d] = cell.box.lo[d] + lengths[static_cast<std::size_t>(d)];
        cell.wraps[static_cast<std::size_t>(d)] = axes.find("xyz"[d]) != std::string::npos;
    }
    return cell;
}

template <int Dim>
PackResult<Dim> packIn(const PeriodicCell<Dim>& cell, std::uint64_t seed = 1, int threads = 0,
                       const std::vector<Sphere<Dim>>& existing = {}, double gap = 0) {
    PackOptions options(SizeDistribution::uniform(1, 2));
    options.seed = seed;
    options.threads = threads;
    options.gap = gap;
    return packSpheres<Dim>(*periodicDomain<Dim>(cell), options, {}, existing);
}

/// All pairs with all 27 (2D: 9) images of one of the two.
struct AllPairs {
    double smallestGap = std::numeric_limits<double>::infinity();
    std::uint64_t partners = 0;  ///< gap below a share of the smaller radius
};
template <int Dim>
AllPairs allPairs(const std::vector<Sphere<Dim>>& spheres, const PeriodicCell<Dim>& cell,
                  double tolerance) {
    AllPairs found;
    for (int image = 0; image < (Dim == 3 ? 27 : 9); ++image) {
        Vec<Dim> shift;
        bool own = true, exists = true;
        for (int d = 0, rest = image; d < Dim; ++d, rest /= 3) {
            shift[d] = (rest % 3 - 1) * cell.length(d);
            own = own && rest % 3 == 1;
            exists = exists && (cell.isAlong(d) || rest % 3 == 1);
        }
        if (!exists) continue;
        for (std::size_t i = 0; i < spheres.size(); ++i)
            for (std::size_t j = 0; j < spheres.size(); ++j) {
                if (own && i == j) continue;
                const Sphere<Dim> b{spheres[j].center + shift, spheres[j].radius};
                const double between = gap(spheres[i], b);
                found.smallestGap = std::min(found.smallestGap, between);
                found.partners += between < tolerance * std::min(spheres[i].radius, b.radius);
            }
    }
    return found;
}

template <int Dim>
std::vector<Sphere<Dim>> shifted(std::vector<Sphere<Dim>> spheres, const PeriodicCell<Dim>& cell,
                                 const Vec<Dim>& by) {
    for (auto& s : spheres) s.center = cell.wrapped(s.center + by);
    return spheres;
}

constexpr double kTolerance = 1e-3;

}  // namespace

DIM_TEST_CASE("no two spheres of a periodic pack overlap across its faces") {
    const auto seed = GENERATE(range(1u, 4u));
    const auto axes = GENERATE(as<std::string>(), "xyz", "x", "xy");
    const bool plane = Dim == 2;
    const auto cell = cellOf<Dim>(
        plane ? std::array<double, 3>{50, 31.3, 0} : std::array<double, 3>{23.7, 16, 18.1}, axes);
    CAPTURE(Dim, seed, axes);
    const auto pack = packIn<Dim>(cell, seed).pack;
    const auto& spheres = pack.spheres;
    REQUIRE(spheres.size() > 100);
    CHECK(pack.cell.wraps == cell.wraps);
    CHECK(std::all_of(spheres.begin(), spheres.end(),
                      [&](const Sphere<Dim>& s) { return cell.wrapped(s.center) == s.center; }));
    const AllPairs pairs = allPairs<Dim>(spheres, cell, kTolerance);
    CHECK(pairs.smallestGap >= 0);
    const auto contacts = countContacts<Dim>(spheres, kTolerance, {}, cell);
    CHECK(contacts.pairs * 2 == pairs.partners);
    CHECK(listContacts<Dim>(spheres, kTolerance, cell).size() * 2 == pairs.partners);
    CHECK(*smallestGap<Dim>(spheres, 0, cell) == Approx(pairs.smallestGap).margin(1e-12));
    CHECK(checkOverlap<Dim>(spheres, cell).pairs == 0);
    if (cell.all()) CHECK(contacts.largestComponent > 0.98);
}

TEST_CASE("a periodic pack is the same for any number of threads") {
    const auto cell = cellOf<3>({62, 50, 41});
    const auto once = packIn<3>(cell, 5, 1).pack.spheres;
    for (const int threads : {2, 3, 8}) CHECK(packIn<3>(cell, 5, threads).pack.spheres == once);
}

TEST_CASE("a periodic cell is as dense as the inside of a box") {
    const auto cell = cellOf<3>({62, 62, 62});
    const auto pack = packIn<3>(cell).pack;
    CHECK(solidFraction(pack.spheres, *periodicDomain<3>(cell)) > 0.63);
    const auto flat = cellOf<2>({300, 300, 0});
    CHECK(solidFraction(packIn<2>(flat).pack.spheres, *periodicDomain<2>(flat)) > 0.82);
}

TEST_CASE("a cell shorter than four diameters is refused") {
    CHECK_THROWS_AS(packIn<3>(cellOf<3>({15.9, 40, 40})), InputError);
    CHECK_NOTHROW(packIn<3>(cellOf<3>({15.9, 40, 40}, "yz")));
    const auto cell = cellOf<3>({40, 40, 40});
    CHECK_THROWS_AS(packIn<3>(cell, 1, 0, {{cell.box.center(), 6}}), InputError);
}

TEST_CASE("a periodic pack goes around existing spheres and keeps the gap") {
    const auto cell = cellOf<3>({30, 30, 30});
    const Sphere<3> corner{cell.box.lo, 3};  // in all eight corners
    const Sphere<3> beyond{cell.box.center() + Vec<3>{{cell.length(0), 0, 0}}, 2};
    std::vector<Sphere<3>> all{corner, beyond};
    const auto added = packIn<3>(cell, 1, 0, all, 0.2).pack.spheres;
    REQUIRE(added.size() > 300);
    all[1].center = cell.wrapped(beyond.center);
    all.insert(all.end(), added.begin(), added.end());
    CHECK(allPairs<3>(all, cell, 0).smallestGap >= 0.2 * (1 - 1e-6));
}

DIM_TEST_CASE("blocks of a cell wait for neighbors across its faces without cycles") {
    const double length = GENERATE(17.0, 28.0, 55.0, 90.0);
    auto cell = cellOf<Dim>({length, 40, 28});
    const BlockLattice<Dim> lattice(cell.box, 10, 2, 0x1p-20, cell);
    std::vector<std::size_t> at(lattice.size());
    for (std::size_t i = 0; i < lattice.size(); ++i) at[lattice.order()[i]] = i;
    std::set<std::pair<std::uint32_t, std::uint32_t>> waits;
    for (std::uint32_t b = 0; b < lattice.size(); ++b)
        for (const auto& lower : lattice.lowerNeighbors(b)) {
            CHECK(at[lower.block] < at[b]);
            waits.insert({b, lower.block});
            // Its image touches the block.
            Box<Dim> image = lattice.own(lower.block);
            image.lo += cell.shift(lower.laps);
            image.hi += cell.shift(lower.laps);
            CHECK(!intersection(image.grown(0.01), lattice.own(b)).empty());
        }
    for (std::uint32_t a = 0; a < lattice.size(); ++a)
        for (std::uint32_t b = 0; b < a; ++b) {
            bool touch = false;
            cell.forEachShift(lattice.own(b), lattice.own(a).grown(0.01),
                              [&](const Vec<Dim>&) { touch = true; });
            CHECK(touch == (waits.count({a, b}) + waits.count({b, a}) == 1));
        }
    CHECK(lattice.longestChain() <= lattice.size());
}

TEST_CASE("overlaps across the faces of a cell are found") {
    const auto cell = cellOf<3>({20, 20, 20}, "xz");
    const Vec<3> lo = cell.box.lo, hi = cell.box.hi;
    const std::vector<Sphere<3>> spheres{{{{lo[0] + 0.5, lo[1] + 5, lo[2] + 0.5}}, 1},
                                         {{{hi[0] - 0.5, lo[1] + 5, hi[2] - 0.6}}, 1},
                                         {{{lo[0] + 9, lo[1] + 1, lo[2] + 9}}, 1},
                                         {{{lo[0] + 9, hi[1] - 0.5, lo[2] + 9}}, 1}};
    const OverlapCheck check = checkOverlap<3>(spheres, cell);
    CHECK(check.pairs == 1);  // of the other two there are walls between
    REQUIRE(check.worst.size() == 1);
    CHECK(check.worst[0].i == 0);
    CHECK(check.worst[0].j == 1);
    CHECK(check.max == Approx(2 - std::hypot(1.0, 1.1)));
    CHECK(checkOverlap<3>(spheres).pairs == 0);
    // Wherever the spheres were written.
    auto away = spheres;
    away[1].center[0] += 40;
    CHECK(checkOverlap<3>(away, cell).max == Approx(check.max));
    CHECK_THROWS_AS(checkOverlap<3>({{lo, 6}}, cell), InputError);
}

DIM_TEST_CASE("measures of a cell and of its shifted copy are equal") {
    const auto cell = Dim == 3 ? cellOf<Dim>({25, 21, 24}) : cellOf<Dim>({70, 55, 0});
    const auto spheres = packIn<Dim>(cell).pack.spheres;
    Vec<Dim> by;
    for (int d = 0; d < Dim; ++d) by[d] = 7.3 + d;
    const auto moved = shifted<Dim>(spheres, cell, by);
    const double volume = cell.box.volume();
    const auto g = pairCorrelation<Dim>(spheres, {}, 9, volume, 50, {}, cell);
    const auto h = pairCorrelation<Dim>(moved, {}, 9, volume, 50, {}, cell);
    REQUIRE((g && h));
    CHECK(g->references == spheres.size());
    for (std::size_t k = 0; k < g->g.size(); ++k) {
        // Rounding may move a few pairs to the next bin.
        const double pair = g->g[k] > 0 ? g->error[k] * g->error[k] / g->g[k] : 0;
        CHECK(std::fabs(g->g[k] - h->g[k]) <= 4 * pair);
    }
    CHECK(solidLikeShare<Dim>(spheres, cell) == Approx(solidLikeShare<Dim>(moved, cell)));
    const auto contacts = countContacts<Dim>(spheres, kTolerance, {}, cell);
    const auto again = countContacts<Dim>(moved, kTolerance, {}, cell);
    CHECK(contacts.pairs == again.pairs);
    CHECK(contacts.histogram == again.histogram);
    for (std::size_t r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            CHECK(contacts.fabric[r][c] == Approx(again.fabric[r][c]).margin(1e-6));
    CHECK_THROWS_AS(pairCorrelation<Dim>(spheres, {}, 30, volume, 50, {}, cell), ParameterError);
}

DIM_TEST_CASE("densified periodic packs have no overlaps across faces") {
    const auto axes = GENERATE(as<std::string>(), "xyz", "y");
    const auto cell = Dim == 3 ? cellOf<Dim>({24, 21, 24}, axes) : cellOf<Dim>({70, 55, 0}, axes);
    const auto domain = periodicDomain<Dim>(cell);
    const auto front = packIn<Dim>(cell).pack.spheres;
    DensifyOptions options;
    options.fraction = solidFraction(front, *domain) + (Dim == 3 ? 0.02 : 0.006);
    const auto result = densify<Dim>(*domain, front, options);
    CAPTURE(Dim, axes, result.before, result.after);
    CHECK(result.reached);
    CHECK(allPairs<Dim>(result.spheres, cell, 0).smallestGap >= 0);
    CHECK(std::all_of(result.spheres.begin(), result.spheres.end(),
                      [&](const Sphere<Dim>& s) { return cell.wrapped(s.center) == s.center; }));
}

TEST_CASE("spheres that overlap across a face are moved apart") {
    const auto cell = cellOf<3>({17, 17, 17});
    const auto domain = periodicDomain<3>(cell);
    auto spheres = shifted<3>(packIn<3>(cell).pack.spheres, cell, {{3, 4, 5}});
    for (auto& s : spheres) s.radius *= 1.01;
    REQUIRE(allPairs<3>(spheres, cell, 0).smallestGap < 0);
    DensifyOptions options;
    options.fixed = 1;
    const auto result = densify<3>(*domain, spheres, options);
    CHECK(result.apart);
    CHECK(result.spheres[0] == spheres[0]);
    CHECK(allPairs<3>(result.spheres, cell, 0).smallestGap >= 0);
}

TEST_CASE("a densified periodic pack is at its faces as elsewhere") {
    const auto cell = cellOf<3>({62, 62, 62});
    const auto domain = periodicDomain<3>(cell);
    const double layer = cell.box.volume() - boxDomain<3>(cell.box)->volumeDeeperThan(4);
    constexpr int kSeeds = 4;  // 10,000 spheres scatter by 0.002
    double denser = 0, larger = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
        DensifyOptions options;
        options.fraction = 0.65;
        options.sizes = SizeDistribution::uniform(1, 2);
        options.seed = static_cast<std::uint64_t>(seed);
        options.mixSizes = true;
        const auto result =
            densify<3>(*domain, packIn<3>(cell, options.seed).pack.spheres, options);
        REQUIRE(result.reached);
        // Whole spheres with their images, and the box without a layer at its faces.
        const auto all = withImages<3>(result.spheres, cell, 0);
        const double total = solidFraction(result.spheres, *domain);
        const auto inner = interiorFraction<3>(all.spheres, *boxDomain<3>(cell.box), 4);
        REQUIRE(inner);
        denser += (total - *inner) * cell.box.volume() / layer / kSeeds;
        double sum = 0, count = 0;
        for (const auto& s : result.spheres) {
            const bool near = [&] {
                for (int d = 0; d < 3; ++d)
                    if (std::min(s.center[d] - cell.box.lo[d], cell.box.hi[d] - s.center[d]) < 4)
                        return true;
                return false;
            }();
            sum += near ? s.radius : 0;
            count += near;
        }
        larger += (sum / count / 1.5 - 1) / kSeeds;
    }
    CAPTURE(denser, larger);
    CHECK(std::fabs(denser) < 0.002);
    CHECK(std::fabs(larger) < 0.005);
}

TEST_CASE("a periodic pack stays as it was where a fraction cannot be reached") {
    const auto cell = cellOf<3>({17, 17, 17});
    const auto domain = periodicDomain<3>(cell);
    const auto front = packIn<3>(cell).pack.spheres;
    DensifyOptions options;
    options.fraction = 0.94;
    options.mixSizes = true;
    int calls = 0;
    Callbacks callbacks;
    const bool interrupted = GENERATE(false, true);
    callbacks.cancelled = [&] { return interrupted && ++calls > 20; };
    const auto result = densify<3>(*domain, front, options, callbacks);
    CHECK_FALSE(result.reached);
    CHECK(result.interrupted == interrupted);
    CHECK(allPairs<3>(result.spheres, cell, 0).smallestGap >= 0);
    CHECK(result.after >= result.before);
    if (interrupted) CHECK(result.spheres == front);
}
