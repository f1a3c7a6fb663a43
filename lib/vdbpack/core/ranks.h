// Ranks: processes that work on one pack together, and what they tell one another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

/// Connects a rank, usually a process, to the others. Every rank makes the same calls with the same
/// domain and options, and works on its own share of the spheres.
///
/// All members are called from one thread of the rank.
class Ranks {
public:
    using Bytes = std::vector<std::byte>;

    virtual ~Ranks() = default;

    virtual int rank() const = 0;
    virtual int count() const = 0;

    /// Sends a message without waiting for its receipt. Messages between two ranks keep their
    /// order.
    virtual void send(int to, Bytes message) = 0;
    /// The next message, if one has arrived. @return whether there was one.
    virtual bool receive(Bytes& message) = 0;

    // Called by all ranks, and wait for all.

    /// Replaces numbers by their sums over all ranks, modulo 2^64.
    virtual void sum(std::vector<std::uint64_t>& numbers) = 0;
    /// @param toEach  what each rank is to get. @return what each rank sent to this one.
    virtual std::vector<Bytes> exchange(std::vector<Bytes> toEach) = 0;

    bool isFirst() const { return rank() == 0; }
};

/// Values that can be sent as they are, as bytes.
template <class T>
Ranks::Bytes bytesOf(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    Ranks::Bytes bytes(values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}
/// @param bytes  of `bytesOf`, on a machine of the same kind.
template <class T>
std::vector<T> valuesOf(const Ranks::Bytes& bytes) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<T> values(bytes.size() / sizeof(T));
    if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
}

/// Sends a list of values to each rank. @return the lists of all ranks for this one, by rank.
template <class T>
std::vector<std::vector<T>> exchanged(Ranks& ranks, std::vector<std::vector<T>> toEach) {
    std::vector<Ranks::Bytes> bytes;
    for (auto& list : toEach) {
        bytes.push_back(bytesOf(list));
        list = {};
    }
    bytes = ranks.exchange(std::move(bytes));
    for (std::size_t r = 0; r < bytes.size(); ++r) {
        toEach[r] = valuesOf<T>(bytes[r]);
        bytes[r] = {};
    }
    return toEach;
}
/// All values of some lists, in their order.
template <class T>
std::vector<T> joined(const std::vector<std::vector<T>>& lists) {
    std::vector<T> all;
    for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
}

/// The values of each rank, by rank, on all of them. @param ranks  null: this one alone.
template <class T>
std::vector<std::vector<T>> gathered(Ranks* ranks, std::vector<T> values) {
    if (!ranks) return {std::move(values)};
    const auto each = static_cast<std::size_t>(ranks->count());
    return exchanged(*ranks, std::vector<std::vector<T>>(each, values));
}

// Over all ranks; `ranks` null: this one alone. Integers are exact, a sum of doubles is rounded in
// the order of the ranks.

inline std::uint64_t sumOver(Ranks* ranks, std::uint64_t number) {
    if (!ranks) return number;
    std::vector<std::uint64_t> sum{number};
    ranks->sum(sum);
    return sum.front();
}
inline double sumOver(Ranks* ranks, double number) {
    double sum = 0;
    for (const auto& values : gathered(ranks, std::vector<double>{number})) sum += values.front();
    return sum;
}
inline double maxOver(Ranks* ranks, double number) {
    for (const auto& values : gathered(ranks, std::vector<double>{number}))
        number = values.front() > number ? values.front() : number;
    return number;
}
inline double minOver(Ranks* ranks, double number) {
    return -maxOver(ranks, -number);
}
inline bool anyOver(Ranks* ranks, bool value) {
    return sumOver(ranks, std::uint64_t{value}) > 0;
}

/// Which rows the spheres of a rank are in the pack of all; by default it has the whole pack.
struct SphereRows {
    Ranks* ranks = nullptr;
    std::vector<std::int64_t> rows{};  ///< of each sphere; unused without `ranks`

    std::size_t operator[](std::size_t i) const {
        return ranks ? static_cast<std::size_t>(rows[i]) : i;
    }
};

}  // namespace vdbpack
