#include "vdbpack/pack/block_front.h"

#include "vdbpack/pack/caps.h"
#include "vdbpack/pack/cell_list.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <queue>

namespace vdbpack {

namespace {

/// Body numbers at and above this are wall planes of the pivot, below it neighbors.
constexpr std::uint32_t kWallBody = 0x40000000u;
constexpr std::uint32_t kNoBody = 0x7fffffffu;

/// Tangent planes that one pivot may collect; corners need three, rough walls a few more.
constexpr std::size_t kMaxPlanes = 12;

/// Places are searched down to cells this small, in smallest radii.
constexpr double kSmallestCell = 0.06;

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
    std::optional<Vec<Dim>> restingPlace(const Sphere<Dim>& pivot, double radius);
    void buildCaps(const Sphere<Dim>& pivot, double radius);
    void looseVertices(double radius);
    bool polish(const Sphere<Dim>& pivot, double radius, const Vertex& vertex, Vec<Dim>& center);
    bool findPlane(const Vec<Dim>& center, double reach, const Vec<Dim>& insideOf, Plane& plane);
    Vec<Dim> snapped(const Vec<Dim>& x) const;
    bool owns(const Vec<Dim>& x) const;

    void searchPlaces();
    void searchCell(const Vec<Dim>& center, double edge);
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
    std::vector<std::uint32_t> neighbors_;
    std::vector<Plane> planes_;
    CapSet<Dim> caps_;
    std::vector<Vertex> vertices_;
    std::vector<std::pair<Vec<Dim>, double>> looseCaps_;
    double searchRadius_ = 0;
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
    cells_.reset(own_.grown(halo), halo);
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
void BlockFront<Dim>::Work::growFrom(std::uint32_t index) {
    const Sphere<Dim> pivot = spheres_[index];
    const double largest = pool_->largest();
    const double reach = pivot.radius + 2 * largest;
    neighbors_.clear();
    cells_.near(pivot.center, reach, settings_.maxRadius, [&](std::uint32_t i) {
        if (i != index) neighbors_.push_back(i);
        return true;
    });
    planes_.clear();
    const double depth = -sampler_->signedDistance(pivot.center + origin_);
    if (depth < reach + settings_.fieldError) {
        Plane plane;
        if (findPlane(pivot.center, reach, pivot.center, plane)) planes_.push_back(plane);
    }

    // What does not fit never will: neighbors only get more.
    double tooLarge = std::nextafter(largest, std::numeric_limits<double>::infinity());
    while (!stop_ && pool_->smallest() < tooLarge) {
        std::size_t fits = 0;
        auto center = restingPlace(pivot, (*pool_)[0]);
        if (!center) return;
        // The largest pending radius, then halfway between what fits and what does not.
        auto end = static_cast<std::size_t>(pool_->countUpTo(std::nextafter(tooLarge, 0.0)));
        for (int t = 1; t < settings_.radiiTried && fits + 1 < end; ++t) {
            const std::size_t k = t == 1 ? end - 1 : (fits + end) / 2;
            if (const auto c = restingPlace(pivot, (*pool_)[k])) {
                center = c;
                fits = k;
            } else {
                tooLarge = (*pool_)[k];
                end = k;
            }
        }
        const double radius = (*pool_)[fits];
        neighbors_.push_back(static_cast<std::uint32_t>(spheres_.size()));
        place(*center, radius);
        pool_->take(fits);
    }
}

template <int Dim>
bool BlockFront<Dim>::Work::findPlane(const Vec<Dim>& center, double reach,
                                      const Vec<Dim>& insideOf, Plane& plane) {
    WallPoint<Dim> wall;
    if (!sampler_->nearestWall(center + origin_, reach, wall)) return false;
    plane.point = wall.point - origin_;
    plane.normal = center - plane.point;
    const double l = length(plane.normal);
    if (!(l > 1e-9 * reach)) return false;
    // Triangles do not say which side is inside; the pivot does.
    const double side = dot(insideOf - plane.point, plane.normal);
    plane.normal *= (side < 0 ? -1.0 : 1.0) / l;
    return true;
}

template <int Dim>
void BlockFront<Dim>::Work::buildCaps(const Sphere<Dim>& pivot, double radius) {
    caps_.clear();
    looseCaps_.clear();
    const double rolling = pivot.radius + radius + settings_.quantum;
    const auto add = [&](const Vec<Dim>& axis, double height, std::uint32_t body) {
        std::array<float, Dim> a;
        for (std::size_t d = 0; d < Dim; ++d) a[d] = static_cast<float>(axis.c[d]);
        if (height < 1 && looseCaps_.size() < Dim + 1) looseCaps_.emplace_back(axis, height);
        return caps_.add(a, static_cast<float>(height), body);
    };
    for (std::size_t p = 0; p < planes_.size(); ++p) {
        const double above = dot(pivot.center - planes_[p].point, planes_[p].normal);
        if (!add(-planes_[p].normal, (above - radius - settings_.quantum) / rolling,
                 kWallBody + static_cast<std::uint32_t>(p))) {
            caps_.clear();
            looseCaps_.clear();
            looseCaps_.resize(Dim + 2);  // closed on all sides: no loose vertices either
            return;
        }
    }
    for (const std::uint32_t i : neighbors_) {
        const Vec<Dim> to = spheres_[i].center - pivot.center;
        const double square = squaredLength(to);
        const double other = spheres_[i].radius + radius + settings_.quantum;
        if (square >= (rolling + other) * (rolling + other)) continue;
        const double distance = std::sqrt(square);
        add(to * (1 / distance),
            (square + rolling * rolling - other * other) / (2 * rolling * distance), i);
    }
}

/// A front begins with too few bodies for a vertex: then a candidate may rest on fewer.
template <int Dim>
void BlockFront<Dim>::Work::looseVertices(double) {
    const auto allowed = [&](const Vec<Dim>& n, std::size_t but) {
        for (std::size_t k = 0; k < looseCaps_.size(); ++k)
            if (k != but && dot(n, looseCaps_[k].first) > looseCaps_[k].second) return false;
        return true;
    };
    const auto emit = [&](const Vec<Dim>& n) {
        Vertex v;
        for (std::size_t d = 0; d < Dim; ++d) v.direction[d] = static_cast<float>(n.c[d]);
        v.bodies.fill(kNoBody);
        vertices_.push_back(v);
    };
    if (looseCaps_.size() > Dim) return;
    if (looseCaps_.empty()) emit(-settings_.sweep);
    if constexpr (Dim == 3) {
        constexpr int kAround = 16;
        for (std::size_t k = 0; k < looseCaps_.size(); ++k) {
            const auto& [axis, height] = looseCaps_[k];
            const Vec<3> other = std::fabs(axis[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
            const Vec<3> e1 = normalized(cross(axis, other));
            const Vec<3> e2 = cross(axis, e1);
            // A little off the cap: the candidate rests on the pivot alone and needs no polish.
            const double up = std::min(height, 1.0) - 1e-7;
            const double out = std::sqrt(std::max(0.0, 1 - up * up));
            for (int a = 0; a < kAround; ++a) {
                const double angle = 2 * kPi * a / kAround;
                const Vec<3> n = axis * up + (e1 * std::cos(angle) + e2 * std::sin(angle)) * out;
                if (allowed(n, k)) emit(n);
            }
        }
    }
}

template <int Dim>
bool BlockFront<Dim>::Work::polish(const Sphere<Dim>& pivot, double radius, const Vertex& vertex,
                                   Vec<Dim>& center) {
    const double slack = settings_.quantum;
    const double rolling = pivot.radius + radius + slack;
    Vec<Dim> n;
    for (std::size_t d = 0; d < Dim; ++d) n.c[d] = vertex.direction[d];
    center = pivot.center + normalized(n) * rolling;
    if (vertex.bodies[0] == kNoBody) return true;

    std::size_t wallBodies = 0, wallAt = 0;
    for (std::size_t b = 0; b < Dim - 1; ++b)
        if (vertex.bodies[b] >= kWallBody) ++wallBodies, wallAt = b;
    Plane tangent{};
    // One curved wall is followed to its true nearest point; two (a corner) are taken as planes.
    const int rounds = wallBodies == 1 ? 4 : 1;
    for (int round = 0; round < rounds; ++round) {
        const Vec<Dim> before = center;
        if (wallBodies == 1) {
            if (!findPlane(center, 2 * radius, pivot.center, tangent)) return false;
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
                    const Vec<Dim> away = center - spheres_[body].center;
                    const double d = length(away);
                    gradient[b + 1] = away * (1 / d);
                    residual[static_cast<int>(b) + 1] = spheres_[body].radius + radius + slack - d;
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
std::optional<Vec<Dim>> BlockFront<Dim>::Work::restingPlace(const Sphere<Dim>& pivot,
                                                            double radius) {
    const double rolling = pivot.radius + radius + settings_.quantum;
    for (;;) {
        buildCaps(pivot, radius);
        caps_.findVertices(vertices_);
        if (vertices_.empty()) looseVertices(radius);
        bool wallLearned = false;
        // Lowest along the sweep first.
        const auto key = [&](const Vertex& v) {
            double k = 0;
            for (std::size_t d = 0; d < Dim; ++d)
                k += static_cast<double>(v.direction[d]) * settings_.sweep.c[d];
            return k;
        };
        while (!vertices_.empty()) {
            std::size_t best = 0;
            double bestKey = key(vertices_[0]);
            for (std::size_t i = 1; i < vertices_.size(); ++i) {
                const double k = key(vertices_[i]);
                if (k < bestKey) bestKey = k, best = i;
            }
            const Vertex vertex = vertices_[best];
            vertices_[best] = vertices_.back();
            vertices_.pop_back();

            Vec<Dim> n;
            for (std::size_t d = 0; d < Dim; ++d) n.c[d] = vertex.direction[d];
            Vec<Dim> center = pivot.center + n * rolling;
            if (!own_.grown(0.01 * radius).contains(center)) continue;
            if (!polish(pivot, radius, vertex, center)) continue;
            center = snapped(center);
            if (!owns(center)) continue;
            bool free = squaredLength(center - pivot.center) >=
                        (pivot.radius + radius) * (pivot.radius + radius);
            for (std::size_t i = 0; free && i < neighbors_.size(); ++i) {
                const Sphere<Dim>& s = spheres_[neighbors_[i]];
                const double least = s.radius + radius;
                free = squaredLength(center - s.center) >= least * least;
            }
            if (!free) continue;
            Plane plane;
            if (!findPlane(center, radius, pivot.center, plane)) return center;
            // A wall that the pivot did not know: learn its plane and look again, unless the
            // plane does not forbid this vertex (then another round would find it once more).
            const double above = dot(pivot.center + n * rolling - plane.point, plane.normal);
            if (planes_.size() < kMaxPlanes && above < radius * (1 - 1e-4)) {
                planes_.push_back(plane);
                wallLearned = true;
                break;
            }
        }
        if (!wallLearned) return std::nullopt;
    }
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
    return sampler_->signedDistance(global) < 0 ? least : -least;
}

template <int Dim>
void BlockFront<Dim>::Work::searchPlaces() {
    // Large cells first: most of what lies outside the domain goes with them.
    const double edge = 8 * settings_.minRadius;
    int n[3] = {1, 1, 1};
    double step[3] = {0, 0, 0};
    double longest = 0;
    for (int d = 0; d < Dim; ++d) {
        const double side = search_.hi[d] - search_.lo[d];
        n[d] = std::max(1, static_cast<int>(std::ceil(side / edge)));
        step[d] = side / n[d];
        longest = std::max(longest, step[d]);
    }
    for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0] && !stop_; ++i) {
                const int at[3] = {i, j, k};
                Vec<Dim> center;
                for (int d = 0; d < Dim; ++d) center[d] = search_.lo[d] + (at[d] + 0.5) * step[d];
                searchCell(center, longest);
            }
}

template <int Dim>
void BlockFront<Dim>::Work::searchCell(const Vec<Dim>& center, double edge) {
    // No point of the cell is farther from its center than this, so none has more room than
    // the center has, plus this.
    const double corner = 0.5 * edge * std::sqrt(static_cast<double>(Dim));
    for (;;) {
        const double wanted = pool_->smallest();
        const double depth = -sampler_->signedDistance(center + origin_);
        if (depth < std::min(wanted - corner - settings_.fieldError, 0.99 * settings_.fieldDepth))
            return;
        const bool open =
            cells_.near(center, wanted - corner, settings_.maxRadius, [&](std::uint32_t i) {
                const double least = spheres_[i].radius + wanted - corner;
                return least <= 0 || squaredLength(spheres_[i].center - center) >= least * least;
            });
        if (!open) return;
        if (clearance(center, wanted) >= wanted) {
            const std::size_t before = spheres_.size();
            fillPlace(center);
            if (spheres_.size() == before || stop_) return;
            continue;  // the same cell may hold another place
        }
        if (edge < kSmallestCell * settings_.minRadius) return;
        for (int child = 0; child < (1 << Dim) && !stop_; ++child) {
            Vec<Dim> c = center;
            for (int d = 0; d < Dim; ++d) c[d] += (child >> d & 1 ? 0.25 : -0.25) * edge;
            searchCell(c, 0.5 * edge);
        }
        return;
    }
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
    const double radius = (*pool_)[fitting - 1];
    // Down the sweep until it touches something.
    for (int step = 0; step < 200; ++step) {
        const double free = clearance(x, far) - radius - settings_.quantum;
        if (free < 1e-6 * radius) break;
        const Vec<Dim> y = x - settings_.sweep * free;
        if (!owns(y)) break;
        x = y;
    }
    // Snapping moves the center by less than a quantum; step back where that was too much.
    Vec<Dim> center = snapped(x);
    for (int step = 0; step < 8 && clearance(center, far) < radius; ++step)
        center = snapped(x + settings_.sweep * (settings_.quantum * (2 << step)));
    if (!owns(center)) return;
    bool overlaps = false;
    cells_.near(center, radius, settings_.maxRadius, [&](std::uint32_t i) {
        const double least = spheres_[i].radius + radius;
        overlaps = overlaps || squaredLength(spheres_[i].center - center) < least * least;
        return true;
    });
    WallPoint<Dim> wall;
    if (overlaps || sampler_->nearestWall(center + origin_, radius, wall)) return;
    ++seeds_;
    place(center, radius);
    pool_->take(fitting - 1);
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
