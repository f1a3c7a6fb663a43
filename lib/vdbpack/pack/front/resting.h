// Where spheres rest that touch a pivot and other bodies, and how far they can grow there.
#pragma once

#include "vdbpack/pack/front/cell_list.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace vdbpack {

/// How deep inside another body a resting place may seem to lie, in squared rolling radii: above
/// the rounding of the place, far below what matters; the decision is made in double.
inline constexpr float kSlack = 2e-5f;
/// Growth that counts as none, in rolling radii: a body touched at the start stops it at once.
inline constexpr float kTouching = 1e-5f;

/// A body beside a pivot, as a bound on the center of a sphere that touches the pivot.
///
/// With x the center as seen from the pivot and r the radius, the sphere stays off the body
/// where x . to <= level + r * slope and touches it where both are equal. The bound is linear
/// because |x| = pivot radius + r is given; spheres and walls take the same form.
template <class T, int Dim>
struct Body {
    std::array<T, Dim> to;
    T level, slope;

    /// A sphere: `to` its center from the pivot.
    static Body sphere(const std::array<T, Dim>& to, T pivotRadius, T radius) {
        T square = 0;
        for (std::size_t d = 0; d < Dim; ++d) square += to[d] * to[d];
        return {to, T(0.5) * (square + (pivotRadius - radius) * (pivotRadius + radius)),
                pivotRadius - radius};
    }
    /// A wall: its unit normal into the domain, the pivot's center `above` it.
    static Body plane(std::array<T, Dim> normal, T above) {
        for (auto& n : normal) n = -n;
        return {normal, above, T(-1)};
    }
};

/// The path that the center of a sphere takes as it grows from radius `start` on while it rests
/// on the pivot and on Dim - 1 bodies:
///     x(t) = alpha(t) a + beta(t) b + side sqrt(extent(t)) w,  t = radius - start,
/// with a, b the bodies' directions and w normal to them; alpha and beta are linear in t,
/// extent is quadratic. In 2D there is no b.
template <class T, int Dim>
struct Track {
    std::array<T, Dim> a, b, w;
    T alpha0, alpha1, beta0, beta1;
    T extent0, extent1, extent2;
    T side;

    /// For bodies whose directions are not parallel; where `extent0` is negative the sphere cannot
    /// touch them all at the start.
    /// @param rolling  pivot radius + start.
    /// @param bodies   Dim - 1 of them.
    /// @param sign     +1 or -1: the side of the bodies on which the sphere rests.
    template <class Scalar>
    void set(Scalar rolling, Scalar start, const std::array<Body<T, Dim>, Dim - 1>& bodies,
             Scalar sign) {
        const Scalar two = 2;
        const Body<T, Dim>& first = bodies[0];
        a = first.to;
        const T ca = first.level + start * first.slope, ma = first.slope;
        T aa{};
        for (std::size_t d = 0; d < Dim; ++d) aa += a[d] * a[d];
        T area;
        if constexpr (Dim == 3) {
            const Body<T, Dim>& second = bodies[1];
            b = second.to;
            const T cb = second.level + start * second.slope, mb = second.slope;
            const T bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
            const T ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            area = aa * bb - ab * ab;
            w = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
            const T inverse = Scalar(1) / area;
            alpha0 = (ca * bb - cb * ab) * inverse;
            beta0 = (cb * aa - ca * ab) * inverse;
            alpha1 = (ma * bb - mb * ab) * inverse;
            beta1 = (mb * aa - ma * ab) * inverse;
            extent0 = rolling * rolling * area - (ca * ca * bb - two * ca * cb * ab + cb * cb * aa);
            extent1 =
                two * (rolling * area - (ca * ma * bb - (ca * mb + cb * ma) * ab + cb * mb * aa));
            extent2 = area - (ma * ma * bb - two * ma * mb * ab + mb * mb * aa);
            side = sign * inverse;
        } else {
            b.fill(T{});
            area = aa;
            w = {-a[1], a[0]};
            alpha0 = ca / aa, alpha1 = ma / aa;
            beta0 = beta1 = T{};
            extent0 = rolling * rolling * area - ca * ca;
            extent1 = two * (rolling * area - ca * ma);
            extent2 = area - ma * ma;
            side = sign / area;
        }
    }

    /// As `set`, with any bodies. @return false if there is no such path.
    bool make(T rolling, T start, const std::array<Body<T, Dim>, Dim - 1>& bodies, T sign) {
        if constexpr (Dim == 3) {
            const auto &p = bodies[0].to, &q = bodies[1].to;
            const T pp = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            const T qq = q[0] * q[0] + q[1] * q[1] + q[2] * q[2];
            const T pq = p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
            if (!(pp * qq - pq * pq > T(1e-6) * pp * qq)) return false;
        }
        set(rolling, start, bodies, sign);
        return extent0 >= 0;
    }

    /// A sphere that touches the pivot alone, in unit direction `n`.
    void makeLoose(T rolling, const std::array<T, Dim>& n) {
        a = b = {};
        w = n;
        alpha0 = alpha1 = beta0 = beta1 = 0;
        extent0 = rolling * rolling;
        extent1 = 2 * rolling;
        extent2 = 1;
        side = 1;
    }

