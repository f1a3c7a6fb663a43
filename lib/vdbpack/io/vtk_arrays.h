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
struct VtkArray {
    enum class Format { ascii, inlineBase64, appended };

    std::string name;
    std::string tag;  ///< around it, for messages: "Points"
    NumberType type = NumberType::f64;
    bool string = false;  ///< holds texts
    std::uint64_t components = 1;
    Format format = Format::ascii;
    std::string_view text;     ///< between the tags
    std::uint64_t offset = 0;  ///< into the appended section
};

/// The numbers of an array, in memory.
struct VtkNumbers {
    std::vector<char> bytes;
    NumberType type;
    bool swap;  ///< the byte order differs from the host's

    /// Number `i`, as `loadNumber` hands it to `use`.
    template <class Use>
    bool at(std::uint64_t i, const Use& use) const {
        return loadNumber(type, bytes.data() + i * bytesOf(type), swap, use);
    }
};

/// How the arrays of a file are stored, as the file's root says.
struct VtkEncoding {
    bool swap = false;        ///< the byte order differs from the host's
    bool wideHeader = false;  ///< sizes have 64 bits rather than 32
    std::string compressor;   ///< empty: none
};

/// Reads the arrays of a file, from the file or from the texts of its XML.
///
/// Sizes are compared before anything is inflated: an array takes the bytes that its tag promises,
/// no more than deflate can make of the bytes that are there, and no more than the limit on memory
/// leaves; no two take the same bytes.
class VtkArrays {
public:
    /// @param memoryLimit  bytes that the process may hold, as `memoryLimit`.
    VtkArrays(const InputFile& file, VtkEncoding encoding, double memoryLimit)
        : file_(file), encoding_(std::move(encoding)), memoryLimit_(memoryLimit) {}

    /// The appended section begins at this byte of the file, after its underscore.
    void appendRaw(std::uint64_t offset) { appended_ = offset; }
    void appendBase64(std::uint64_t offset);

    /// The numbers of `count` tuples. @throws InputError, IoError, ResourceError
    VtkNumbers numbers(const VtkArray& array, std::uint64_t count);
    /// `count` texts of at most `longest` bytes on average.
    /// @throws InputError, IoError, ResourceError
    std::vector<std::string> texts(const VtkArray& array, std::uint64_t count,
                                   std::uint64_t longest);

private:
    class ByteSource;

    /// Sizes of the deflated blocks of an array.
    struct Blocks {
        std::vector<std::uint64_t> packed;
        std::uint64_t full = 0;  ///< bytes of each block, inflated
        std::uint64_t last = 0;  ///< of the last one

        std::uint64_t size(std::size_t block) const {
            return block + 1 == packed.size() ? last : full;
        }
    };

    [[noreturn]] void fail(const VtkArray& array, const std::string& what) const;
    ByteSource sourceOf(const VtkArray& array) const;
    std::uint64_t headerWord(ByteSource& source) const;
    /// The bytes of an array that is not ASCII, if `isSound` accepts how many there are.
    template <class Check>
    std::vector<char> bytesOfArray(const VtkArray& array, const Check& isSound);
    Blocks blocksOf(const VtkArray& array, ByteSource& source) const;
    void inflate(const VtkArray& array, const Blocks& blocks, ByteSource& source,
                 std::vector<char>& data) const;
    std::vector<std::string> splitTexts(const VtkArray& array, const std::vector<char>& data,
                                        std::uint64_t count) const;
    VtkNumbers asciiNumbers(const VtkArray& array, std::uint64_t count) const;

    const InputFile& file_;
    VtkEncoding encoding_;
    double memoryLimit_;
    std::uint64_t appended_ = 0;  ///< 0: there is no appended section
    bool base64_ = false;         ///< the appended section is
    std::string appendedText_;
    std::uint64_t taken_ = 0;  ///< bytes of the file that arrays took
};

}  // namespace vdbpack
