// Private: the text formats with a row a sphere, as header and rows.
#pragma once

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/pack_view.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// A text file of a pack, row by row. Refers to the pack.
struct PackTextRows {
    std::string header;
    /// Adds the row of a sphere to a text; called from several threads.
    std::function<void(std::string& text, std::size_t i)> append;
};

/// A cell as RFC 4180 wants it: in quotes where it holds a comma, a quote or a line end.
void appendCell(std::string& text, std::string_view cell);
PackTextRows csvRows(const PackView& pack);
PackTextRows yadeRows(const PackView& pack, const PackWriteOptions& options);

/// What the head of a LAMMPS file states about all atoms.
struct AllAtoms {
    std::uint64_t count = 0;
    std::int64_t types = 1;
    Box<3> box;  ///< around whole spheres, in the unit that is written
};
AllAtoms allAtoms(const PackView& pack);
/// @param rows  of the spheres in the pack of all ranks, by which atoms are numbered from 1.
PackTextRows lammpsRows(const PackView& pack, const PackWriteOptions& options, const AllAtoms& all,
                        const std::vector<std::uint64_t>& rows);

}  // namespace vdbpack
