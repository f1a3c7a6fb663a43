#include "vdbpack/field/vdb_init.h"

#include <openvdb/openvdb.h>
#include <openvdb/version.h>

#include <mutex>

namespace vdbpack {

void initializeOpenVdb() {
    static std::once_flag once;
    std::call_once(once, [] { openvdb::initialize(); });
}

const char* openVdbVersion() {
    return OPENVDB_LIBRARY_VERSION_STRING;
}

}  // namespace vdbpack
