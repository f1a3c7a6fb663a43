#include "sculpture.h"

#include "vdbpack/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

// Pieces a spline's span is cut into; finer makes no visible difference at the voxels used.
constexpr int kPiecesPerSpan = 8;
// A mirrored solid is rounded over this distance from the mirror plane, mm: shapes that reach
// it at an angle would otherwise leave a crease.
constexpr double kMirrorRounding = 1.5;

double square(double x) {
    return x * x;
}

double catmullRom(double a, double b, double c, double d, double t) {
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

Vec<3> catmullRom(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d, double t) {
    Vec<3> r;
    for (int i = 0; i < 3; ++i) r[i] = catmullRom(a[i], b[i], c[i], d[i], t);
    return r;
}

double distanceToBox(const Box<3>& box, const Vec<3>& p) {
    double s = 0;
    for (int i = 0; i < 3; ++i)
        s += square(std::max(0.0, std::max(box.lo[i] - p[i], p[i] - box.hi[i])));
    return std::sqrt(s);
}

// First-order distance to an ellipsoid: exact at the surface and linear around it.
// Source: the quotient of a function and its gradient's length, as for any implicit surface
// (Taubin 1994, doi:10.1145/195784.195786), with k0 = |p / radii| and its gradient.
double ellipsoidDistance(const Vec<3>& p, const Vec<3>& radii) {
    double k0 = 0;
    double k1 = 0;
    double smallest = radii[0];
    for (int i = 0; i < 3; ++i) {
        const double q = p[i] / radii[i];
        k0 += q * q;
        k1 += square(q / radii[i]);
        smallest = std::min(smallest, radii[i]);
    }
    if (k1 < 1e-18) return -smallest;
    k0 = std::sqrt(k0);
    return k0 * (k0 - 1) / std::sqrt(k1);
}

class Ellipsoid : public Shape {
public:
    Ellipsoid(const Vec<3>& center, const Vec<3>& radii, const Frame& frame)
        : center_(center), radii_(radii), frame_(frame) {}

    double distance(const Vec<3>& p) const override {
        const Vec<3> d = p - center_;
        return ellipsoidDistance({{dot(d, frame_.x), dot(d, frame_.y), dot(d, frame_.z)}}, radii_);
    }
    Box<3> bounds() const override {
        Box<3> box;
        Vec<3> half;
        for (int i = 0; i < 3; ++i)
            half[i] = std::sqrt(square(frame_.x[i] * radii_[0]) + square(frame_.y[i] * radii_[1]) +
                                square(frame_.z[i] * radii_[2]));
        box.add(center_ - half);
        box.add(center_ + half);
        return box;
    }

private:
    Vec<3> center_, radii_;
    Frame frame_;
};

class Tube : public Shape {
public:
    Tube(const std::vector<Section>& sections, Profile profile) : profile_(profile) {
        const int count = static_cast<int>(sections.size());
        if (count < 2) throw ParameterError("tube: fewer than two sections");
        const auto at = [&](int i) -> const Section& {
            return sections[static_cast<std::size_t>(std::clamp(i, 0, count - 1))];
        };
        for (int i = 0; i + 1 < count; ++i) {
            const bool last = i + 2 == count;
            for (int k = 0; k < kPiecesPerSpan + (last ? 1 : 0); ++k) {
                const double t = double(k) / kPiecesPerSpan;
                const Section &a = at(i - 1), &b = at(i), &c = at(i + 1), &d = at(i + 2);
                Section s;
                s.center = catmullRom(a.center, b.center, c.center, d.center, t);
                // A spline through radii may undershoot where they fall steeply.
                const double least =
                    0.5 * std::min({b.halfWidth, b.halfDepth, c.halfWidth, c.halfDepth});
                s.halfWidth = std::max(
                    least, catmullRom(a.halfWidth, b.halfWidth, c.halfWidth, d.halfWidth, t));
                s.halfDepth = std::max(
                    least, catmullRom(a.halfDepth, b.halfDepth, c.halfDepth, d.halfDepth, t));
                s.across = normalized(catmullRom(a.across, b.across, c.across, d.across, t));
                nodes_.push_back(s);
            }
        }
        // Each node gets the tangent of its neighbors, so that frames turn without steps.
        const std::size_t n = nodes_.size();
        tangents_.resize(n);
        for (std::size_t i = 0; i < n; ++i)
            tangents_[i] = normalized(nodes_[std::min(i + 1, n - 1)].center -
                                      nodes_[i > 0 ? i - 1 : 0].center);
        for (std::size_t i = 0; i + 1 < n; i += kPiecesPerSpan) {
            Span span{i, std::min(i + kPiecesPerSpan, n - 1), {}, 0};
            span.center = (nodes_[span.first].center + nodes_[span.last].center) * 0.5;
            for (std::size_t k = span.first; k <= span.last; ++k)
                span.radius = std::max(span.radius, length(nodes_[k].center - span.center));
            spans_.push_back(span);
        }
        for (const Section& s : nodes_) {
            const double r = std::max(s.halfWidth, s.halfDepth);
            bounds_.add(s.center - Box<3>::filled(r));
            bounds_.add(s.center + Box<3>::filled(r));
        }
    }

    double distance(const Vec<3>& p) const override {
        std::size_t best = 0;
        double bestSquared = std::numeric_limits<double>::infinity();
        for (const Span& span : spans_) {
            if (square(std::max(0.0, length(p - span.center) - span.radius)) >= bestSquared)
                continue;
            for (std::size_t i = span.first; i < span.last; ++i) {
                const Vec<3> axis = nodes_[i + 1].center - nodes_[i].center;
                const Vec<3> d = p - nodes_[i].center;
                const double t = std::clamp(dot(d, axis) / squaredLength(axis), 0.0, 1.0);
                const double s = squaredLength(d - axis * t);
                if (s < bestSquared) {
                    bestSquared = s;
                    best = i;
                }
            }
        }
        // The foot of the perpendicular, by tangents that turn evenly along the spline: with chords
        // only, their corners would show on the surface.
        const auto ahead = [&](std::size_t i) { return dot(p - nodes_[i].center, tangents_[i]); };
        for (int i = 0; i < 3; ++i) {
            if (ahead(best) < 0 && best > 0)
                --best;
            else if (ahead(best + 1) > 0 && best + 2 < nodes_.size())
                ++best;
            else
                break;
        }
        double bestT;
        const double before = ahead(best), after = ahead(best + 1);
        if (before >= 0 && after <= 0 && before - after > 0)
            bestT = before / (before - after);
        else
            bestT = before < 0 ? 0.0 : 1.0;
        const Section &a = nodes_[best], &b = nodes_[best + 1];
        const auto mix = [&](double x, double y) { return x + bestT * (y - x); };
        const double width = mix(a.halfWidth, b.halfWidth);
        const double depth = mix(a.halfDepth, b.halfDepth);
        const double chord = length(b.center - a.center);
        const double t = bestT, u1 = 1 - t;
        const Vec<3> center =
            a.center * (u1 * u1 * (1 + 2 * t)) + tangents_[best] * (chord * t * u1 * u1) +
            b.center * (t * t * (3 - 2 * t)) - tangents_[best + 1] * (chord * t * t * u1);
        const Vec<3> d = p - center;
        const Vec<3> along =
            normalized(tangents_[best] + bestT * (tangents_[best + 1] - tangents_[best]));
        const Frame f = Frame::of(along, a.across + bestT * (b.across - a.across));
        const bool end = (best == 0 && bestT == 0) || (best + 2 == nodes_.size() && bestT == 1);
        // Inside the tube a remainder along its axis is an error of the interpolation.
        const double u = dot(d, f.x), v = dot(d, f.y), w = end ? dot(d, f.z) : 0.0;
        const double cap = std::min(width, depth);
        if (profile_ == Profile::kEllipse)
            return ellipsoidDistance({{u, v, w}}, {{width, depth, cap}});
        const double flat =
            std::max(0.0, std::abs(width > depth ? u : v) - std::abs(width - depth));
        return std::sqrt(flat * flat + square(width > depth ? v : u) + w * w) - cap;
    }
    Box<3> bounds() const override { return bounds_; }

private:
    Profile profile_;
    std::vector<Section> nodes_;
    std::vector<Vec<3>> tangents_;
    // Balls around runs of chords: most runs need no closer look.
    struct Span {
        std::size_t first, last;  // chords
        Vec<3> center;
        double radius;
    };
    std::vector<Span> spans_;
    Box<3> bounds_;
};

class BentPlate : public Shape {
public:
    explicit BentPlate(const Plate& p) : plate_(p) {
        const int count = static_cast<int>(p.outline.size());
        if (count < 3) throw ParameterError("plate: fewer than three outline points");
        const auto at = [&](int i) {
            return p.outline[static_cast<std::size_t>((i + count) % count)];
        };
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < kPiecesPerSpan; ++k) {
                const double t = double(k) / kPiecesPerSpan;
                const auto a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
                outline_.push_back(
                    {catmullRom(a[0], b[0], c[0], d[0], t), catmullRom(a[1], b[1], c[1], d[1], t)});
            }
        for (const auto& uv : outline_) {
            const double h = p.height(uv[0], uv[1]);
            const double t = p.halfThickness(uv[0], uv[1]);
            const Vec<3> q = p.origin + p.frame.x * uv[0] + p.frame.y * uv[1] + p.frame.z * h;
            bounds_.add(q - Box<3>::filled(t));
            bounds_.add(q + Box<3>::filled(t));
        }
        // The middle may bulge out of the box around the rim: sample it on a lattice too.
        double lo[2] = {1e30, 1e30}, hi[2] = {-1e30, -1e30};
        for (const auto& uv : outline_)
            for (int k = 0; k < 2; ++k) {
                lo[k] = std::min(lo[k], uv[static_cast<std::size_t>(k)]);
                hi[k] = std::max(hi[k], uv[static_cast<std::size_t>(k)]);
            }
        constexpr int kLattice = 24;
        for (int i = 0; i <= kLattice; ++i)
            for (int j = 0; j <= kLattice; ++j) {
                const double u = lo[0] + (hi[0] - lo[0]) * i / kLattice;
                const double v = lo[1] + (hi[1] - lo[1]) * j / kLattice;
                if (outlineDistance(u, v) > 0) continue;
                const Vec<3> q =
                    p.origin + p.frame.x * u + p.frame.y * v + p.frame.z * p.height(u, v);
                const double t = 1.5 * p.halfThickness(u, v);
                bounds_.add(q - Box<3>::filled(t));
                bounds_.add(q + Box<3>::filled(t));
            }
    }

    double distance(const Vec<3>& p) const override {
        const Vec<3> d = p - plate_.origin;
        const double u = dot(d, plate_.frame.x), v = dot(d, plate_.frame.y);
        const double h0 = plate_.height(u, v);
        const double e = 0.5;
        const double du = (plate_.height(u + e, v) - plate_.height(u - e, v)) / (2 * e);
        const double dv = (plate_.height(u, v + e) - plate_.height(u, v - e)) / (2 * e);
        // A slope stretches heights; dividing by its length gives the distance to first order.
        const double height = (dot(d, plate_.frame.z) - h0) / std::sqrt(1 + du * du + dv * dv);
        const double half = plate_.halfThickness(u, v);
        const double rim = std::max(0.0, outlineDistance(u, v) + half);
        return std::sqrt(rim * rim + height * height) - half;
    }
    Box<3> bounds() const override { return bounds_; }

private:
    // Signed distance in the plane: nearest edge, sign by crossings.
    double outlineDistance(double u, double v) const {
        double best = std::numeric_limits<double>::infinity();
        bool inside = false;
        for (std::size_t i = 0, j = outline_.size() - 1; i < outline_.size(); j = i++) {
            const double ax = outline_[j][0], ay = outline_[j][1];
            const double bx = outline_[i][0] - ax, by = outline_[i][1] - ay;
            const double px = u - ax, py = v - ay;
            const double t = std::clamp((px * bx + py * by) / (bx * bx + by * by), 0.0, 1.0);
            best = std::min(best, square(px - t * bx) + square(py - t * by));
            const bool above = py >= 0, endAbove = py - by >= 0;
            if (above != endAbove && (px * by - py * bx < 0) == (by > 0)) inside = !inside;
        }
        return inside ? -std::sqrt(best) : std::sqrt(best);
    }

    Plate plate_;
    std::vector<std::array<double, 2>> outline_;
    Box<3> bounds_;
};

