// One step of the relaxation: overlaps push, and all spheres of a run move.
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Where gaps count, a sphere with more listed neighbors (in whole eights) gains less velocity from
/// each of them: all together would make it oscillate.
constexpr float kFewNeighbors = 24;

/// The sum of the overlaps of a sphere, quanta.
struct Push {
    float x = 0, y = 0, z = 0;
    float squeeze = 0;   ///< sum of the magnitudes
    float contacts = 0;  ///< number of the overlaps
};

/// How overlaps and gaps become forces.
struct Law {
    float grow;         ///< factor on radii
    float range, pull;  ///< of the step
};

/// From the spheres `ids` up to `end`, whole eights.
/// @param kSqueeze  whether squeeze and contacts are counted.
/// @param kPull     whether gaps count, as negative overlaps.
/// @param kGraded   whether stiffness and mass go with the radii: where sizes differ by place, the
///                  pressure of spheres that overlap by the same share is then the same, and fine
///                  ones do not drift towards coarse ones.
/// @param worst     of each lane, raised to the largest overlap divided by the distance.
template <bool kSqueeze, bool kPull, bool kGraded>
VDBPACK_INLINE Push pushOfSpheres(const Body* bodies, const Body& body, const std::uint32_t* ids,
                                  const std::uint32_t* end, const Law& law, Float8& worst) {
    Float8 fx = {}, fy = {}, fz = {}, squeeze = {};
    Int8 touching = {};
    for (; ids != end; ids += 8) {
        const Bodies8 other = gather(bodies, ids);
        const Float8 dx = difference(other.x, body.x);
        const Float8 dy = difference(other.y, body.y);
        const Float8 dz = difference(other.z, body.z);
        const Float8 d2 = dx * dx + dy * dy + dz * dz;
        const Float8 reach = (other.radius + body.radius) * law.grow;
        // Eights are filled up with the sphere itself, at distance 0.
        const Float8 far = kPull ? reach * law.range : reach;
        const Int8 near = (d2 < far * far) & (d2 > 0);
        const Float8 d = squareRoot(d2);
        Float8 push = reach / d - 1;
        if constexpr (kPull) push = larger(push, -law.pull);
        push = where8(near, push);
        Float8 gain = push;
        if constexpr (kGraded) gain = push * (2.0f * other.radius) / (other.radius + body.radius);
        fx -= gain * dx;
        fy -= gain * dy;
        fz -= gain * dz;
        worst = larger(worst, push);
        if constexpr (kSqueeze) {
            squeeze += push * d;
            touching -= near;
        }
    }
    Push sums{sum(fx), sum(fy), sum(fz)};
    if constexpr (kSqueeze) {
        sums.squeeze = sum(squeeze);
        sums.contacts = sum(__builtin_convertvector(touching, Float8));
    }
    return sums;
}

/// Adds the overlaps with the planes `plane` up to `last`, and moves `plane` there.
/// @param worst  raised to the largest overlap divided by the distance.
template <bool kPull>
VDBPACK_INLINE void addPushOfWall(const WallPlane* planes, std::uint32_t& plane, std::uint32_t last,
                                  const Body& body, const Law& law, Push& push, float& worst) {
    const float reach = body.radius * law.grow;
    const float least = kPull ? reach - reach * law.range : 0;
    for (; plane < last; ++plane) {
        const WallPlane& p = planes[plane];
        const float away = p.distance(body);
        float over = reach - away;
        if (!(over > least)) continue;
        if constexpr (kPull) over = larger(over, -law.pull * reach);
        push.x += over * p.nx;
        push.y += over * p.ny;
        push.z += over * p.nz;
        worst = std::max(worst, p.overlap(away, reach));
        push.squeeze += over;
        push.contacts += 1;
    }
}

VDBPACK_INLINE std::uint32_t moved(std::uint32_t at, float by) {
    return at + static_cast<std::uint32_t>(static_cast<std::int32_t>(std::rint(by)));
}

}  // namespace

template <int Dim>
template <bool kSqueeze, bool kPull>
void Relaxation<Dim>::stepRun(Run& run, const Step& step) {
    const Body* bodies = now_.bodies.data();
    Body* next = next_.data();
    const Law law{1 + delta_, step.range, step.pull};
    const std::uint32_t* ids = run.ids.data();
    Float8 worst = {};
    float worstWall = 0, fastest = 0;
    float beyondEdge = 0;  // no overlap: `keepsSide` has the last word
    std::uint32_t plane = 0, edge = 0;
    for (std::uint32_t i = run.first; i < run.last; ++i) {
        const Body body = bodies[i];
        const std::uint32_t* end = run.ids.data() + run.ends[i - run.first];
        Push push = graded_
                        ? pushOfSpheres<kSqueeze, kPull, true>(bodies, body, ids, end, law, worst)
                        : pushOfSpheres<kSqueeze, kPull, false>(bodies, body, ids, end, law, worst);
        float share = step.push, inertia = step.inertia;
        if constexpr (kPull) share *= std::min(1.0f, kFewNeighbors / static_cast<float>(end - ids));
        ids = end;
        if (const std::uint32_t last = run.planeEnds[i - run.first]; plane < last)
            addPushOfWall<kPull>(run.planes.data(), plane, last, body, law, push, worstWall);
        if (!run.edgeEnds.empty())
            addPushOfWall<false>(run.edges.data(), edge, run.edgeEnds[i - run.first], body, law,
                                 push, beyondEdge);
        Motion& motion = now_.motions[i];
        if constexpr (kPull)
            if (!step.drifts && push.x == 0 && push.y == 0 && push.z == 0) inertia = 0;
        float vx = inertia * motion.x + share * push.x;
        float vy = inertia * motion.y + share * push.y;
        float vz = inertia * motion.z + share * push.z;
        const float unit = unitOf(body.radius), cap = step.cap * unit, capSquare = cap * cap;
        float speed = vx * vx + vy * vy + vz * vz;
        if (speed > capSquare) {
            const float slower = cap / std::sqrt(speed);
            vx *= slower, vy *= slower, vz *= slower;
            speed = capSquare;
        }
        fastest = std::max(fastest, speed / (unit * unit));
        motion.x = vx, motion.y = vy, motion.z = vz;
        if constexpr (kSqueeze) {
            motion.squeeze = push.squeeze;
            touching_[i] = push.contacts;
        }
        next[i] = {moved(body.x, vx), moved(body.y, vy), moved(body.z, vz), body.radius};
    }
    run.worst = std::max(largest(worst), worstWall);
    if (run.coincides) run.worst = std::max(run.worst, 1.0f);
    run.fastest = fastest;
}

template void Relaxation<2>::stepRun<false, false>(Run&, const Step&);
template void Relaxation<2>::stepRun<true, false>(Run&, const Step&);
template void Relaxation<2>::stepRun<false, true>(Run&, const Step&);
template void Relaxation<3>::stepRun<false, false>(Run&, const Step&);
template void Relaxation<3>::stepRun<true, false>(Run&, const Step&);
template void Relaxation<3>::stepRun<false, true>(Run&, const Step&);

}  // namespace vdbpack
