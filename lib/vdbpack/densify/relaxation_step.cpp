// One step of the relaxation: overlaps push, and all spheres of a run move.
//
// Eight spheres at a time, each in its lane, and each sum in the order of its list: the same bits
// as of one sphere after the other.
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

VDBPACK_INLINE Int8 counted(Int8 count, Int8 mask) {
    return count - mask;
}
VDBPACK_INLINE int counted(int count, bool mask) {
    return count + mask;
}

/// Without fractions, so that the slowest motions end.
VDBPACK_INLINE Word8 whole(Float8 v) {
    return bitsAs<Word8>(__builtin_convertvector(v, Int8));
}

}  // namespace

#define INLINE VDBPACK_INLINE
namespace one {
using Real = float;
using Mask = bool;
using Count = int;
#define EVERY(v) (v)
#include "vdbpack/densify/relaxation_law.cl"
#undef EVERY
}  // namespace one
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
void Relaxation<Dim>::addPlanes(const Run& run, const std::uint32_t* slots,
                                const RelaxationStep& step, eight::Push& push) const {
    const one::Law wall = one::lawOf(step.wallPull, step.wallRange), edge = one::lawOf(0, 1);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const Body& body = now_.bodies[slots[lane]];
        const std::uint32_t k = slots[lane] - run.first;
        one::Push sum{};
        const auto add = [&](const std::vector<WallPlane>& planes,
                             const std::vector<std::uint32_t>& ends, const one::Law& law,
                             bool isWall) {
            for (std::uint32_t p = k > 0 ? ends[k - 1] : 0; p < ends[k]; ++p) {
                const WallPlane& plane = planes[p];
                const float away = plane.distance(body), reach = body.radius * (1 + delta_);
                if (plane.overlap(away, reach) > law.least)  // else it adds nothing
                    one::addPlane(&sum, plane.nx, plane.ny, plane.nz, away, reach, law, isWall);
            }
        };
        add(run.planes, run.planeEnds, wall, true);
        if (!run.edgeEnds.empty()) add(run.edges, run.edgeEnds, edge, false);
        push.x[lane] = sum.x;
        push.y[lane] = sum.y;
        push.z[lane] = sum.z;
        push.squeeze[lane] = sum.squeeze;
        push.worst[lane] = sum.worst;
        push.contacts[lane] = sum.contacts;
    }
}

template <int Dim>
void Relaxation<Dim>::touch(const Run& run, bool exchanges) const {
    const auto read = [](const auto* from, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; i += std::max<std::size_t>(1, 64 / sizeof *from))
            asm volatile("" ::"r"(*reinterpret_cast<const std::uint32_t*>(from + i)));
    };
    read(run.ids.data(), 0, run.ids.size());
    read(now_.before.data(), run.first, run.last);
    read(now_.listed.data(), run.first, run.last);
    if (!exchanges) return;
    read(now_.labels.data(), run.first, run.last);
    read(now_.vicinities.data(), run.first, run.last);
}

template <int Dim>
template <bool kPull, bool kGraded>
void Relaxation<Dim>::stepRun(Run& run, const RelaxationStep& step) {
    const Body* bodies = now_.bodies.data();
    const eight::Law law = eight::lawOf(step.pull, step.range);
    const float grow = 1 + delta_;
    const std::uint32_t* ids = run.ids.data();
    run.exchanged.clear();
    touch(run, step.exchanges);
    std::vector<Squeezed> squeezed(step.exchanges ? run.last - run.first : 0);
    Float8 worst = {}, fastest = {};
    Int8 expired = {};
    for (std::size_t m = 0; m < run.members.size(); m += kLanes) {
        const std::uint32_t* slots = run.members.data() + m;
        const std::uint32_t* end = run.ids.data() + run.ends[m / kLanes];
        const Bodies8 own = gather(bodies, slots);
        eight::Push push{};
        if (m < run.wallMembers) addPlanes(run, slots, step, push);
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
