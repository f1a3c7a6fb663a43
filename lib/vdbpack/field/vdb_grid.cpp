#include "vdbpack/field/vdb_grid.h"

#include "vdbpack/field/vdb_init.h"

#include <openvdb/version.h>

#include <mutex>

template class openvdb::Grid<openvdb::FloatTree>;
template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
template class openvdb::tree::LeafManager<openvdb::FloatTree>;

namespace vdbpack {

void initializeOpenVdb() {
    static std::once_flag once;
    std::call_once(once, [] { openvdb::initialize(); });
}

const char* openVdbVersion() {
    return OPENVDB_LIBRARY_VERSION_STRING;
}

}  // namespace vdbpack
