// Sites that pass from one block's front to the next.
#pragma once

#include "vdbpack/pack/front/block_spheres.h"
#include "vdbpack/pack/front/front.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Appends the sites on the spheres placed in a block that lie in later blocks.
template <int Dim>
void handOver(const Front<Dim>& front, std::vector<HandedSite<Dim>>& handed);

/// Adds the sites that finished blocks have handed over, limited by the spheres placed since.
/// @param around  spheres and sites as the finished blocks left them.
/// @param local   index in the front of each sphere of `around`; FrontSites::kNone: not in reach.
template <int Dim>
void takeOver(const BlockSpheres<Dim>& around, const std::vector<std::uint32_t>& local,
              Front<Dim>& front);

}  // namespace vdbpack
