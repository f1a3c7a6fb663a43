#include "vdbpack/field/vdb_init.h"

#include <openvdb/openvdb.h>

#include <mutex>

namespace vdbpack {

void initializeOpenVdb() {
    static std::once_flag once;
    std::call_once(once, [] { openvdb::initialize(); });
}

}  // namespace vdbpack
