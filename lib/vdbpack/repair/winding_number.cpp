#include "vdbpack/repair/winding_number.h"

#include "vdbpack/core/sphere.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbpack {

namespace {

constexpr std::uint32_t kLeafTriangles = 8;
/// Clusters further away than this many of their reaches count by their moments.
constexpr double kFar = 2;

/// Which products of coordinates the second moments stand for.
constexpr std::array<std::array<int, 3>, 10> kSecond{{{{0, 0, 0}},
                                                      {{1, 1, 1}},
                                                      {{2, 2, 2}},
                                                      {{0, 0, 1}},
                                                      {{0, 0, 2}},
                                                      {{1, 1, 0}},
                                                      {{1, 1, 2}},
                                                      {{2, 2, 0}},
                                                      {{2, 2, 1}},
                                                      {{0, 1, 2}}}};

/// A sum of angles between -pi and pi as a product of complex numbers: one arc tangent for all.
class AngleSum {
public:
    /// Adds the angle of (x, y).
    void add(double x, double y) {
        const double re = re_ * x - im_ * y, im = re_ * y + im_ * x;
        // Two angles of one sign that add up to more than half a turn change it.
        if (im_ >= 0 && y >= 0 && im < 0) ++turns_;
        if (im_ < 0 && y < 0 && im >= 0) --turns_;
        re_ = re;
        im_ = im;
    }
    double value() const { return std::atan2(im_, re_) + 2 * kPi * turns_; }

private:
    double re_ = 1, im_ = 0;
    int turns_ = 0;
};

/// Adds half the solid angle of a triangle seen from the origin.
void addHalfSolidAngle(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, AngleSum& sum) {
    const double la = length(a), lb = length(b), lc = length(c);
    const double above = dot(a, cross(b, c));
    const double below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    if (above == 0 && below <= 0) return;  // in the plane of the triangle, or on its rim
    sum.add(below, above);
}

}  // namespace

WindingNumber::WindingNumber(const TriangleMesh& mesh) {
    if (!mesh.vertices.empty()) origin_ = mesh.bounds().center();
    triangles_.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles)
        triangles_.push_back({mesh.vertices[t[0]] - origin_, mesh.vertices[t[1]] - origin_,
                              mesh.vertices[t[2]] - origin_});
    if (triangles_.empty()) return;
    clusters_.reserve(triangles_.size() / 2 + 1);
    Cluster all;
    all.end = static_cast<std::uint32_t>(triangles_.size());
    clusters_.push_back(all);
    // Every cluster is split after those before it: no recursion, the same tree each time.
    for (std::uint32_t i = 0; i < clusters_.size(); ++i) build(i);
    for (Cluster& cluster : clusters_) summarize(cluster);
}

void WindingNumber::build(std::uint32_t index) {
    Cluster& cluster = clusters_[index];
    if (cluster.end - cluster.begin <= kLeafTriangles) return;
    const auto centroid = [](const Triangle& t, int axis) {
        return t.a[axis] + t.b[axis] + t.c[axis];
    };
    Box<3> box;
    for (std::uint32_t i = cluster.begin; i < cluster.end; ++i) {
        const Triangle& t = triangles_[i];
        box.add({{centroid(t, 0), centroid(t, 1), centroid(t, 2)}});
    }
    const Vec<3> size = box.size();
    const int axis =
        static_cast<int>(std::max_element(size.c.begin(), size.c.end()) - size.c.begin());
    const std::uint32_t middle = cluster.begin + (cluster.end - cluster.begin) / 2;
    std::nth_element(triangles_.begin() + cluster.begin, triangles_.begin() + middle,
                     triangles_.begin() + cluster.end, [&](const Triangle& s, const Triangle& t) {
                         return centroid(s, axis) < centroid(t, axis);
                     });
    Cluster lower, upper;
    lower.begin = cluster.begin;
    lower.end = upper.begin = middle;
    upper.end = cluster.end;
    cluster.children = static_cast<std::uint32_t>(clusters_.size());
    clusters_.push_back(lower);
    clusters_.push_back(upper);
}

