// Files of LAMMPS as text, with the same two spheres.
#pragma once

#include "formats/file_text.h"

#include <catch2/catch.hpp>

#include <string>
#include <vector>

namespace vdbpack::test {

inline const std::vector<Sphere<3>> kTwo = {{{{1, 2, 3}}, 0.5}, {{{4, 5, -6}}, 1}};

inline const char* const kHeader =
    "LAMMPS data file via write_data, version 29 Sep 2021, timestep = 10\n\n"
    "2 atoms\n3 atom types\n\n-10 10 xlo xhi\n-10 10 ylo yhi\n-10 10 zlo zhi\n\n";
inline const char* const kAtoms =
    "Atoms # sphere\n\n7 1 1.0 2500 1 2 3 0 0 0\n4 3 2 1e3 4 5 -6 0 0 -1\n";

/// A frame of a dump.
inline std::string frame(const std::string& columns, const std::vector<std::string>& rows,
                         const std::string& bounds = "pp pp ff\n-1 1\n-1 1\n-1 1") {
    std::string text = "ITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n" +
                       std::to_string(rows.size()) + "\nITEM: BOX BOUNDS " + bounds +
                       "\nITEM: ATOMS " + columns + "\n";
    for (const auto& row : rows) text += row + "\n";
    return text;
}

inline const std::string kDump = frame("id type x y z radius", {"7 1 1 2 3 0.5", "4 3 4 5 -6 1"});

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

/// Whether the file could be read; any error but ours escapes.
inline bool reads(const std::string& name, const std::string& content) {
    return errorOf(name, content).empty();
}

}  // namespace vdbpack::test
