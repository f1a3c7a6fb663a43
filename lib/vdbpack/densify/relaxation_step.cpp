// One step of the relaxation: overlaps push, and all spheres of a run move.
#include "vdbpack/densify/relaxation.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Share of an overlap that a sphere gains as velocity in a step.
constexpr float kPush = 0.3f;

/// The sum of the overlaps of a sphere, quanta.
struct Push {
    float x = 0, y = 0, z = 0;
    float squeeze = 0;   ///< sum of the magnitudes
    float contacts = 0;  ///< number of the overlaps
};

/// From the spheres `ids` up to `end`, whole eights.
/// @param kSqueeze  whether squeeze and contacts are counted.
/// @param worst     of each lane, raised to the largest overlap divided by the distance.
template <bool kSqueeze>
VDBPACK_INLINE Push pushOfSpheres(const Body* bodies, const Body& body, const std::uint32_t* ids,
                                  const std::uint32_t* end, float grow, Float8& worst) {
    Float8 fx = {}, fy = {}, fz = {}, squeeze = {};
    Int8 touching = {};
    for (; ids != end; ids += 8) {
        const Bodies8 other = gather(bodies, ids);
        const Float8 dx = difference(other.x, body.x);
        const Float8 dy = difference(other.y, body.y);
        const Float8 dz = difference(other.z, body.z);
        const Float8 d2 = dx * dx + dy * dy + dz * dz;
        const Float8 reach = (other.radius + body.radius) * grow;
        // Eights are filled up with the sphere itself, at distance 0.
        const Int8 near = (d2 < reach * reach) & (d2 > 0);
        const Float8 d = squareRoot(d2);
        const Float8 push = where8(near, reach / d - 1);
        fx -= push * dx;
        fy -= push * dy;
        fz -= push * dz;
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
VDBPACK_INLINE void addPushOfWall(const WallPlane* planes, std::uint32_t& plane, std::uint32_t last,
                                  const Body& body, float grow, Push& push, float& worst) {
    const float reach = body.radius * grow;
    for (; plane < last; ++plane) {
        const WallPlane& p = planes[plane];
        const float away = p.distance(body);
        const float over = reach - away;
        if (!(over > 0)) continue;
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
template <bool kSqueeze>
void Relaxation<Dim>::stepRun(Run& run, float inertia, float cap) {
    const Body* bodies = now_.bodies.data();
    Body* next = next_.data();
    const float grow = 1 + delta_;
    const std::uint32_t* ids = run.ids.data();
    Float8 worst = {};
    float worstWall = 0, fastest = 0;
    std::uint32_t plane = 0;
    const float capSquare = cap * cap;
    for (std::uint32_t i = run.first; i < run.last; ++i) {
        const Body body = bodies[i];
        const std::uint32_t* end = run.ids.data() + run.ends[i - run.first];
        Push push = pushOfSpheres<kSqueeze>(bodies, body, ids, end, grow, worst);
        ids = end;
        if (const std::uint32_t last = run.planeEnds[i - run.first]; plane < last)
            addPushOfWall(run.planes.data(), plane, last, body, grow, push, worstWall);
        Motion& motion = now_.motions[i];
        float vx = inertia * motion.x + kPush * push.x;
        float vy = inertia * motion.y + kPush * push.y;
        float vz = inertia * motion.z + kPush * push.z;
        float speed = vx * vx + vy * vy + vz * vz;
        if (speed > capSquare) {
            const float slower = cap / std::sqrt(speed);
            vx *= slower, vy *= slower, vz *= slower;
            speed = capSquare;
        }
        fastest = std::max(fastest, speed);
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

template void Relaxation<2>::stepRun<false>(Run&, float, float);
template void Relaxation<2>::stepRun<true>(Run&, float, float);
template void Relaxation<3>::stepRun<false>(Run&, float, float);
template void Relaxation<3>::stepRun<true>(Run&, float, float);

}  // namespace vdbpack
