// Time of distance fields of meshes.
#pragma once

#include <string>
#include <vector>

/// Prints the time of the distance field of each mesh (`readBenchMesh`), and that of a single call
/// of OpenVDB's meshToVolume at the same voxel size and band.
void benchFields(const std::vector<std::string>& meshes);
