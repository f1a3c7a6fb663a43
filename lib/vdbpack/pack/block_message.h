// Private to pack: what a block tells the ranks of the blocks that build on it.
#pragma once

#include "vdbpack/pack/front/block_spheres.h"
#include "vdbpack/pack/radius_pool.h"
#include "vdbpack/pack/species.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdbpack {

template <int Dim>
struct BlockMessage {
    std::uint32_t block = 0;
    bool stopped = false;      ///< the sender was interrupted: the block may not be complete
    BlockSpheres<Dim> placed;  ///< in reach of blocks of the receiver, with their sites there
    /// What is pending of each group of sizes, if the receiver takes it over.
    std::vector<RadiusPool::State> pools;
    std::optional<SpeciesQueue::State> further;
};

template <int Dim>
std::vector<std::byte> toBytes(const BlockMessage<Dim>& message);
/// @param bytes  of `toBytes`, on a machine of the same kind.
template <int Dim>
BlockMessage<Dim> blockMessage(const std::vector<std::byte>& bytes);

}  // namespace vdbpack
