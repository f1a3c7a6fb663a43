// Steps on an OpenCL device: between two renewals of the lists, all that a step changes is there.
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/densify/relaxation.h"
#include "vdbpack/densify/step_device.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

/// What all runs have of an array, one after the other. @param begin  where each one's begins.
template <class Run, class Item>
std::vector<Item> joined(const std::vector<Run>& runs, std::vector<Item> Run::*part,
                         std::vector<DeviceRun>& places, std::uint32_t DeviceRun::*begin) {
    std::vector<std::size_t> begins{0};
    for (const Run& run : runs) begins.push_back(begins.back() + (run.*part).size());
    if (begins.back() > std::numeric_limits<std::uint32_t>::max())
        throw StepDevice::Failure("lists are longer than 2^32");
    std::vector<Item> all(begins.back());
    parallelFor(std::size_t(0), runs.size(), [&](std::size_t k) {
        if (begin) places[k].*begin = static_cast<std::uint32_t>(begins[k]);
        std::copy((runs[k].*part).begin(), (runs[k].*part).end(),
                  all.begin() + static_cast<std::ptrdiff_t>(begins[k]));
    });
    return all;
}

class Stopwatch {
public:
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

template <int Dim>
void Relaxation<Dim>::toDevice() {
    using D = StepDevice;
    std::vector<DeviceRun> places(runs_.size());
    for (std::size_t k = 0; k < runs_.size(); ++k) {
        const Run& run = runs_[k];
        DeviceRun& place = places[k];
        place.first = run.first;
        place.members = static_cast<std::uint32_t>(run.members.size());
        place.wallMembers = static_cast<std::uint32_t>(run.wallMembers);
        place.ranks = static_cast<std::uint32_t>(run.ranks.size());
    }
    device_->put(D::kMembers, joined(runs_, &Run::members, places, &DeviceRun::member));
    device_->put(D::kIds, joined(runs_, &Run::ids, places, &DeviceRun::id));
    device_->put(D::kEnds, joined<Run, std::uint32_t>(runs_, &Run::ends, places, nullptr));
    device_->put(D::kPlanes, joined(runs_, &Run::planes, places, &DeviceRun::plane));
    device_->put(D::kPlaneEnds,
                 joined<Run, std::uint32_t>(runs_, &Run::planeEnds, places, nullptr));
    device_->put(D::kEdges, joined(runs_, &Run::edges, places, &DeviceRun::edge));
    device_->put(D::kEdgeEnds, joined<Run, std::uint32_t>(runs_, &Run::edgeEnds, places, nullptr));
    device_->put(D::kRanks, joined(runs_, &Run::ranks, places, &DeviceRun::rank));
    device_->put(D::kRuns, places);
    device_->put(D::kBodies, now_.bodies);
    device_->put(D::kNext, now_.before);
    device_->put(D::kListed, now_.listed);
    device_->put(D::kLabels, now_.labels);
    const std::size_t n = now_.labels.size();
    std::vector<float> roams(n);
    std::vector<std::uint32_t> alikes(n);  // spheres exchange positions where they are equal
    parallelFor(std::size_t(0), runs_.size(), [&](std::size_t k) {
        constexpr std::uint32_t kAlone = 0x80000000;
        for (std::uint32_t i = runs_[k].first; i < runs_[k].last; ++i) {
            roams[i] = now_.vicinities[i].roam;
            const std::uint32_t label = now_.labels[i];
            if (settling_ && runs_[k].isBetweenWalls(i))
                alikes[i] = kAlone | i;
            else if (!regions_.empty() && label != kOfOthers)
                alikes[i] = static_cast<std::uint32_t>(regions_[label]);
        }
    });
    device_->put(D::kRoam, roams);
    device_->put(D::kAlikes, alikes);
    std::vector<DeviceImage> images;
    for (const Image& image : images_)
        images.push_back({image.slot, image.source, lowBits(image.shift[0]),
                          lowBits(image.shift[1]), lowBits(image.shift[2])});
    device_->put(D::kImages, images);
    device_->template reserve<std::uint8_t>(D::kExchanged, n);
    device_->template reserve<std::int32_t>(D::kExtremes, 3 * runs_.size());
    onDevice_ = true;
}

template <int Dim>
void Relaxation<Dim>::toHost() {
    if (!onDevice_) return;
    const Stopwatch watch;
    using D = StepDevice;
    onDevice_ = false;
    device_->get(D::kBodies, now_.bodies);
    device_->get(D::kNext, now_.before);
    device_->get(D::kListed, now_.listed);
    device_->get(D::kLabels, now_.labels);
    std::vector<float> roams(now_.labels.size());
    device_->get(D::kRoam, roams);
    forAll(roams.size(), [&](std::size_t i) { now_.vicinities[i].roam = roams[i]; });
    std::size_t count = 0;
    for (const Run& run : runs_) count += run.ranks.size();
    std::vector<std::uint32_t> ranks(count);
    device_->get(D::kRanks, ranks);
    std::vector<std::uint8_t> exchanged(exchangesOnDevice_ ? count : 0);
    device_->get(D::kExchanged, exchanged);
    std::size_t at = 0;
    for (Run& run : runs_) {
        std::copy_n(ranks.begin() + static_cast<std::ptrdiff_t>(at), run.ranks.size(),
                    run.ranks.begin());
        run.exchanged.clear();
        for (std::size_t k = 0; exchangesOnDevice_ && k < run.ranks.size(); ++k)
            if (const std::size_t stride = exchanged[at + k])
                run.exchanged.emplace_back(run.ranks[k], run.ranks[k + stride]);
        at += run.ranks.size();
    }
    device_->record(true, watch.seconds(), 0);
}

template <int Dim>
void Relaxation<Dim>::stepOnDevice(const RelaxationStep& step) {
    if (!onDevice_) toDevice();
    DeviceStep s;
    s.seed = seed_;
    s.clock = clock_;
    s.motion = step;
    s.grow = 1 + delta_;
    s.listGrow = listGrow_;
    s.perLeast = perLeast_;
    s.graded = graded_;
    s.edges = boundary_ != nullptr;
    exchangesOnDevice_ = step.exchanges != 0;
    device_->step(s, runs_.size());
    std::vector<std::int32_t> extremes(3 * runs_.size());
    device_->get(StepDevice::kExtremes, extremes);
    for (std::size_t k = 0; k < runs_.size(); ++k) {
        Run& run = runs_[k];
        run.worst = bitsAs<float>(extremes[3 * k]);
        if (run.coincides) run.worst = std::max(run.worst, 1.0f);
        run.fastest = bitsAs<float>(extremes[3 * k + 1]);
        run.expired |= extremes[3 * k + 2] != 0;
    }
}

template <int Dim>
bool Relaxation<Dim>::isDeviceRight(const RelaxationStep& step) {
    std::vector<Body> next(now_.before.size()), listed(now_.listed.size());
    device_->get(StepDevice::kNext, next);
    device_->get(StepDevice::kListed, listed);
    std::vector<std::tuple<float, float, bool>> extremes;
    for (const Run& run : runs_) extremes.emplace_back(run.worst, run.fastest, run.expired);
    onDevice_ = false;  // the processor has the state from before the step
    for (Run& run : runs_) run.expired = false;
    stepRuns(step);
    const auto same = [](const Body& a, const Body& b) {
        return std::tie(a.x, a.y, a.z, a.radius) == std::tie(b.x, b.y, b.z, b.radius);
    };
    bool right = std::equal(next.begin(), next.end(), now_.before.begin(), same) &&
                 std::equal(listed.begin(), listed.end(), now_.listed.begin(), same);
    for (std::size_t k = 0; k < runs_.size(); ++k)
        right = right && extremes[k] == std::tuple<float, float, bool>(
                                            runs_[k].worst, runs_[k].fastest, runs_[k].expired);
    return right;
}

template <int Dim>
void Relaxation<Dim>::takeStep(const RelaxationStep& step) {
    const Stopwatch watch;
    if (!deviceTurn_) {
        stepRuns(step);
        if (device_) device_->record(false, watch.seconds());
        return;
    }
    try {
        stepOnDevice(step);
    } catch (const StepDevice::Failure& e) {
        // Nothing is lost where the processor has the state still.
        if (onDevice_) throw ResourceError(std::string(e.what()) + "; choose `device` cpu");
        device_->giveUp(e.what());
        deviceTurn_ = false;
        return stepRuns(step);
    }
    const bool pulls = step.range > 1;
    if (device_->isTrusted(pulls)) return device_->record(true, watch.seconds());
    if (isDeviceRight(step)) return device_->trust(pulls);
    device_->giveUp("a step differs from that of the processor");
    deviceTurn_ = false;
}

#define VDBPACK_INSTANTIATE(Dim)             \
    template void Relaxation<Dim>::toHost(); \
    template void Relaxation<Dim>::takeStep(const RelaxationStep&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