class Inset : public Shape {
public:
    Inset(std::shared_ptr<const Sculpture> s, double inset)
        : sculpture_(std::move(s)), inset_(inset), bounds_(sculpture_->bounds().grown(-inset)) {}
    double distance(const Vec<3>& p) const override { return sculpture_->distance(p) + inset_; }
    Box<3> bounds() const override { return bounds_; }

private:
    std::shared_ptr<const Sculpture> sculpture_;
    double inset_;
    Box<3> bounds_;
};

// The smaller of two values with the corner rounded by a parabola over |a - b| < k.
double roundedMin(double a, double b, double k) {
    const double h = std::max(0.0, k - std::abs(a - b));
    return std::min(a, b) - (k > 0 ? h * h / (4 * k) : 0.0);
}

}  // namespace

Frame Frame::of(const Vec<3>& along, const Vec<3>& across) {
    Frame f;
    f.z = normalized(along);
    f.x = normalized(across - f.z * dot(across, f.z));
    f.y = cross(f.z, f.x);
    return f;
}

ShapePtr ellipsoid(const Vec<3>& center, const Vec<3>& radii, const Frame& frame) {
    return std::make_shared<Ellipsoid>(center, radii, frame);
}

ShapePtr tube(const std::vector<Section>& sections, Profile profile) {
    return std::make_shared<Tube>(sections, profile);
}

