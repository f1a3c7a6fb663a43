// A pack as a script that shows it in Blender.
#pragma once

#include "vdbpack/formats/pack_file.h"

#include <string>
#include <vector>

namespace vdbpack {

/// The files that `writeBlender` leaves for a script NAME.py: itself, NAME.points.npy and, unless
/// there is a `volume` to share, NAME.vdb. @throws ParameterError if the script has another ending.
std::vector<std::string> blenderFiles(const std::string& script, bool levelSets,
                                      const std::string& volume = "");

/// Writes a Python script that builds a scene in Blender 3.4 or later: the spheres as points that
/// render as true spheres, colored by a column, the level sets as volume and meshes, camera and
/// light. It needs nothing but Blender and the files beside it, and moves with them.
///
/// NAME.points.npy is an array of records for numpy.load: x, y, z and radius, then id, region,
/// order, depth, contacts and those further columns of numbers that have plain names.
/// Lengths are in `options.unit`, float, with x, y and z from the middle of the pack (`center` in
/// the script), so that 32 bits hold them to 10^-7 of its size. The script holds the checksum of
/// its array and refuses another one. Each file is whole or absent; the script comes last.
///
/// @param script  ends in .py
/// @param volume  .vdb that holds `options.levelSets`; empty: they are written as NAME.vdb.
///        Ignored if there are none.
/// @return the files written: `blenderFiles`.
/// @throws ParameterError (another ending; a name that is not UTF-8; packs that `writePack`
/// refuses), IoError
template <int Dim>
std::vector<std::string> writeBlender(const Pack<Dim>& pack, const std::string& script,
                                      const PackWriteOptions& options,
                                      const std::string& volume = "");

}  // namespace vdbpack
