// What the name of an output says.
#pragma once

#include <string>

namespace vdbpack {

enum class OutputKind {
    pack,
    contacts,
    voidList,
    materials,
    labels,
    contour,
    levelSets,
    fog,
    blender
};

/// Level sets by name.
inline constexpr const char* kSurface = "surface";
inline constexpr const char* kVoids = "voids";
inline constexpr const char* kSolid = "solid";

struct OutputTarget {
    OutputKind kind;
    std::string file;
    std::string grid;    ///< level set that it names; empty: the one left, of several
    std::string labels;  ///< of a label map: "ids", "regions", "parts", "materials" or "solid"
};

/// @throws ParameterError for a prefix without a file; whether a pack file has a format is another
/// question.
OutputTarget targetOf(const std::string& output);

/// The first file behind "prefix:name", where the prefix is one that names a format.
std::string filePart(const std::string& name);

}  // namespace vdbpack