ShapePtr roundTube(const std::vector<Bead>& beads) {
    // A round section needs no particular direction, only one that the tube never runs along.
    Box<3> box;
    for (const Bead& b : beads) box.add(b.center);
    int shortest = 0;
    for (int i = 1; i < 3; ++i)
        if (box.size()[i] < box.size()[shortest]) shortest = i;
    Vec<3> across;
    across[shortest] = 1;
    std::vector<Section> sections;
    for (const Bead& b : beads) sections.push_back({b.center, b.radius, b.radius, across});
    return tube(sections);
}

ShapePtr plate(const Plate& p) {
    return std::make_shared<BentPlate>(p);
}

Sculpture& Sculpture::join(Join how, ShapePtr shape, double blend) {
    const Box<3> box = shape->bounds();
    steps_.push_back({how, std::move(shape), blend, box});
    return *this;
}

double Sculpture::distance(const Vec<3>& point) const {
    Vec<3> p = point;
    if (mirrored_) {
        const double x = std::abs(p[0]);
        p[0] = x < kMirrorRounding ? 0.5 * (x * x / kMirrorRounding + kMirrorRounding) : x;
    }
    double d = 1e9;
    for (const Step& s : steps_) {
        // A shape is at least as far away as its box; most are too far to matter.
        const double far = distanceToBox(s.bounds, p);
        const auto near = [&] {
            const double own = s.shape->distance(p);
            return far > 0 ? std::max(far, own) : own;
        };
        if (s.how == Join::kAdd) {
            if (far >= d + s.blend) continue;
            d = roundedMin(d, near(), s.blend);
        } else {
            if (far >= s.blend - d) continue;
            d = -roundedMin(-d, near(), s.blend);
        }
    }
    return d;
}

