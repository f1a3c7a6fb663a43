// Packs with every attribute filled, as files must give them back.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/rng.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <cstdint>

namespace vdbpack::test {

/// Spheres on the lattice of a packer: whole multiples of 2^-22 mm about `center`, radii that are
/// floats near 1, with every attribute filled.
template <int Dim>
Pack<Dim> latticePack(std::size_t count, const Vec<Dim>& center, double side, std::uint64_t seed) {
    RandomStream random(seed, 7);
    Pack<Dim> pack;
    for (std::size_t i = 0; i < count; ++i) {
        Sphere<Dim> s;
        for (int d = 0; d < Dim; ++d)
            s.center[d] =
                std::nearbyint((center[d] + side * (random.uniform() - 0.5)) * 0x1p22) * 0x1p-22;
        s.radius = static_cast<double>(static_cast<float>(1 + random.uniform()));
        pack.spheres.push_back(s);
        pack.region.push_back(static_cast<std::int32_t>(random.bits() % 2));
        pack.order.push_back(static_cast<std::int64_t>(count - i));
        pack.depth.push_back(static_cast<float>(random.uniform() * 30));
        pack.contacts.push_back(static_cast<std::int32_t>(random.bits() % 12));
    }
    return pack;
}

/// All attributes but the further columns.
inline void requireSameAttributes(const PackAttributes& read, const PackAttributes& written) {
    // Compared before the macro: a million numbers are no message.
    REQUIRE((read.id == written.id));
    REQUIRE((read.region == written.region));
    REQUIRE((read.order == written.order));
    REQUIRE((read.depth == written.depth));
    REQUIRE((read.contacts == written.contacts));
}

}  // namespace vdbpack::test
