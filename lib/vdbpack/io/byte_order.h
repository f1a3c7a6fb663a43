// Private: numbers in binary files.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>

namespace vdbpack {

/// Types of numbers in files and images.
enum class NumberType { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };

inline constexpr const char* kNumberTypeNames[] = {
    "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"};
/// Such as "uint8".
inline const char* nameOf(NumberType type) {
    return kNumberTypeNames[static_cast<std::size_t>(type)];
}
/// The type of such a name; nothing for any other name.
inline std::optional<NumberType> numberTypeNamed(std::string_view name) {
    for (std::size_t t = 0; t < std::size(kNumberTypeNames); ++t)
        if (name == kNumberTypeNames[t]) return static_cast<NumberType>(t);
    return std::nullopt;
}

inline std::size_t bytesOf(NumberType type) {
    constexpr std::size_t kBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return kBytes[static_cast<std::size_t>(type)];
}

inline bool isReal(NumberType type) {
    return type == NumberType::f32 || type == NumberType::f64;
}

inline bool hostIsBigEndian() {
    const std::uint16_t probe = 1;
    unsigned char first = 0;
    std::memcpy(&first, &probe, 1);
    return first == 0;
}

/// The value at `bytes`, its bytes in reverse order if `swap`.
template <typename T>
T loadAs(const char* bytes, bool swap) {
    char copy[sizeof(T)];
    std::memcpy(copy, bytes, sizeof(T));
    if (swap) std::reverse(copy, copy + sizeof(T));
    T value;
    std::memcpy(&value, copy, sizeof(T));
    return value;
}

template <typename T>
T loadLittleEndian(const char* bytes) {
    return loadAs<T>(bytes, hostIsBigEndian());
}

/// The unsigned number in at most 8 bytes.
inline std::uint64_t unsignedNumber(const unsigned char* bytes, std::size_t count, bool bigEndian) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum = sum << 8 | bytes[bigEndian ? i : count - 1 - i];
    return sum;
}

/// Appends the bytes of a number, the least significant first.
template <typename T>
void appendLittleEndian(std::string& bytes, T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (hostIsBigEndian()) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
}

/// A number of `type`: calls `use` with a double or, for whole numbers, an int64.
/// @return what `use` returns; false for a whole number beyond int64.
template <typename Use>
bool loadNumber(NumberType type, const char* bytes, bool swap, const Use& use) {
    switch (type) {
        case NumberType::i8:
            return use(std::int64_t{loadAs<std::int8_t>(bytes, swap)});
        case NumberType::u8:
            return use(std::int64_t{loadAs<std::uint8_t>(bytes, swap)});
        case NumberType::i16:
            return use(std::int64_t{loadAs<std::int16_t>(bytes, swap)});
        case NumberType::u16:
            return use(std::int64_t{loadAs<std::uint16_t>(bytes, swap)});
        case NumberType::i32:
            return use(std::int64_t{loadAs<std::int32_t>(bytes, swap)});
        case NumberType::u32:
            return use(std::int64_t{loadAs<std::uint32_t>(bytes, swap)});
        case NumberType::i64:
            return use(loadAs<std::int64_t>(bytes, swap));
        case NumberType::u64: {
            const auto value = loadAs<std::uint64_t>(bytes, swap);
            return value <= INT64_MAX && use(static_cast<std::int64_t>(value));
        }
        case NumberType::f32:
            return use(static_cast<double>(loadAs<float>(bytes, swap)));
        case NumberType::f64:
            return use(loadAs<double>(bytes, swap));
    }
    return false;
}

}  // namespace vdbpack
