// What several processes (ranks) are worth: measured here, and predicted for more.
#pragma once

namespace vdbpack {
class Ranks;
}

/// Without ranks: measures the blocks of the paper's cube (side 200 mm, radii 1 to 2 mm), what
/// smaller ones cost, and prints the model's efficiency for 10^8 to 10^10 spheres on 16 to 4096
/// cores. With ranks: packs the cube with them, and prints time, messages and bytes beside the
/// prediction.
/// @param threads  of each rank, or of the one process.
/// @param ranks    null: there are none.
void benchRanks(int threads, bool quick, vdbpack::Ranks* ranks);
