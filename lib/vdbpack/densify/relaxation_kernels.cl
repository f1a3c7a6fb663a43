// The steps of a relaxation on an OpenCL device, for the lists that the processor has made. What
// relaxation_step.cpp and exchanges.cpp say of runs holds here: a work-group takes a run.
#pragma OPENCL FP_CONTRACT OFF

#define INLINE static inline
#define Real float
#define Mask int
#define Count int
#define EVERY(v) (v)
#define LANES 8
#define MOST_SLOTS 1024  // of a run

INLINE float larger(float a, float b) { return a > b ? a : b; }
INLINE float smaller(float a, float b) { return a < b ? a : b; }
INLINE float choose(int mask, float yes, float no) { return mask ? yes : no; }
INLINE int counted(int count, int mask) { return count + (mask != 0); }
INLINE float inverseRoot(float v) {  // as in core/lanes.h
    const float y = as_float(0x5f1ffff9 - (as_int(v) >> 1));
    const float z = 0.703952253f * y * (2.38924456f - v * y * y);
    return z * (1.5f - 0.5f * v * z * z);
}
INLINE float inverse(float v) {
    const float root = inverseRoot(v);
    return root * root;
}
INLINE float difference(uint a, uint b) { return (float)(int)(a - b); }
INLINE ulong mix64(ulong x) {  // as in core/rng.h
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ul;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebul;
    return x ^ (x >> 31);
}

//@law

// What the host has under the same names, in step_device.h.
typedef struct DeviceRun {
    uint first, member, members, wallMembers, id, rank, ranks, plane, edge;
} DeviceRun;
typedef struct DeviceStep {
    ulong seed, clock;
    float inertia, turning, cap, push, pull, range, wallPull, wallRange;
    uint exchanges, drifts;
    float grow, listGrow, perLeast;
    uint graded, edges, unused;
} DeviceStep;
typedef struct Plane {
    float nx, ny, nz;
    uint x, y, z;
} Plane;
typedef struct DeviceImage {
    uint slot, source, x, y, z;
} DeviceImage;

/// Bodies: low bits of a position, and a radius in the last place.
INLINE float radiusOf(uint4 body) { return as_float(body.w); }
INLINE int isBeyond(uint4 listed, uint4 body) {
    const float x = difference(body.x, listed.x), y = difference(body.y, listed.y),
                z = difference(body.z, listed.z);
    return x * x + y * y + z * z > radiusOf(listed) * fabs(radiusOf(listed));
}

INLINE void addPlanes(Push* sum, uint4 own, float grow, const Law law, int isWall,
                      __global const Plane* planes, __global const uint* ends, uint k) {
    for (uint p = k > 0 ? ends[k - 1] : 0; p < ends[k]; ++p) {
        const Plane at = planes[p];
        const float away = at.nx * difference(own.x, at.x) + at.ny * difference(own.y, at.y) +
                           at.nz * difference(own.z, at.z);
        addPlane(sum, at.nx, at.ny, at.nz, away, radiusOf(own) * grow, law, isWall);
    }
}

/// Exchanges for the positions after a step.
/// @param squeeze, touching  of the slots of the run.
void exchangeRun(const DeviceRun run, const DeviceStep step, __global uint4* next,
                 __global uint4* listed, __global float* roam, __global uint* ranks,
                 __global const uint* alike, __global uchar* exchanged,
                 __local const float* squeeze, __local const float* touching,
                 __local int* expired) {
    const ulong key = mix64(step.seed ^ mix64(step.clock * 0x9e3779b97f4a7c15ul + run.first));
    const uint stride = 1 + (uint)(key % MOST_RANKS);
    const uint offset = (uint)((key >> 32) % (2 * stride));
    for (uint k = get_local_id(0); k < run.ranks; k += get_local_size(0)) {
        exchanged[k] = 0;
        if ((k + offset) % (2 * stride) >= stride || k + stride >= run.ranks) continue;
        const uint a = ranks[k], b = ranks[k + stride];
        const float radius = radiusOf(next[a]), more = radiusOf(next[b]) - radius;
        const uint i = a - run.first, j = b - run.first;
        if (!(more > 0 && squeeze[j] > 0 &&
              squeeze[j] - squeeze[i] > 0.5f * (touching[i] + touching[j]) * more &&
              more <= MOST_ALIKE * radius && alike[a] == alike[b]))
            continue;
        next[a].w = next[b].w;
        next[b].w = as_uint(radius);
        ranks[k] = b;
        ranks[k + stride] = a;
        listed[a].w = as_uint(radiusOf(listed[a]) - more * step.listGrow);
        listed[b].w = as_uint(radiusOf(listed[b]) + more * step.listGrow);
        roam[a] -= more;
        if (isBeyond(listed[a], next[a])) atomic_or(expired, 1);
        exchanged[k] = (uchar)stride;
    }
}

