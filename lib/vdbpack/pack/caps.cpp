#include "vdbpack/pack/caps.h"

#include <algorithm>
#include <cmath>
#include <experimental/simd>
#include <numeric>

namespace vdbpack {

namespace {

namespace stdx = std::experimental;

/// Eight lanes on every machine, whatever its registers: the same pack everywhere.
constexpr std::size_t kLanes = 8;
using Lanes = stdx::fixed_size_simd<float, kLanes>;

/// How deep inside another cap a vertex may seem to lie: above the rounding of the vertex on its
/// own caps, far below what matters; the decision is made in double.
constexpr float kSlack = 2e-5f;
/// Cap circles whose axes are this close to (anti)parallel, by 1 - cos², cross too flatly.
constexpr float kParallel = 1e-5f;

Lanes load(const float* p) {
    return Lanes(p, stdx::element_aligned);
}

std::size_t paddedSize(std::size_t n) {
    return (n + kLanes - 1) / kLanes * kLanes;
}

}  // namespace

template <int Dim>
void CapSet<Dim>::clear() {
    count_ = 0;
    for (auto& a : axis_) a.clear();
    height_.clear();
    body_.clear();
}

template <int Dim>
bool CapSet<Dim>::add(const std::array<float, Dim>& axis, float height, std::uint32_t body) {
    if (height >= 1.0f) return true;
    if (height <= -1.0f) return false;
    for (std::size_t d = 0; d < Dim; ++d) axis_[d].push_back(axis[d]);
    height_.push_back(height);
    body_.push_back(body);
    ++count_;
    return true;
}

template <int Dim>
void CapSet<Dim>::sortAndPad() {
    rank_.resize(count_);
    std::iota(rank_.begin(), rank_.end(), 0u);
    std::sort(rank_.begin(), rank_.end(), [&](std::uint32_t a, std::uint32_t b) {
        return height_[a] < height_[b] || (height_[a] == height_[b] && body_[a] < body_[b]);
    });
    const auto arrange = [&](auto& values, auto& scratch) {
        scratch.resize(count_);
        for (std::size_t i = 0; i < count_; ++i) scratch[i] = values[rank_[i]];
        values.swap(scratch);
    };
    // Padding caps forbid nothing: height 2 is beyond every direction.
    for (auto& a : axis_) {
        arrange(a, scratch_);
        a.resize(paddedSize(count_), 0.0f);
    }
    arrange(height_, scratch_);
    height_.resize(paddedSize(count_), 2.0f);
    arrange(body_, bodyScratch_);
}

template <int Dim>
void CapSet<Dim>::findVertices(std::vector<Vertex>& vertices) {
    vertices.clear();
    if (count_ < Dim - 1) return;
    sortAndPad();
    if constexpr (Dim == 3) {
        const float* const ux = axis_[0].data();
        const float* const uy = axis_[1].data();
        const float* const uz = axis_[2].data();
        const float* const h = height_.data();

        // Pairs of circles that cross.
        pairs_.clear();
        for (std::size_t i = 0; i + 1 < count_; ++i) {
            const Lanes ax = ux[i], ay = uy[i], az = uz[i], ah = h[i];
            for (std::size_t j0 = (i + 1) / kLanes * kLanes; j0 < count_; j0 += kLanes) {
                const Lanes c = ax * load(ux + j0) + ay * load(uy + j0) + az * load(uz + j0);
                const Lanes bh = load(h + j0);
                // (1 - c²) γ² D = 1 - c² - h_i² - h_j² + 2 c h_i h_j > 0 where the circles cross.
                const Lanes d = 1.0f - c * c;
                const auto crossing = (d - ah * ah - bh * bh + 2.0f * c * ah * bh > 0.0f) &&
                                      (d > kParallel) && (bh < 1.0f);
                if (none_of(crossing)) continue;
                for (std::size_t l = j0 > i ? 0 : i + 1 - j0; l < kLanes; ++l)
                    if (crossing[l])
                        pairs_.push_back(
                            {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j0 + l)});
            }
        }

        for (std::size_t p0 = 0; p0 < pairs_.size(); p0 += kLanes) {
            const std::size_t used = std::min(kLanes, pairs_.size() - p0);
            alignas(32) float a[4][kLanes], b[4][kLanes];
            for (std::size_t l = 0; l < kLanes; ++l) {
                const auto& pair = pairs_[p0 + std::min(l, used - 1)];
                const std::size_t i = pair[0], j = pair[1];
                a[0][l] = ux[i], a[1][l] = uy[i], a[2][l] = uz[i], a[3][l] = h[i];
                b[0][l] = ux[j], b[1][l] = uy[j], b[2][l] = uz[j], b[3][l] = h[j];
            }
            const Lanes ax = load(a[0]), ay = load(a[1]), az = load(a[2]), ah = load(a[3]);
            const Lanes bx = load(b[0]), by = load(b[1]), bz = load(b[2]), bh = load(b[3]);
            const Lanes c = ax * bx + ay * by + az * bz;
            const Lanes inverse = 1.0f / (1.0f - c * c);
            const Lanes alpha = (ah - bh * c) * inverse;
            const Lanes beta = (bh - ah * c) * inverse;
            const Lanes square = (1.0f - alpha * ah - beta * bh) * inverse;
            const Lanes gamma = sqrt(stdx::max(square, Lanes(0.0f)));
            const Lanes mx = alpha * ax + beta * bx, wx = gamma * (ay * bz - az * by);
            const Lanes my = alpha * ay + beta * by, wy = gamma * (az * bx - ax * bz);
            const Lanes mz = alpha * az + beta * bz, wz = gamma * (ax * by - ay * bx);
            Lanes::mask_type up(false), down(false);
            for (std::size_t l = 0; l < used; ++l) up[l] = down[l] = true;
            for (std::size_t k = 0; k < count_; ++k) {
                const Lanes middle = mx * ux[k] + my * uy[k] + mz * uz[k];
                const Lanes side = wx * ux[k] + wy * uy[k] + wz * uz[k];
                const Lanes limit(h[k] + kSlack);
                up = up && (middle + side <= limit);
                down = down && (middle - side <= limit);
                if (none_of(up || down)) break;
            }
            if (none_of(up || down)) continue;
            for (std::size_t l = 0; l < used; ++l) {
                const auto& pair = pairs_[p0 + l];
                const std::array<std::uint32_t, 2> bodies{body_[pair[0]], body_[pair[1]]};
                if (up[l])
                    vertices.push_back({{mx[l] + wx[l], my[l] + wy[l], mz[l] + wz[l]}, bodies});
                if (down[l])
                    vertices.push_back({{mx[l] - wx[l], my[l] - wy[l], mz[l] - wz[l]}, bodies});
            }
        }
    } else {
        const float* const ux = axis_[0].data();
        const float* const uy = axis_[1].data();
        const float* const h = height_.data();
        for (std::size_t i0 = 0; i0 < count_; i0 += kLanes) {
            const Lanes ax = load(ux + i0), ay = load(uy + i0), ah = load(h + i0);
            const Lanes gamma = sqrt(stdx::max(1.0f - ah * ah, Lanes(0.0f)));
            const Lanes mx = ah * ax, wx = -gamma * ay;
            const Lanes my = ah * ay, wy = gamma * ax;
            Lanes::mask_type up = ah <= 1.0f;
            Lanes::mask_type down = up;
            for (std::size_t k = 0; k < count_; ++k) {
                const Lanes middle = mx * ux[k] + my * uy[k];
                const Lanes side = wx * ux[k] + wy * uy[k];
                const Lanes limit(h[k] + kSlack);
                up = up && (middle + side <= limit);
                down = down && (middle - side <= limit);
                if (none_of(up || down)) break;
            }
            if (none_of(up || down)) continue;
            for (std::size_t l = 0; l < kLanes; ++l) {
                if (up[l]) vertices.push_back({{mx[l] + wx[l], my[l] + wy[l]}, {body_[i0 + l]}});
                if (down[l]) vertices.push_back({{mx[l] - wx[l], my[l] - wy[l]}, {body_[i0 + l]}});
            }
        }
    }
}

template class CapSet<2>;
template class CapSet<3>;

}  // namespace vdbpack
