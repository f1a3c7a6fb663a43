#include "vdbpack/pack/front/resting.h"

#include "vdbpack/core/lanes.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Bodies whose directions are this close to (anti)parallel, by sin², define no place.
constexpr float kParallel = 1e-5f;
/// Level of padding: a bound that no center meets, with squares that are still finite.
constexpr float kNoBound = 1e15f;
/// Padding of collected spheres lies farther away than this, squared.
constexpr float kFarAway = 1e30f;

template <class N>
N along(const std::array<float, 3>& a, const std::array<N, 3>& x) {
    return a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
}
template <class N>
N along(const std::array<float, 2>& a, const std::array<N, 2>& x) {
    return a[0] * x[0] + a[1] * x[1];
}

}  // namespace

namespace {

/// See firstHit in the header; N is float or lanes of floats.
template <class N, int Dim>
[[gnu::always_inline]] inline N hit(const Track<float, Dim>& track, const std::array<N, Dim>& to,
                                    const N& level, const N& slope, float tolerance, float most) {
    // Off the body while u(t) - g sqrt(extent(t)) >= 0 with u linear: a hit is a root of
    // u² - g² extent where u and g have one sign; of the two roots, the slopes tell which one
    // leads into the body. Bodies that the track rests on have u = g = 0 but for rounding.
    const N alongA = along(track.a, to);
    N u0 = level - track.alpha0 * alongA, u1 = slope - track.alpha1 * alongA;
    if constexpr (Dim == 3) {
        const N alongB = along(track.b, to);
        u0 -= track.beta0 * alongB;
        u1 -= track.beta1 * alongB;
    }
    const N g = track.side * along(track.w, to);
    const N gg = g * g;
    const N qa = u1 * u1 - gg * track.extent2;
    const N qb = 2.0f * u0 * u1 - gg * track.extent1;
    const N qc = u0 * u0 - gg * track.extent0;
    const N disc = qb * qb - 4.0f * qa * qc;
    const N q = -0.5f * (qb + withSign(squareRoot(larger(disc, 0.0f)), qb));
    const auto same = qb * g > 0.0f;
    const N t = choose(same, q, qc) / choose(same, qa, q);
    const auto found = (disc >= 0.0f) & (t > -tolerance) & ((u0 + u1 * t) * g >= 0.0f) & (t < most);
    return larger(choose(found, t, most), 0.0f);
}

/// One of eight tracks.
template <int Dim>
Track<float, Dim> laneOf(const Track<Float8, Dim>& tracks, std::size_t l) {
    Track<float, Dim> t;
    for (std::size_t d = 0; d < Dim; ++d) {
        t.a[d] = tracks.a[d][l];
        t.b[d] = tracks.b[d][l];
        t.w[d] = tracks.w[d][l];
    }
    t.alpha0 = tracks.alpha0[l], t.alpha1 = tracks.alpha1[l];
    t.beta0 = tracks.beta0[l], t.beta1 = tracks.beta1[l];
    t.extent0 = tracks.extent0[l], t.extent1 = tracks.extent1[l], t.extent2 = tracks.extent2[l];
    t.side = tracks.side[l];
    return t;
}

}  // namespace

template <int Dim>
float firstHit(const Track<float, Dim>& track, const Body<float, Dim>& body, float level,
               float tolerance, float most) {
    return hit<float, Dim>(track, body.to, level, body.slope, tolerance, most);
}

template <int Dim>
void Surroundings<Dim>::Group::resize(std::size_t n) {
    for (auto& t : to) t.resize(n);
    level.resize(n);
    slope.resize(n);
    square.resize(n);
    open.resize(n);
    index.resize(n);
}

/// Padding crosses nothing and forbids nothing.
template <int Dim>
void Surroundings<Dim>::Group::pad() {
    for (std::size_t n = count; n < padded(count); ++n) {
        for (auto& t : to) t[n] = 0;
        level[n] = open[n] = kNoBound;
        slope[n] = square[n] = 0;
    }
}

