// Memory and disk space: what is available, what the process holds, and a limit on it.
#pragma once

#include "vdbpack/core/progress.h"

#include <cstdint>
#include <string>

namespace vdbpack {

/// "1.5 GiB", "820 MiB", "12 KiB".
std::string bytesText(double bytes);

/// Bytes that this process may still take: the least of what the machine has left, its control
/// groups (version 2) and `ulimit -v` allow. Infinite where the system reports none of them.
double availableMemory();

/// Bytes of memory that this process holds now; 0 where the system does not report it.
double residentMemory();

/// Peak memory of this process, bytes.
std::uint64_t peakMemory();

/// Returns what was freed in small pieces to the system, which the allocator keeps otherwise; a
/// millisecond for each 10 MB or so.
void returnFreedMemory();

/// Bytes that this process may hold: `limit`, or for 0 what it holds now and what is available.
double memoryLimit(double limit);

/// Refuses to hold `bytes` more than now for the content of a file.
/// @throws ResourceError "file: ..." beyond `limit` (as `memoryLimit`).
void requireMemoryToRead(const std::string& file, double bytes, double limit);

/// Bytes that a file in the folder of `path` may still take; infinite where the file system does
/// not report it.
double availableSpace(const std::string& path);

/// The same callbacks, but `cancelled` throws ResourceError once the process holds more than
/// `limit` bytes (as `memoryLimit`): every computation that can be interrupted stops there.
Callbacks withinMemory(Callbacks callbacks, double limit);

}  // namespace vdbpack
