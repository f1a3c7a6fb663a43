// Time of whole runs with more and more threads.
#pragma once

#include <string>
#include <vector>

/// Runs with 1, 2, 4, ... and `most` threads: seconds of each stage, the least of some runs.
/// @param quick   small packs.
/// @param meshes  MESH[:UNIT[:SMALLEST_RADIUS_MM]] to be packed, too, with a shell and voids.
/// @throws std::runtime_error if a pack depends on the number of threads.
void benchThreads(int most, bool quick, const std::vector<std::string>& meshes);