template <int Dim>
void Surroundings<Dim>::addPlane(const std::array<float, Dim>& normal, float above,
                                 std::uint32_t name) {
    const auto body = Body<float, Dim>::plane(normal, above);
    planes_.emplace_back(spheres.count, body);
    spheres.append(body.to, 0.0f, name);
}

/// Sorts the bodies into those in reach of the probe and the others.
/// @return false if one of them leaves the probe no place at all.
template <int Dim>
bool Surroundings<Dim>::reach(float pivotRadius, float probe) {
    spheres.pad();
    const std::size_t size = padded(spheres.count);
    if (near_.level.size() < size + kLanes) {
        near_.resize(2 * size + kLanes);
        far_.resize(2 * size + kLanes);
    }
    near_.count = far_.count = 0;
    tolerance_ = kTouching * (pivotRadius + probe);
    pivotReach_ = pivotRadius + 2 * probe;
    const float rolling = pivotRadius + probe;
    bool allOpen = true;
    for (std::size_t i = 0; i < size; i += kLanes) {
        Float8 square{};
        for (std::size_t d = 0; d < Dim; ++d) {
            const Float8 to = load(&spheres.to[d][i]);
            square += to * to;
        }
        const Float8 radius = load(&spheres.radius[i]);
        Float8 slope = pivotRadius - radius;
        Float8 level = 0.5f * (square + slope * (pivotRadius + radius)) + probe * slope;
        Float8 open = squareRoot(square) - radius;
        for (const auto& [at, body] : planes_) {
            if (at / kLanes != i / kLanes) continue;
            level[at % kLanes] = body.level + probe * body.slope;
            slope[at % kLanes] = body.slope;
            open[at % kLanes] = body.level;
        }
        const Float8 bound = rolling * rolling * square;
        const Float8 signedSquare = level * absolute(level);
        const Int8 used = square < kFarAway;
        const Int8 near = used & (signedSquare < bound);
        allOpen = allOpen && noneOf(used & (signedSquare <= -bound));
        float levels[kLanes], slopes[kLanes], squares[kLanes], opens[kLanes];
        store(levels, level);
        store(slopes, slope);
        store(squares, square);
        store(opens, open);
        const auto put = [&](Group& group, std::size_t l) {
            const std::size_t n = group.count++;
            for (std::size_t d = 0; d < Dim; ++d) group.to[d][n] = spheres.to[d][i + l];
            group.level[n] = levels[l];
            group.slope[n] = slopes[l];
            group.square[n] = squares[l];
            group.open[n] = opens[l];
            group.index[n] = static_cast<std::uint32_t>(i + l);
        };
        forEachSet(near, [&](std::size_t l) { put(near_, l); });
        forEachSet(used & ~near, [&](std::size_t l) { put(far_, l); });
    }
    near_.pad();
    far_.pad();
    return allOpen;
}

/// Pairs of near bodies whose bounds meet on the sphere of directions.
template <int Dim>
void Surroundings<Dim>::findPairs(float rolling, std::uint32_t only) {
    const std::size_t count = near_.count;
    pairCount_ = 0;
    if (pairs_.size() < count * count) pairs_.resize(count * count);
    if constexpr (Dim == 2) {
        for (std::uint32_t i = 0; i < count; ++i)
            if (only == kAll || spheres.index[near_.index[i]] == only)
                pairs_[pairCount_++] = {i, i};
        return;
    } else {
        for (std::size_t i = 0; i < count; ++i) {
            std::size_t from = i + 1;
            if (only != kAll) {
                if (spheres.index[near_.index[i]] != only) continue;
                from = 0;
            }
            const float x = near_.to[0][i], y = near_.to[1][i], z = near_.to[2][i];
            const float aa = near_.square[i], ca = near_.level[i];
            for (std::size_t j = from / kLanes * kLanes; j < count; j += kLanes) {
                const Float8 ab = x * load(&near_.to[0][j]) + y * load(&near_.to[1][j]) +
                                  z * load(&near_.to[2][j]);
                const Float8 bb = load(&near_.square[j]), cb = load(&near_.level[j]);
                const Float8 area = aa * bb - ab * ab;
                const Float8 extent =
                    rolling * rolling * area - (ca * ca * bb - 2.0f * ca * cb * ab + cb * cb * aa);
                forEachSet((extent > 0.0f) & (area > kParallel * aa * bb), [&](std::size_t l) {
                    if (j + l >= from && j + l != i)
                        pairs_[pairCount_++] = {static_cast<std::uint32_t>(i),
                                                static_cast<std::uint32_t>(j + l)};
                });
            }
        }
    }
}

