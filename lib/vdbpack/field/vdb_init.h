// Private: registers OpenVDB's grid types once a process.
#pragma once

namespace vdbpack {

/// Call before reading or writing .vdb files. Cheap after the first time; thread-safe.
void initializeOpenVdb();

}  // namespace vdbpack
