// Private: the layout of VTKHDF files (VTK File Formats, "VTKHDF File Format", version 1.0).
#pragma once

#include "vdbpack/core/units.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/io/byte_order.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbpack {

struct NumberColumn {
    std::string name;
    NumberType type;
};

/// The columns of a pack that are numbers, as files list them: the radius, the id, and the others.
std::vector<NumberColumn> numberColumns(const PackView& pack);

/// The name in VTK's XML files of a type that packs have: Int32, Int64, Float32 or Float64.
std::string vtkNameOf(NumberType type);

/// Where the values of each array begin in a file, bytes.
struct VtkHdfOffsets {
    std::uint64_t points = 0;  ///< three doubles each
    std::uint64_t types = 0, connectivity = 0, offsets = 0;
    std::vector<std::uint64_t> columns;
};

/// Bytes of the arrays of such a file.
std::uint64_t bytesOfVtkHdf(std::uint64_t points, const std::vector<NumberColumn>& columns);

/// Makes the file of an unstructured grid of vertices, in pieces of so many points, with room for
/// its arrays one after another: their values are then written as bytes, by any number of
/// processes. @param partNames  as `partLines`. @throws IoError
VtkHdfOffsets layOutVtkHdf(const std::string& path, const std::vector<std::uint64_t>& pieces,
                           const std::vector<NumberColumn>& columns, Unit unit,
                           const std::string& generator, const std::string& partNames);

}  // namespace vdbpack
