#include "bench_mesh.h"

#include "vdbpack/mesh/formats/mesh_io.h"

#include <cstdlib>
#include <vector>

using namespace vdbpack;

FieldOptions BenchMesh::fieldOptions() const {
    FieldOptions options;
    options.name = file;
    options.detail = smallestRadius;
    options.depth = 6 * smallestRadius;  // three largest radii
    return options;
}

BenchMesh readBenchMesh(const std::string& argument) {
    std::vector<std::string> words(1);
    for (const char c : argument) {
        if (c == ':')
            words.emplace_back();
        else
            words.back() += c;
    }
    BenchMesh result;
    result.file = words[0];
    MeshReadOptions read;
    if (words.size() > 1) read.unit = parseUnit(words[1]);
    result.mesh = readMesh(words[0], read);
    if (words.size() > 2) result.smallestRadius = std::atof(words[2].c_str());
    return result;
}
