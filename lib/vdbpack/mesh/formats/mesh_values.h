// Private: numbers in the body of a mesh file, as text or binary.
#pragma once

#include "vdbpack/io/byte_order.h"
#include "vdbpack/mesh/formats/mesh_reader.h"

#include <cctype>
#include <cstdint>
#include <string>

namespace vdbpack {

/// Numbers one after another, whatever their encoding.
class MeshValues {
public:
    MeshValues(MeshReader& reader, bool isText, bool isBigEndian)
        : reader_(reader),
          words_(reader.file),
          isText_(isText),
          swap_(isBigEndian != hostIsBigEndian()) {}

    bool isText() const { return isText_; }

    double real(NumberType type) {
        if (isText_) return reader_.real(words_.next(), "a number");
        double number = 0;
        takeNumber(type, [&number](auto value) {
            number = static_cast<double>(value);
            return true;
        });
        return number;
    }
    /// @param type  not one of real numbers.
    std::int64_t integer(NumberType type) {
        if (isText_) return reader_.integer(words_.next(), "an integer");
        std::int64_t number = 0;
        takeNumber(type, [&number](auto value) {
            number = static_cast<std::int64_t>(value);
            return true;
        });
        return number;
    }
    void skip(NumberType type, std::uint64_t count) {
        for (std::uint64_t i = 0; i < count; ++i)
            if (isText_ ? words_.next().empty() : reader_.file.take(bytesOf(type)) == nullptr)
                truncated();
    }
    /// Names the current position.
    [[noreturn]] void fail(const std::string& what) const {
        if (isText_) reader_.file.failAtLine(what);
        reader_.file.failAtByte(reader_.file.offset(), what);
    }
    /// True if only blanks follow.
    bool atEnd() {
        if (isText_) return words_.next().empty();
        while (const char* c = reader_.file.take(1))
            if (std::isspace(static_cast<unsigned char>(*c)) == 0) return false;
        return true;
    }

private:
    template <typename Use>
    void takeNumber(NumberType type, const Use& use) {
        const char* const bytes = reader_.file.take(bytesOf(type));
        if (bytes == nullptr) truncated();
        if (!loadNumber(type, bytes, swap_, use)) fail("a number beyond 64 bits");
    }
    [[noreturn]] void truncated() const { fail("the file ends too early; it is truncated"); }

    MeshReader& reader_;
    TextWords words_;
    bool isText_;
    bool swap_;  ///< the bytes of each number
};

}  // namespace vdbpack