    /// The middle between the two places after growing by `t`. @return the extent there.
    template <class Scalar>
    T middle(Scalar t, std::array<T, Dim>& x) const {
        const T alpha = alpha0 + t * alpha1, beta = beta0 + t * beta1;
        for (std::size_t d = 0; d < Dim; ++d) x[d] = alpha * a[d] + beta * b[d];
        return extent0 + t * (extent1 + t * extent2);
    }

    /// The center after growing by `t`. @return false if there is none.
    bool at(T t, std::array<T, Dim>& x) const {
        const T extent = middle(t, x);
        if (!(extent >= 0)) return false;
        const T out = side * std::sqrt(extent);
        for (std::size_t d = 0; d < Dim; ++d) x[d] += out * w[d];
        return true;
    }

    /// The largest growth up to `most` for which the sphere can touch all its bodies.
    T end(T most) const {
        const T disc = extent1 * extent1 - 4 * extent2 * extent0;
        if (!(disc >= 0)) return most;
        const T q = T(-0.5) * (extent1 + std::copysign(std::sqrt(disc), extent1));
        // Both roots; extent0 >= 0, so the first positive one ends the path.
        for (const T root : {q / extent2, extent0 / q})
            if (root > 0 && root < most) most = root;
        return most;
    }
};

/// The bodies around one pivot: spheres as a cell list finds them, and wall planes.
///
/// Works in float, eight bodies at a time, as a filter: results carry errors of about 1e-5 of
/// the radii; the caller decides in double.
/// Source: positions in contact with three bodies are the vertices of the caps that neighbors
/// forbid on the sphere of directions; the largest sphere at one of them is a vertex of the
/// additively weighted Voronoi (Apollonius) diagram.
template <int Dim>
class Surroundings {
public:
    /// A place where a sphere rests on the pivot and on Dim - 1 bodies.
    struct Site {
        std::array<float, Dim> start;  ///< center at the probe's radius, from the pivot
        std::array<float, Dim> end;    ///< center at radius `limit`
        Track<float, Dim> track;       ///< from the probe's radius on
        float limit;                   ///< largest radius that fits
        float side;
        std::array<std::uint32_t, Dim - 1> bodies;  ///< as named in `spheres` and `addPlane`
    };

    /// Starts anew with the spheres that `cells` hold around a pivot at `x` that is sphere
    /// `except`: all with a gap smaller than `reach` to the point `x`.
    void collect(const CellList<Dim>& cells, const Vec<Dim>& x, double reach,
                 std::uint32_t except) {
        planes_.clear();
        cells.collect(x, reach, except, spheres);
    }
    /// As collected, then the walls that were added.
    typename CellList<Dim>::Around spheres;

    /// Adds a wall that the pivot's center is `above`, with unit normal into the domain.
    void addPlane(const std::array<float, Dim>& normal, float above, std::uint32_t name);

    /// Where sites are wanted, from the pivot.
    struct Region {
        std::array<float, Dim> lo, hi;
    };
    /// For what radii sites are wanted, mm.
    struct Radii {
        float probe;    ///< sites are sought for this one
        float least;    ///< and where they cannot grow to this one may be left out
        float largest;  ///< they need not grow beyond
    };
    /// All sites for a sphere of the probe's radius, in a fixed order.
    /// @param only    keeps sites that rest on this body; kAll for all.
    /// @param region  keeps those that start within; null for all.
    /// @param sites   is overwritten.
    void findSites(float pivotRadius, const Radii& radii, std::uint32_t only, const Region* region,
                   std::vector<Site>& sites);
    static constexpr std::uint32_t kAll = 0xffffffffu;

    /// Bodies that a sphere of the probe's radius on the pivot can reach; after `findSites`.
    std::size_t reached() const { return near_.count; }
    /// The growth, at most `most`, at which a sphere on `track` hits one of the bodies; after
    /// `findSites` with the radii that the track starts from.
    float growth(const Track<float, Dim>& track, float most) const;

private:
    /// Bodies as padded arrays.
    struct Group {
        std::array<std::vector<float>, Dim> to;
        std::vector<float> level;  ///< at the probe's radius
        std::vector<float> slope;
        std::vector<float> square;         ///< |to|²
        std::vector<float> open;           ///< room between body and pivot's center
        std::vector<std::uint32_t> index;  ///< in `spheres`
        std::size_t count = 0;

        void resize(std::size_t n);
        void pad();
    };
    bool reach(float pivotRadius, float probe);
    float growth(const Group& group, const Track<float, Dim>& track, float most) const;
    void findPairs(float rolling, std::uint32_t only);

    float tolerance_ = 0;   ///< growth that counts as none, mm
    float pivotReach_ = 0;  ///< pivot radius and twice the probe's, mm
    std::vector<std::pair<std::size_t, Body<float, Dim>>> planes_;  ///< place and body
    Group near_, far_;  ///< in reach of the probe, and of larger spheres only
    std::vector<std::array<std::uint32_t, 2>> pairs_;
    std::size_t pairCount_ = 0;
};

/// The growth t in [0, most] at which a sphere on `track` first hits a body; `level` is the
/// body's at the start of the track.
template <int Dim>
float firstHit(const Track<float, Dim>& track, const Body<float, Dim>& body, float level,
               float tolerance, float most);

extern template class Surroundings<2>;
extern template class Surroundings<3>;

}  // namespace vdbpack
