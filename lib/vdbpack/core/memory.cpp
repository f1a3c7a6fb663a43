#include "vdbpack/core/memory.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

namespace vdbpack {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
/// Seconds between two readings of the memory held; a reading takes some microseconds.
constexpr double kInterval = 0.05;

/// The first number of a file; infinite for "max" and where there is none.
double numberIn(const std::string& path) {
    std::ifstream file(path);
    double value = kInfinite;
    return file >> value ? value : kInfinite;
}

/// Bytes that the control groups leave, from that of the process up to the root.
double leftByGroups() {
    double left = kInfinite;
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        const auto first = line.find(':'), second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string kind = line.substr(first + 1, second - first - 1);
        const bool unified = kind.empty();
        if (!unified && kind != "memory") continue;
        const std::string root = unified ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        const char* most = unified ? "/memory.max" : "/memory.limit_in_bytes";
        const char* held = unified ? "/memory.current" : "/memory.usage_in_bytes";
        std::string path = line.substr(second + 1);
        for (;;) {
            const double limit = numberIn(root + path + most);
            // Version 1 writes "no limit" as a number beyond any machine.
            if (limit < 1e18) {
                const double now = numberIn(root + path + held);
                left = std::min(left, std::max(0.0, limit - (std::isfinite(now) ? now : 0)));
            }
            if (path.empty() || path == "/") break;
            path.erase(path.find_last_of('/'));
        }
    }
    return left;
}

double leftByMachine() {
    std::ifstream info("/proc/meminfo");
    std::string key;
    double value = 0;
    for (std::string rest; info >> key >> value && std::getline(info, rest);)
        if (key == "MemAvailable:") return value * 1024;
    return kInfinite;
}

/// Entry `at` of /proc/self/statm in bytes: 0 all addresses, 1 held, 5 data.
double pagesHeld(int at) {
    std::ifstream file("/proc/self/statm");
    double value = 0;
    for (int i = 0; i <= at; ++i)
        if (!(file >> value)) return 0;
    return value * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

double leftByLimits() {
    double left = kInfinite;
    for (const auto& [what, entry] : {std::pair{RLIMIT_AS, 0}, std::pair{RLIMIT_DATA, 5}}) {
        rlimit limit{};
        if (::getrlimit(what, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
            left = std::min(left,
                            std::max(0.0, static_cast<double>(limit.rlim_cur) - pagesHeld(entry)));
    }
    return left;
}

}  // namespace

double parseBytes(const std::string& text, const std::string& option) {
    const auto fail = [&] {
        throw ParameterError(fmt::format(
            "{} '{}': not a size of memory. Write a positive number of bytes, or one with a unit: "
            "8G, 500M, 1.5GiB",
            option, text));
    };
    double value = 0;
    const char* const end = text.data() + text.size();
    auto [at, failed] = std::from_chars(text.data(), end, value);
    if (failed != std::errc()) fail();
    while (at != end && *at == ' ') ++at;
    std::string unit(at, end);
    for (char& c : unit) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 32 : c);
    if (!unit.empty() && unit != "B") {
        const auto power = std::string("KMGT").find(unit.front());
        const std::string rest = unit.substr(1);
        if (power == std::string::npos || (!rest.empty() && rest != "B" && rest != "IB")) fail();
        value *= std::pow(rest == "B" ? 1000.0 : 1024.0, static_cast<double>(power + 1));
    }
    if (!(value >= 1) || !std::isfinite(value)) fail();
    return value;
}

std::string bytesText(double bytes) {
    const char* const units[] = {"KiB", "MiB", "GiB", "TiB"};
    std::size_t u = 0;
    double value = bytes / 1024;
    for (; u < 3 && value >= 1000; ++u) value /= 1024;
    return fmt::format(value < 10 && u > 0 ? "{:.1f} {}"
                       : value < 1e6       ? "{:.0f} {}"
                                           : "{:.3g} {}",
                       value, units[u]);
}

double availableMemory() {
    return std::min({leftByMachine(), leftByGroups(), leftByLimits()});
}

double residentMemory() {
    return pagesHeld(1);
}

double availableSpace(const std::string& path, std::uint64_t* device) {
    const auto slash = path.find_last_of('/');
    const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
    struct stat info {};
    if (device) *device = ::stat(folder.c_str(), &info) == 0 ? info.st_dev : 0;
    struct statvfs space {};
    // File systems without blocks of their own (/dev, /proc) report none at all.
    if (::statvfs(folder.c_str(), &space) != 0 || space.f_blocks == 0) return kInfinite;
    return static_cast<double>(space.f_bavail) * static_cast<double>(space.f_frsize);
}

bool isShortage(const std::exception& failure) {
    if (const auto* system = dynamic_cast<const std::system_error*>(&failure))
        return system->code() == std::errc::not_enough_memory ||
               system->code() == std::errc::resource_unavailable_try_again;
    // TBB throws a std::runtime_error that only its text identifies.
    return dynamic_cast<const std::bad_alloc*>(&failure) != nullptr ||
           dynamic_cast<const ResourceError*>(&failure) != nullptr ||
           std::string_view(failure.what()).find("pthread_create") != std::string_view::npos;
}

Callbacks withinMemory(Callbacks callbacks, double limit) {
    if (!std::isfinite(limit)) return callbacks;
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const auto next = std::make_shared<std::atomic<double>>(0.0);
    callbacks.cancelled = [limit, start, next, asked = std::move(callbacks.cancelled)] {
        const double now = std::chrono::duration<double>(Clock::now() - start).count();
        if (now >= next->load(std::memory_order_relaxed)) {
            next->store(now + kInterval, std::memory_order_relaxed);
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
