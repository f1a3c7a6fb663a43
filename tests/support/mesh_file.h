// Meshes as files for tests that read them.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <cstdio>
#include <stdexcept>
#include <string>

namespace vdbpack::test {

/// Writes a mesh as .obj with all digits.
inline void writeObj(const TriangleMesh& mesh, const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (!file) throw std::runtime_error("cannot write " + path);
    for (const auto& v : mesh.vertices)
        std::fprintf(file, "v %.17g %.17g %.17g\n", v[0], v[1], v[2]);
    for (const auto& t : mesh.triangles)
        std::fprintf(file, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
    std::fclose(file);
}

}  // namespace vdbpack::test
