// Private: .vdb files looked over before OpenVDB reads them.
#pragma once

#include <string>

namespace vdbpack {

/// Walks through a .vdb file as OpenVDB's reader will and compares every count and size in it with
/// what is there. OpenVDB trusts them: a file cut short, or one whose numbers lie, makes it run for
/// minutes, take any amount of memory or write past its buffers. What passes here it reads in time
/// and memory in proportion to the file.
///
/// Trees of floats, doubles, whole numbers, vectors and points are followed to their leaves, other
/// grids only as far as their metadata. Registers OpenVDB's types (vdb_init.h).
///
/// @throws IoError     if the file is missing or cannot be read.
/// @throws InputError  with the byte, if it is no OpenVDB file, damaged or cut short; of a format
///                     older than OpenVDB 2 (version 222) or newer than 224; or written as a stream
///                     and holding a tree of any other type.
///
/// Cost: the file is read once, about 1 ms a MB; 64 bytes of memory for each leaf of a tree.
void checkVdbFile(const std::string& path);

}  // namespace vdbpack
