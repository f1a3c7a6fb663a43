// Private: the arrays of VTK's XML files: ASCII, base64 or raw, plain or deflated.
#pragma once

#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// An array as its tag describes it.
struct VtpArray {
    enum class Format { ascii, inlineBase64, appended };

    std::string name;
    NumberType type = NumberType::f64;
    bool string = false;  ///< holds texts
    std::uint64_t components = 1;
    Format format = Format::ascii;
    std::string_view text;     ///< between the tags
    std::uint64_t offset = 0;  ///< into the appended section
};

/// How the arrays of a file are stored, as the file's root says.
struct VtpEncoding {
    bool swap = false;        ///< the byte order is not that of the host
    bool wideHeader = false;  ///< sizes have 64 bits rather than 32
    std::string compressor;   ///< empty: none
};

/// Reads the arrays of a file, from the file or from the texts of its XML.
///
/// Time and memory are in proportion to the file: no array is larger than what deflate can make of
/// the bytes that are there, and no two take the same bytes.
class VtpArrays {
public:
    VtpArrays(const InputFile& file, VtpEncoding encoding)
        : file_(file), encoding_(std::move(encoding)) {}

    /// The appended section begins at this byte of the file, after its underscore.
    void appendRaw(std::uint64_t offset) { appended_ = offset; }
    void appendBase64(std::uint64_t offset);

    bool swap() const { return encoding_.swap; }

    /// `count` tuples as bytes of the array's type, in the byte order of the file.
    /// @throws InputError, IoError
    std::vector<char> numbers(const VtpArray& array, std::uint64_t count);
    /// @throws InputError, IoError
    std::vector<std::string> texts(const VtpArray& array);

private:
    class ByteSource;

    [[noreturn]] void fail(const VtpArray& array, const std::string& what) const;
    ByteSource sourceOf(const VtpArray& array) const;
    std::uint64_t headerWord(ByteSource& source) const;
    /// The bytes of an array that is not ASCII.
    std::vector<char> bytesOfArray(const VtpArray& array);
    std::vector<char> plain(const VtpArray& array, ByteSource& source) const;
    std::vector<char> inflated(const VtpArray& array, ByteSource& source) const;
    std::vector<char> asciiNumbers(const VtpArray& array, std::uint64_t count) const;
    /// Writes the number that `word` spells to `target`.
    void storeWord(const VtpArray& array, std::string_view word, std::size_t index,
                   char* target) const;

    const InputFile& file_;
    VtpEncoding encoding_;
    std::uint64_t appended_ = 0;  ///< 0: there is no appended section
    bool base64_ = false;         ///< the appended section is
    std::string appendedText_;
    std::uint64_t taken_ = 0;  ///< bytes of the file that arrays took
};

}  // namespace vdbpack
