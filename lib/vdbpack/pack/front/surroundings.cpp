#include "vdbpack/pack/front/surroundings.h"

#include "vdbpack/core/lanes.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Caps whose directions are this close to (anti)parallel, by sin², have no common edge.
constexpr float kParallel = 1e-5f;
/// Level of padding: a bound that every center meets, with squares that are still finite.
constexpr float kNoBound = 1e15f;
/// Padding of collected spheres is farther away than this, squared.
constexpr float kFarAway = 1e30f;
constexpr Word8 kNumbers{0, 1, 2, 3, 4, 5, 6, 7};

/// One of eight tracks.
template <int Dim>
VDBPACK_INLINE Track<float, Dim> laneOf(const Track<Float8, Dim>& tracks, std::size_t l) {
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

/// Eight pairs of candidates: the centers middle + side and middle - side on each track.
template <int Dim>
struct Candidates {
    std::array<Float8, Dim> middle, side;
    Float8 extent;  ///< negative where the tracks have ended

    VDBPACK_INLINE Candidates(const Track<Float8, Dim>& tracks, float t) {
        extent = tracks.middle(t, middle);
        const Float8 out = squareRoot(larger(extent, 0.0f)) * tracks.side;
        for (std::size_t d = 0; d < Dim; ++d) side[d] = out * tracks.w[d];
    }
};

/// Least room of eight pairs of candidates to any cap so far; negative: inside one.
template <int Dim>
struct Room {
    Float8 up, down;

    VDBPACK_INLINE explicit Room(float most) : up(everyLane(most)), down(up) {}

    VDBPACK_INLINE Int8 isLeft() const { return larger(up, down) >= 0.0f; }

    template <class Region>
    VDBPACK_INLINE void keepWithin(const Region& region, const Candidates<Dim>& x) {
        for (std::size_t d = 0; d < Dim; ++d) {
            const float lo = region.lo[d], hi = region.hi[d];
            const Float8 above = x.middle[d] + x.side[d], below = x.middle[d] - x.side[d];
            up = choose((above < lo) | (above > hi), -1.0f, up);
            down = choose((below < lo) | (below > hi), -1.0f, down);
        }
    }
    VDBPACK_INLINE void keepOnTrack(const Candidates<Dim>& x) {
        up = choose(x.extent < 0.0f, -1.0f, up);
        down = choose(x.extent < 0.0f, -1.0f, down);
    }
    /// Takes the `k`-th cap into account.
    template <class Directions>
    VDBPACK_INLINE void keepOff(const Directions& to, std::size_t k, float level,
                                const Candidates<Dim>& x) {
        Float8 room = everyLane(level);
        Float8 tilt{};
        for (std::size_t d = 0; d < Dim; ++d) {
            room -= x.middle[d] * to[d][k];
            tilt += x.side[d] * to[d][k];
        }
        up = smaller(up, room - tilt);
        down = smaller(down, room + tilt);
    }
};

}  // namespace

template <int Dim>
void Surroundings<Dim>::Caps::resize(std::size_t n) {
    for (auto& t : to) t.resize(n);
    level.resize(n);
    slope.resize(n);
    square.resize(n);
    open.resize(n);
    index.resize(n);
}

/// Padding meets no other cap and forbids nothing.
template <int Dim>
void Surroundings<Dim>::Caps::pad() {
    for (std::size_t n = count; n < padded(count); ++n) {
        for (auto& t : to) t[n] = 0;
        level[n] = open[n] = kNoBound;
        slope[n] = square[n] = 0;
    }
}

template <int Dim>
void Surroundings<Dim>::addWall(const std::array<float, Dim>& normal, float above,
                                std::uint32_t index) {
    const auto cap = Cap<float, Dim>::ofWall(normal, above);
    walls_.emplace_back(spheres.count, cap);
    spheres.append(cap.to, 0.0f, index);
}

