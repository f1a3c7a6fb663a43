// Paths of the program and of the bundled files that tests use.
#pragma once

#include <string>

namespace vdbpack::test {

/// The vdb_pack of this build.
extern const std::string kTool;
/// The folder of the bundled meshes, without a slash at its end.
extern const std::string kMeshes;
/// The folder of the tests' sources, without a slash at its end.
extern const std::string kTests;

}  // namespace vdbpack::test
