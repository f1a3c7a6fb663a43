// A folder for the files of one test, removed with all that it holds.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/rng.h"

#include <catch2/catch.hpp>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace vdbpack {

class Scratch {
public:
    Scratch() {
        std::string name = (std::filesystem::temp_directory_path() / "vdbpack.XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) FAIL("no folder for the files of the test");
        folder_ = name;
    }
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    std::string operator/(const std::string& name) const { return (folder_ / name).string(); }
    std::size_t files() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_),
                                                      std::filesystem::directory_iterator()));
    }

private:
    std::filesystem::path folder_;
};

inline std::string contentOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void putContent(const std::string& path, const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
}

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

}  // namespace vdbpack
