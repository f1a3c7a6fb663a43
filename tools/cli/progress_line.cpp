#include "cli/progress_line.h"

#include "cli/terminal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>

namespace {

constexpr double kBetween = 0.1;                          // seconds
constexpr double kTellableAfter = 0.5, kTellable = 0.02;  // seconds, share that is done

std::string grouped(double n) {
    std::string digits = fmt::format("{:.0f}", n);
    for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
    return digits;
}

std::string duration(double seconds) {
    const auto s = static_cast<std::int64_t>(std::ceil(seconds));
    return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                    : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

std::string progressLine(const vdbpack::Progress& p, double seconds) {
    std::string line = fmt::format("{:<8} {:3.0f} %", p.stage, 100 * p.fraction);
    const bool spheres = p.stage == "pack";
    if (p.count > 0)
        line += fmt::format("   {} {}", grouped(p.count),
                            spheres               ? "spheres"
                            : p.stage == "voids"  ? "voids"
                            : p.stage == "domain" ? "voxels"
                                                  : "");
    if (seconds >= kTellableAfter && p.fraction >= kTellable && p.fraction < 1) {
        if (spheres && p.count > 0) line += fmt::format("   {}/s", grouped(p.count / seconds));
        line += fmt::format("   {} left", duration(seconds * (1 - p.fraction) / p.fraction));
    }
    return line;
}

void ProgressLine::show(const vdbpack::Progress& p) {
    const auto now = Clock::now();
    const auto since = [now](Clock::time_point t) {
        return std::chrono::duration<double>(now - t).count();
    };
    const bool fresh = p.stage != stage_ || p.fraction == 0;
    if (fresh) {
        stage_ = p.stage;
        began_ = now;
    }
    if (!fresh && p.fraction < 1 && since(shown_) < kBetween) return;
    shown_ = now;
    const std::string line = progressLine(p, since(began_)).substr(0, columnsOf(STDERR_FILENO) - 1);
    // A terminal that is gone is no reason to stop: these do not throw.
    std::fprintf(stderr, "\r%s\x1b[K", line.c_str());
    if (p.fraction >= 1) clearProgressLine();
    std::fflush(stderr);
}

void clearProgressLine() {
    if (::isatty(STDERR_FILENO) != 0) std::fputs("\r\x1b[K", stderr);
}
