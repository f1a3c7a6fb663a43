// Private: OpenVDB as a library: registration of its types, version.
#pragma once

namespace vdbpack {

/// Call before reading or writing .vdb files. Cheap after the first time; thread-safe.
void initializeOpenVdb();

/// Such as "10.0.1".
const char* openVdbVersion();

}  // namespace vdbpack
