// One step of the relaxation: overlaps push, and all spheres of a run move.
//
// Eight spheres at a time, each in its lane, and each sum in the order of its list: the same bits
// as of one sphere after the other.
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

namespace vdbpack {

namespace {

VDBPACK_INLINE Int8 counted(Int8 count, Int8 mask) {
    return count - mask;
}

/// Without fractions, so that the slowest motions end.
VDBPACK_INLINE Word8 whole(Float8 v) {
    return bitsAs<Word8>(__builtin_convertvector(v, Int8));
}

}  // namespace

#define INLINE VDBPACK_INLINE
namespace eight {
using Real = Float8;
using Mask = Int8;
using Count = Int8;
#define EVERY(v) everyLane(v)
#include "vdbpack/densify/relaxation_law.cl"
#undef EVERY
}  // namespace eight
#undef INLINE

template <int Dim>
eight::Push Relaxation<Dim>::pushOfPlanes(const Run& run, const std::uint32_t* slots,
                                          const RelaxationStep& step) const {
    constexpr float kFar = 1e15f;  // from where there is no plane
    eight::Push push{};
    const Bodies8 own = gather(now_.bodies.data(), slots);
    const auto add = [&](const std::vector<WallPlane>& planes,
                         const std::vector<std::uint32_t>& ends, const eight::Law& law,
                         bool isWall) {
        std::uint32_t first[kLanes], count[kLanes], most = 0;
        for (std::size_t l = 0; l < kLanes; ++l) {
            const std::uint32_t k = slots[l] - run.first;
            first[l] = k > 0 ? ends[k - 1] : 0;
            count[l] = ends[k] - first[l];
            most = std::max(most, count[l]);
        }
        for (std::uint32_t p = 0; p < most; ++p) {
            WallPlane of[kLanes];
            Int8 has{};
            for (std::size_t l = 0; l < kLanes; ++l) {
                if (p >= count[l]) continue;
                of[l] = planes[first[l] + p];
                has[l] = -1;
            }
            const auto all = [&of](auto member) {
                using Value = std::decay_t<decltype(of[0].*member)>;
                std::array<Value, kLanes> values;
                for (std::size_t l = 0; l < kLanes; ++l) values[l] = of[l].*member;
                return bitsAs<std::conditional_t<std::is_same_v<Value, float>, Float8, Word8>>(
                    values);
            };
            const Float8 nx = all(&WallPlane::nx), ny = all(&WallPlane::ny),
                         nz = all(&WallPlane::nz);
            const Float8 away = nx * difference(own.x, all(&WallPlane::x)) +
                                ny * difference(own.y, all(&WallPlane::y)) +
                                nz * difference(own.z, all(&WallPlane::z));
            eight::addPlane(&push, nx, ny, nz, choose(has, away, kFar), own.radius * (1 + delta_),
                            law, isWall);
        }
    };
    add(run.planes, run.planeEnds, eight::lawOf(step.wallPull, step.wallRange), true);
    if (!run.edgeEnds.empty()) add(run.edges, run.edgeEnds, eight::lawOf(0, 1), false);
    return push;
}

template <int Dim>
template <bool kPull, bool kGraded>
void Relaxation<Dim>::stepRun(Run& run, const RelaxationStep& step) {
    const Body* bodies = now_.bodies.data();
    const eight::Law law = eight::lawOf(step.pull, step.range);
    const float grow = 1 + delta_;
    const std::uint32_t* ids = run.ids.data();
    run.exchanged.clear();
    std::vector<Squeezed> squeezed(step.exchanges ? run.last - run.first : 0);
    Float8 worst = {}, fastest = {};
    Int8 expired = {};
    for (std::size_t m = 0; m < run.members.size(); m += kLanes) {
        const std::uint32_t* slots = run.members.data() + m;
        const std::uint32_t* end = run.ids.data() + run.ends[m / kLanes];
        const Bodies8 own = gather(bodies, slots);
        eight::Push push = m < run.wallMembers ? pushOfPlanes(run, slots, step) : eight::Push{};
        for (; ids != end; ids += kLanes) {
            const Bodies8 other = gather(bodies, ids);
            eight::addSphere(&push, difference(other.x, own.x), difference(other.y, own.y),
                             difference(other.z, own.z), other.radius, own.radius, grow, law, kPull,
                             kGraded);
        }
        const Bodies8 before = gather(now_.before.data(), slots);
        const Float8 contacts = __builtin_convertvector(push.contacts, Float8);
        const Float8 unit = kGraded ? own.radius * perLeast_ : everyLane(1);
        const eight::Motion from{difference(own.x, before.x), difference(own.y, before.y),
                                 difference(own.z, before.z), Float8{}};
        const eight::Motion v = eight::moved(push, contacts, from, step.cap * unit, step.inertia,
                                             step.turning, step.push, kPull, step.drifts);
        fastest = larger(fastest, v.square * inverse(unit * unit));
        worst = larger(worst, push.worst);
        const Bodies8 next{own.x + whole(v.x), own.y + whole(v.y), own.z + whole(v.z), own.radius};
        expired |= areBeyond(gather(now_.listed.data(), slots), next);
        scatter(now_.before.data(), slots, next);
        if (step.exchanges)
            for (std::size_t l = 0; l < kLanes; ++l)
                squeezed[slots[l] - run.first] = {push.squeeze[l], contacts[l]};
    }
    run.worst = run.coincides ? std::max(largest(worst), 1.0f) : largest(worst);
    run.fastest = largest(fastest);
    run.expired |= !noneOf(expired);
    if (step.exchanges) swapRun(run, squeezed);
}

#define VDBPACK_INSTANTIATE(Dim)                                                       \
    template void Relaxation<Dim>::stepRun<false, false>(Run&, const RelaxationStep&); \
    template void Relaxation<Dim>::stepRun<true, false>(Run&, const RelaxationStep&);  \
    template void Relaxation<Dim>::stepRun<false, true>(Run&, const RelaxationStep&);  \
    template void Relaxation<Dim>::stepRun<true, true>(Run&, const RelaxationStep&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
