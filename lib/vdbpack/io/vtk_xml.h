// Private: VTK's XML files: the tags, and the arrays that they describe.
#pragma once

#include "vdbpack/io/input_file.h"
#include "vdbpack/io/vtk_arrays.h"

#include <pugixml.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdbpack {

/// A file such as .vtp. The bytes of its arrays are read when they are asked for.
class VtkXml {
public:
    /// @param type  of the data that is expected: "PolyData".
    /// @param memoryLimit  bytes that the process may hold, as `memoryLimit`.
    /// @throws IoError, InputError if the file is damaged, cut short or of another type.
    VtkXml(const std::string& path, const std::string& type, double memoryLimit);

    const std::string& path() const { return file_.path(); }
    /// The tag of the expected type, which holds the pieces.
    pugi::xml_node data() const { return root_.child(type_.c_str()); }
    VtkArrays& arrays() { return *arrays_; }

    static bool isArray(const pugi::xml_node& node);
    static std::string_view attribute(const pugi::xml_node& node, const char* name);
    /// A count that a tag has as an attribute. @throws InputError if it has none that is usable.
    std::uint64_t countOf(const pugi::xml_node& node, const char* name) const;
    /// What an array's tag says of it. @throws InputError
    VtkArray described(const pugi::xml_node& node) const;

    /// @throws InputError "file: what"
    [[noreturn]] void fail(const std::string& what) const;
    /// @throws InputError with the byte at which the node begins.
    [[noreturn]] void failAt(const pugi::xml_node& node, const std::string& what) const;

private:
    [[noreturn]] void failAtByte(std::ptrdiff_t byte, const std::string& what) const;
    void readTags();
    void requireEnd() const;
    void takeAppended();

    InputFile file_;
    std::string type_;
    std::string xml_;  ///< holds the texts of `document_`
    pugi::xml_document document_;
    pugi::xml_node root_;
    std::uint64_t appended_ = 0;  ///< offset of the first appended byte; 0: there is none
    std::optional<VtkArrays> arrays_;
};

}  // namespace vdbpack
