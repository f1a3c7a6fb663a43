// Private to field: the bytes of a .vdb file, and the pages in which attributes of points lie.
#pragma once

#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace vdbpack {

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
            fmt::format("{}: byte {} of {}: {}; the file is damaged or cut short: "
                        "write it again",
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

private:
    static constexpr std::uint32_t kLongestName = 1 << 12;

    InputFile file_;
};

template <std::size_t Bits>
std::bitset<Bits> takeMask(VdbBytes& bytes) {
    const char* const from = bytes.take(Bits / 8, "a mask of a node");
    std::bitset<Bits> mask;
    static_assert(sizeof mask == Bits / 8 && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
    std::memcpy(static_cast<void*>(&mask), from, Bits / 8);
    return mask;
}
using LeafMask = std::bitset<512>;

/// Attribute arrays that follow each other in pages.
class Pages {
public:
    /// An array of `count` bytes is announced: in the page before, or in one whose sizes stand
    /// here.
    void announce(VdbBytes& bytes, std::uint64_t count) {
        if (index_ == held_) {
            Page page;
            page.stored = bytes.get<std::int32_t>("the size of a page");
            page.held = page.stored > 0 ? bytes.get<std::int32_t>("the size of a page")
                                        : -static_cast<std::int64_t>(page.stored);
            if (page.held <= 0) bytes.fail(fmt::format("a page of {} bytes", page.held));
            pages_.push_back(page);
            held_ = static_cast<std::uint64_t>(page.held);
            index_ = 0;
        }
        if (count > held_ - index_)
            bytes.fail(fmt::format("an array of {} bytes in a page that has {} left", count,
                                   held_ - index_));
        index_ += count;
        arrays_.push_back({pages_.size() - 1, index_ == count});
    }
    /// All arrays are announced.
    void close(const VdbBytes& bytes) const {
        if (index_ != held_) bytes.fail("a page is larger than its arrays");
    }
    struct Page {
        std::int64_t stored = 0;  ///< bytes in the file, negative if they are plain
        std::int64_t held = 0;    ///< bytes once unpacked
    };
    /// The page that begins with the array announced as number `array`, or none.
    const Page* pageAt(std::size_t array) const {
        return arrays_[array].begins ? &pages_[arrays_[array].page] : nullptr;
    }

private:
    struct Announced {
        std::size_t page;
        bool begins;
    };
    std::vector<Page> pages_;
    std::vector<Announced> arrays_;
    std::uint64_t held_ = 0, index_ = 0;
};

}  // namespace vdbpack
