#include "vdbpack/pack/species.h"

#include "vdbpack/pack/radius_pool.h"

#include <algorithm>
#include <limits>

namespace vdbpack {

namespace {
/// Offset from the random streams of pools.
constexpr std::uint64_t kStreams = std::uint64_t{1} << 48;
/// Bounds what waits where no sphere of a species finds room.
constexpr std::size_t kMostDue = 4096;
}  // namespace

SpeciesQueue::SpeciesQueue(const std::vector<Species>& species, std::uint64_t seed,
                           std::uint64_t stream, double shell)
    : species_(species),
      shell_(shell),
      depth_(std::numeric_limits<double>::infinity()),
      random_(seed, kStreams + stream) {
    for (const Species& s : species_) {
        depth_ = std::min(depth_, s.depth);
        shares_.push_back(random_.bits());
    }
}

void SpeciesQueue::draw() {
    while (due_.size() < kMostDue) {
        double u = random_.uniform();
        std::size_t s = 0;
        while (s < species_.size() && u >= species_[s].probability) u -= species_[s++].probability;
        if (s == species_.size()) return;  // the first species
        shares_[s] += kGoldenStep;
        const double share = static_cast<double>(shares_[s] >> 11) * 0x1p-53;
        due_.push_back({static_cast<std::uint8_t>(s + 1),
                        species_[s].sizes.quantile(share) + shell_, species_[s].depth});
    }
}

}  // namespace vdbpack
