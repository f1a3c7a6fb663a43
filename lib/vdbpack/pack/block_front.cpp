#include "vdbpack/pack/block_front.h"

#include "vdbpack/pack/caps.h"
#include "vdbpack/pack/cell_list.h"
#include "vdbpack/pack/lanes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>

namespace vdbpack {

namespace {

/// Body numbers at and above this are wall planes of the pivot, below it neighbors.
constexpr std::uint32_t kWallBody = 0x40000000u;
constexpr std::uint32_t kNoBody = 0x7fffffffu;

/// Tangent planes that one pivot may collect; corners need three, rough walls a few more.
constexpr std::size_t kMaxPlanes = 12;

/// Places are searched down to cells this small, in wanted radii: what may be missed is smaller
/// than the wanted radius and half the diagonal of such a cell.
constexpr double kSmallestCell = 0.01;

/// Solves the Dim x Dim system a x = b in place by elimination with pivoting.
template <int Dim>
bool solve(std::array<Vec<Dim>, Dim>& a, Vec<Dim>& b) {
    for (int k = 0; k < Dim; ++k) {
        int best = k;
        for (int i = k + 1; i < Dim; ++i)
            if (std::fabs(a[static_cast<std::size_t>(i)][k]) >
                std::fabs(a[static_cast<std::size_t>(best)][k]))
                best = i;
        std::swap(a[static_cast<std::size_t>(k)], a[static_cast<std::size_t>(best)]);
        std::swap(b[k], b[best]);
        const auto& top = a[static_cast<std::size_t>(k)];
        if (std::fabs(top[k]) < 1e-9) return false;
        for (int i = k + 1; i < Dim; ++i) {
            auto& row = a[static_cast<std::size_t>(i)];
            const double f = row[k] / top[k];
            for (int j = k; j < Dim; ++j) row[j] -= f * top[j];
            b[i] -= f * b[k];
        }
    }
    for (int k = Dim - 1; k >= 0; --k) {
        const auto& row = a[static_cast<std::size_t>(k)];
        for (int j = k + 1; j < Dim; ++j) b[k] -= row[j] * b[j];
        b[k] /= row[k];
    }
    return true;
}

}  // namespace

template <int Dim>
class BlockFront<Dim>::Work {
public:
    explicit Work(const FrontSettings<Dim>& settings) : settings_(settings) {}

    void fill(const Box<Dim>& own, const Box<Dim>& search, const std::vector<Sphere<Dim>>& around,
              RadiusPool& pool, DomainSampler<Dim>& sampler, const std::function<bool()>& cancelled,
              std::vector<Sphere<Dim>>& placed);

    std::size_t seeds_ = 0;

private:
    struct Plane {
        Vec<Dim> point, normal;  ///< on the wall; unit, into the domain
    };
    struct Queued {
        double key;
        std::uint32_t sphere;
        bool operator<(const Queued& o) const {
            return key > o.key || (key == o.key && sphere > o.sphere);
        }
    };
    using Vertex = typename CapSet<Dim>::Vertex;

    void push(std::uint32_t sphere) {
        front_.push({dot(spheres_[sphere].center, settings_.sweep), sphere});
    }
    void place(const Vec<Dim>& center, double radius);
    void runFront();
    void growFrom(std::uint32_t pivot);
    void gather(std::uint32_t pivot, double reach);
    bool heightOf(std::uint32_t body, double radius, Vec<Dim>& axis, double& height) const;
    bool buildCaps(double radius);
    bool addCapLater(std::uint32_t body, double radius);
    void looseVertices();
    bool restingCenter(const Vertex& vertex, double radius, Vec<Dim>& fromPivot) const;
    bool seemsFree(const Vec<Dim>& fromPivot, double radius) const;
    bool overlaps(const Vec<Dim>& center, double radius) const;
    /// What came of placing a sphere at a vertex.
    enum class Outcome { placed, blocked, wallLearned };
    Outcome tryVertex(const Vertex& vertex, double radius, Vec<Dim> center);
    bool polish(double radius, const Vertex& vertex, Vec<Dim>& center);
    bool findPlane(const Vec<Dim>& center, double reach, Plane& plane);
    Vec<Dim> snapped(const Vec<Dim>& x) const;
    bool owns(const Vec<Dim>& x) const;

    void searchPlaces();
    void stampSpheres();
    void refine(const Vec<Dim>& center, double edge);
    bool hasPlace(const Vec<Dim>& center, double edge, Vec<Dim>& place);
    void fillPlace(Vec<Dim> x);
    /// Distance from `x` to the nearest sphere or wall, at most `reach`.
    double clearance(const Vec<Dim>& x, double reach);

