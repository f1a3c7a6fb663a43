#include "vdbpack/densify/step_device.h"

#include <fmt/format.h>

#include <utility>

namespace vdbpack {

StepDevice::StepDevice(DeviceUse use, bool chosen, Warn warn)
    : use_(std::move(use)), warn_(std::move(warn)), chosen_(chosen) {}

StepDevice::~StepDevice() = default;

bool StepDevice::takesNext() {
    if (givenUp_ || chosen_) return !givenUp_;
    // Each takes the steps of some lists first; then the quicker one takes all.
    constexpr int kTrials = 4;
    if (turns_ < kTrials) return turns_++ % 2 == 1;
    return own_.steps > 0 && own_.perStep() < processor_.perStep();
}

void StepDevice::record(bool byDevice, double seconds, int steps) {
    Times& times = byDevice ? own_ : processor_;
    times.seconds += seconds;
    times.steps += static_cast<std::uint64_t>(steps);
}

void StepDevice::giveUp(const std::string& why) {
    givenUp_ = true;
    if (warn_) warn_(fmt::format("{}: {}; the processor takes all further steps", use_.name, why));
}

DeviceUse StepDevice::use() {
    if (!givenUp_) collect();
    return use_;
}

}  // namespace vdbpack
