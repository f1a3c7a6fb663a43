// Without OpenCL.
#include "vdbpack/core/error.h"
#include "vdbpack/densify/step_device.h"

namespace vdbpack {

std::unique_ptr<StepDevice> StepDevice::open(const DeviceChoice& choice, std::uint64_t, Warn) {
    if (choice.kind == DeviceChoice::Kind::gpu)
        throw ParameterError(
            "`device` gpu: this build has no OpenCL. Build it with "
            "ocl-icd-opencl-dev and opencl-clhpp-headers, or leave out `device`");
    return nullptr;
}

}  // namespace vdbpack
