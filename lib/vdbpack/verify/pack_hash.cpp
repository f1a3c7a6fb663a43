#include "vdbpack/core/parallel.h"
#include "vdbpack/verify/mix.h"
#include "vdbpack/verify/verify.h"

#include <fmt/format.h>
#include <tbb/parallel_reduce.h>

#include <functional>

namespace vdbpack {

template <int Dim>
std::uint64_t packHash(const Pack<Dim>& pack) {
    const auto take = [](std::uint64_t h, double v) { return mixedBits(h ^ bitsOfNumber(v)); };
    return tbb::parallel_reduce(
        IndexRange(0, pack.spheres.size(), 4096), std::uint64_t{0},
        [&](const IndexRange& block, std::uint64_t sum) {
            for (std::size_t i = block.begin(); i < block.end(); ++i) {
                const Sphere<Dim>& s = pack.spheres[i];
                std::uint64_t h = kHashStart;
                for (int k = 0; k < Dim; ++k) h = take(h, s.center[k]);
                if (Dim == 2) h = take(h, pack.sliceHeight);
                sum += take(h, s.radius);
            }
            return sum;
        },
        std::plus<>());
}

std::string hashText(std::uint64_t hash) {
    return fmt::format("{:016x}", hash);
}

template std::uint64_t packHash<2>(const Pack<2>&);
template std::uint64_t packHash<3>(const Pack<3>&);

}  // namespace vdbpack