/// @param next      where bodies were before the last step; where they are after this one.
/// @param extremes  of each run: worst overlap and fastest squared step (bits), whether expired.
__kernel void stepRuns(__global const DeviceRun* runs, __global const uint4* bodies,
                       __global uint4* next, __global uint4* listed, __global float* roam,
                       __global uint* ranks, __global const uint* members,
                       __global const uint* ids, __global const uint* ends,
                       __global const Plane* planes, __global const uint* planeEnds,
                       __global const Plane* edges, __global const uint* edgeEnds,
                       __global const uint* alike, __global uchar* exchanged,
                       __global int* extremes, const DeviceStep step) {
    __local int worst, fastest, expired;
    __local float squeeze[MOST_SLOTS], touching[MOST_SLOTS];
    const DeviceRun run = runs[get_group_id(0)];
    const int pulls = step.range > 1;
    const Law law = lawOf(step.pull, step.range), wall = lawOf(step.wallPull, step.wallRange),
              edge = lawOf(0, 1);
    if (get_local_id(0) == 0) worst = fastest = expired = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint m = get_local_id(0); m < run.members; m += get_local_size(0)) {
        const uint slot = members[run.member + m];
        if (m > 0 && members[run.member + m - 1] == slot) continue;  // only fills up the eight
        const uint k = slot - run.first;
        const uint4 own = bodies[slot], before = next[slot];
        Push sum = {0, 0, 0, 0, 0, 0};
        if (m < run.wallMembers) {
            addPlanes(&sum, own, step.grow, wall, 1, planes + run.plane, planeEnds + run.first, k);
            if (step.edges)
                addPlanes(&sum, own, step.grow, edge, 0, edges + run.edge, edgeEnds + run.first, k);
        }
        const uint eight = (run.member + m) / LANES;
        const uint last = run.id + ends[eight];
        for (uint e = run.id + (m < LANES ? 0 : ends[eight - 1]) + m % LANES; e < last; e += LANES) {
            const uint4 other = bodies[ids[e]];
            addSphere(&sum, difference(other.x, own.x), difference(other.y, own.y),
                      difference(other.z, own.z), radiusOf(other), radiusOf(own), step.grow, law,
                      pulls, step.graded);
        }
        const float contacts = (float)sum.contacts;
        const float unit = step.graded ? radiusOf(own) * step.perLeast : 1;
        Motion v = {difference(own.x, before.x), difference(own.y, before.y),
                    difference(own.z, before.z), 0};
        v = moved(sum, contacts, v, step.cap * unit, step.inertia, step.turning, step.push, pulls,
                  step.drifts);
        const uint4 to = (uint4)(own.x + (uint)(int)v.x, own.y + (uint)(int)v.y,
                                 own.z + (uint)(int)v.z, own.w);
        next[slot] = to;
        atomic_max(&worst, as_int(sum.worst));
        atomic_max(&fastest, as_int(v.square * inverse(unit * unit)));
        if (isBeyond(listed[slot], to)) atomic_or(&expired, 1);
        squeeze[k] = sum.squeeze;
        touching[k] = contacts;
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (step.exchanges)
        exchangeRun(run, step, next, listed, roam, ranks + run.rank, alike, exchanged + run.rank,
                    squeeze, touching, &expired);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) != 0) return;
    extremes[3 * get_group_id(0)] = worst;
    extremes[3 * get_group_id(0) + 1] = fastest;
    extremes[3 * get_group_id(0) + 2] = expired;
}

/// The labels of the spheres that the last step has exchanged.
__kernel void exchangeLabels(__global const DeviceRun* runs, __global const uint* ranks,
                             __global const uchar* exchanged, __global uint* labels) {
    const DeviceRun run = runs[get_group_id(0)];
    for (uint k = get_local_id(0); k < run.ranks; k += get_local_size(0)) {
        const uint stride = exchanged[run.rank + k];
        if (stride == 0) continue;
        const uint a = ranks[run.rank + k], b = ranks[run.rank + k + stride];
        const uint label = labels[a];
        labels[a] = labels[b];
        labels[b] = label;
    }
}

/// Puts the images of a periodic cell to where the spheres are.
__kernel void refreshImages(__global const DeviceImage* images, __global uint4* bodies) {
    const DeviceImage image = images[get_global_id(0)];
    const uint4 body = bodies[image.source];
    bodies[image.slot] = (uint4)(body.x + image.x, body.y + image.y, body.z + image.z, body.w);
}
