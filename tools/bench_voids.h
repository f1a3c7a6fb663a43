// Time of stamping voids.
#pragma once

#include <string>

/// Stamps 100,000 ellipsoids with half-axes of about 1.5 x 0.5 mm into a mesh in voxels of 0.3 mm,
/// compared with cutting 200 of them one by one; packs the mesh and carves the pack with all of
/// them.
/// @param mesh  MESH[:UNIT].
void benchVoids(const std::string& mesh, int threads, double targetCount);
