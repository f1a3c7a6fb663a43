// Private: packs from rows of named columns, whatever the format.
#pragma once

#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/byte_order.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vdbpack {

/// Adds the columns of an array with so many numbers a row: `name`, or `name`_0, `name`_1, ...
void addNames(std::vector<std::string>& names, const std::string& name, std::uint64_t components);

/// Removes ids that count 0, 1, 2, ...: an empty `id` means the same.
void dropDefaultIds(Pack<3>& pack);

/// Collects the rows of a pack file. Names say what a column holds, in any case and with any signs
/// between letters: x, y, z (PosX, p_x, position_x, center_x, Points:0, ...), radius (r, rad,
/// pscale, radii, ...) or else diameter, with the unit of length at the end where it is another
/// than the unit of the file (`x [m]`, `radius_um`); id, region, order, depth, contacts. All others
/// are kept as further columns.
class PackBuilder {
public:
    /// @param options  the unit of lengths in the file, and what it has in place of its names and
    ///                 radii.
    /// @throws InputError without a column for x, y, z or the radius, with two of one name, or with
    /// an unknown unit.
    PackBuilder(std::string file, std::vector<std::string> names, const PackReadOptions& options);
    PackBuilder(const PackBuilder&) = delete;
    PackBuilder& operator=(const PackBuilder&) = delete;

    const std::vector<std::string>& names() const { return names_; }
    Unit unit() const { return options_.unit; }
    std::size_t rows() const { return pack_.spheres.size(); }
    /// Whether the column is a further one: a pack does not know it by name.
    bool isFurther(std::size_t column) const {
        return std::holds_alternative<Numbers>(columns_[column]) || isText(column);
    }
    /// Makes a further column one of texts; before the first row, once per column.
    /// @throws InputError for a column that the pack knows by name: those are numbers.
    void makeText(std::size_t column);
    bool isText(std::size_t column) const {
        return std::holds_alternative<Texts>(columns_[column]);
    }

    /// Bytes of memory that so many rows take, but for the characters of texts.
    double bytesOf(std::uint64_t rows) const;
    void reserve(std::size_t rows);
    void addRow();

    /// The cell of the last row. @return false if the column cannot hold the value.
    bool set(std::size_t column, double value);
    bool set(std::size_t column, std::int64_t value);
    void setText(std::size_t column, std::string_view value);
    /// The cell of the last row from text. @return false if the column cannot hold it.
    bool parse(std::size_t column, std::string_view text);

    /// @throws InputError "file: where: column 'name' is 'value'; ..."
    [[noreturn]] void failCell(const std::string& where, std::size_t column,
                               std::string_view value) const;
    /// Checks the last row. @param where  makes its place in the file, for messages.
    /// @throws InputError "file: where: radius is -1; ..."
    template <class Where>
    void checkRow(const Where& where) const {
        if (const std::string wrong = problem(); !wrong.empty()) failRow(where() + ": " + wrong);
    }

    /// Sets the cell of the last row in a column from row `row` of a file. @return false if the
    /// column cannot hold the value.
    using Put = std::function<bool(std::size_t column, std::uint64_t row)>;
    /// Takes numbers in memory, one every `stride` bytes from `first` on.
    Put numbersFrom(const char* first, std::size_t stride, NumberType type, bool swap);
    Put textsFrom(const std::vector<std::string>& texts);
    /// Adds `count` rows from the same rows of a file. @param puts  one a column.
    /// @param what  the file calls a row, and `first` the number of row 0, for messages.
    /// @throws InputError naming row and column.
    void addRows(std::uint64_t count, const std::vector<Put>& puts, const char* what,
                 std::uint64_t first = 0);

    /// The pack in mm, without ids 0, 1, 2, ...
    /// @throws InputError for particles that are no spheres by columns of axes and exponents, and
    /// for a column `diameter` that is not twice the radius.
    Pack<3> finish();

private:
    enum Quantity { x, y, z, radius, diameter };
    struct SphereNumber {
        Quantity quantity;
        Unit unit;
    };
    using Numbers = std::vector<double>*;
    using Texts = std::vector<std::string>*;
    /// What a column fills: a number of the spheres, or values in the pack.
    using Target = std::variant<Numbers, Texts, SphereNumber, std::vector<std::int32_t>*,
                                std::vector<std::int64_t>*, std::vector<float>*>;

    bool isWhole(std::size_t column) const;
    /// Calls `use` with the vector of each column that has one.
    template <class Use>
    void forEachColumn(const Use& use) const;
    void rename();
    /// Gives the column that has one of these names, the best first, to the quantity.
    bool claim(Quantity quantity, const std::vector<std::string>& synonyms);
    /// The unit in a column's name. @throws InputError for one that is not known.
    Unit unitOf(const std::string& name) const;
    void setSphere(SphereNumber which, double value);
    void requireSpheres() const;
    /// Whether a further column is the diameter beside the radius, in the unit of the file.
    bool repeatsRadius(const Column& column) const;
    /// The error in the last row ("radius is -1; ..."), or an empty text.
    std::string problem() const;
    [[noreturn]] void failRow(const std::string& what) const;
    [[noreturn]] void failTwice(const std::string& first, const std::string& second) const;
    /// @param wanted  the column that is missing; empty: a coordinate or the radius.
    [[noreturn]] void failIncomplete(const std::string& wanted = {}) const;

    std::string file_;
    PackReadOptions options_;
    std::vector<std::string> names_;
    std::vector<std::string> low_, quantities_;  ///< of the names
    bool hasRadii_ = false;
    std::vector<Target> columns_;
    Pack<3> pack_;
};

}  // namespace vdbpack
