#include "vdbpack/measure/stiffness.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Smallest share of the largest eigenvalue of a stiffness that has an inverse.
constexpr double kSingular = 1e-6;
/// Starts lie on a lattice from -kStarts to kStarts; first and last step of a search.
constexpr int kStarts = 2;
constexpr double kFirstStep = 0.125, kLastStep = 1e-5;

/// The direction of the smallest value: descends from many directions in steps along the axes.
template <int Dim, class Value>
Vec<Dim> lowestDirection(const Value& value) {
    Vec<Dim> best;
    double least = 0;
    constexpr int kAcross = 2 * kStarts + 1;
    const int count = static_cast<int>(std::pow(kAcross, Dim));
    // Opposite directions are one: the second half of the lattice has one of each.
    for (int code = count / 2 + 1; code < count; ++code) {
        Vec<Dim> at;
        for (int i = 0, rest = code; i < Dim; ++i, rest /= kAcross)
            at[i] = rest % kAcross - kStarts;
        at = normalized(at);
        double here = value(at);
        for (double step = kFirstStep; step > kLastStep;) {
            bool moved = false;
            for (int way = 0; way < 2 * Dim; ++way) {
                Vec<Dim> next = at;
                next[way / 2] += way % 2 ? step : -step;
                next = normalized(next);
                const double there = value(next);
                if (!(there < here)) continue;
                at = next;
                here = there;
                moved = true;
            }
            if (!moved) step *= 0.5;
        }
        if (length(best) > 0 && !(here < least)) continue;
        best = at;
        least = here;
    }
    return best;
}

}  // namespace

template <int Dim>
std::optional<ModulusRatio> modulusRatio(const Matrix<Dim*(Dim + 1) / 2>& stiffness) {
    constexpr int kSize = Dim * (Dim + 1) / 2;
    const auto eigen = eigenSystem<kSize>(stiffness);
    if (!(eigen.values[kSize - 1] > kSingular * eigen.values[0])) return std::nullopt;
    const auto compliance = [&](const Vec<Dim>& d) {
        const auto strain = mandelDyad(d);
        double sum = 0;
        for (std::size_t k = 0; k < kSize; ++k) {
            const double along = dot(eigen.vectors[k], strain);
            sum += along * along / eigen.values.c[k];
        }
        return sum;
    };
    Vec<Dim> stiff = lowestDirection<Dim>(compliance);
    const auto soft = lowestDirection<Dim>([&](const Vec<Dim>& d) { return -compliance(d); });
    const auto isSmaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
    if (*std::max_element(stiff.c.begin(), stiff.c.end(), isSmaller) < 0) stiff *= -1;
    ModulusRatio result{compliance(soft) / compliance(stiff), {}};
    std::copy(stiff.c.begin(), stiff.c.end(), result.direction.c.begin());
    return result;
}

template std::optional<ModulusRatio> modulusRatio<2>(const Matrix<3>&);
template std::optional<ModulusRatio> modulusRatio<3>(const Matrix<6>&);

}  // namespace vdbpack
