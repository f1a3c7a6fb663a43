#include "vdbpack/pack/block_message.h"

#include <cstring>
#include <new>
#include <type_traits>
#include <utility>

namespace vdbpack {

namespace {

class ByteWriter {
public:
    template <class T>
    void operator()(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        append(&value, sizeof value);
    }
    template <class T>
    void operator()(const std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        (*this)(std::uint64_t{values.size()});
        append(values.data(), values.size() * sizeof(T));
    }
    std::vector<std::byte> take() { return std::move(bytes_); }

private:
    void append(const void* data, std::size_t size) {
        const auto* const from = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), from, from + size);
    }
    std::vector<std::byte> bytes_;
};

class ByteReader {
public:
    explicit ByteReader(const std::vector<std::byte>& bytes) : at_(bytes.data()) {}

    template <class T>
    void operator()(T& value) {
        take(&value, sizeof value);
    }
    template <class T>
    void operator()(std::vector<T>& values) {
        std::uint64_t size = 0;
        (*this)(size);
        for (std::uint64_t i = 0; i < size; ++i) {
            alignas(T) std::byte copy[sizeof(T)];
            take(copy, sizeof copy);
            values.push_back(*std::launder(reinterpret_cast<T*>(copy)));
        }
    }

private:
    void take(void* to, std::size_t size) {
        std::memcpy(to, at_, size);
        at_ += size;
    }
    const std::byte* at_;
};

/// The members of a message in the order of the bytes.
template <int Dim, class Bytes, class Message>
void visit(Bytes& bytes, Message& message) {
    bytes(message.block);
    bytes(message.stopped);
    bytes(message.placed.spheres);
    bytes(message.placed.sites);
}
template <class Bytes, class State>
void visitPool(Bytes& bytes, State& pool) {
    bytes(pool.share);
    bytes(pool.given);
    bytes(pool.limit);
    bytes(pool.radii);
}
template <class Bytes, class State>
void visitFurther(Bytes& bytes, State& further) {
    bytes(further.random);
    bytes(further.shares);
    bytes(further.due);
}

}  // namespace

template <int Dim>
std::vector<std::byte> toBytes(const BlockMessage<Dim>& message) {
    ByteWriter bytes;
    visit<Dim>(bytes, message);
    bytes(std::uint64_t{message.pools.size()});
    for (const auto& pool : message.pools) visitPool(bytes, pool);
    bytes(message.further.has_value());
    if (message.further) visitFurther(bytes, *message.further);
    return bytes.take();
}

template <int Dim>
BlockMessage<Dim> blockMessage(const std::vector<std::byte>& from) {
    BlockMessage<Dim> message;
    ByteReader bytes(from);
    visit<Dim>(bytes, message);
    std::uint64_t pools = 0;
    bytes(pools);
    message.pools.resize(pools);
    for (auto& pool : message.pools) visitPool(bytes, pool);
    bool has = false;
    bytes(has);
    if (has) visitFurther(bytes, message.further.emplace());
    return message;
}

template std::vector<std::byte> toBytes(const BlockMessage<2>&);
template std::vector<std::byte> toBytes(const BlockMessage<3>&);
template BlockMessage<2> blockMessage(const std::vector<std::byte>&);
template BlockMessage<3> blockMessage(const std::vector<std::byte>&);

}  // namespace vdbpack