/// Sorts the bodies into those in reach of the probe and the others.
/// @return false if one of them leaves the probe no room on the pivot at all.
template <int Dim>
bool Surroundings<Dim>::sortByReach(float pivotRadius, float probe) {
    spheres.pad();
    const std::size_t size = padded(spheres.count);
    if (near_.level.size() < size + kLanes) {
        near_.resize(2 * size + kLanes);
        far_.resize(2 * size + kLanes);
    }
    near_.count = far_.count = 0;
    const float rolling = pivotRadius + probe;
    tolerance_ = kTouching * rolling;
    pivotReach_ = pivotRadius + 2 * probe;
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
        for (const auto& [at, cap] : walls_) {
            if (at / kLanes != i / kLanes) continue;
            level[at % kLanes] = cap.level + probe * cap.slope;
            slope[at % kLanes] = cap.slope;
            open[at % kLanes] = cap.level;
        }
        const Float8 bound = rolling * rolling * square;
        const Float8 signedSquare = level * absolute(level);
        const Int8 used = square < kFarAway;
        const Int8 near = used & (signedSquare < bound);
        allOpen = allOpen && noneOf(used & (signedSquare <= -bound));
        const auto put = [&](Caps& caps, Int8 which) {
            const LanePacking packed(bitsOf(which));
            const std::size_t n = caps.count;
            for (std::size_t d = 0; d < Dim; ++d)
                store(&caps.to[d][n], packed(load(&spheres.to[d][i])));
            store(&caps.level[n], packed(level));
            store(&caps.slope[n], packed(slope));
            store(&caps.square[n], packed(square));
            store(&caps.open[n], packed(open));
            store(&caps.index[n], packed(kNumbers + static_cast<std::uint32_t>(i)));
            caps.count += packed.count();
        };
        put(near_, near);
        put(far_, used & ~near);
    }
    near_.pad();
    far_.pad();
    return allOpen;
}

/// Pairs of near caps whose edges meet on the sphere of directions.
template <int Dim>
void Surroundings<Dim>::findPairs(float rolling, std::uint32_t only) {
    const std::size_t count = near_.count;
    pairCount_ = 0;
    if (pairs_[0].size() < count * count + kLanes)
        for (auto& ends : pairs_) ends.resize(count * count + kLanes);
    if constexpr (Dim == 2) {
        for (std::uint32_t i = 0; i < count; ++i)
            if (only == kAll || spheres.index[near_.index[i]] == only) {
                pairs_[0][pairCount_] = i;
                pairs_[1][pairCount_++] = i;
            }
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
                const Word8 other = kNumbers + static_cast<std::uint32_t>(j);
                const Int8 isPair = (extent > 0.0f) & (area > kParallel * aa * bb) &
                                    (other >= static_cast<std::uint32_t>(from)) &
                                    (other != static_cast<std::uint32_t>(i));
                const LanePacking packed(bitsOf(isPair));
                store(&pairs_[0][pairCount_], Word8{} + static_cast<std::uint32_t>(i));
                store(&pairs_[1][pairCount_], packed(other));
                pairCount_ += packed.count();
            }
        }
    }
}

/// The tracks of eight pairs, the last one repeated where there are fewer.
template <int Dim>
[[gnu::always_inline]] inline Track<Float8, Dim> Surroundings<Dim>::tracksFrom(
    std::size_t firstPair, float rolling) const {
    float gathered[Dim - 1][Dim + 2][kLanes];
    for (std::size_t l = 0; l < kLanes; ++l) {
        const std::size_t pair = std::min(firstPair + l, pairCount_ - 1);
        for (std::size_t n = 0; n < Dim - 1; ++n) {
            const std::size_t i = pairs_[n][pair];
            for (std::size_t d = 0; d < Dim; ++d) gathered[n][d][l] = near_.to[d][i];
            gathered[n][Dim][l] = near_.level[i];
            gathered[n][Dim + 1][l] = near_.slope[i];
        }
    }
    std::array<Cap<Float8, Dim>, Dim - 1> caps;
    for (std::size_t n = 0; n < Dim - 1; ++n) {
        for (std::size_t d = 0; d < Dim; ++d) caps[n].to[d] = load(gathered[n][d]);
        caps[n].level = load(gathered[n][Dim]);
        caps[n].slope = load(gathered[n][Dim + 1]);
    }
    // Levels are those at the start already.
    Track<Float8, Dim> tracks;
    tracks.set(rolling, 0.0f, caps, 1.0f);
    return tracks;
}

/// The site of a pair on one side of it, with its limit; `start` is left to the caller.
template <int Dim>
[[gnu::always_inline]] inline typename Surroundings<Dim>::Site Surroundings<Dim>::siteOf(
    const std::array<std::uint32_t, 2>& pair, const Track<float, Dim>& track, float sign,
    const Radii& radii) {
    Site site;
    for (std::size_t n = 0; n < Dim - 1; ++n) site.bodies[n] = spheres.index[near_.index[pair[n]]];
    site.track = track;
    site.track.extent0 = std::max(site.track.extent0, 0.0f);
    site.track.side *= sign;
    site.side = sign;
    const float most = radii.largest - radii.probe;
    // Growth leaves out the caps of the pair itself: the track follows their edges.
    const float level[2] = {near_.level[pair[0]], near_.level[pair[Dim - 2]]};
    near_.level[pair[0]] = near_.level[pair[Dim - 2]] = kNoBound;
    const float t = most > 0 ? growth(site.track, site.track.end(most)) : 0.0f;
    near_.level[pair[0]] = level[0];
    near_.level[pair[Dim - 2]] = level[1];
    site.limit = t >= most ? radii.largest : radii.probe + t;
    // Where the track itself ends, its extent is 0, or less by rounding.
    const float extent = std::max(site.track.middle(t, site.end), 0.0f);
    const float outward = site.track.side * std::sqrt(extent);
    for (std::size_t d = 0; d < Dim; ++d) site.end[d] += outward * site.track.w[d];
    return site;
}

