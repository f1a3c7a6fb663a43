// Time of signed distances of a domain, compared with CGAL; needs VDBPACK_BENCH_CGAL.
#pragma once

#include "vdbpack/mesh/triangle_mesh.h"

#include <string>

/// Prints a row per method: lookups per second, and the time relative to that of the domain.
/// @param detail  smallest radius that the field is made for, mm.
void benchLookups(const vdbpack::TriangleMesh& mesh, const std::string& name, double detail);
