// Private: VTK's legacy files (.vtk): statements of words, and the numbers that follow them.
#pragma once

#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/io/vtk_arrays.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// Lists of points: the points of cell i end before entry ends[i].
struct VtkCells {
    std::vector<std::int64_t> corners;
    std::vector<std::size_t> ends;
};

/// The values of an array, as numbers or texts.
struct VtkTuples {
    std::uint64_t count = 0;
    VtkNumbers numbers{{}, NumberType::f64, false};
    std::vector<std::string> texts;
};

/// A .vtk file, text or binary, read from front to end. All throw InputError with the line or byte.
class VtkLegacy {
public:
    /// Takes the header with the line DATASET. @throws IoError, InputError
    VtkLegacy(const std::string& path, double memoryLimit);

    const std::string& path() const { return file_.path(); }
    /// What follows DATASET, in small letters: "polydata".
    const std::string& dataSet() const { return dataSet_; }

    /// Takes the next line that is not blank. @param keyword  its first word, in small letters.
    /// @return false at the end.
    bool nextStatement(std::string& keyword);
    /// The next word of the statement; empty at its end.
    std::string_view word() { return words_.next(); }
    std::string_view rest() const { return words_.rest(); }
    /// The next word as a count that the file is large enough for.
    std::uint64_t count(const char* what);
    /// The next word as a name, where %20 is a blank.
    std::string name();
    /// An array of that name whose type is the next word.
    VtkArray typed(std::string name, std::uint64_t components);

    /// What follows, `count` numbers in all.
    VtkNumbers numbers(const VtkArray& array, std::uint64_t count);
    std::vector<std::int64_t> integers(NumberType type, std::uint64_t count);
    /// What follows of an array of numbers or texts.
    VtkTuples tuples(const VtkArray& array, std::uint64_t count);
    /// The arrays of a FIELD.
    void forFieldArrays(const std::function<void(const VtkArray&, const VtkTuples&)>& use);
    /// The lists of a statement such as POLYGONS or CELLS, of any version.
    VtkCells cells();
    /// Skips so many bytes, or in text numbers from 0 to 1.
    void skipColors(std::uint64_t count);
    /// Skips a block that describes an array, up to a blank line.
    void skipMetadata();

    [[noreturn]] void fail(const std::string& what) const;

private:
    std::string_view takeLine(const char* what);
    NumberType typeIn(std::string_view name) const;
    std::string takeText();

    InputFile file_;
    double memoryLimit_;
    bool isText_ = true;
    std::string dataSet_, statement_;
    Words words_{{}};  ///< of the statement
    Words row_{{}};    ///< of a line of numbers
};

}  // namespace vdbpack