template <int Dim>
void Surroundings<Dim>::findSites(float pivotRadius, const Radii& radii, std::uint32_t only,
                                  const Region* region, std::vector<Site>& sites) {
    sites.clear();
    if (!sortByReach(pivotRadius, radii.probe)) return;
    const float rolling = pivotRadius + radii.probe;
    findPairs(rolling, only);
    const float slack = kSlack * rolling * rolling;
    const std::size_t count = near_.count;
    for (std::size_t p = 0; p < pairCount_; p += kLanes) {
        const Track<Float8, Dim> tracks = tracksFrom(p, rolling);
        const Candidates<Dim> start(tracks, 0.0f);
        Room<Dim> room(slack);
        if (region) {
            room.keepWithin(*region, start);
            if (noneOf(room.isLeft())) continue;
        }
        for (std::size_t k = 0; k < count; ++k) {
            room.keepOff(near_.to, k, near_.level[k] + slack, start);
            if ((k & 1) && noneOf(room.isLeft())) break;
        }
        if (noneOf(room.isLeft())) continue;
        // Most that end before the least radius are blocked at it as well.
        if (radii.least > radii.probe) {
            const float t = radii.least - radii.probe;
            const Candidates<Dim> then(tracks, t);
            room.keepOnTrack(then);
            for (std::size_t k = 0; k < count; ++k)
                room.keepOff(near_.to, k, near_.level[k] + t * near_.slope[k] + slack, then);
        }
        const std::size_t used = std::min(kLanes, pairCount_ - p);
        forEachSet(
            room.isLeft(), [&](std::size_t l) __attribute__((always_inline)) {
                if (l >= used) return;
                const auto add = [&](float sign) __attribute__((always_inline)) {
                    sites.push_back(siteOf({pairs_[0][p + l], pairs_[1][p + l]}, laneOf(tracks, l),
                                           sign, radii));
                    for (std::size_t d = 0; d < Dim; ++d)
                        sites.back().start[d] = start.middle[d][l] + sign * start.side[d][l];
                };
                if (room.up[l] >= 0.0f) add(1.0f);
                if (room.down[l] >= 0.0f) add(-1.0f);
            });
    }
}

template <int Dim>
float Surroundings<Dim>::growth(const Caps& caps, const Track<float, Dim>& track,
                                float most) const {
    for (std::size_t k = 0; k < caps.count; k += kLanes) {
        if (noneOf(load(&caps.open[k]) < pivotReach_ + 2 * most)) continue;
        std::array<Float8, Dim> to;
        for (std::size_t d = 0; d < Dim; ++d) to[d] = load(&caps.to[d][k]);
        most =
            std::min(most, smallest(firstHit<Float8, Dim>(track, to, load(&caps.level[k]),
                                                          load(&caps.slope[k]), tolerance_, most)));
    }
    return most;
}

template <int Dim>
float Surroundings<Dim>::growth(const Track<float, Dim>& track, float most) const {
    return growth(far_, track, growth(near_, track, most));
}

template <int Dim>
float Surroundings<Dim>::crowdAt(const std::array<float, Dim>& x, float radius, float range) const {
    Float8 crowd{};
    for (std::size_t i = 0; i < spheres.count; i += kLanes) {
        Float8 square{};
        for (std::size_t d = 0; d < Dim; ++d) {
            const Float8 to = load(&spheres.to[d][i]) - x[d];
            square += to * to;
        }
        const Float8 own = load(&spheres.radius[i]);
        const Float8 gap = squareRoot(square) - own - radius;
        const Float8 near = larger(1.0f - larger(gap, 0.0f) * (1 / range), 0.0f);
        crowd += choose(own > 0.0f, near * near, 0.0f);  // walls and padding have no radius
    }
    return sum(crowd);
}

template class Surroundings<2>;
template class Surroundings<3>;

}  // namespace vdbpack
