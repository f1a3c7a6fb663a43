// Density and speed of packs.
#pragma once

#include <string>
#include <vector>

/// Packs boxes, squares and meshes (`readBenchMesh`), each in a process of its own, and prints
/// their density, the time of packing and of checking for overlaps, and the peak of memory.
/// @return whether all packs were made without overlaps.
bool benchPacks(bool quick, int threads, const std::vector<std::string>& meshes);
