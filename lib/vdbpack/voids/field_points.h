// Private: what fields of directions and of numbers share: the points of tables, and what they
// cover.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/io/number_table.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>

namespace vdbpack {

/// The columns x, y and, unless the field is one of the plane, z of a table.
class PointColumns {
public:
    /// @throws InputError if x or y is missing.
    explicit PointColumns(const NumberTable& table);
    bool planar() const { return !columns_[2]; }
    /// The point of the row, mm; z = 0 in the plane. @throws InputError if it is too far away.
    Vec<3> point(const NumberTable& table, double scale) const;

private:
    std::array<std::optional<std::size_t>, 3> columns_;
};

/// The box that a table covers whose points lie in `points`: grown on each side by a tenth of its
/// length or a hundredth of its longest side, whichever is larger; infinite along z in the plane.
Box<3> coveredBy(const Box<3>& points, bool planar);

/// @param field        for the message.
/// @param sliceHeight  2D: height of the plane in the field, mm.
/// @throws InputError with both boxes if `covered` does not contain `bounds`.
template <int Dim>
void requireCovered(const std::string& field, const Box<3>& covered, const Box<Dim>& bounds,
                    double sliceHeight);

}  // namespace vdbpack