template <int Dim>
void Surroundings<Dim>::findSites(float pivotRadius, const Radii& radii, std::uint32_t only,
                                  const Region* region, std::vector<Site>& sites) {
    sites.clear();
    const float probe = radii.probe;
    const bool open = reach(pivotRadius, probe);
    if (!open) return;
    const float rolling = pivotRadius + probe;
    findPairs(rolling, only);
    const float slack = kSlack * rolling * rolling;
    const std::size_t count = near_.count;
    for (std::size_t p = 0; p < pairCount_; p += kLanes) {
        const std::size_t used = std::min(kLanes, pairCount_ - p);
        float gathered[Dim - 1][Dim + 2][kLanes];
        for (std::size_t l = 0; l < kLanes; ++l) {
            const auto& pair = pairs_[p + std::min(l, used - 1)];
            for (std::size_t n = 0; n < Dim - 1; ++n) {
                const std::size_t i = pair[n];
                for (std::size_t d = 0; d < Dim; ++d) gathered[n][d][l] = near_.to[d][i];
                gathered[n][Dim][l] = near_.level[i];
                gathered[n][Dim + 1][l] = near_.slope[i];
            }
        }
        std::array<Body<Float8, Dim>, Dim - 1> bodies;
        for (std::size_t n = 0; n < Dim - 1; ++n) {
            for (std::size_t d = 0; d < Dim; ++d) bodies[n].to[d] = load(gathered[n][d]);
            bodies[n].level = load(gathered[n][Dim]);
            bodies[n].slope = load(gathered[n][Dim + 1]);
        }
        // Levels are those at the start already.
        Track<Float8, Dim> tracks;
        tracks.set(rolling, 0.0f, bodies, 1.0f);
        // The two places of a pair are middle + side and middle - side.
        std::array<Float8, Dim> middle, side;
        const Float8 out = squareRoot(larger(tracks.middle(0.0f, middle), 0.0f)) * tracks.side;
        for (std::size_t d = 0; d < Dim; ++d) side[d] = out * tracks.w[d];
        Float8 up = everyLane(slack), down = up;  // least room to any body, so far
        if (region) {
            for (std::size_t d = 0; d < Dim; ++d) {
                const float lo = region->lo[d], hi = region->hi[d];
                const Float8 above = middle[d] + side[d], below = middle[d] - side[d];
                up = choose((above < lo) | (above > hi), -1.0f, up);
                down = choose((below < lo) | (below > hi), -1.0f, down);
            }
            if (noneOf(larger(up, down) >= 0.0f)) continue;
        }
        const auto takeOff = [&](std::size_t k, float level, const auto& from, const auto& by) {
            Float8 room = everyLane(level + slack);
            Float8 tilt{};
            for (std::size_t d = 0; d < Dim; ++d) {
                room -= from[d] * near_.to[d][k];
                tilt += by[d] * near_.to[d][k];
            }
            up = smaller(up, room - tilt);
            down = smaller(down, room + tilt);
        };
        for (std::size_t k = 0; k < count; ++k) {
            takeOff(k, near_.level[k], middle, side);
            if ((k & 1) && noneOf(larger(up, down) >= 0.0f)) break;
        }
        const auto emit = [&](std::size_t l, float sign) __attribute__((always_inline)) {
            const auto& pair = pairs_[p + l];
            sites.emplace_back();
            Site& site = sites.back();
            for (std::size_t n = 0; n < Dim - 1; ++n)
                site.bodies[n] = spheres.index[near_.index[pair[n]]];
            site.track = laneOf(tracks, l);
            site.track.extent0 = std::max(site.track.extent0, 0.0f);
            site.track.side *= sign;
            site.side = sign;
            for (std::size_t d = 0; d < Dim; ++d) site.start[d] = middle[d][l] + sign * side[d][l];
            const float most = radii.largest - probe;
            // The path leaves its own bodies out: their bounds are kept.
            const float level[2] = {near_.level[pair[0]], near_.level[pair[Dim - 2]]};
            near_.level[pair[0]] = near_.level[pair[Dim - 2]] = kNoBound;
            const float t = most > 0 ? growth(site.track, site.track.end(most)) : 0.0f;
            near_.level[pair[0]] = level[0];
            near_.level[pair[Dim - 2]] = level[1];
            site.limit = t >= most ? radii.largest : probe + t;
            // Where the path itself ends nothing is left of its extent, or by rounding less.
            const float extent = std::max(site.track.middle(t, site.end), 0.0f);
            const float outward = site.track.side * std::sqrt(extent);
            for (std::size_t d = 0; d < Dim; ++d) site.end[d] += outward * site.track.w[d];
        };
        Int8 live = larger(up, down) >= 0.0f;
        if (noneOf(live)) continue;
        // Most that end before the least radius are blocked at it as well.
        if (radii.least > probe) {
            const float t = radii.least - probe;
            std::array<Float8, Dim> middleThen, sideThen;
            const Float8 extent = tracks.middle(t, middleThen);
            const Float8 outThen = squareRoot(larger(extent, 0.0f)) * tracks.side;
            for (std::size_t d = 0; d < Dim; ++d) sideThen[d] = outThen * tracks.w[d];
            up = choose(extent < 0.0f, -1.0f, up);
            down = choose(extent < 0.0f, -1.0f, down);
            for (std::size_t k = 0; k < count; ++k)
                takeOff(k, near_.level[k] + t * near_.slope[k], middleThen, sideThen);
            live = larger(up, down) >= 0.0f;
            if (noneOf(live)) continue;
        }
        forEachSet(
            live, [&](std::size_t l) __attribute__((always_inline)) {
                if (l >= used) return;
                if (up[l] >= 0.0f) emit(l, 1.0f);
                if (down[l] >= 0.0f) emit(l, -1.0f);
            });
    }
}

template <int Dim>
float Surroundings<Dim>::growth(const Group& group, const Track<float, Dim>& track,
                                float most) const {
    for (std::size_t k = 0; k < group.count; k += kLanes) {
        if (noneOf(load(&group.open[k]) < pivotReach_ + 2 * most)) continue;
        std::array<Float8, Dim> to;
        for (std::size_t d = 0; d < Dim; ++d) to[d] = load(&group.to[d][k]);
        most = std::min(most, smallest(hit<Float8, Dim>(track, to, load(&group.level[k]),
                                                        load(&group.slope[k]), tolerance_, most)));
    }
    return most;
}

template <int Dim>
float Surroundings<Dim>::growth(const Track<float, Dim>& track, float most) const {
    return growth(far_, track, growth(near_, track, most));
}

template float firstHit<2>(const Track<float, 2>&, const Body<float, 2>&, float, float, float);
template float firstHit<3>(const Track<float, 3>&, const Body<float, 3>&, float, float, float);
template class Surroundings<2>;
template class Surroundings<3>;

}  // namespace vdbpack
