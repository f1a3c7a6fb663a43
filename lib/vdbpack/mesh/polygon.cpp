#include "vdbpack/mesh/polygon.h"

#include "vdbpack/core/box.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdbpack {

namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Areas below this share of the square of a polygon's size are rounding.
constexpr double kFlatLoop = 1e-12;

double size2Of(const std::vector<Vec<3>>& corners) {
    Box<3> box;
    for (const auto& c : corners) box.add(c);
    return squaredLength(box.size());
}

Triangles fanOf(std::size_t corners) {
    Triangles triangles;
    for (std::uint32_t k = 2; k < corners; ++k) triangles.push_back({0, k - 1, k});
    return triangles;
}

/// Twice the area of a triangle of the plane; positive if it runs counterclockwise.
double turnOf(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// The corners in the plane across `normal`, from which they run counterclockwise.
std::vector<Vec<2>> projected(const std::vector<Vec<3>>& corners, const Vec<3>& normal) {
    const Vec<3> n = normalized(normal);
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (std::fabs(n[i]) < std::fabs(n[least])) least = i;
    Vec<3> axis{};
    axis[least] = 1;
    const Vec<3> u = normalized(cross(axis, n)), v = cross(n, u);
    std::vector<Vec<2>> points;
    points.reserve(corners.size());
    for (const auto& c : corners)
        points.push_back({{dot(c - corners.front(), u), dot(c - corners.front(), v)}});
    return points;
}

/// What is left of a polygon while its ears are cut off.
class EarCutter {
public:
    explicit EarCutter(std::vector<Vec<2>> points) : points_(std::move(points)) {
        const auto n = static_cast<std::uint32_t>(points_.size());
        for (const auto& p : points_) bounds_.add(p);
        flat_ = kFlatLoop * squaredLength(bounds_.size());
        before_.resize(n);
        after_.resize(n);
        pointsInward_.resize(n);
        for (std::uint32_t k = 0; k < n; ++k) {
            before_[k] = (k + n - 1) % n;
            after_[k] = (k + 1) % n;
        }
        std::vector<std::uint32_t> inward;
        for (std::uint32_t k = 0; k < n; ++k) {
            pointsInward_[k] = static_cast<char>(turnAt(k) <= flat_);
            if (pointsInward_[k] != 0) inward.push_back(k);
        }
        fillGrid(inward);
    }

    /// @return false if there is no ear at some point: the outline crosses itself.
    bool cut(Triangles& triangles) {
        auto left = static_cast<std::uint32_t>(points_.size());
        std::uint32_t at = 0, tried = 0;
        bool takeFlat = false;  // ears without area, once there are no others
        while (left > 3) {
            if (isEar(at, takeFlat)) {
                triangles.push_back({before_[at], at, after_[at]});
                at = remove(at);
                --left;
                tried = 0;
                takeFlat = false;
                continue;
            }
            at = after_[at];
            if (++tried < left) continue;
            if (takeFlat) return false;
            takeFlat = true;
            tried = 0;
        }
        triangles.push_back({before_[at], at, after_[at]});
        return turnAt(at) >= -flat_;
    }

private:
    double turnAt(std::uint32_t k) const {
        return turnOf(points_[before_[k]], points_[k], points_[after_[k]]);
    }

    /// Takes a corner out. @return the one after the next: ears in turn make thinner triangles.
    std::uint32_t remove(std::uint32_t k) {
        const std::uint32_t before = before_[k], after = after_[k];
        after_[before] = after;
        before_[after] = before;
        pointsInward_[k] = 0;
        for (const std::uint32_t neighbor : {before, after})
            if (turnAt(neighbor) > flat_) pointsInward_[neighbor] = 0;
        return after_[after];
    }

    bool isEar(std::uint32_t k, bool takeFlat) const {
        const double turn = turnAt(k);
        const std::uint32_t ka = before_[k], kc = after_[k];
        const Vec<2>&a = points_[ka], &b = points_[k], &c = points_[kc];
        if (takeFlat && std::fabs(turn) <= flat_) return true;
        if (!(turn > flat_)) return false;
        Box<2> box;
        for (const auto* p : {&a, &b, &c}) box.add(*p);
        for (int j = cellOf(box.lo[1], 1); j <= cellOf(box.hi[1], 1); ++j)
            for (int i = cellOf(box.lo[0], 0); i <= cellOf(box.hi[0], 0); ++i) {
                const auto cell = static_cast<std::size_t>(j * cells_ + i);
                for (std::uint32_t e = start_[cell]; e < start_[cell + 1]; ++e) {
                    const std::uint32_t other = inGrid_[e];
                    if (pointsInward_[other] == 0 || other == ka || other == k || other == kc)
                        continue;
                    const Vec<2>& p = points_[other];
                    if (p == a || p == b || p == c) continue;
                    if (turnOf(a, b, p) >= 0 && turnOf(b, c, p) >= 0 && turnOf(c, a, p) >= 0)
                        return false;
                }
            }
        return true;
    }

    int cellOf(double x, int axis) const {
        return static_cast<int>(std::clamp((x - bounds_.lo[axis]) * perLength_[axis], 0.0,
                                           static_cast<double>(cells_ - 1)));
    }
    std::size_t cellOf(const Vec<2>& p) const {
        return static_cast<std::size_t>(cellOf(p[1], 1) * cells_ + cellOf(p[0], 0));
    }
    /// Sorts the corners that point inward into about as many cells.
    void fillGrid(const std::vector<std::uint32_t>& inward) {
        cells_ = static_cast<int>(
            std::clamp(std::sqrt(static_cast<double>(inward.size())), 1.0, 1024.0));
        for (int d = 0; d < 2; ++d)
            perLength_[d] = bounds_.size()[d] > 0 ? cells_ / bounds_.size()[d] : 0;
        start_.assign(static_cast<std::size_t>(cells_) * static_cast<std::size_t>(cells_) + 1, 0);
        for (const std::uint32_t k : inward) ++start_[cellOf(points_[k]) + 1];
        for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
        auto next = start_;
        inGrid_.resize(inward.size());
        for (const std::uint32_t k : inward) inGrid_[next[cellOf(points_[k])]++] = k;
    }

    std::vector<Vec<2>> points_;
    Box<2> bounds_;
    double flat_ = 0;
    std::vector<std::uint32_t> before_, after_;
    std::vector<char> pointsInward_;  ///< or is on a line with its neighbors; 0 once cut off
    int cells_ = 1;
    Vec<2> perLength_{};
    std::vector<std::uint32_t> start_, inGrid_;
};

}  // namespace

PolygonSplit splitPolygon(const std::vector<Vec<3>>& corners, Triangles& triangles) {
    triangles = fanOf(corners.size());
    const auto normalOf = [&](const std::array<std::uint32_t, 3>& t) {
        return cross(corners[t[1]] - corners[t[0]], corners[t[2]] - corners[t[0]]);
    };
    Vec<3> normal{};
    double area = 0;
    for (const auto& t : triangles) {
        normal += normalOf(t);
        area += length(normalOf(t));
    }
    const double rounding = kFlatLoop * size2Of(corners);
    if (!(area > rounding)) return PolygonSplit::fan;  // a line, which has no inside
    const double size = length(normal);
    if (!(size > rounding)) return PolygonSplit::crossed;
    const bool covers = std::all_of(triangles.begin(), triangles.end(), [&](const auto& t) {
        return dot(normalOf(t), normal) >= -rounding * size;
    });
    if (covers) return PolygonSplit::fan;
    Triangles ears;
    ears.reserve(triangles.size());
    if (!EarCutter(projected(corners, normal)).cut(ears)) return PolygonSplit::crossed;
    triangles = std::move(ears);
    return PolygonSplit::ears;
}

}  // namespace vdbpack
