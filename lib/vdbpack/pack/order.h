// The order in which a front takes its places.
#pragma once

namespace vdbpack {

/// sweep: along a diagonal of the axes, in blocks and on all threads. The others are those of the
/// literature, for comparison, and run as one block on one thread: wall first, those nearest to the
/// middle first, and first in, first out from the middle.
enum class Order { sweep, wall, center, fifo };

}  // namespace vdbpack
