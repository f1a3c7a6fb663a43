// Packs that several ranks fill together; here threads stand for them.
#include "support/test.h"
#include "support/thread_ranks.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/pack/size_field.h"
#include "vdbpack/pack/wavefront.h"

#include <atomic>

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
    if (all.blocks == 6 * 6 * 3) CHECK(office.bytes <= 80 * total);
    return all;
}

template <int Dim>
void checkRanks(const Domain<Dim>& domain, PackOptions options,
                const std::vector<Sphere<Dim>>& existing = {}) {
    const auto alone = packBlocks(domain, domain, options, Callbacks{}, existing);
    REQUIRE(alone.blocks > 8);
    for (const auto& [ranks, threads] : {std::pair(1, 2), {3, 1}, {8, 2}}) {
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

TEST_CASE("the pack is the same for any number of ranks and threads") {
    const auto box = boxDomain<3>({{}, {{60, 70, 80}}});
    const auto rect = boxDomain<2>({{}, {{300, 250}}});
    const PackOptions space = optionsFor("uniform:1,2", 3), plane = optionsFor("uniform:1,2", 2);
    SECTION("in boxes, and in a ball, whose first blocks are empty") {
        checkRanks<3>(*box, space);
        checkRanks<2>(*rect, plane);
        checkRanks<3>(*ballDomain<3>(30), optionsFor("constant:1.2", 3));
        checkRanks<3>(*box, optionsFor("uniform:0.8,3", 3));
        PackOptions wavy = space;
        wavy.order = Order::waves;
        checkRanks<3>(*box, wavy);
    }
    SECTION("in a periodic cell") {
        checkRanks<3>(*periodicDomain<3>({{{}, {{60, 70, 80}}}, {true, true, true}}), space);
        // Of two blocks along an axis, each is the neighbor of the other on both sides.
        checkRanks<3>(*periodicDomain<3>({{{}, {{30, 40, 80}}}, {true, false, true}}), space);
        checkRanks<2>(*periodicDomain<2>({{{}, {{300, 250}}}, {true, true}}), plane);
    }
    SECTION("with sizes that differ by place") {
        PackOptions options = optionsFor("uniform:0.5,1", 3);
        options.local.factor = std::make_shared<SizeField>(
            box->bounds(), Vec<3>{}, 1, [](const Vec<3>& x) { return 1.5 + x[0] / 60; });
        options.local.shellSizes = SizeDistribution::parse("uniform:0.8,1.2", 3);
        options.local.shell = ShellThickness(5);
        options.blockSide = 22;
        checkRanks<3>(*box, options);
    }
    SECTION("with further species, and around existing spheres, of which the first are taken") {
        PackOptions options = space;
        options.species.push_back({SizeDistribution::parse("constant:3", 3), 0.05, 2});
        checkRanks<3>(*box, options);
        options = space;
        options.gap = 0.1;
        options.maxCount = 5000;
        checkRanks<3>(*box, options, {{{{30, 30, 30}}, 12}, {{{20, 60, 60}}, 1.5}});
    }
}

TEST_CASE("ranks tell one another few bytes of each sphere") {
    // Blocks of the usual size.
    PackOptions options(SizeDistribution::parse("uniform:1,2", 3));
    options.effort = Effort::fast;
    const auto box = boxDomain<3>({{}, {{250, 250, 125}}});
    CHECK(packByRanks<3>(8, *box, options).blocks == 6 * 6 * 3);
}

TEST_CASE("ranks end together when one of them is interrupted") {
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