void WindingNumber::summarize(Cluster& cluster) const {
    double total = 0;
    Vec<3> weighted, plain;
    for (std::uint32_t i = cluster.begin; i < cluster.end; ++i) {
        const Triangle& t = triangles_[i];
        const Vec<3> n = cross(t.b - t.a, t.c - t.a) * 0.5;
        const Vec<3> middle = (t.a + t.b + t.c) * (1.0 / 3);
        const double area = length(n);
        total += area;
        weighted += middle * area;
        plain += middle;
        cluster.area += n;
    }
    cluster.center = total > 0 ? weighted * (1 / total)
                               : plain * (1.0 / static_cast<double>(cluster.end - cluster.begin));
    double reach = 0;
    for (std::uint32_t index = cluster.begin; index < cluster.end; ++index) {
        const Triangle& t = triangles_[index];
        const Vec<3> n = cross(t.b - t.a, t.c - t.a) * 0.5;
        const std::array<Vec<3>, 3> corners{t.a - cluster.center, t.b - cluster.center,
                                            t.c - cluster.center};
        const Vec<3> middle = (corners[0] + corners[1] + corners[2]) * (1.0 / 3);
        cluster.trace += dot(n, middle);
        const auto first = [&](int i, int k) { return n[i] * middle[k] + n[k] * middle[i]; };
        for (int i = 0; i < 3; ++i) {
            cluster.first[static_cast<std::size_t>(i)] += 0.5 * first(i, i);
            cluster.first[static_cast<std::size_t>(3 + i)] += 0.5 * first(i, (i + 1) % 3);
        }
        // Mean of d d^T over the triangle.
        const auto mean = [&](int i, int k) {
            double sum = 9 * middle[i] * middle[k];
            for (const Vec<3>& d : corners) sum += d[i] * d[k];
            return sum / 12;
        };
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k)
                cluster.contracted[i] += 2 * n[k] * mean(k, i) + n[i] * mean(k, k);
        const auto second = [&](int i, int j, int k) {
            return (n[i] * mean(j, k) + n[j] * mean(i, k) + n[k] * mean(i, j)) / 3;
        };
        for (std::size_t m = 0; m < kSecond.size(); ++m)
            cluster.second[m] += second(kSecond[m][0], kSecond[m][1], kSecond[m][2]);
        for (const Vec<3>& corner : {t.a, t.b, t.c})
            reach = std::max(reach, squaredLength(corner - cluster.center));
    }
    cluster.reach = std::sqrt(reach);
}

double WindingNumber::operator()(const Vec<3>& point) const {
    if (clusters_.empty()) return 0;
    const Vec<3> x = point - origin_;
    double halves = 0, quarters = 0;  // solid angle / 2, solid angle
    std::array<std::uint32_t, 64> waiting;
    std::size_t count = 0;
    waiting[count++] = 0;
    while (count > 0) {
        const Cluster& cluster = clusters_[waiting[--count]];
        const Vec<3> r = cluster.center - x;
        const double squared = squaredLength(r);
        if (squared > kFar * kFar * cluster.reach * cluster.reach) {
            // n A . r / |r|^3, and its first and second change over the cluster.
            const double inverse2 = 1 / squared;
            const double inverse3 = inverse2 * std::sqrt(inverse2);
            const double x0 = r[0], y0 = r[1], z0 = r[2];
            const auto& f = cluster.first;
            const double once = x0 * x0 * f[0] + y0 * y0 * f[1] + z0 * z0 * f[2] +
                                2 * (x0 * y0 * f[3] + y0 * z0 * f[4] + z0 * x0 * f[5]);
            const auto& s = cluster.second;
            const double twice = x0 * x0 * (x0 * s[0] + 3 * (y0 * s[3] + z0 * s[4])) +
                                 y0 * y0 * (y0 * s[1] + 3 * (x0 * s[5] + z0 * s[6])) +
                                 z0 * z0 * (z0 * s[2] + 3 * (x0 * s[7] + y0 * s[8])) +
                                 6 * x0 * y0 * z0 * s[9];
            quarters +=
                inverse3 * (dot(cluster.area, r) + cluster.trace - 3 * once * inverse2 +
                            1.5 * inverse2 * (5 * inverse2 * twice - dot(cluster.contracted, r)));
        } else if (cluster.children != 0) {
            waiting[count++] = cluster.children;
            waiting[count++] = cluster.children + 1;
        } else {
            AngleSum sum;
            for (std::uint32_t i = cluster.begin; i < cluster.end; ++i) {
                const Triangle& t = triangles_[i];
                addHalfSolidAngle(t.a - x, t.b - x, t.c - x, sum);
            }
            halves += sum.value();
        }
    }
    return (2 * halves + quarters) / (4 * kPi);
}

}  // namespace vdbpack
