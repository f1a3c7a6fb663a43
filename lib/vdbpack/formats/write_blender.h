// A pack as a script that shows it in Blender.
#pragma once

#include "vdbpack/formats/pack_file.h"

#include <string>
#include <vector>

namespace vdbpack {

/// The files that `writeBlender` leaves for a script NAME.py: itself, NAME.points.npz and, unless
/// there is a `volume` to share, NAME.vdb. @throws ParameterError if the script has another ending.
std::vector<std::string> blenderFiles(const std::string& script, bool levelSets,
                                      const std::string& volume = "");

/// Writes a Python script that builds a scene in Blender 3.4 or later: the spheres as points that
/// render as true spheres, colored by a column, the level sets as volume and meshes, camera and
/// light. It needs nothing but Blender and the files beside it, and moves with them.
///
/// NAME.points.npz holds the spheres as `writePack` writes .npz, in `options.unit`. The script
/// holds the checksum of its positions and refuses others. Each file is whole or absent; the script
/// comes last.
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