    FrontSettings<Dim> settings_;
    // Of the block being filled; coordinates relative to origin_.
    Vec<Dim> origin_;
    Box<Dim> own_, search_;
    RadiusPool* pool_ = nullptr;
    DomainSampler<Dim>* sampler_ = nullptr;
    const std::function<bool()>* cancelled_ = nullptr;
    bool stop_ = false;
    std::vector<Sphere<Dim>> spheres_;
    CellList<Dim> cells_;
    std::priority_queue<Queued> front_;
    // Of the pivot being grown from.
    Sphere<Dim> pivot_;
    typename CellList<Dim>::Around around_;  ///< spheres in reach; bodies are their places here
    std::vector<Plane> planes_;
    CapSet<Dim> caps_;
    std::vector<Vertex> vertices_;
    // Of the search for places.
    double wanted_ = 0;                   ///< radius that a place must have, mm
    double step_ = 0;                     ///< edge of a search cell, mm
    std::array<int, 3> steps_{};          ///< search cells along each axis
    std::size_t rowWords_ = 0;            ///< 64-bit words of a row of cells
    std::vector<std::uint64_t> covered_;  ///< a bit a cell: certainly no place in it
    std::vector<std::uint32_t> nearby_;   ///< spheres that may reach into a cell
};

template <int Dim>
Vec<Dim> BlockFront<Dim>::Work::snapped(const Vec<Dim>& x) const {
    Vec<Dim> s;
    for (int d = 0; d < Dim; ++d)
        s[d] = std::nearbyint(x[d] / settings_.quantum) * settings_.quantum;
    return s;
}

template <int Dim>
bool BlockFront<Dim>::Work::owns(const Vec<Dim>& x) const {
    for (int d = 0; d < Dim; ++d)
        if (!(own_.lo[d] <= x[d] && x[d] < own_.hi[d])) return false;
    return true;
}

template <int Dim>
void BlockFront<Dim>::Work::place(const Vec<Dim>& center, double radius) {
    const auto index = static_cast<std::uint32_t>(spheres_.size());
    spheres_.push_back({center, radius});
    cells_.add(spheres_.back(), index);
    push(index);
}

template <int Dim>
void BlockFront<Dim>::Work::fill(const Box<Dim>& own, const Box<Dim>& search,
                                 const std::vector<Sphere<Dim>>& around, RadiusPool& pool,
                                 DomainSampler<Dim>& sampler,
                                 const std::function<bool()>& cancelled,
                                 std::vector<Sphere<Dim>>& placed) {
    origin_ = own.lo;
    search_ = {search.lo - origin_, search.hi - origin_};
    own_ = {search_.lo, own.hi - origin_};
    pool_ = &pool;
    sampler_ = &sampler;
    cancelled_ = &cancelled;
    stop_ = false;
    spheres_.clear();
    front_ = {};
    const double halo = 2 * settings_.maxRadius;
    // About six spheres a cell: nearly a full chunk, and few cells in reach.
    cells_.reset(own_.grown(halo), std::pow(10 * settings_.meanBall, 1.0 / Dim));
    const Box<Dim> reach = own_.grown(halo);
    for (const auto& s : around) {
        const Sphere<Dim> local{s.center - origin_, s.radius};
        if (!reach.contains(local.center)) continue;
        const auto index = static_cast<std::uint32_t>(spheres_.size());
        spheres_.push_back(local);
        cells_.add(local, index);
        bool borders = true;  // on the block itself, not on the part that is only searched
        for (int d = 0; d < Dim; ++d) borders = borders && local.center[d] > -halo;
        if (borders) push(index);
    }
    const std::size_t standing = spheres_.size();
    pool.refill();
    runFront();
    searchPlaces();
    placed.clear();
    placed.reserve(spheres_.size() - standing);
    for (std::size_t i = standing; i < spheres_.size(); ++i)
        placed.push_back({spheres_[i].center + origin_, spheres_[i].radius});
}

template <int Dim>
void BlockFront<Dim>::Work::runFront() {
    while (!front_.empty() && !stop_) {
        const std::uint32_t pivot = front_.top().sphere;
        front_.pop();
        growFrom(pivot);
        if (*cancelled_ && (*cancelled_)()) stop_ = true;
    }
}

template <int Dim>
void BlockFront<Dim>::Work::gather(std::uint32_t pivot, double reach) {
    cells_.collect(pivot_.center, reach, settings_.maxRadius, pivot, around_);
    planes_.clear();
    const double depth = -sampler_->signedDistance(pivot_.center + origin_);
    if (depth < reach + settings_.fieldError) {
        Plane plane;
        if (findPlane(pivot_.center, reach, plane)) planes_.push_back(plane);
    }
}

template <int Dim>
void BlockFront<Dim>::Work::growFrom(std::uint32_t index) {
    pivot_ = spheres_[index];
    const double smallest = pool_->smallest();
    const double largest = pool_->largest();
    gather(index, pivot_.radius + 2 * largest);
    if (!buildCaps(smallest)) return;
    caps_.findVertices(vertices_);
    if (vertices_.empty()) looseVertices();

    while (!vertices_.empty() && !stop_) {
        // Lowest along the sweep first.
        const auto key = [&](const Vertex& v) {
            double k = 0;
            for (std::size_t d = 0; d < Dim; ++d)
                k += static_cast<double>(v.direction[d]) * settings_.sweep.c[d];
            return k;
        };
        std::size_t lowest = 0;
        double lowestKey = key(vertices_[0]);
        for (std::size_t i = 1; i < vertices_.size(); ++i) {
            const double k = key(vertices_[i]);
            if (k < lowestKey) lowestKey = k, lowest = i;
        }
        const Vertex vertex = vertices_[lowest];
        vertices_[lowest] = vertices_.back();
        vertices_.pop_back();

        // The largest pending radius that rests on the same bodies: the largest of all first,
        // then halfway between what fits and what does not.
        const auto fitsAt = [&](std::size_t k, Vec<Dim>& from) {
            return restingCenter(vertex, (*pool_)[k], from) && seemsFree(from, (*pool_)[k]);
        };
        Vec<Dim> center;
        std::size_t fits = pool_->size();
        std::size_t below = 0;  // nothing is known to fit below this
        std::size_t end = pool_->countUpTo(largest);
        for (int t = 0; t < settings_.radiiTried && below < end; ++t) {
            const std::size_t k = t == 0 ? end - 1 : (below + end) / 2;
            Vec<Dim> from;
            if (fitsAt(k, from)) {
                center = from;
                fits = k;
                below = k + 1;
            } else {
                end = k;
            }
        }
        if (fits == pool_->size()) {
            if (end == 0 || !fitsAt(0, center)) continue;
            fits = 0;
        }
        Outcome outcome = tryVertex(vertex, (*pool_)[fits], center + pivot_.center);
        if (outcome == Outcome::blocked && fits > 0 && fitsAt(0, center)) {
            fits = 0;
            outcome = tryVertex(vertex, (*pool_)[0], center + pivot_.center);
        }
        if (outcome == Outcome::placed) {
            pool_->take(fits);
            const auto child = static_cast<std::uint32_t>(spheres_.size() - 1);
            around_.add(spheres_[child], pivot_.center, child);
            if (!addCapLater(static_cast<std::uint32_t>(around_.count - 1), smallest)) return;
        } else if (outcome == Outcome::wallLearned) {
            const auto plane = kWallBody + static_cast<std::uint32_t>(planes_.size() - 1);
            if (!addCapLater(plane, smallest)) return;
        }
    }
}

template <int Dim>
bool BlockFront<Dim>::Work::findPlane(const Vec<Dim>& center, double reach, Plane& plane) {
    WallPoint<Dim> wall;
    if (!sampler_->nearestWall(center + origin_, reach, wall)) return false;
    plane.point = wall.point - origin_;
    plane.normal = center - plane.point;
    const double l = length(plane.normal);
    if (!(l > 1e-9 * reach)) return false;
    // Triangles do not say which side is inside; the pivot does.
    const double side = dot(pivot_.center - plane.point, plane.normal);
    plane.normal *= (side < 0 ? -1.0 : 1.0) / l;
    return true;
}

/// The cap that `body` forbids a candidate of `radius`.
/// @return false if the body is out of reach.
template <int Dim>
bool BlockFront<Dim>::Work::heightOf(std::uint32_t body, double radius, Vec<Dim>& axis,
                                     double& height) const {
    const double rolling = pivot_.radius + radius + settings_.quantum;
    if (body >= kWallBody) {
        const Plane& plane = planes_[body - kWallBody];
        const double above = dot(pivot_.center - plane.point, plane.normal);
        axis = -plane.normal;
        height = (above - radius - settings_.quantum) / rolling;
        return height < 1;
    }
    const Sphere<Dim>& s = spheres_[around_.index[body]];
    const Vec<Dim> to = s.center - pivot_.center;
    const double square = squaredLength(to);
    const double other = s.radius + radius + settings_.quantum;
    if (square >= (rolling + other) * (rolling + other)) return false;
    const double inverse = 1 / std::sqrt(square);
    axis = to * inverse;
    height = (square + rolling * rolling - other * other) / (2 * rolling) * inverse;
    return true;
}

template <int Dim>
bool BlockFront<Dim>::Work::buildCaps(double radius) {
    caps_.clear();
    const auto add = [&](std::uint32_t body) {
        Vec<Dim> axis;
        double height;
        if (!heightOf(body, radius, axis, height)) return true;
        std::array<float, Dim> a;
        for (std::size_t d = 0; d < Dim; ++d) a[d] = static_cast<float>(axis.c[d]);
        return caps_.add(a, static_cast<float>(height), body);
    };
    for (std::uint32_t p = 0; p < planes_.size(); ++p)
        if (!add(kWallBody + p)) return false;
    const Lanes rolling = static_cast<float>(pivot_.radius + radius + settings_.quantum);
    const Lanes own = static_cast<float>(radius + settings_.quantum);
    for (std::size_t i = 0; i < around_.count; i += kLanes) {
        Lanes square = 0.0f;
        for (std::size_t d = 0; d < Dim; ++d) {
            const Lanes to = load(&around_.to[d][i]);
            square += to * to;
        }
        const Lanes other = load(&around_.radius[i]) + own;
        const auto reached = square < (rolling + other) * (rolling + other);
        if (none_of(reached)) continue;
        const Lanes inverse = 1.0f / sqrt(square);
        float axis[Dim][kLanes], height[kLanes];
        for (std::size_t d = 0; d < Dim; ++d)
            (load(&around_.to[d][i]) * inverse).copy_to(axis[d], stdx::element_aligned);
        const Lanes h = (square + (rolling * rolling - other * other)) / (2.0f * rolling) * inverse;
        h.copy_to(height, stdx::element_aligned);
        bool open = true;
        forEachSet(reached, [&](std::size_t l) {
            std::array<float, Dim> a;
            for (std::size_t d = 0; d < Dim; ++d) a[d] = axis[d][l];
            open = caps_.add(a, height[l], static_cast<std::uint32_t>(i + l)) && open;
        });
        if (!open) return false;
    }
    return true;
}

template <int Dim>
bool BlockFront<Dim>::Work::addCapLater(std::uint32_t body, double radius) {
    Vec<Dim> axis;
    double height;
    if (!heightOf(body, radius, axis, height)) return true;
    std::array<float, Dim> a;
    for (std::size_t d = 0; d < Dim; ++d) a[d] = static_cast<float>(axis.c[d]);
    return caps_.addLater(a, static_cast<float>(height), body, vertices_);
}

/// A front begins with too few bodies for a vertex: then a candidate may rest on fewer.
template <int Dim>
void BlockFront<Dim>::Work::looseVertices() {
    if (caps_.size() > Dim) return;
    std::vector<std::pair<Vec<Dim>, double>> caps;
    const auto collect = [&](std::uint32_t body) {
        Vec<Dim> axis;
        double height;
        if (heightOf(body, pool_->smallest(), axis, height)) caps.emplace_back(axis, height);
    };
    for (std::uint32_t p = 0; p < planes_.size(); ++p) collect(kWallBody + p);
    for (std::uint32_t n = 0; n < around_.count; ++n) collect(n);
    const auto emit = [&](const Vec<Dim>& n) {
        for (const auto& [axis, height] : caps)
            if (dot(n, axis) > height) return;
        Vertex v;
        for (std::size_t d = 0; d < Dim; ++d) v.direction[d] = static_cast<float>(n.c[d]);
        v.bodies.fill(kNoBody);
        v.side = 1;
        vertices_.push_back(v);
    };
    if (caps.empty()) emit(-settings_.sweep);
    if constexpr (Dim == 3) {
        constexpr int kAround = 16;
        for (const auto& [axis, height] : caps) {
            const Vec<3> other = std::fabs(axis[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
            const Vec<3> e1 = normalized(cross(axis, other));
            const Vec<3> e2 = cross(axis, e1);
            // A little off the cap: the candidate rests on the pivot alone and needs no polish.
            const double up = std::min(height, 1.0) - 1e-6;
            const double out = std::sqrt(std::max(0.0, 1 - up * up));
            for (int a = 0; a < kAround; ++a) {
                const double angle = 2 * kPi * a / kAround;
                emit(axis * up + (e1 * std::cos(angle) + e2 * std::sin(angle)) * out);
            }
        }
    }
}

/// Where a candidate of `radius` rests on the bodies of `vertex`, on the same side of them.
/// @return false if it cannot touch them all.
template <int Dim>
bool BlockFront<Dim>::Work::restingCenter(const Vertex& vertex, double radius,
                                          Vec<Dim>& fromPivot) const {
    const double rolling = pivot_.radius + radius + settings_.quantum;
    if (vertex.bodies[0] == kNoBody) {
        Vec<Dim> n;
        for (std::size_t d = 0; d < Dim; ++d) n.c[d] = vertex.direction[d];
        fromPivot = normalized(n) * rolling;
        return true;
    }
    Vec<Dim> a;
    double ha;
    if (!heightOf(vertex.bodies[0], radius, a, ha)) return false;
    if constexpr (Dim == 3) {
        Vec<3> b;
        double hb;
        if (!heightOf(vertex.bodies[1], radius, b, hb)) return false;
        const double c = dot(a, b);
        const double inverse = 1 / (1 - c * c);
        const double alpha = (ha - hb * c) * inverse;
        const double beta = (hb - ha * c) * inverse;
        const double square = (1 - alpha * ha - beta * hb) * inverse;
        if (!(square >= 0)) return false;
        fromPivot = (a * alpha + b * beta +
                     cross(a, b) * (static_cast<double>(vertex.side) * std::sqrt(square))) *
                    rolling;
    } else {
        if (!(ha * ha <= 1)) return false;
        const double out = static_cast<double>(vertex.side) * std::sqrt(1 - ha * ha);
        fromPivot = (a * ha + Vec<2>{{-a[1], a[0]}} * out) * rolling;
    }
    return true;
}

/// A filter in float: false if a neighbor or a known plane is clearly in the way.
template <int Dim>
bool BlockFront<Dim>::Work::seemsFree(const Vec<Dim>& fromPivot, double radius) const {
    constexpr double kSlack = 2e-5;
    const Lanes r = static_cast<float>(radius * (1 - kSlack));
    std::array<Lanes, Dim> x;
    for (std::size_t d = 0; d < Dim; ++d) x[d] = static_cast<float>(fromPivot.c[d]);
    for (std::size_t i = 0; i < around_.count; i += kLanes) {
        Lanes square = 0.0f;
        for (std::size_t d = 0; d < Dim; ++d) {
            const Lanes to = load(&around_.to[d][i]) - x[d];
            square += to * to;
        }
        const Lanes least = load(&around_.radius[i]) + r;
        if (any_of(square < least * least)) return false;
    }
    for (const Plane& plane : planes_)
        if (dot(fromPivot + pivot_.center - plane.point, plane.normal) < radius * (1 - kSlack))
            return false;
    return true;
}

/// The decision, in double: whether a sphere there would overlap the pivot or a neighbor.
template <int Dim>
bool BlockFront<Dim>::Work::overlaps(const Vec<Dim>& center, double radius) const {
    const double contact = pivot_.radius + radius;
    const Vec<Dim> from = center - pivot_.center;
    if (squaredLength(from) < contact * contact) return true;
    const Lanes r = static_cast<float>(radius * (1 + 1e-4));
    std::array<Lanes, Dim> x;
    for (std::size_t d = 0; d < Dim; ++d) x[d] = static_cast<float>(from.c[d]);
    for (std::size_t i = 0; i < around_.count; i += kLanes) {
        Lanes square = 0.0f;
        for (std::size_t d = 0; d < Dim; ++d) {
            const Lanes to = load(&around_.to[d][i]) - x[d];
            square += to * to;
        }
        const Lanes least = load(&around_.radius[i]) + r;
        const auto close = square < least * least;
        if (none_of(close)) continue;
        bool disjoint = true;
        forEachSet(close, [&](std::size_t l) {
            const Sphere<Dim>& s = spheres_[around_.index[i + l]];
            const double exact = s.radius + radius;
            disjoint = disjoint && squaredLength(center - s.center) >= exact * exact;
        });
        if (!disjoint) return true;
    }
    return false;
}

/// Follows the resting place to curved walls, where the plane was only a first guess.
template <int Dim>
bool BlockFront<Dim>::Work::polish(double radius, const Vertex& vertex, Vec<Dim>& center) {
    const Sphere<Dim>& pivot = pivot_;
    const double slack = settings_.quantum;
    const double rolling = pivot.radius + radius + slack;
    if (vertex.bodies[0] == kNoBody) return true;
    std::size_t wallBodies = 0, wallAt = 0;
    for (std::size_t b = 0; b < Dim - 1; ++b)
        if (vertex.bodies[b] >= kWallBody) ++wallBodies, wallAt = b;
    if (wallBodies == 0) return true;
    Plane tangent{};
    // One curved wall is followed to its true nearest point; two (a corner) are taken as planes.
    const int rounds = wallBodies == 1 ? 4 : 1;
    for (int round = 0; round < rounds; ++round) {
        const Vec<Dim> before = center;
        if (wallBodies == 1) {
            if (!findPlane(center, 2 * radius, tangent)) return false;
        }
        for (int step = 0; step < 3; ++step) {
            std::array<Vec<Dim>, Dim> gradient;
            Vec<Dim> residual;
            const Vec<Dim> from = center - pivot.center;
            const double d0 = length(from);
            gradient[0] = from * (1 / d0);
            residual[0] = rolling - d0;
            for (std::size_t b = 0; b < Dim - 1; ++b) {
                const std::uint32_t body = vertex.bodies[b];
                if (body >= kWallBody) {
                    const Plane& plane =
                        wallBodies == 1 && b == wallAt ? tangent : planes_[body - kWallBody];
                    gradient[b + 1] = plane.normal;
                    residual[static_cast<int>(b) + 1] =
                        radius + slack - dot(center - plane.point, plane.normal);
                } else {
                    const Sphere<Dim>& other = spheres_[around_.index[body]];
                    const Vec<Dim> away = center - other.center;
                    const double d = length(away);
                    gradient[b + 1] = away * (1 / d);
                    residual[static_cast<int>(b) + 1] = other.radius + radius + slack - d;
                }
            }
            if (!solve<Dim>(gradient, residual)) return false;
            center += residual;
            const double moved = squaredLength(residual);
            if (!(moved < radius * radius)) return false;
            if (moved < 0.01 * slack * slack) break;
        }
        if (squaredLength(center - before) < 0.01 * slack * slack) break;
    }
    return true;
}

template <int Dim>
typename BlockFront<Dim>::Work::Outcome BlockFront<Dim>::Work::tryVertex(const Vertex& vertex,
                                                                         double radius,
                                                                         Vec<Dim> center) {
    const Vec<Dim> guess = center;
    if (!own_.grown(0.5 * radius).contains(center)) return Outcome::blocked;
    if (!polish(radius, vertex, center)) return Outcome::blocked;
    center = snapped(center);
    if (!owns(center)) return Outcome::blocked;
    if (overlaps(center, radius)) return Outcome::blocked;
    Plane plane;
    if (!findPlane(center, radius, plane)) {
        place(center, radius);
        return Outcome::placed;
    }
    // A wall that the pivot did not know. Learn its plane, unless the plane leaves this vertex
    // as it is: then it would come up again and again.
    if (planes_.size() < kMaxPlanes &&
        dot(guess - plane.point, plane.normal) < radius * (1 - 1e-4)) {
        planes_.push_back(plane);
        return Outcome::wallLearned;
    }
    return Outcome::blocked;
}

template <int Dim>
double BlockFront<Dim>::Work::clearance(const Vec<Dim>& x, double reach) {
    double least = reach;
    cells_.near(x, reach, settings_.maxRadius, [&](std::uint32_t i) {
        least = std::min(least, length(spheres_[i].center - x) - spheres_[i].radius);
        return true;
    });
    if (least <= 0) return least;
    WallPoint<Dim> wall;
    const Vec<Dim> global = x + origin_;
    if (sampler_->nearestWall(global, least, wall)) least = wall.distance;
    return sampler_->contains(global) ? least : -least;
}

/// Marks the cells in which some sphere leaves no place: a center with room for `wanted_` is
/// nowhere farther from its cell's center than half the diagonal.
template <int Dim>
void BlockFront<Dim>::Work::stampSpheres() {
    const double corner = 0.5 * step_ * std::sqrt(static_cast<double>(Dim));
    const auto rows = static_cast<std::size_t>(steps_[1]) * static_cast<std::size_t>(steps_[2]);
    covered_.assign(rows * rowWords_, 0);
    const double inverse = 1 / step_;
    for (const auto& s : spheres_) {
        const double reach = (s.radius + wanted_ - corner) * inverse;
        if (reach <= 0) continue;
        // In steps, with cell i's center at i.
        Vec<3> c;
        for (int d = 0; d < Dim; ++d) c[d] = (s.center[d] - search_.lo[d]) * inverse - 0.5;
        int from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
        for (int d = 1; d < Dim; ++d) {
            from[d] = std::max(0, static_cast<int>(std::ceil(c[d] - reach)));
            to[d] = std::min(steps_[static_cast<std::size_t>(d)] - 1,
                             static_cast<int>(std::floor(c[d] + reach)));
        }
        for (int k = from[2]; k <= to[2]; ++k)
            for (int j = from[1]; j <= to[1]; ++j) {
                const double square = reach * reach - (k - c[2]) * (k - c[2]) -
                                      (Dim > 1 ? (j - c[1]) * (j - c[1]) : 0.0);
                if (square <= 0) continue;
                const double half = std::sqrt(square);
                const int first = std::max(0, static_cast<int>(std::ceil(c[0] - half)));
                const int last = std::min(steps_[0] - 1, static_cast<int>(std::floor(c[0] + half)));
                if (first > last) continue;
                std::uint64_t* const row =
                    &covered_[(static_cast<std::size_t>(k) * static_cast<std::size_t>(steps_[1]) +
                               static_cast<std::size_t>(j)) *
                              rowWords_];
                const int firstWord = first >> 6, lastWord = last >> 6;
                const std::uint64_t head = ~std::uint64_t{0} << (first & 63);
                const std::uint64_t tail = ~std::uint64_t{0} >> (63 - (last & 63));
                if (firstWord == lastWord) {
                    row[firstWord] |= head & tail;
                } else {
                    row[firstWord] |= head;
                    for (int w = firstWord + 1; w < lastWord; ++w) row[w] = ~std::uint64_t{0};
                    row[lastWord] |= tail;
                }
            }
    }
}

template <int Dim>
void BlockFront<Dim>::Work::searchPlaces() {
    wanted_ = settings_.meanRadius;
    step_ = std::min(settings_.minRadius, 0.7 * wanted_);
    step_ = std::max(step_, 0.3 * wanted_);
    steps_ = {1, 1, 1};
    for (int d = 0; d < Dim; ++d)
        steps_[static_cast<std::size_t>(d)] =
            std::max(1, static_cast<int>(std::ceil((search_.hi[d] - search_.lo[d]) / step_)));
    rowWords_ = (static_cast<std::size_t>(steps_[0]) + 63) / 64;
    stampSpheres();

    // In bricks, since one lookup tells most of them to lie outside the domain or deep inside.
    constexpr int kBrick = 4;
    const double corner = 0.5 * step_ * std::sqrt(static_cast<double>(Dim));
    const double error = 2 * settings_.fieldError;
    const auto depthAt = [&](const Vec<Dim>& x) {
        const double depth = -sampler_->signedDistance(x + origin_);
        return depth < 0.99 * settings_.fieldDepth ? depth
                                                   : std::numeric_limits<double>::infinity();
    };
    int bricks[3], size[3];
    for (std::size_t d = 0; d < 3; ++d) {
        size[d] = d < Dim ? kBrick : 1;
        bricks[d] = (steps_[d] + size[d] - 1) / size[d];
    }
    for (int bk = 0; bk < bricks[2]; ++bk)
        for (int bj = 0; bj < bricks[1]; ++bj)
            for (int bi = 0; bi < bricks[0]; ++bi) {
                const int at[3] = {bi * size[0], bj * size[1], bk * size[2]};
                Vec<Dim> center;
                for (int d = 0; d < Dim; ++d)
                    center[d] = search_.lo[d] + (at[d] + 0.5 * size[d]) * step_;
                const double depth = depthAt(center);
                if (depth < wanted_ - kBrick * corner - error) continue;
                const bool deep = depth > wanted_ + kBrick * corner + error;
                for (int k = at[2]; k < std::min(at[2] + size[2], steps_[2]); ++k)
                    for (int j = at[1]; j < std::min(at[1] + size[1], steps_[1]); ++j)
                        for (int i = at[0]; i < std::min(at[0] + size[0], steps_[0]); ++i) {
                            const std::size_t row =
                                (static_cast<std::size_t>(k) * static_cast<std::size_t>(steps_[1]) +
                                 static_cast<std::size_t>(j)) *
                                rowWords_;
                            if (covered_[row + static_cast<std::size_t>(i >> 6)] >> (i & 63) & 1)
                                continue;
                            const int cell[3] = {i, j, k};
                            Vec<Dim> c;
                            for (int d = 0; d < Dim; ++d)
                                c[d] = search_.lo[d] + (cell[d] + 0.5) * step_;
                            if (!deep && depthAt(c) < wanted_ - corner - error) continue;
                            refine(c, step_);
                            if (stop_) return;
                        }
            }
}

/// Fills all places with a center in the cell.
template <int Dim>
void BlockFront<Dim>::Work::refine(const Vec<Dim>& center, double edge) {
    for (;;) {
        nearby_.clear();
        cells_.near(center, wanted_, settings_.maxRadius, [&](std::uint32_t i) {
            nearby_.push_back(i);
            return true;
        });
        Vec<Dim> place;
        const std::size_t before = spheres_.size();
        if (!hasPlace(center, edge, place)) return;
        fillPlace(place);
        if (spheres_.size() == before || stop_) return;
    }
}

/// Looks for a place with its center in the cell, by halving; `nearby_` holds the spheres in reach.
template <int Dim>
bool BlockFront<Dim>::Work::hasPlace(const Vec<Dim>& center, double edge, Vec<Dim>& place) {
    const double corner = 0.5 * edge * std::sqrt(static_cast<double>(Dim));
    double room = std::numeric_limits<double>::infinity();
    for (const std::uint32_t i : nearby_) {
        const Sphere<Dim>& s = spheres_[i];
        const double least = s.radius + wanted_ - corner;
        const double square = squaredLength(s.center - center);
        if (least > 0 && square < least * least) return false;
        room = std::min(room, std::sqrt(square) - s.radius);
    }
    // The field is too coarse a guess here: every cell along the wall would be halved to the end.
    WallPoint<Dim> wall;
    const Vec<Dim> global = center + origin_;
    if (wanted_ > corner && sampler_->nearestWall(global, wanted_ - corner, wall)) return false;
    const bool crossed = wanted_ < 2 * corner && sampler_->nearestWall(global, corner, wall);
    if (!crossed) {
        const double outside = sampler_->signedDistance(global);
        // Near the wall even the field's sign can be wrong; the triangles know.
        if (outside > 2 * settings_.fieldError ||
            (outside > 0 && (settings_.fieldError == 0 || !sampler_->contains(global))))
            return false;
    }
    if (room >= wanted_ && !sampler_->nearestWall(global, wanted_, wall)) {
        place = center;
        // All of a ball that no wall crosses is on one side.
        return sampler_->contains(global);
    }
    if (edge < kSmallestCell * wanted_) return false;
    for (int child = 0; child < (1 << Dim); ++child) {
        Vec<Dim> c = center;
        for (int d = 0; d < Dim; ++d) c[d] += (child >> d & 1 ? 0.25 : -0.25) * edge;
        if (hasPlace(c, 0.5 * edge, place)) return true;
    }
    return false;
}

template <int Dim>
void BlockFront<Dim>::Work::fillPlace(Vec<Dim> x) {
    const double far = 1.5 * settings_.maxRadius;
    double room = clearance(x, far);
    // Uphill to where there is most room, so that the largest pending radius that fits is taken.
    for (double step = 0.25 * settings_.minRadius; step > 0.005 * settings_.minRadius;) {
        Vec<Dim> best = x;
        double bestRoom = room;
        for (int d = 0; d < Dim; ++d)
            for (const double sign : {-1.0, 1.0}) {
                Vec<Dim> y = x;
                y[d] += sign * step;
                if (!owns(y)) continue;
                const double c = clearance(y, far);
                if (c > bestRoom) bestRoom = c, best = y;
            }
        if (bestRoom > room) {
            x = best;
            room = bestRoom;
        } else {
            step *= 0.5;
        }
    }
    const std::size_t fitting = pool_->countUpTo(room - 2 * settings_.quantum);
    if (fitting == 0) return;
    const auto placeAt = [&](const Vec<Dim>& center, std::size_t k) {
        const double radius = (*pool_)[k];
        if (!owns(center)) return false;
        bool overlaps = false;
        cells_.near(center, radius, settings_.maxRadius, [&](std::uint32_t i) {
            const double least = spheres_[i].radius + radius;
            overlaps = overlaps || squaredLength(spheres_[i].center - center) < least * least;
            return true;
        });
        WallPoint<Dim> wall;
        if (overlaps || sampler_->nearestWall(center + origin_, radius, wall) ||
            !sampler_->contains(center + origin_))
            return false;
        ++seeds_;
        place(center, radius);
        pool_->take(k);
        return true;
    };
    // Down the sweep until it touches something.
    const double radius = (*pool_)[fitting - 1];
    Vec<Dim> low = x;
    for (int step = 0; step < 200; ++step) {
        const double free = clearance(low, far) - radius - settings_.quantum;
        if (free < 1e-6 * radius) break;
        const Vec<Dim> y = low - settings_.sweep * free;
        if (!owns(y)) break;
        low = y;
    }
    // Snapping moves the center by less than a quantum; step back where that was too much.
    Vec<Dim> center = snapped(low);
    for (int step = 0; step < 8 && clearance(center, far) < radius; ++step)
        center = snapped(low + settings_.sweep * (settings_.quantum * (2 << step)));
    if (placeAt(center, fitting - 1) || placeAt(snapped(x), fitting - 1) || placeAt(snapped(x), 0))
        runFront();
}

template <int Dim>
BlockFront<Dim>::BlockFront(const FrontSettings<Dim>& settings)
    : work_(std::make_unique<Work>(settings)) {}

template <int Dim>
BlockFront<Dim>::~BlockFront() = default;

template <int Dim>
void BlockFront<Dim>::fill(const Box<Dim>& own, const Box<Dim>& search,
                           const std::vector<Sphere<Dim>>& around, RadiusPool& pool,
                           DomainSampler<Dim>& sampler, const std::function<bool()>& cancelled,
                           std::vector<Sphere<Dim>>& placed) {
    work_->fill(own, search, around, pool, sampler, cancelled, placed);
}

template <int Dim>
std::size_t BlockFront<Dim>::seeds() const {
    return work_->seeds_;
}

template class BlockFront<2>;
template class BlockFront<3>;

}  // namespace vdbpack