Vec<3> Sculpture::gradient(const Vec<3>& p) const {
    constexpr double kStep = 0.05;  // mm; well under the smallest feature
    // Four corners of a tetrahedron: second order as central differences, at two thirds the cost.
    Vec<3> g;
    for (const Vec<3>& corner :
         {Vec<3>{{1, -1, -1}}, Vec<3>{{-1, -1, 1}}, Vec<3>{{-1, 1, -1}}, Vec<3>{{1, 1, 1}}})
        g += corner * (distance(p + corner * kStep) / (4 * kStep));
    return g;
}

Box<3> Sculpture::bounds() const {
    Box<3> box;
    for (const Step& s : steps_)
        if (s.how == Join::kAdd) {
            box.add(s.bounds.lo);
            box.add(s.bounds.hi);
        }
    if (mirrored_ && !box.empty()) {
        const double x = std::max(std::abs(box.lo[0]), std::abs(box.hi[0]));
        box.lo[0] = -x;
        box.hi[0] = x;
    }
    double margin = 0;
    for (const Step& s : steps_) margin = std::max(margin, s.blend);
    return box.empty() ? box : box.grown(0.25 * margin);
}

ShapePtr insetOf(std::shared_ptr<const Sculpture> sculpture, double inset) {
    return std::make_shared<Inset>(std::move(sculpture), inset);
}

}  // namespace vdbpack
