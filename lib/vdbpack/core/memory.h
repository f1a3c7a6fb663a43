// Memory and space on disks: what there is, what is held, what is allowed.
#pragma once

#include "vdbpack/core/progress.h"

#include <cstddef>
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

/// Bytes that this process may still take: what the machine has left, or its control group or
/// `ulimit` allows, whichever is less. Infinite where nothing tells.
double availableMemory();

/// Bytes of memory that this process holds now; 0 where nothing tells.
double residentMemory();

/// Bytes that a file in the folder of `path` may still take; infinite where nothing tells.
/// @param device  set to a number of the file system, if not null.
double availableSpace(const std::string& path, std::uint64_t* device = nullptr);

/// Whether an exception says that memory or threads are not to be had: `std::bad_alloc`,
/// ResourceError, `std::system_error` of that kind, and what TBB throws where no thread starts.
bool isShortage(const std::exception& failure);

/// Memory held back for the way out. The first allocation that fails while it lives gives half of
/// it back and is tried again: small ones succeed from then on, and what asks `withinMemory` is
/// told to stop. If one fails all the same, the other half is there while the exception unwinds.
/// OpenVDB, TBB and nlohmann-json need that: destructors take memory and may not throw, threads
/// that join what they made wait for ever if one throws.
///
/// By `std::set_new_handler`, for all threads: where there is a handler already (another reserve,
/// or the program's own) it does nothing.
class MemoryReserve {
public:
    /// @param bytes  of address space, which take no memory.
    explicit MemoryReserve(std::size_t bytes = std::size_t{64} << 20);
    ~MemoryReserve();
    MemoryReserve(const MemoryReserve&) = delete;
    MemoryReserve& operator=(const MemoryReserve&) = delete;

    /// Whether the one that lives was given back.
    static bool isSpent();

private:
    bool installed_ = false;
};

/// The same callbacks, but `cancelled` throws ResourceError once the process holds more than
/// `limit` bytes, or had to take its `MemoryReserve`: whatever can be stopped can be stopped for
/// that. Holds such a reserve as long as it lives. Infinite: the reserve alone.
Callbacks withinMemory(Callbacks callbacks, double limit);

}  // namespace vdbpack
