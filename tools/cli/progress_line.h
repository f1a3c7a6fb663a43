// The progress of a run, on one line of a terminal.
#pragma once

#include "vdbpack/core/progress.h"

#include <chrono>
#include <string>

/// "pack      43 %   1,234,567 spheres   580,000/s   0:03 left"; rate and remaining time once
/// they can be estimated.
/// @param seconds  since the stage began.
std::string progressLine(const vdbpack::Progress& progress, double seconds);

/// Shows progress on the terminal at standard error, ten times a second at the most.
class ProgressLine {
public:
    void show(const vdbpack::Progress& progress);

private:
    using Clock = std::chrono::steady_clock;
    std::string stage_;
    Clock::time_point began_, shown_;
};

/// Removes the line, if standard error is a terminal.
void clearProgressLine();
