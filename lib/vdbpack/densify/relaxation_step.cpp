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

/// Where gaps count, a sphere with more neighbors in range gains less velocity from each of them:
/// all together would make it oscillate.
constexpr float kFewNeighbors = 14;
/// Neighbors that are requested from memory before they are needed.
constexpr std::size_t kIdsAhead = 256;

/// How overlaps and gaps become forces.
struct Law {
    float pull;      ///< of the step
    float least;     ///< least overlap divided by the distance that counts, not positive
    float perRange;  ///< 1 / the largest gap that counts

    Law(float pullOfStep, float range)
        : pull(pullOfStep),
          least(range > 1 ? inverse(range) - 1 : 0),
          perRange(range > 1 ? inverse(range - 1) : 0) {}
    /// The overlap, or how strongly a gap pulls: as an overlap of its size would, but for no more
    /// than `pull`, which falls to 0 at the end of the range. The nearest neighbor wins.
    template <class Number>
    VDBPACK_INLINE Number force(Number push) const {
        return larger(push, -pull * (1 + push * perRange));
    }
};

/// Without fractions, so that the slowest motions end.
VDBPACK_INLINE Word8 whole(Float8 v) {
    return bitsAs<Word8>(__builtin_convertvector(v, Int8));
}

}  // namespace

/// The sums of the overlaps of eight spheres, quanta.
struct PushOfEight {
    Float8 x = {}, y = {}, z = {};
    Float8 squeeze = {};  ///< sum of the magnitudes
    Int8 contacts = {};   ///< number of the overlaps and gaps that count
    Float8 worst = {};    ///< the largest overlap divided by the distance

    /// Adds the overlaps with the spheres in the rows `ids` up to `end`.
    /// @param kPull    whether gaps count, as negative overlaps.
    /// @param kGraded  whether stiffness and mass go with the radii: where sizes differ by place,
    ///                 the pressure of spheres that overlap by the same share is then the same, and
    ///                 fine ones do not drift towards coarse ones.
    template <bool kPull, bool kGraded>
    VDBPACK_INLINE void addSpheres(const Body* bodies, const Bodies8& own, const std::uint32_t* ids,
                                   const std::uint32_t* end, float grow, const Law& law) {
        for (; ids != end; ids += kLanes) {
            const Bodies8 other = gather(bodies, ids);
            const Float8 dx = difference(other.x, own.x);
            const Float8 dy = difference(other.y, own.y);
            const Float8 dz = difference(other.z, own.z);
            const Float8 d2 = dx * dx + dy * dy + dz * dz;
            const Float8 reach = (other.radius + own.radius) * grow;
            Float8 push = reach * inverseRoot(d2) - 1;
            const Int8 near = push > law.least;
            worst = larger(worst, push);
            push = kPull ? where8(near, law.force(push)) : larger(push, 0.0f);
            Float8 gain = push;
            if constexpr (kGraded)
                gain =
                    where8(near, push * (2.0f * other.radius) * inverse(other.radius + own.radius));
            x -= gain * dx;
            y -= gain * dy;
            z -= gain * dz;
            squeeze += push * reach;
            contacts -= near;
        }
    }

    /// Adds the overlap of a body in a lane with a plane.
    /// @param isWall  else the plane is the end of a shell: `keepsSide` has the last word there.
    void addPlane(std::size_t lane, const WallPlane& p, const Body& body, float grow,
                  const Law& law, bool isWall) {
        const float reach = body.radius * grow;
        const float away = p.distance(body);
        const float over = p.overlap(away, reach);
        if (!(over > law.least)) return;
        const float push = law.force(over) * std::max(away, 0.1f * reach);
        x[lane] += push * p.nx;
        y[lane] += push * p.ny;
        z[lane] += push * p.nz;
        if (isWall) worst[lane] = std::max(worst[lane], over);
        squeeze[lane] += push;
        contacts[lane] += 1;
    }
};

template <int Dim>
void Relaxation<Dim>::addPlanes(const Run& run, const std::uint32_t* slots,
                                const RelaxationStep& step, PushOfEight& push) const {
    const Law wall(step.wallPull, step.wallRange), edge(0, 1);
    const auto part = [](const std::vector<std::uint32_t>& ends, std::uint32_t k) {
        return std::pair{k > 0 ? ends[k - 1] : 0, ends[k]};
    };
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const Body& body = now_.bodies[slots[lane]];
        const std::uint32_t k = slots[lane] - run.first;
        for (auto [p, end] = part(run.planeEnds, k); p < end; ++p)
            push.addPlane(lane, run.planes[p], body, 1 + delta_, wall, true);
        if (run.edgeEnds.empty()) continue;
        for (auto [p, end] = part(run.edgeEnds, k); p < end; ++p)
            push.addPlane(lane, run.edges[p], body, 1 + delta_, edge, false);
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
template <bool kPull>
void Relaxation<Dim>::stepRun(Run& run, const RelaxationStep& step) {
    const Body* bodies = now_.bodies.data();
    const Law law(step.pull, step.range);
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
        PushOfEight push;
        if (m < run.wallMembers) addPlanes(run, slots, step, push);
        if (graded_)
            push.addSpheres<kPull, true>(bodies, own, ids, end, grow, law);
        else
            push.addSpheres<kPull, false>(bodies, own, ids, end, grow, law);
        ids = end;
        const Bodies8 before = gather(now_.before.data(), slots);
        Float8 vx = difference(own.x, before.x), vy = difference(own.y, before.y),
               vz = difference(own.z, before.z);
        const Float8 contacts = __builtin_convertvector(push.contacts, Float8);
        Float8 share = everyLane(step.push), inertia = everyLane(step.inertia);
        if constexpr (kPull) {
            share = share * smaller(kFewNeighbors * inverse(larger(contacts, 1.0f)), 1.0f);
            if (!step.drifts)
                inertia = where8((push.x != 0) | (push.y != 0) | (push.z != 0), inertia);
        } else {
            const Int8 turns = vx * push.x + vy * push.y + vz * push.z < 0;
            inertia = choose(turns, inertia * step.turning, inertia);
        }
        vx = inertia * vx + share * push.x;
        vy = inertia * vy + share * push.y;
        vz = inertia * vz + share * push.z;
        const Float8 unit = graded_ ? own.radius * perLeast_ : everyLane(1);
        const Float8 cap = step.cap * unit;
        Float8 speed = vx * vx + vy * vy + vz * vz;
        const Int8 tooFast = speed > cap * cap;
        const Float8 slower = choose(tooFast, cap * inverseRoot(speed), 1.0f);
        vx *= slower, vy *= slower, vz *= slower;
        speed = choose(tooFast, cap * cap, speed);
        fastest = larger(fastest, speed * inverse(unit * unit));
        worst = larger(worst, push.worst);
        const Bodies8 next{own.x + whole(vx), own.y + whole(vy), own.z + whole(vz), own.radius};
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

template void Relaxation<2>::stepRun<false>(Run&, const RelaxationStep&);
template void Relaxation<2>::stepRun<true>(Run&, const RelaxationStep&);
template void Relaxation<3>::stepRun<false>(Run&, const RelaxationStep&);
template void Relaxation<3>::stepRun<true>(Run&, const RelaxationStep&);

}  // namespace vdbpack
