// Sample points of a domain.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

/// One sampler per thread.
template <int Dim>
class Samplers {
public:
    explicit Samplers(const Domain<Dim>& domain)
        : samplers_([&domain] { return domain.sampler(); }) {}
    DomainSampler<Dim>& local() { return *samplers_.local(); }

private:
    PerThread<std::unique_ptr<DomainSampler<Dim>>> samplers_;
};

/// The additive recurrence of lowest discrepancy in `Dim` dimensions, shifted at random.
/// Source: Roberts (2018), "The unreasonable effectiveness of quasirandom sequences": steps are
/// powers of 1/g, where g^(Dim+1) = g + 1.
template <int Dim>
class Spread {
public:
    explicit Spread(std::uint64_t seed) {
        RandomStream stream(0, seed);
        for (int i = 0; i < Dim; ++i) at_[i] = stream.uniform();
    }
    /// The next point of the unit cube.
    const Vec<Dim>& next() {
        constexpr double g = Dim == 2 ? 1.32471795724474602596 : 1.22074408460575947536;
        double step = 1;
        for (int i = 0; i < Dim; ++i) {
            step /= g;
            at_[i] += step;
            if (at_[i] >= 1) at_[i] -= 1;
        }
        return at_;
    }

private:
    Vec<Dim> at_;
};

/// The unit cube onto the unit ball (2D: disc), volumes in proportion.
template <int Dim>
Vec<Dim> ballPoint(const Vec<Dim>& u) {
    if constexpr (Dim == 2) {
        const double r = std::sqrt(u[0]), a = 2 * kPi * u[1];
        return {{r * std::cos(a), r * std::sin(a)}};
    } else {
        const double r = std::cbrt(u[0]), a = 2 * kPi * u[1], z = 1 - 2 * u[2];
        const double s = std::sqrt(std::max(0.0, 1 - z * z));
        return {{r * s * std::cos(a), r * s * std::sin(a), r * z}};
    }
}

/// A long run of evenly spread points in the unit ball, of which every part is spread as evenly.
template <int Dim>
class BallPoints {
public:
    explicit BallPoints(std::size_t count) {
        points_.reserve(count);
        Spread<Dim> spread(0);
        while (points_.size() < count) points_.push_back(ballPoint<Dim>(spread.next()));
    }
    /// Calls `work(x)` for `count` points of a sphere: for each seed another part of the run,
    /// mirrored at other axes.
    template <class Work>
    void visit(const Sphere<Dim>& sphere, std::uint64_t seed, std::size_t count,
               const Work& work) const {
        const std::uint64_t bits = mix64(seed);
        const Vec<Dim>* point = points_.data() + (bits >> Dim) % (points_.size() - count + 1);
        Vec<Dim> scale;
        for (int i = 0; i < Dim; ++i) scale[i] = bits >> i & 1 ? sphere.radius : -sphere.radius;
        for (std::size_t k = 0; k < count; ++k) {
            Vec<Dim> x = sphere.center;
            for (int i = 0; i < Dim; ++i) x[i] += scale[i] * point[k][i];
            work(x);
        }
    }

private:
    std::vector<Vec<Dim>> points_;
};

}  // namespace vdbpack
