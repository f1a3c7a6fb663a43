// Memory and space on disks: what there is, what is held, what is allowed.
#pragma once

#include "vdbpack/core/progress.h"

#include <cstdint>
#include <string>

namespace vdbpack {

/// Bytes of a size as people write it: "8G", "500 MB", "1.5GiB", "65536". K, M, G and T are powers
/// of 1024, with or without iB; KB, MB, GB and TB of 1000.
/// @throws ParameterError, which names `option`, for anything else and for less than one byte.
double parseBytes(const std::string& text, const std::string& option);

/// "1.5 GiB", "820 MiB", "12 KiB".
std::string bytesText(double bytes);

/// Bytes that this process may still take: what the machine has left, or its control group or
/// `ulimit` allows, whichever is less. Infinite where nothing tells.
double availableMemory();

/// Bytes of memory that this process holds now; 0 where nothing tells.
double residentMemory();

/// Bytes that a file in the folder of `path` may still take; infinite where nothing tells.
/// @param device  set to a number of the file system, if not null.
double availableSpace(const std::string& path, std::uint64_t* device = nullptr);

/// The same callbacks, but `cancelled` throws ResourceError once the process holds more than
/// `limit` bytes: whatever can be stopped can be stopped for that. Infinite: the callbacks alone.
Callbacks withinMemory(Callbacks callbacks, double limit);

}  // namespace vdbpack
