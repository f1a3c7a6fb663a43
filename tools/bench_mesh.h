// A mesh as an argument of benchmarks.
#pragma once

#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <string>

struct BenchMesh {
    std::string file;
    vdbpack::TriangleMesh mesh;
    double smallestRadius = vdbpack::FieldOptions{}.detail;  ///< mm

    /// Options of its field, deep enough for radii at a ratio of 1:2.
    vdbpack::FieldOptions fieldOptions() const;
};

/// Reads MESH[:UNIT[:SMALLEST_RADIUS_MM]]. @throws InputError, IoError, ParameterError
BenchMesh readBenchMesh(const std::string& argument);
