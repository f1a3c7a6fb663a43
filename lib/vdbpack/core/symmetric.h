// Eigenvalues of small symmetric matrices.
#pragma once

#include "vdbpack/core/vec.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace vdbpack {

/// A symmetric Dim x Dim matrix, by rows.
template <int Dim>
using Matrix = std::array<Vec<Dim>, static_cast<std::size_t>(Dim)>;

template <int Dim>
struct EigenSystem {
    Vec<Dim> values;      ///< falling
    Matrix<Dim> vectors;  ///< of length one, by value; the largest component is positive
};

/// Eigenvalues and eigenvectors of a symmetric matrix, to rounding, by Jacobi rotations
/// (Golub, Van Loan: Matrix Computations, 8.5).
template <int Dim>
EigenSystem<Dim> eigenSystem(Matrix<Dim> m) {
    Matrix<Dim> v{};
    for (std::size_t i = 0; i < Dim; ++i) v[i].c[i] = 1;
    for (int sweep = 0; sweep < 50; ++sweep) {
        double off = 0, all = 0;
        for (std::size_t i = 0; i < Dim; ++i)
            for (std::size_t j = 0; j < Dim; ++j) (i == j ? all : off) += m[i].c[j] * m[i].c[j];
        if (!(off > 1e-32 * all)) break;
        for (std::size_t p = 0; p < Dim; ++p)
            for (std::size_t q = p + 1; q < Dim; ++q) {
                if (m[p].c[q] == 0) continue;
                const double theta = (m[q].c[q] - m[p].c[p]) / (2 * m[p].c[q]);
                const double t =
                    std::copysign(1.0, theta) / (std::fabs(theta) + std::hypot(theta, 1.0));
                const double c = 1 / std::hypot(t, 1.0), s = t * c;
                for (std::size_t k = 0; k < Dim; ++k) {
                    const double a = m[k].c[p], b = m[k].c[q];
                    m[k].c[p] = c * a - s * b;
                    m[k].c[q] = s * a + c * b;
                }
                for (std::size_t k = 0; k < Dim; ++k) {
                    const double a = m[p].c[k], b = m[q].c[k];
                    m[p].c[k] = c * a - s * b;
                    m[q].c[k] = s * a + c * b;
                }
                for (std::size_t k = 0; k < Dim; ++k) {
                    const double a = v[p].c[k], b = v[q].c[k];
                    v[p].c[k] = c * a - s * b;
                    v[q].c[k] = s * a + c * b;
                }
            }
    }
    EigenSystem<Dim> e;
    for (std::size_t i = 0; i < Dim; ++i) e.values.c[i] = m[i].c[i];
    e.vectors = v;
    for (std::size_t i = 0; i < Dim; ++i) {
        for (std::size_t j = i + 1; j < Dim; ++j)
            if (e.values.c[j] > e.values.c[i]) {
                std::swap(e.values.c[i], e.values.c[j]);
                std::swap(e.vectors[i], e.vectors[j]);
            }
        double most = 0;
        for (const double x : e.vectors[i].c)
            if (std::fabs(x) > std::fabs(most) * (1 + 1e-9)) most = x;
        if (most < 0) e.vectors[i] *= -1;
    }
    return e;
}

}  // namespace vdbpack
