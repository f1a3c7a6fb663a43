// Private to field: the bytes of a .vdb file, and checks of its parts (vdb_check.h).
#pragma once

#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace vdbpack {

using LeafMask = std::bitset<512>;

/// The bytes of a file in order, none behind its end.
class VdbBytes {
public:
    explicit VdbBytes(const std::string& path) : file_(path) {}

    const std::string& path() const { return file_.path(); }
    std::uint64_t size() const { return file_.size(); }
    std::uint64_t at() const { return file_.offset(); }
    std::uint64_t left() const { return file_.remaining(); }

    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(
            fmt::format("{}: byte {} of {}: {}; the file is damaged or cut short: write it again",
                        path(), at(), size(), what));
    }
    /// The next `count` bytes (a few KB at most), valid until the next call.
    const char* take(std::size_t count, const char* what) {
        if (count > left()) fail(fmt::format("{} should follow, but the file ends", what));
        return file_.take(count);
    }
    void skip(std::uint64_t count, const char* what) {
        if (count > left())
            fail(fmt::format("{} of {} bytes should follow, more than the file has", what, count));
        seek(at() + count);
    }
    void seek(std::uint64_t offset) { file_.seek(offset); }
    template <typename T>
    T get(const char* what) {
        T value;
        std::memcpy(&value, take(sizeof value, what), sizeof value);
        return value;
    }
    template <std::size_t Bits>
    std::bitset<Bits> mask() {
        const char* const from = take(Bits / 8, "a mask of a node");
        std::bitset<Bits> mask;
        static_assert(sizeof mask == Bits / 8 && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
        std::memcpy(static_cast<void*>(&mask), from, Bits / 8);
        return mask;
    }
    /// The mask of a leaf a second time.
    void skipLeafMask(const LeafMask& before) {
        if (mask<512>() != before) fail("two masks of a leaf that differ");
    }
    /// A text behind its length; what is shown of names is short.
    std::string text(const char* what) {
        const auto length = get<std::uint32_t>(what);
        if (length > left()) fail(fmt::format("{} of {} letters", what, length));
        std::string value;
        const auto kept = std::min<std::uint32_t>(length, kLongestName);
        value.assign(take(kept, what), kept);
        if (length > kept) fail(fmt::format("{} of {} letters", what, length));
        return value;
    }

    /// Skips a block of Blosc in `stored` bytes; its header must agree, as it is what Blosc goes
    /// by.
    /// @param padded  whether short blocks may be filled up to 128 bytes.
    void skipBlosc(std::uint64_t stored, std::uint64_t expected, bool padded) {
        if (stored < kBloscHeader || stored > left())
            fail(fmt::format("{} bytes packed by Blosc", stored));
        std::array<std::uint32_t, 4> header{};
        std::memcpy(header.data(), take(kBloscHeader, "packed values"), kBloscHeader);
        const std::uint64_t unpackedBytes = header[1], packedBytes = header[3];
        const bool fits = unpackedBytes == expected ||
                          (padded && unpackedBytes == kBloscPadding && expected <= kBloscPadding);
        if (packedBytes != stored || !fits || unpackedBytes > kMostPerByte * stored)
            fail(fmt::format("{} of {} bytes packed by Blosc into {} of {}", unpackedBytes,
                             expected, packedBytes, stored));
        skip(stored - kBloscHeader, "packed values");
    }

private:
    static constexpr std::size_t kBloscHeader = 16;
    static constexpr std::uint64_t kBloscPadding = 128;  ///< shorter arrays are filled up to this
    static constexpr std::uint64_t kMostPerByte = 1032;  ///< bytes that a packed byte stands for
    static constexpr std::uint32_t kLongestName = 1 << 12;

    InputFile file_;
};

/// Checks metadata of a file or of a grid. @param savedAsHalf  set if they say whether floats are
/// saved as 16 bits; null: not of interest.
void checkMetadata(VdbBytes& bytes, bool* savedAsHalf = nullptr);

/// Checks the points of a tree and their attributes. @param leaves  of the tree, in its order
void checkPoints(VdbBytes& bytes, std::uint32_t version, const std::vector<LeafMask>& leaves);

}  // namespace vdbpack
