// Memory and disk space: what is available, what the process holds, and a limit on it.
#pragma once

#include "vdbpack/core/progress.h"

#include <cstdint>
#include <exception>
#include <string>

namespace vdbpack {

/// Bytes of a size as people write it: "8G", "500 MB", "1.5GiB", "65536". K, M, G and T are powers
/// of 1024, with or without iB; KB, MB, GB and TB of 1000.
/// @throws ParameterError, which names `option`, for anything else and for less than one byte.
double parseBytes(const std::string& text, const std::string& option);

/// "1.5 GiB", "820 MiB", "12 KiB".
std::string bytesText(double bytes);

/// Bytes that this process may still take: the least of what the machine has left, its control
/// groups and `ulimit` allow. Infinite where the system reports none of them.
double availableMemory();

/// Bytes of memory that this process holds now; 0 where the system does not report it.
double residentMemory();

/// Bytes that a file in the folder of `path` may still take; infinite where the file system does
/// not report it.
/// @param device  set to the number of the file system, if not null.
double availableSpace(const std::string& path, std::uint64_t* device = nullptr);

/// Whether an exception means that the system is out of memory or threads: `std::bad_alloc`,
/// ResourceError, `std::system_error` of that kind, and the exception of TBB when no thread starts.
bool isShortage(const std::exception& failure);

/// The same callbacks, but `cancelled` throws ResourceError once the process holds more than
/// `limit` bytes: every computation that can be interrupted stops there. Infinite: no limit.
Callbacks withinMemory(Callbacks callbacks, double limit);

}  // namespace vdbpack
