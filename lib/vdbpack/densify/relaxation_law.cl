// How overlaps become forces, and forces motion, in what C++ and OpenCL C have in common: the
// processor takes it for eight spheres at a time, a device for one.
//
// Who includes this defines INLINE, Real (a number, or eight), Mask (of what is compared) and Count,
// EVERY(number) and larger, smaller, inverse, inverseRoot, choose and counted.

/// Where gaps count, a sphere with more neighbors in range gains less velocity from each of them:
/// all together would make it oscillate.
#define FEW_NEIGHBORS 14

/// How overlaps and gaps become forces.
typedef struct Law {
    float pull;      ///< of the step
    float least;     ///< least overlap divided by the distance that counts, not positive
    float perRange;  ///< 1 / the largest gap that counts
} Law;

INLINE Law lawOf(float pull, float range) {
    Law law = {pull, 0, 0};
    if (range > 1) {
        law.least = inverse(range) - 1;
        law.perRange = inverse(range - 1);
    }
    return law;
}

/// The overlap, or how strongly a gap pulls: as an overlap of its size would, but for no more than
/// `pull`, which falls to 0 at the end of the range. The nearest neighbor wins.
INLINE Real forceOf(const Law law, const Real push) {
    return larger(push, -law.pull * (1 + push * law.perRange));
}

/// The sums of the overlaps of a sphere, quanta.
typedef struct Push {
    Real x, y, z;
    Real squeeze;    ///< sum of the magnitudes
    Real worst;      ///< the largest overlap divided by the distance
    Count contacts;  ///< number of the overlaps and gaps that count
} Push;

/// Adds the overlap with a sphere at a distance.
/// @param pulls   whether gaps count, as negative overlaps.
/// @param graded  whether stiffness and mass go with the radii: where sizes differ by place, the
///                pressure of spheres that overlap by the same share is then the same, and fine
///                ones do not drift towards coarse ones.
INLINE void addSphere(Push* sum, const Real dx, const Real dy, const Real dz, const Real other,
                      const Real radius, const float grow, const Law law, const bool pulls,
                      const bool graded) {
    const Real reach = (other + radius) * grow;
    Real push = reach * inverseRoot(dx * dx + dy * dy + dz * dz) - 1;
    const Mask near = push > law.least;
    sum->worst = larger(sum->worst, push);
    push = pulls ? choose(near, forceOf(law, push), 0.0f) : larger(push, EVERY(0.0f));
    Real gain = push;
    if (graded) gain = choose(near, push * (2.0f * other) * inverse(other + radius), 0.0f);
    sum->x -= gain * dx;
    sum->y -= gain * dy;
    sum->z -= gain * dz;
    sum->squeeze += push * reach;
    sum->contacts = counted(sum->contacts, near);
}

/// Adds the overlap with a plane.
/// @param away    how far from it the center is.
/// @param isWall  else the plane is the end of a shell, whose overlaps are not the worst ones.
INLINE void addPlane(Push* sum, const Real nx, const Real ny, const Real nz, const Real away,
                     const Real reach, const Law law, const bool isWall) {
    const Real length = larger(away, 0.1f * reach);
    const Real over = (reach - away) * inverse(length);
    const Mask near = over > law.least;
    const Real push = choose(near, forceOf(law, over) * length, 0.0f);
    sum->x += push * nx;
    sum->y += push * ny;
    sum->z += push * nz;
    if (isWall) sum->worst = larger(sum->worst, choose(near, over, 0.0f));
    sum->squeeze += push;
    sum->contacts = counted(sum->contacts, near);
}

/// A velocity, and its square.
typedef struct Motion {
    Real x, y, z, square;
} Motion;

/// The velocity after a step. @param contacts  of `sum`. @param cap  the largest one.
INLINE Motion moved(const Push sum, const Real contacts, Motion v, const Real cap,
                    const float inertiaOfStep, const float turning, const float pushOfStep,
                    const bool pulls, const bool drifts) {
    Real share = EVERY(pushOfStep), inertia = EVERY(inertiaOfStep);
    if (pulls) {
        share = share * smaller(FEW_NEIGHBORS * inverse(larger(contacts, EVERY(1.0f))), EVERY(1.0f));
        if (!drifts) inertia = choose((sum.x != 0) | (sum.y != 0) | (sum.z != 0), inertia, 0.0f);
    } else {
        const Mask turns = v.x * sum.x + v.y * sum.y + v.z * sum.z < 0;
        inertia = choose(turns, inertia * turning, inertia);
    }
    v.x = inertia * v.x + share * sum.x;
    v.y = inertia * v.y + share * sum.y;
    v.z = inertia * v.z + share * sum.z;
    v.square = v.x * v.x + v.y * v.y + v.z * v.z;
    const Mask tooFast = v.square > cap * cap;
    const Real slower = choose(tooFast, cap * inverseRoot(v.square), 1.0f);
    v.x *= slower;
    v.y *= slower;
    v.z *= slower;
    v.square = choose(tooFast, cap * cap, v.square);
    return v;
}
