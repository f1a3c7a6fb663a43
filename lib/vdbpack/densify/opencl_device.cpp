// OpenCL: devices, and the steps on one of them.
#include "vdbpack/core/error.h"
#include "vdbpack/densify/step_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <initializer_list>
#include <system_error>
#include <utility>

#define CL_HPP_ENABLE_EXCEPTIONS
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#include <CL/opencl.hpp>

namespace vdbpack {

extern const char* const kRelaxationKernels;

namespace {

/// An automatic choice opens a device for so many spheres or more: to open it, and to compile
/// kernels for it, takes about a second.
constexpr std::uint64_t kManySpheres = 250000;
constexpr std::size_t kGroup = 256;  // work-items of a run

/// Whether the system has files of a GPU; without them, an automatic choice asks for no devices:
/// that alone loads all drivers, and PoCL's takes 60 MB (findings/pocl_memory_of_a_question.sh).
bool mayHaveGpu() {
    for (const char* file : {"/dev/nvidiactl", "/dev/dri/renderD128", "/dev/kfd", "/dev/dxg"})
        if (std::error_code ignored; std::filesystem::exists(file, ignored)) return true;
    return false;
}

/// Calls `work`, with failures as ours.
template <class Work>
auto orFailure(const Work& work) {
    try {
        return work();
    } catch (const cl::Error& e) {
        throw StepDevice::Failure(
            fmt::format("{} failed with OpenCL's error {}", e.what(), e.err()));
    }
}

bool isGpu(const cl::Device& device) {
    return (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_GPU) != 0;
}

/// Of all drivers, GPUs first.
std::vector<cl::Device> allDevices() {
    std::vector<cl::Device> all;
    std::vector<cl::Platform> platforms;
    try {
        cl::Platform::get(&platforms);
    } catch (const cl::Error&) {
        return all;  // no driver
    }
    for (const cl::Platform& platform : platforms) {
        std::vector<cl::Device> devices;
        try {
            platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
        } catch (const cl::Error&) {
            continue;  // none of this driver
        }
        all.insert(all.end(), devices.begin(), devices.end());
    }
    std::stable_partition(all.begin(), all.end(), isGpu);
    return all;
}

class OpenClDevice final : public StepDevice {
public:
    OpenClDevice(const cl::Device& device, bool chosen, Warn warn)
        : StepDevice({device.getInfo<CL_DEVICE_NAME>(), device.getInfo<CL_DRIVER_VERSION>()},
                     chosen, std::move(warn)),
          context_(device),
          queue_(context_, device, CL_QUEUE_PROFILING_ENABLE) {
        cl::Program program(context_, kRelaxationKernels);
        program.build(device, fmt::format("-cl-std=CL1.2 -DMOST_RANKS={} -DMOST_ALIKE={}f "
                                          "-DMOST_SLOTS={}",
                                          kExchangeRanks, kAlike, kSlotsOfRun)
                                  .c_str());
        steps_ = cl::Kernel(program, "stepRuns");
        labels_ = cl::Kernel(program, "exchangeLabels");
        images_ = cl::Kernel(program, "refreshImages");
        for (const cl::Kernel* kernel : {&steps_, &labels_})
            group_ = std::min(group_, kernel->getWorkGroupInfo<CL_KERNEL_WORK_GROUP_SIZE>(device));
        for (std::size_t k = 0; k < kArrays; ++k) allocate(static_cast<Array>(k), kLeastBytes);
    }

    void step(const DeviceStep& step, std::size_t runs) override {
        orFailure([&] {
            collect();
            constexpr cl_uint kStep = 16;  // behind the arrays
            steps_.setArg(kStep, step);
            run(steps_,
                {kRuns, kBodies, kNext, kListed, kRoam, kRanks, kMembers, kIds, kEnds, kPlanes,
                 kPlaneEnds, kEdges, kEdgeEnds, kAlikes, kExchanged, kExtremes},
                runs * group_, group_);
        });
        ++use_.steps;
    }

    void advance(bool exchanges, std::size_t runs, std::size_t images) override {
        orFailure([&] {
            std::swap(buffers_[kBodies], buffers_[kNext]);
            std::swap(bytes_[kBodies], bytes_[kNext]);
            if (exchanges)
                run(labels_, {kRuns, kRanks, kExchanged, kLabels}, runs * group_, group_);
            if (images > 0) run(images_, {kImages, kBodies}, images, 0);
        });
    }

private:
    static constexpr std::size_t kLeastBytes = 64;  // of a buffer

