// What the name of an output says.
#pragma once

#include <string>

namespace vdbpack {

enum class OutputKind {
    pack,
    contacts,
    bonds,
    bondCoefficients,
    interfaces,
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

/// A file that a run writes, "FILE" or "FORMAT:FILE", and what it holds.
struct OutputTarget {
    /// @throws ParameterError for a prefix without a file; whether a pack file has a format is
    /// another question.
    OutputTarget(const std::string& name);  // NOLINT: recipes list texts
    OutputTarget(const char* name) : OutputTarget(std::string(name)) {}

    std::string text;  ///< as it was named
    OutputKind kind = OutputKind::pack;
    std::string file;
    std::string grid;    ///< level set that it names; empty: the one left, of several
    std::string labels;  ///< of a label map: "ids", "regions", "parts", "materials" or "solid"

    std::string extension() const;  ///< of the file, in small letters: ".vdb"
    /// Whether it is made from level sets alone: .stl, .vdb, levelsets: or fog:.
    bool isSolid() const;
    /// The same, or a file that shows level sets beside the spheres (blender:).
    bool usesLevelSets() const { return isSolid() || kind == OutputKind::blender; }
    /// Whether it lists elastic bonds, or their stiffness.
    bool isOfBonds() const {
        return kind == OutputKind::bonds || kind == OutputKind::bondCoefficients;
    }
    /// The same, or joins spheres by bonds (lammps-bonds:).
    bool listsBonds() const;
    /// Whether it lists pairs of spheres in contact, or counts them.
    bool listsPairs() const;
};

/// The first file behind "prefix:name", where the prefix is one that names a format.
std::string filePart(const std::string& name);

/// NAME.interrupted.EXT for NAME.EXT, behind the same prefix, if there is one: what an interrupted
/// run leaves never replaces the file of a whole one.
std::string interruptedName(const std::string& name);

}  // namespace vdbpack
