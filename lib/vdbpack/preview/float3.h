// Private to previews: vectors in single precision, and sample points.
#pragma once

#include "vdbpack/core/vec.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace vdbpack {

struct Float3 {
    float x = 0, y = 0, z = 0;
    friend Float3 operator+(const Float3& a, const Float3& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend Float3 operator-(const Float3& a, const Float3& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend Float3 operator*(const Float3& a, float s) { return {a.x * s, a.y * s, a.z * s}; }
    Float3 operator-() const { return {-x, -y, -z}; }
    float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
};
inline float dot(const Float3& a, const Float3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Float3 normalized(const Float3& a) {
    const float square = dot(a, a);
    return square > 0 ? a * (1 / std::sqrt(square)) : a;
}
inline Float3 cross(const Float3& a, const Float3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Float3 single(const Vec<3>& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}
/// Two unit vectors orthogonal to `n` and to each other: Duff et al. (2017), "Building an
/// orthonormal basis, revisited", JCGT 6(1).
inline void basis(const Float3& n, Float3& s, Float3& t) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z), b = n.x * n.y * a;
    s = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
}

/// Point `n` of the first two dimensions of Sobol's sequence: every aligned block of 2^k points is
/// a net in base 2.
inline std::array<float, 2> sobol(std::uint32_t n, std::uint32_t scramble0,
                                  std::uint32_t scramble1) {
    std::uint32_t a = 0, b = 0, direction = 1u << 31;
    for (std::uint32_t bit = 0, v = n; v != 0; ++bit, v >>= 1) {
        if (v & 1) {
            a ^= 1u << (31 - bit);
            b ^= direction;
        }
        direction ^= direction >> 1;
    }
    const auto unit = [](std::uint32_t v) { return static_cast<float>(v >> 8) * 0x1p-24f; };
    return {unit(a ^ scramble0), unit(b ^ scramble1)};
}

}  // namespace vdbpack
