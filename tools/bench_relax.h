// Cost of the steps that move spheres, on the processor and on devices.
#pragma once

#include <string>
#include <vector>

/// Densifies the packs of boxes to 0.66 on the processor and on the first device of OpenCL, if
/// there is one, and prints a row for each: steps, seconds, nanoseconds a step of a sphere, hash.
/// @param words  numbers of spheres, or "gpu:N" for a device; none: 70,000 and 1,000,000.
/// @return whether all devices made the packs of the processor.
/// @throws ParameterError for other words.
bool benchRelax(int threads, bool quick, std::vector<std::string> words);
