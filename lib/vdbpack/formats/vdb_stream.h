// Private: OpenVDB files written to a stream of ours.
#pragma once

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/output_file.h"

#include <openvdb/Grid.h>

#include <vector>

namespace vdbpack {

/// Writes the level sets of the options, in their unit, then `others`, each with the unit and the
/// generator in its metadata. @throws IoError naming the file and the cause (disk full, ...)
void writeGrids(const PackWriteOptions& options, const std::vector<openvdb::GridBase::Ptr>& others,
                OutputFile& out);

}  // namespace vdbpack
