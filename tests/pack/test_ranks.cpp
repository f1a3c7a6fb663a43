// Packs that several ranks fill together; here threads stand for them.
#include "support/thread_ranks.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/size_field.h"
#include "vdbpack/pack/wavefront.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <atomic>
#include <utility>

using namespace vdbpack;

namespace {

/// The packs of all ranks, joined by `order`.
template <int Dim>
PackResult<Dim> packByRanks(int ranks, const Domain<Dim>& domain, const PackOptions& options,
                            const std::vector<Sphere<Dim>>& existing = {},
                            const Callbacks& callbacks = {}) {
    RankOffice office(ranks);
    std::vector<PackResult<Dim>> parts(static_cast<std::size_t>(ranks));
    onRanks(office, [&](Ranks& rank) {
        PackOptions mine = options;
        mine.ranks = &rank;
        parts[static_cast<std::size_t>(rank.rank())] =
            packBlocks(domain, domain, mine, callbacks, existing);
    });
    for (const auto& box : office.boxes) CHECK(box.empty());
    PackResult<Dim> all = parts.front();
    std::size_t total = 0;
    for (const auto& part : parts) total += part.pack.spheres.size();
    all.pack.spheres.assign(total, {});
    all.species.assign(options.species.empty() ? 0 : total, 0);
    for (const auto& part : parts)
        for (std::size_t i = 0; i < part.pack.order.size(); ++i) {
            const auto at = static_cast<std::size_t>(part.pack.order[i]);
            REQUIRE(at < total);
            all.pack.spheres[at] = part.pack.spheres[i];
            if (!all.species.empty()) all.species[at] = part.species[i];
        }
    if (ranks > 1 && all.blocks > 1) CHECK(office.messages > 0);
    CHECK(office.messages <= 8 * all.blocks);
    if (all.blocks == 8 * 27) CHECK(office.bytes <= 80 * total);
    return all;
}

template <int Dim>
void checkRanks(const Domain<Dim>& domain, PackOptions options,
                const std::vector<Sphere<Dim>>& existing = {}) {
    const auto alone = packBlocks(domain, domain, options, Callbacks{}, existing);
    REQUIRE(alone.blocks > 8);
    for (const auto& [ranks, threads] : {std::pair(1, 2), {2, 1}, {3, 2}, {4, 1}, {8, 2}}) {
        CAPTURE(ranks, threads);
        options.threads = threads;
        const auto together = packByRanks(ranks, domain, options, existing);
        CHECK(together.pack.spheres == alone.pack.spheres);
        CHECK(together.species == alone.species);
    }
}

PackOptions optionsFor(const std::string& radii, int dim) {
    PackOptions options(SizeDistribution::parse(radii, dim));
    options.effort = Effort::fast;
    options.blockSide = 18;
    return options;
}

}  // namespace

TEST_CASE("the pack is the same for any number of ranks and threads", "[pack][ranks]") {
    SECTION("in a box") {
        checkRanks<3>(*boxDomain<3>({{}, {{60, 70, 80}}}), optionsFor("uniform:1,2", 3));
    }
    SECTION("in a ball, whose first blocks are empty") {
        checkRanks<3>(*ballDomain<3>(30), optionsFor("constant:1.2", 3));
    }
    SECTION("in the plane") {
        checkRanks<2>(*boxDomain<2>({{}, {{300, 250}}}), optionsFor("uniform:1,2", 2));
    }
    SECTION("in a periodic cell") {
        checkRanks<3>(*periodicDomain<3>({{{}, {{60, 70, 80}}}, {true, true, true}}),
                      optionsFor("uniform:1,2", 3));
        // Of two blocks along an axis, each is the neighbor of the other on both sides.
        checkRanks<3>(*periodicDomain<3>({{{}, {{30, 40, 80}}}, {true, false, true}}),
                      optionsFor("uniform:1,2", 3));
        checkRanks<2>(*periodicDomain<2>({{{}, {{300, 250}}}, {true, true}}),
                      optionsFor("uniform:1,2", 2));
    }
    SECTION("with wide sizes") {
        checkRanks<3>(*boxDomain<3>({{}, {{60, 70, 80}}}), optionsFor("uniform:0.8,3", 3));
    }
    SECTION("with sizes that differ by place") {
        const auto box = boxDomain<3>({{}, {{60, 70, 80}}});
        PackOptions options = optionsFor("uniform:0.5,1", 3);
        options.local.factor = std::make_shared<SizeField>(
            box->bounds(), Vec<3>{}, 1, [](const Vec<3>& x) { return 1.5 + x[0] / 60; });
        options.local.shellSizes = SizeDistribution::parse("uniform:0.8,1.2", 3);
        options.local.shell = ShellThickness(5);
        options.blockSide = 22;
        checkRanks<3>(*box, options);
    }
    SECTION("with further species") {
        PackOptions options = optionsFor("uniform:1,2", 3);
        options.species.push_back({SizeDistribution::parse("constant:3", 3), 0.05, 2});
        checkRanks<3>(*boxDomain<3>({{}, {{60, 70, 80}}}), options);
    }
    SECTION("around existing spheres, with a gap, of which the first are taken") {
        PackOptions options = optionsFor("uniform:1,2", 3);
        options.gap = 0.1;
        options.maxCount = 5000;
        checkRanks<3>(*boxDomain<3>({{}, {{60, 70, 80}}}), options,
                      {{{{30, 30, 30}}, 12}, {{{20, 60, 60}}, 1.5}});
    }
}

TEST_CASE("ranks tell one another few bytes of each sphere", "[pack][ranks]") {
    // Blocks of the usual size, 6 along each side.
    PackOptions options(SizeDistribution::parse("uniform:1,2", 3));
    options.effort = Effort::fast;
    const auto box = boxDomain<3>({{}, {{250, 250, 250}}});
    CHECK(packByRanks<3>(8, *box, options).blocks == 8 * 27);
}

TEST_CASE("ranks end together when one of them is interrupted", "[pack][ranks]") {
    const auto domain = boxDomain<3>({{}, {{80, 80, 80}}});
    const PackOptions options = optionsFor("uniform:1,2", 3);
    std::atomic<int> asked{0};
    Callbacks callbacks;
    callbacks.cancelled = [&] { return ++asked > 200; };
    const auto part = packByRanks<3>(4, *domain, options, {}, callbacks);
    CHECK(part.interrupted);
    CHECK(part.pack.spheres.size() <
          packBlocks(*domain, *domain, options, Callbacks{}, {}).pack.spheres.size());
}
