#include "vdbpack/pack/front/touching.h"

#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

constexpr int kSteps = 3;

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
bool moveToTouch(const std::array<Contact<Dim>, static_cast<std::size_t>(Dim)>& contacts,
                 double precision, double farthest, Vec<Dim>& center) {
    for (int step = 0; step < kSteps; ++step) {
        std::array<Vec<Dim>, Dim> gradient;
        Vec<Dim> missing;
        for (std::size_t k = 0; k < Dim; ++k) {
            const Contact<Dim>& contact = contacts[k];
            const Vec<Dim> from = center - contact.at;
            const double now = contact.flat ? dot(from, contact.normal) : length(from);
            gradient[k] = contact.flat ? contact.normal : from * (1 / now);
            missing.c[k] = contact.distance - now;
        }
        if (!solve<Dim>(gradient, missing)) return false;
        center += missing;
        const double moved = squaredLength(missing);
        if (!(moved < farthest * farthest)) return false;
        if (moved < 0.01 * precision * precision) break;
    }
    return true;
}

template bool moveToTouch<2>(const std::array<Contact<2>, 2>&, double, double, Vec<2>&);
template bool moveToTouch<3>(const std::array<Contact<3>, 3>&, double, double, Vec<3>&);

}  // namespace vdbpack
