#include "bench_mesh.h"

#include "vdbpack/mesh/formats/mesh_io.h"

#include <vector>

using namespace vdbpack;

FieldOptions BenchMesh::fieldOptions() const {
    FieldOptions options;
    options.name = file;
    options.detail = smallestRadius;
    options.depth = 6 * smallestRadius;  // three largest radii
    return options;
}

MeshArgument parseMeshArgument(const std::string& argument) {
    std::vector<std::string> words(1);
    for (const char c : argument) {
        if (c == ':')
            words.emplace_back();
        else
            words.back() += c;
    }
    MeshArgument result;
    result.file = words[0];
    if (words.size() > 1) result.unit = parseUnit(words[1]);
    if (words.size() > 2) result.smallestRadius = std::atof(words[2].c_str());
    return result;
}

BenchMesh readBenchMesh(const std::string& argument) {
    BenchMesh result;
    static_cast<MeshArgument&>(result) = parseMeshArgument(argument);
    MeshReadOptions read;
    read.unit = result.unit;
    result.mesh = readMesh(result.file, read);
    return result;
}
