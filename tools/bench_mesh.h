// A mesh as an argument of benchmarks.
#pragma once

#include "vdbpack/core/units.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <string>

/// MESH[:UNIT[:SMALLEST_RADIUS_MM]].
struct MeshArgument {
    std::string file;
    vdbpack::Unit unit = vdbpack::Unit::millimeter;
    double smallestRadius = vdbpack::FieldOptions{}.detail;  ///< mm
};

/// @throws ParameterError
MeshArgument parseMeshArgument(const std::string& argument);

struct BenchMesh : MeshArgument {
    vdbpack::TriangleMesh mesh;

    /// Options of its field, deep enough for radii at a ratio of 1:2.
    vdbpack::FieldOptions fieldOptions() const;
};

/// Reads the mesh of an argument. @throws InputError, IoError, ParameterError
BenchMesh readBenchMesh(const std::string& argument);
