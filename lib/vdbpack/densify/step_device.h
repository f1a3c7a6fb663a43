// Private to densify: an OpenCL device that takes steps of a relaxation.
#pragma once

#include "vdbpack/core/error.h"
#include "vdbpack/densify/densify.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace vdbpack {

/// Slots that are one task of a processor, one work-group of a device.
inline constexpr std::uint32_t kSlotsOfRun = 1024;
/// Largest difference of ranks of two spheres that exchange positions, and of their radii (as a
/// share of the smaller one).
inline constexpr std::uint32_t kExchangeRanks = 20;
inline constexpr float kAlike = 0.1f;

/// How spheres move in a step.
struct RelaxationStep {
    float inertia = 0;  ///< share of its velocity that a sphere keeps
    float turning = 1;  ///< factor on that where overlaps push against the velocity
    float cap = 0;      ///< largest step, quanta
    float push = 0;     ///< share of an overlap that a sphere gains as velocity
    float pull = 0;     ///< gaps count as negative overlaps, but for no more than this
    float range = 1;    ///< how far they do, in sums of the radii
    float wallPull = 0, wallRange = 1;  ///< the same of walls, in radii
    std::uint32_t exchanges = 0;        ///< whether spheres exchange positions
    std::uint32_t drifts = 1;  ///< where gaps count: whether spheres move on that nothing pushes
};
// What relaxation_kernels.cl has under the same names.
/// A run: numbers of its members and ranks, and where its part of each array begins.
struct DeviceRun {
    std::uint32_t first = 0, member = 0, members = 0, wallMembers = 0, id = 0, rank = 0, ranks = 0,
                  plane = 0, edge = 0;
};
struct DeviceStep {
    std::uint64_t seed = 0, clock = 0;
    RelaxationStep motion;
    float grow = 0, listGrow = 0, perLeast = 0;
    std::uint32_t graded = 0, edges = 0, unused = 0;
};
static_assert(sizeof(DeviceStep) == 80);
struct DeviceImage {
    std::uint32_t slot = 0, source = 0, x = 0, y = 0, z = 0;
};

/// A device that takes steps; each array that they need is put there before.
class StepDevice {
public:
    using Warn = std::function<void(const std::string&)>;
    /// Something that the device could not do, such as to allocate memory.
    struct Failure : ResourceError {
        using ResourceError::ResourceError;
    };
    /// An OpenCL device.
    /// @param spheres  that move: for few of them, an automatic choice needs no device.
    /// @return null: the processor takes all steps.
    /// @throws ParameterError if there is no such device; ResourceError if it does not work.
    static std::unique_ptr<StepDevice> open(const DeviceChoice& choice, std::uint64_t spheres,
                                            Warn warn);
    virtual ~StepDevice();

    /// What the kernels work on; see relaxation_kernels.cl.
    enum Array {
        kBodies,
        kNext,
        kListed,
        kRoam,
        kRanks,
        kLabels,
        kRuns,
        kMembers,
        kIds,
        kEnds,
        kPlanes,
        kPlaneEnds,
        kEdges,
        kEdgeEnds,
        kAlikes,
        kExchanged,
        kExtremes,
        kImages,
        kArrays
    };
    /// @throws Failure, as all that follow.
    template <class Item>
    void put(Array array, const std::vector<Item>& items) {
        static_assert(std::is_trivially_copyable_v<Item>);
        write(array, items.data(), items.size() * sizeof(Item));
    }
    /// Makes room for `count` items.
    template <class Item>
    void reserve(Array array, std::size_t count) {
        allocate(array, count * sizeof(Item));
    }
    /// As many items as the vector has.
    template <class Item>
    void get(Array array, std::vector<Item>& items) {
        read(array, items.data(), items.size() * sizeof(Item));
    }
    /// A step of so many runs, into `kNext` and `kExtremes`.
    virtual void step(const DeviceStep& step, std::size_t runs) = 0;
    /// Takes up the last step: exchanges `kBodies` and `kNext`; labels and images follow.
    virtual void advance(bool exchanges, std::size_t runs, std::size_t images) = 0;

    /// Whether the steps until lists are renewed are the device's.
    bool takesNext();
    /// Time of steps, with what was transferred for them.
    void record(bool byDevice, double seconds, int steps = 1);
    /// Whether a step had the same bits as the processor's, by whether gaps pulled in it.
    bool isTrusted(bool pulls) const { return trusted_[pulls]; }
    void trust(bool pulls) { trusted_[pulls] = true; }
    /// The processor takes all further steps.
    void giveUp(const std::string& why);
    DeviceUse use();

protected:
    /// @param chosen  whether it takes all steps, also where the processor is quicker.
    StepDevice(DeviceUse use, bool chosen, Warn warn);
    DeviceUse use_;

private:
    virtual void allocate(Array array, std::size_t bytes) = 0;
    virtual void write(Array array, const void* from, std::size_t bytes) = 0;
    virtual void read(Array array, void* to, std::size_t bytes) = 0;
    virtual void collect() = 0;

    Warn warn_;
    bool chosen_, givenUp_ = false;
    bool trusted_[2] = {false, false};
    int turns_ = 0;
    struct Times {
        double seconds = 0;
        std::uint64_t steps = 0;
        double perStep() const { return steps == 0 ? 0 : seconds / static_cast<double>(steps); }
    };
    Times processor_, own_;
};

}  // namespace vdbpack
