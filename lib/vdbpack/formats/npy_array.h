// Private: numpy's .npy arrays. Source: numpy.lib.format, versions 1 to 3.
#pragma once

#include "vdbpack/io/byte_order.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// How a .npy array begins.
inline constexpr const char* kNpyMagic = "\x93NUMPY";

/// An array of numbers or texts, one or several a row.
class NpyArray {
public:
    /// Bytes at the beginning of an array from which `headerBytes` follows.
    static constexpr std::size_t kPreamble = 12;
    /// Bytes before the elements.
    /// @param preamble  the first `kPreamble` bytes, or fewer if there are no more.
    /// @throws InputError "where: ..." if this is no array of numpy.
    static std::uint64_t headerBytes(const std::string& preamble, const std::string& where);

    /// An array without its elements.
    /// @param header  all bytes before the elements.
    /// @param bytes  of the header and the elements together.
    /// @return nothing for arrays that a pack has no use for: objects, records, more than two
    /// dimensions.
    /// @throws InputError "where: ..." if header and bytes do not agree.
    static std::optional<NpyArray> describe(const std::string& header, std::uint64_t bytes,
                                            const std::string& name, const std::string& where);
    /// Gives the array its elements: header and elements, as many bytes as were announced.
    void take(std::string content) { content_ = std::move(content); }

    const std::string& name() const { return name_; }
    bool isText() const { return kind_ == 'U' || kind_ == 'S'; }
    const std::vector<std::uint64_t>& shape() const { return shape_; }
    std::uint64_t rows() const { return shape_.empty() ? 1 : shape_[0]; }
    std::uint64_t columns() const { return shape_.size() > 1 ? shape_[1] : 1; }

    /// The text of a row, as UTF-8.
    std::string text(std::uint64_t row) const;
    /// A number, as `loadNumber` hands it to `use`.
    template <typename Use>
    bool number(std::uint64_t row, std::uint64_t column, const Use& use) const {
        return loadNumber(type_, at(row, column), swap_, use);
    }

private:
    const char* at(std::uint64_t row, std::uint64_t column) const {
        const std::uint64_t index = fortran_ ? column * rows() + row : row * columns() + column;
        return content_.data() + begin_ + index * bytes_;
    }
    /// Takes numpy's name of a type ("<f8"). @return false for types that a pack has no use for.
    bool takeType(const std::string& descr);

    std::string name_;
    char kind_ = 'f';        ///< f, i, u, b, U or S
    std::size_t bytes_ = 0;  ///< of an element
    NumberType type_ = NumberType::f64;
    bool swap_ = false, fortran_ = false;
    std::vector<std::uint64_t> shape_;
    std::string content_;
    std::size_t begin_ = 0;  ///< of the elements in `content_`
};

}  // namespace vdbpack
