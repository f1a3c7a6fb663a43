// Private: headers of PLY files.
#pragma once

#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

struct PlyProperty {
    std::string name;
    NumberType type = NumberType::f32;
    bool isList = false;
    NumberType countType = NumberType::u8;  ///< of a list's length
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;  ///< as announced by the header, not necessarily as the file has them
    std::vector<PlyProperty> properties;

    bool hasLists() const;
    /// Of one entry in a binary body, where there are no lists.
    std::size_t bytes() const;
};

enum class PlyFormat { ascii, littleEndian, bigEndian };

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    std::vector<std::string> comments;  ///< lines that begin with comment or obj_info, whole
};

/// Takes the header off the beginning of a file.
/// @throws InputError naming the line that is malformed, IoError
PlyHeader readPlyHeader(InputFile& file);

}  // namespace vdbpack
