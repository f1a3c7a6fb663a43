// The order in which a front takes its sites.
#pragma once

namespace vdbpack {

/// sweep: along a diagonal of the axes, in blocks and on all threads. The others are those of the
/// literature, for comparison, and run as one block on one thread: from the wall inwards, from the
/// middle outwards, and first in, first out from the middle.
enum class Order { sweep, wall, center, fifo };

constexpr const char* nameOf(Order order) {
    return order == Order::sweep    ? "sweep"
           : order == Order::wall   ? "wall"
           : order == Order::center ? "centre"
                                    : "fifo";
}

}  // namespace vdbpack
