#include "vdbpack/view/packed_arrays.h"

#include "vdbpack/core/error.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

std::string deflated(const std::string& bytes) {
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    std::string packed(size, '\0');
    if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                  reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()),
                  Z_DEFAULT_COMPRESSION) != Z_OK)
        throw ResourceError("a view cannot be compressed: too little memory");
    packed.resize(size);
    return packed;
}

/// The lowest 16 bits, two zeros between each and the next.
std::uint64_t spread(std::uint64_t x) {
    x = (x | x << 16) & 0xff0000ffull;
    x = (x | x << 8) & 0xf00f00f00full;
    x = (x | x << 4) & 0xc30c30c30c3ull;
    return (x | x << 2) & 0x249249249249ull;
}

}  // namespace

std::string packedNumbers(const std::vector<std::uint64_t>& numbers, int planes) {
    std::string bytes;
    bytes.reserve(numbers.size() * static_cast<std::size_t>(planes));
    for (int plane = 0; plane < planes; ++plane)
        for (const std::uint64_t n : numbers) bytes += static_cast<char>(n >> 8 * plane & 255);
    return deflated(bytes);
}

int planesFor(std::uint64_t most) {
    int planes = 1;
    while (planes < 8 && most >> 8 * planes != 0) ++planes;
    return planes;
}

std::uint64_t mortonCode(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return spread(x) | spread(y) << 1 | spread(z) << 2;
}

Quantized quantized(const std::vector<double>& values, std::uint64_t most) {
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (const double v : values)
        if (std::isfinite(v)) {
            lo = std::min(lo, v);
            hi = std::max(hi, v);
        }
    Quantized q;
    if (!(lo <= hi)) lo = hi = 0;
    q.lo = lo;
    q.step = (hi - lo) / static_cast<double>(most);
    q.numbers.reserve(values.size());
    for (const double v : values)
        q.numbers.push_back(!std::isfinite(v) ? most + 1
                            : q.step > 0
                                ? static_cast<std::uint64_t>(std::llround((v - lo) / q.step))
                                : 0);
    return q;
}

}  // namespace vdbpack
