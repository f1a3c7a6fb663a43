// Private to views: numbers as compressed bytes that a page decodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

/// Whole numbers as byte planes (all lowest bytes, then all second ones, ...), which compress
/// better than number after number, as a zlib stream.
/// @param planes  bytes a number, 1 to 8.
std::string packedNumbers(const std::vector<std::uint64_t>& numbers, int planes);

/// Bytes that hold numbers up to `most`.
int planesFor(std::uint64_t most);

/// The bits of three 16-bit numbers in turns, x in the lowest: neighbors in the order of these
/// codes are neighbors in space, so that their differences are small (Morton 1966).
std::uint64_t mortonCode(std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// `values` in steps between the least and the greatest.
struct Quantized {
    double lo = 0, step = 0;
    std::vector<std::uint64_t> numbers;
};
/// Values as whole numbers up to `most`; `most + 1` stands for those that are not finite.
Quantized quantized(const std::vector<double>& values, std::uint64_t most);

}  // namespace vdbpack
