// How the blocks of a pack are shared out to ranks, and what ranks tell one another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Connects a rank, usually a process, to the others that fill the same domain. Every rank calls
/// `packBlocks` with the same domain and options, and fills its own blocks.
///
/// All members are called from one thread of the rank.
class BlockExchange {
public:
    virtual ~BlockExchange() = default;

    virtual int rank() const = 0;
    virtual int ranks() const = 0;
    /// Sends a message without waiting for its receipt. Messages between two ranks keep their
    /// order.
    virtual void send(int to, std::vector<std::byte> message) = 0;
    /// The next message, if one has arrived. @return whether there was one.
    virtual bool receive(std::vector<std::byte>& message) = 0;
    /// Replaces numbers by their sums over all ranks; called by all of them.
    virtual void sum(std::vector<std::uint64_t>& numbers) = 0;
};

}  // namespace vdbpack
