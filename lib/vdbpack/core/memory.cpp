#include "vdbpack/core/memory.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// Between two readings of the memory held, each of which takes some 20 microseconds.
constexpr auto kInterval = std::chrono::milliseconds(50);

/// The first number of a file, or the one after a word; infinite where there is none.
double numberIn(const std::string& file, const std::string& after = {}) {
    std::ifstream in(file);
    std::string word;
    while (word != after && in >> word) continue;
    double value = 0;
    return in >> value ? value : kInfinite;
}

/// An entry of the process's status, which is in KiB, as bytes.
double statusOf(const std::string& entry) {
    const double kibibytes = numberIn("/proc/self/status", entry);
    return std::isfinite(kibibytes) ? 1024 * kibibytes : 0;
}

/// Bytes that the control groups leave, from that of the process up to the root.
double leftByGroups() {
    std::ifstream groups("/proc/self/cgroup");
    std::string path;
    std::getline(groups, path);
    if (path.rfind("0::", 0) != 0) return kInfinite;  // not version 2
    path.erase(0, 3);
    double left = kInfinite;
    for (;;) {
        const std::string group = "/sys/fs/cgroup" + path;
        const double held = numberIn(group + "/memory.current");
        // The system gives up cached pages of files when memory runs short.
        const double cached = std::min(held, numberIn(group + "/memory.stat", "inactive_file"));
        const double limit = numberIn(group + "/memory.max");
        if (std::isfinite(limit)) left = std::min(left, std::max(0.0, limit - (held - cached)));
        if (path.empty()) return left;
        path.erase(path.find_last_of('/'));
    }
}

double leftByLimit() {
    rlimit limit{};
    if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kInfinite;
    return std::max(0.0, static_cast<double>(limit.rlim_cur) - statusOf("VmSize:"));
}

}  // namespace

std::string bytesText(double bytes) {
    const char* const units[] = {"KiB", "MiB", "GiB", "TiB"};
    std::size_t u = 0;
    double value = bytes / 1024;
    for (; u < 3 && value >= 999.5; ++u) value /= 1024;
    return fmt::format("{:.3g} {}", value, units[u]);
}

double availableMemory() {
    const double ofMachine = 1024 * numberIn("/proc/meminfo", "MemAvailable:");
    return std::min({ofMachine, leftByGroups(), leftByLimit()});
}

double residentMemory() {
    return statusOf("VmRSS:");
}

std::uint64_t peakMemory() {
    // What getrusage says goes back to before the program was started, by one that may hold more.
    if (const double held = statusOf("VmHWM:"); held > 0) return static_cast<std::uint64_t>(held);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

void returnFreedMemory() {
#ifdef __GLIBC__
    ::malloc_trim(0);
#endif
}

double memoryLimit(double limit) {
    return limit > 0 ? limit : residentMemory() + availableMemory();
}

void requireMemoryToRead(const std::string& file, double bytes, double limit) {
    constexpr double kNegligible = 1 << 20;
    if (bytes < kNegligible) return;
    const double held = residentMemory(), most = memoryLimit(limit);
    if (held + bytes > most)
        throw ResourceError(fmt::format(
            "{}: its content would take {} of memory beside {} that are held, and {} may be taken "
            "(`memoryLimit`). Raise the limit, or read a file of fewer spheres and columns",
            file, bytesText(bytes), bytesText(held), bytesText(most)));
}

double availableSpace(const std::string& path) {
    std::error_code failed;
    const auto space =
        std::filesystem::space(std::filesystem::path(path).parent_path() / ".", failed);
    // File systems without blocks of their own (/dev, /proc) report no capacity.
    return failed || space.capacity == 0 ? kInfinite : static_cast<double>(space.available);
}

Callbacks withinMemory(Callbacks callbacks, double limit) {
    limit = memoryLimit(limit);
    if (!std::isfinite(limit)) return callbacks;
    using Clock = std::chrono::steady_clock;
    const auto next = std::make_shared<std::atomic<Clock::time_point>>(Clock::time_point{});
    callbacks.cancelled = [limit, next, asked = std::move(callbacks.cancelled)] {
        if (const auto now = Clock::now(); now >= next->load()) {
            next->store(now + kInterval);
            if (const double held = residentMemory(); held > limit)
                throw ResourceError(fmt::format(
                    "stopped: the process holds {} of memory, and {} are allowed. Nothing more is "
                    "written. Choose larger radii, voxels or voids, clip the domain, or raise "
                    "`memoryLimit`",
                    bytesText(held), bytesText(limit)));
        }
        return asked && asked();
    };
    return callbacks;
}

}  // namespace vdbpack
