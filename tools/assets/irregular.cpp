#include "irregular.h"

#include <cmath>
#include <cstdint>
#include <memory>

namespace vdbpack {

namespace {

using V = Vec<3>;

/// Bumps of one size: their spacing and height, mm.
struct Octave {
    double spacing;
    double height;
};
constexpr Octave kOctaves[] = {{21, 9}, {10, 3.6}, {6, 1.2}};
// An upper bound of the slope of ball and bumps together, which turns values into distances.
constexpr double kSteepest = 2;

// Uniform in -1 .. 1, determined by the corner of a lattice and the octave.
double valueAt(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t octave) {
    std::uint64_t h = 0x9e3779b97f4a7c15u * (octave + 1);
    for (const std::int64_t c : {x, y, z}) {
        h ^= static_cast<std::uint64_t>(c);
        h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
        h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
        h ^= h >> 31;
    }
    return static_cast<double>(h >> 11) * 0x1p-52 - 1;
}

// Values of a lattice with edge 1, blended so that slope and curvature have no steps.
// Source: the fade of Perlin (2002), doi:10.1145/566570.566636.
double noise(const V& p, std::uint64_t octave) {
    std::int64_t at[3];
    double fade[3];
    for (int i = 0; i < 3; ++i) {
        const double cell = std::floor(p[i]);
        const double t = p[i] - cell;
        at[i] = static_cast<std::int64_t>(cell);
        fade[i] = t * t * t * (t * (t * 6 - 15) + 10);
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        std::int64_t c[3];
        for (int i = 0; i < 3; ++i) {
            const int up = (corner >> i) & 1;
            c[i] = at[i] + up;
            weight *= up ? fade[i] : 1 - fade[i];
        }
        sum += weight * valueAt(c[0], c[1], c[2], octave);
    }
    return sum;
}

class LumpyBall : public Shape {
public:
    explicit LumpyBall(double radius) : radius_(radius) {
        for (const Octave& o : kOctaves) reach_ += o.height;
    }
    double distance(const Vec<3>& p) const override {
        double surface = radius_;
        std::uint64_t octave = 0;
        for (const Octave& o : kOctaves) {
            surface += o.height * noise(p * (1 / o.spacing), octave);
            ++octave;
        }
        return (length(p) - surface) / kSteepest;
    }
    Box<3> bounds() const override {
        return {Box<3>::filled(-radius_ - reach_), Box<3>::filled(radius_ + reach_)};
    }

private:
    double radius_;
    double reach_ = 0;
};

}  // namespace

Sculpture irregular() {
    Sculpture s;
    s.add(std::make_shared<LumpyBall>(28.0), 0);
    // A bite of a third of the size of the body, and two pits narrower than deep.
    s.cut(ellipsoid({{19, -17, 12}}, {{12, 12, 12}}), 5);
    s.cut(roundTube({{{{-34, -8, 12}}, 6.5}, {{{-18, -5, 7}}, 5}, {{{-10, -4, 3}}, 4}}), 4);
    s.cut(roundTube({{{{-6, -36, -14}}, 7}, {{{-4, -20, -10}}, 5.5}, {{{2, -10, -8}}, 4}}), 4);
    return s;
}

}  // namespace vdbpack
