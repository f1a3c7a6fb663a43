#include "support/paths.h"

namespace vdbpack::test {

const std::string kTool = VDBPACK_TOOL;
const std::string kMeshes = VDBPACK_MESHES;
const std::string kTests = VDBPACK_TESTS_FOLDER;

}  // namespace vdbpack::test
