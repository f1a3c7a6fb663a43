// Lookups in a domain beside other ways; needs CGAL, see VDBPACK_BENCH_CGAL.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <string>

/// Prints a row a method: lookups a second, and how many times as long as the domain each takes.
/// @param detail  smallest radius that the field is made for, mm.
void benchLookups(const vdbpack::TriangleMesh& mesh, const std::string& name, double detail);
