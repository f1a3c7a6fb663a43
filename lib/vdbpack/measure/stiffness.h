// Private to measure: how the stiffness of a network of contacts depends on the direction.
#pragma once

#include "vdbpack/core/symmetric.h"
#include "vdbpack/core/vec.h"

#include <array>
#include <cstddef>
#include <optional>

namespace vdbpack {

/// n⊗n in Mandel's notation: n_p n_q for p <= q, times the root of two where p < q, so that the dot
/// product of two of them is the contraction of two tensors.
template <int Dim>
Vec<Dim*(Dim + 1) / 2> mandelDyad(const Vec<Dim>& n) {
    Vec<Dim*(Dim + 1) / 2> dyad;
    std::size_t k = 0;
    for (int p = 0; p < Dim; ++p)
        for (int q = p; q < Dim; ++q)
            dyad.c[k++] = n[p] * n[q] * (p == q ? 1 : 1.41421356237309504880);
    return dyad;
}

/// Young's modulus E(d) = 1 / (S_ijkl d_i d_j d_k d_l) of a stiffness whose inverse is S.
struct ModulusRatio {
    double ratio;      ///< largest / smallest E over all directions
    Vec<3> direction;  ///< of the largest, of length one; the largest component is positive
};

/// @param stiffness  in Mandel's notation, to any scale.
/// @return nothing if some strain meets (almost) no resistance, as in a simple cubic lattice.
///
/// Accuracy: the ratio to 1e-6 of itself. Of several directions as stiff, any.
template <int Dim>
std::optional<ModulusRatio> modulusRatio(const Matrix<Dim*(Dim + 1) / 2>& stiffness);

}  // namespace vdbpack
