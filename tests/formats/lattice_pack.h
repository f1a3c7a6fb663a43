// Packs with every attribute filled, as files must give them back.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/rng.h"

#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>

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

/// Two texts in turn, the first for sphere 0.
inline Column textColumn(const std::string& name, const std::array<std::string, 2>& texts,
                         std::size_t count) {
    Column column;
    column.name = name;
    for (std::size_t i = 0; i < count; ++i) column.texts.push_back(texts[i % 2]);
    return column;
}

/// A lattice pack with ids 1, 3, 5, ..., a column of numbers and one of texts.
inline Pack<3> packWithColumns(std::size_t count, const std::string& numbers,
                               const std::string& text, const std::array<std::string, 2>& texts) {
    auto pack = latticePack<3>(count, {{60, -700, 3}}, 40, 5);
    Column thirds;
    thirds.name = numbers;
    for (std::size_t i = 0; i < count; ++i) {
        pack.id.push_back(static_cast<std::int64_t>(2 * i + 1));
        thirds.numbers.push_back(static_cast<double>(i) / 3);
    }
    pack.columns = {thirds, textColumn(text, texts, count)};
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

/// The further columns. @param named  whether their names are the same, too.
inline void requireSameColumns(const PackAttributes& read, const PackAttributes& written,
                               bool named = true) {
    REQUIRE(read.columns.size() == written.columns.size());
    for (std::size_t c = 0; c < read.columns.size(); ++c) {
        CAPTURE(c);
        if (named) CHECK(read.columns[c].name == written.columns[c].name);
        CHECK((read.columns[c].numbers == written.columns[c].numbers));
        CHECK((read.columns[c].texts == written.columns[c].texts));
    }
}

}  // namespace vdbpack::test
