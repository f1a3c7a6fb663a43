// Points and directions in the plane and in space.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace vdbpack {

/// A point or a direction with `Dim` Cartesian components, mm unless said otherwise.
template <int Dim>
struct Vec {
    std::array<double, static_cast<std::size_t>(Dim)> c{};

    double& operator[](int i) { return c[static_cast<std::size_t>(i)]; }
    double operator[](int i) const { return c[static_cast<std::size_t>(i)]; }

    Vec& operator+=(const Vec& o) {
        for (int i = 0; i < Dim; ++i) (*this)[i] += o[i];
        return *this;
    }
    Vec& operator-=(const Vec& o) {
        for (int i = 0; i < Dim; ++i) (*this)[i] -= o[i];
        return *this;
    }
    Vec& operator*=(double s) {
        for (int i = 0; i < Dim; ++i) (*this)[i] *= s;
        return *this;
    }
    friend Vec operator+(Vec a, const Vec& b) { return a += b; }
    friend Vec operator-(Vec a, const Vec& b) { return a -= b; }
    friend Vec operator*(Vec a, double s) { return a *= s; }
    friend Vec operator*(double s, Vec a) { return a *= s; }
    friend Vec operator-(Vec a) { return a *= -1.0; }
    friend bool operator==(const Vec& a, const Vec& b) { return a.c == b.c; }
    friend bool operator!=(const Vec& a, const Vec& b) { return !(a == b); }
};

template <int Dim>
double dot(const Vec<Dim>& a, const Vec<Dim>& b) {
    double s = 0;
    for (int i = 0; i < Dim; ++i) s += a[i] * b[i];
    return s;
}

template <int Dim>
double squaredLength(const Vec<Dim>& a) {
    return dot(a, a);
}

template <int Dim>
double length(const Vec<Dim>& a) {
    return std::sqrt(dot(a, a));
}

/// `a` scaled to length one; the zero vector stays zero.
template <int Dim>
Vec<Dim> normalized(const Vec<Dim>& a) {
    const double l = length(a);
    return l > 0 ? a * (1.0 / l) : a;
}

inline Vec<3> cross(const Vec<3>& a, const Vec<3>& b) {
    return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

template <int Dim>
bool isFinite(const Vec<Dim>& a) {
    for (int i = 0; i < Dim; ++i)
        if (!std::isfinite(a[i])) return false;
    return true;
}

}  // namespace vdbpack
