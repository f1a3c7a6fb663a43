// Private: the text headers of NRRD and MetaImage files.
#pragma once

#include "vdbpack/image/image.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vdbpack {

/// Lines of "key: value" or "key = value", keys in lower case.
struct TextHeader {
    std::multimap<std::string, std::string> lines;
    std::size_t end = 0;      ///< where data may begin
    std::size_t longest = 0;  ///< bytes of the longest line, but for comments and "key:=value"

    bool has(const std::string& key) const { return lines.count(key) > 0; }
    /// Of the first line with a key; empty if there is none.
    std::string value(const std::string& key) const;
};

/// The lines until an empty one or the name of the data, in the first MB.
/// @throws IoError
TextHeader readTextHeader(const std::string& path);

/// Names of labels as 3D Slicer writes them into .seg.nrrd.
std::vector<LabelName> labelNames(const TextHeader& header);

/// Refuses headers of NRRD files that ITK's reader does not survive. @throws InputError
void checkNrrdHeader(const TextHeader& header, const std::string& path);

/// Bytes of the files that hold the voxels of a NRRD. @throws IoError
std::uint64_t bytesOfData(const TextHeader& header, const std::string& path);

}  // namespace vdbpack