    /// Starts a kernel.
    void run(cl::Kernel& kernel, std::initializer_list<Array> arrays, std::size_t items,
             std::size_t ofGroup) {
        cl_uint number = 0;
        for (const Array array : arrays) kernel.setArg(number++, buffers_[array]);
        cl::Event done;
        queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items),
                                    ofGroup > 0 ? cl::NDRange(ofGroup) : cl::NullRange, nullptr,
                                    &done);
        running_.push_back(done);
    }

    /// Adds up the times of kernels that were started.
    void collect() override {
        for (const cl::Event& event : running_) {
            event.wait();
            use_.seconds +=
                1e-9 * static_cast<double>(event.getProfilingInfo<CL_PROFILING_COMMAND_END>() -
                                           event.getProfilingInfo<CL_PROFILING_COMMAND_START>());
        }
        running_.clear();
    }

    void allocate(Array array, std::size_t bytes) override {
        if (bytes <= bytes_[array]) return;
        const std::size_t room = bytes + bytes / 8;
        orFailure([&] {
            buffers_[array] = cl::Buffer();
            bytes_[array] = 0;
            buffers_[array] = cl::Buffer(context_, CL_MEM_READ_WRITE, room);
            bytes_[array] = room;
        });
    }

    void write(Array array, const void* from, std::size_t bytes) override {
        if (bytes == 0) return;
        allocate(array, bytes);
        orFailure([&] { queue_.enqueueWriteBuffer(buffers_[array], CL_TRUE, 0, bytes, from); });
    }

    void read(Array array, void* to, std::size_t bytes) override {
        if (bytes == 0) return;
        orFailure([&] { queue_.enqueueReadBuffer(buffers_[array], CL_TRUE, 0, bytes, to); });
    }

    cl::Context context_;
    cl::CommandQueue queue_;
    cl::Kernel steps_, labels_, images_;
    std::size_t group_ = kGroup;
    std::array<cl::Buffer, kArrays> buffers_;
    std::array<std::size_t, kArrays> bytes_{};
    std::vector<cl::Event> running_;
};

}  // namespace

std::unique_ptr<StepDevice> StepDevice::open(const DeviceChoice& choice, std::uint64_t spheres,
                                             Warn warn) {
    const bool automatic = choice.kind == DeviceChoice::Kind::automatic;
    if (choice.kind == DeviceChoice::Kind::processor ||
        (automatic && (spheres < kManySpheres || !mayHaveGpu())))
        return nullptr;
    const std::vector<cl::Device> all = allDevices();
    if (automatic && (all.empty() || !isGpu(all.front()))) return nullptr;
    const auto number = static_cast<std::size_t>(choice.number);
    if (all.empty())
        throw ParameterError(
            "`device` gpu: OpenCL finds no device here. Install the OpenCL driver "
            "of the GPU (`clinfo -l` lists what is found), or leave out `device`");
    if (number >= all.size()) {
        std::string names;
        for (std::size_t k = 0; k < all.size(); ++k)
            names +=
                fmt::format("{}gpu:{} {}", k > 0 ? ", " : "", k, all[k].getInfo<CL_DEVICE_NAME>());
        throw ParameterError(
            fmt::format("`device` gpu:{}: there is no such device. These are here: "
                        "{}",
                        number, names));
    }
    const std::string name = all[number].getInfo<CL_DEVICE_NAME>();
    try {
        if (!isGpu(all[number]))
            warn(
                fmt::format("`device` gpu: OpenCL has no GPU here; {} takes the steps, slower than "
                            "without `device`",
                            name));
        return orFailure(
            [&] { return std::make_unique<OpenClDevice>(all[number], !automatic, warn); });
    } catch (const Failure& e) {
        if (!automatic)
            throw ResourceError(
                fmt::format("`device` gpu: {}: {}. Update its driver, or leave out "
                            "`device`",
                            name, e.what()));
        warn(fmt::format("{}: {}; the processor takes all steps", name, e.what()));
        return nullptr;
    }
}

}  // namespace vdbpack
