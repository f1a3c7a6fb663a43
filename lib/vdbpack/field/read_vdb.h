// Private: reading .vdb files with OpenVDB's exceptions as ours.
#pragma once

#include <functional>
#include <string>

namespace vdbpack {

/// Checks a file (vdb_check.h) and calls `read()`, which may read it by OpenVDB.
/// @throws IoError, InputError, ResourceError, each naming the file; as `read` does besides.
void readVdb(const std::string& path, const std::function<void()>& read);

}  // namespace vdbpack
