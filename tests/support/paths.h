// Where the program and the bundled files are that tests use.
#pragma once

#include <string>

namespace vdbpack::test {

/// vdb_pack as it was built.
extern const std::string kTool;
/// The folder of the bundled meshes, without a slash at its end.
extern const std::string kMeshes;
/// The folder of the tests' sources, without a slash at its end.
extern const std::string kTests;

}  // namespace vdbpack::test
