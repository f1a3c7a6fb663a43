// Center and principal axes of solids.
#pragma once

#include "vdbpack/core/symmetric.h"
#include "vdbpack/core/vec.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdbpack {

/// Of a solid of the same density everywhere.
template <int Dim>
struct PrincipalAxes {
    Vec<Dim> center;     ///< of its volume, mm
    Matrix<Dim> axes{};  ///< unit vectors by falling spread; in space right-handed
    Vec<Dim> spread;     ///< standard deviation of its points along each axis, mm
    Vec<Dim> lengths;    ///< its extent along each axis, mm

    /// Whether the solid is longer along the first axis than across, unlike a ball or a cube.
    bool isLong() const { return spread[0] > 1.01 * spread[1]; }
};

/// Integrals over a solid of 1, x and x xᵀ.
template <int Dim>
struct SolidMoments {
    double volume = 0;
    Vec<Dim> first;
    Matrix<Dim> second{};

    /// Adds what has a volume and, about `x`, no extent.
    void add(double amount, const Vec<Dim>& x) {
        volume += amount;
        first += amount * x;
        for (int i = 0; i < Dim; ++i) second[static_cast<std::size_t>(i)] += amount * x[i] * x;
    }
    void add(const SolidMoments& other) {
        volume += other.volume;
        first += other.first;
        for (std::size_t i = 0; i < Dim; ++i) second[i] += other.second[i];
    }
    /// The axes, without lengths. @param origin  from which positions were taken, mm
    PrincipalAxes<Dim> axes(const Vec<Dim>& origin = {}) const {
        const Vec<Dim> mean = first * (1 / volume);
        Matrix<Dim> spread;
        for (int i = 0; i < Dim; ++i) {
            const auto row = static_cast<std::size_t>(i);
            spread[row] = second[row] * (1 / volume) - mean[i] * mean;
        }
        const EigenSystem<Dim> eigen = eigenSystem<Dim>(spread);
        PrincipalAxes<Dim> found;
        found.center = origin + mean;
        found.axes = eigen.vectors;
        if constexpr (Dim == 3) found.axes[2] = cross(found.axes[0], found.axes[1]);
        for (int i = 0; i < Dim; ++i) found.spread[i] = std::sqrt(std::max(0.0, eigen.values[i]));
        return found;
    }
};

}  // namespace vdbpack
