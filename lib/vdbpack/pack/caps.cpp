#include "vdbpack/pack/caps.h"

#include "vdbpack/pack/lanes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vdbpack {

namespace {

/// How deep inside another cap a vertex may seem to lie: above the rounding of the vertex on its
/// own caps, far below what matters; the decision is made in double.
constexpr float kSlack = 2e-5f;
/// Cap circles whose axes are this close to (anti)parallel, by 1 - cos², cross too flatly.
constexpr float kParallel = 1e-5f;

}  // namespace

template <int Dim>
void CapSet<Dim>::clear() {
    count_ = 0;
}

template <int Dim>
bool CapSet<Dim>::add(const std::array<float, Dim>& axis, float height, std::uint32_t body) {
    if (height >= 1.0f) return true;
    if (height <= -1.0f) return false;
    if (count_ == body_.size()) {
        const std::size_t room = padded(2 * count_ + 64);
        for (auto& a : axis_) a.resize(room);
        height_.resize(room);
        body_.resize(room);
    }
    for (std::size_t d = 0; d < Dim; ++d) axis_[d][count_] = axis[d];
    height_[count_] = height;
    body_[count_++] = body;
    return true;
}

template <int Dim>
void CapSet<Dim>::pad() {
    // Padding caps forbid nothing: height 2 is beyond every direction and crosses no circle.
    for (std::size_t i = count_; i < padded(count_); ++i) {
        for (auto& a : axis_) a[i] = 0.0f;
        height_[i] = 2.0f;
    }
}

template <int Dim>
void CapSet<Dim>::sort() {
    // By height, then in the order of adding: heights lie in (-1, 1), and the bits of a positive
    // float rise with its value.
    keys_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
        const float positive = height_[i] + 2.0f;
        std::uint32_t bits;
        std::memcpy(&bits, &positive, sizeof bits);
        keys_[i] = std::uint64_t{bits} << 32 | i;
    }
    std::sort(keys_.begin(), keys_.end());
    scratch_.resize(count_);
    const auto arrange = [&](std::vector<float>& values) {
        for (std::size_t i = 0; i < count_; ++i) scratch_[i] = values[keys_[i] & 0xffffffffu];
        std::copy(scratch_.begin(), scratch_.end(), values.begin());
    };
    for (auto& a : axis_) arrange(a);
    arrange(height_);
    bodyScratch_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) bodyScratch_[i] = body_[keys_[i] & 0xffffffffu];
    std::copy(bodyScratch_.begin(), bodyScratch_.end(), body_.begin());
}

/// Appends the caps from `from` on whose boundary crosses that of cap `i`.
template <int Dim>
void CapSet<Dim>::findPairs(std::size_t i, std::size_t from) {
    const Lanes ax = axis_[0][i], ay = axis_[1][i], az = axis_[Dim - 1][i], ah = height_[i];
    if (pairs_.size() < pairCount_ + count_) pairs_.resize(2 * (pairCount_ + count_));
    for (std::size_t j0 = from / kLanes * kLanes; j0 < count_; j0 += kLanes) {
        const Lanes c =
            ax * load(&axis_[0][j0]) + ay * load(&axis_[1][j0]) + az * load(&axis_[Dim - 1][j0]);
        const Lanes bh = load(&height_[j0]);
        // With c = cos of the angle between the axes, the circles cross where
        // 1 - c² - h_i² - h_j² + 2 c h_i h_j > 0.
        const Lanes d = 1.0f - c * c;
        const Lanes crossing = stdx::min(d - ah * ah - bh * bh + 2.0f * c * ah * bh, d - kParallel);
        auto live = crossing > 0.0f;
        if (j0 < from)
            for (std::size_t l = 0; l < from - j0; ++l) live[l] = false;
        forEachSet(live, [&](std::size_t l) {
            pairs_[pairCount_++] = {static_cast<std::uint32_t>(i),
                                    static_cast<std::uint32_t>(j0 + l)};
        });
    }
}

/// Appends the vertices of `pairs_` that no cap forbids.
template <int Dim>
void CapSet<Dim>::keepLive(std::vector<Vertex>& vertices) {
    const float* const ux = axis_[0].data();
    const float* const uy = axis_[1].data();
    const float* const uz = axis_[Dim - 1].data();
    const float* const h = height_.data();
    for (std::size_t p0 = 0; p0 < pairCount_; p0 += kLanes) {
        const std::size_t used = std::min(kLanes, pairCount_ - p0);
        // The two vertices of a pair are middle + side and middle - side.
        Lanes mx, my, mz, wx, wy, wz;
        float a[4][kLanes], b[4][kLanes];
        for (std::size_t l = 0; l < kLanes; ++l) {
            const auto& pair = pairs_[p0 + std::min(l, used - 1)];
            const std::size_t i = pair[0], j = pair[1];
            a[0][l] = ux[i], a[1][l] = uy[i], a[2][l] = uz[i], a[3][l] = h[i];
            b[0][l] = ux[j], b[1][l] = uy[j], b[2][l] = uz[j], b[3][l] = h[j];
        }
        const Lanes ax = load(a[0]), ay = load(a[1]), az = load(a[2]), ah = load(a[3]);
        if constexpr (Dim == 3) {
            const Lanes bx = load(b[0]), by = load(b[1]), bz = load(b[2]), bh = load(b[3]);
            const Lanes c = ax * bx + ay * by + az * bz;
            const Lanes inverse = 1.0f / (1.0f - c * c);
            const Lanes alpha = (ah - bh * c) * inverse;
            const Lanes beta = (bh - ah * c) * inverse;
            const Lanes square = (1.0f - alpha * ah - beta * bh) * inverse;
            const Lanes gamma = sqrt(stdx::max(square, Lanes(0.0f)));
            mx = alpha * ax + beta * bx, wx = gamma * (ay * bz - az * by);
            my = alpha * ay + beta * by, wy = gamma * (az * bx - ax * bz);
            mz = alpha * az + beta * bz, wz = gamma * (ax * by - ay * bx);
        } else {
            const Lanes gamma = sqrt(stdx::max(1.0f - ah * ah, Lanes(0.0f)));
            mx = ah * ax, wx = -gamma * ay;
            my = ah * ay, wy = gamma * ax;
        }
        Lanes up = kSlack, down = kSlack;  // least room to any cap, so far
        for (std::size_t k = 0; k < count_; ++k) {
            Lanes middle = h[k] + kSlack - (mx * ux[k] + my * uy[k]);
            Lanes side = wx * ux[k] + wy * uy[k];
            if constexpr (Dim == 3) {
                middle -= mz * uz[k];
                side += wz * uz[k];
            }
            up = stdx::min(up, middle - side);
            down = stdx::min(down, middle + side);
            if ((k & 1) && none_of(stdx::max(up, down) >= 0.0f)) break;
        }
        if (none_of(stdx::max(up, down) >= 0.0f)) continue;
        for (std::size_t l = 0; l < used; ++l) {
            const auto& pair = pairs_[p0 + l];
            const auto emit = [&](float s) {
                Vertex v;
                v.direction[0] = mx[l] + s * wx[l];
                v.direction[1] = my[l] + s * wy[l];
                v.bodies[0] = body_[pair[0]];
                if constexpr (Dim == 3) {
                    v.direction[2] = mz[l] + s * wz[l];
                    v.bodies[1] = body_[pair[1]];
                }
                v.side = s;
                vertices.push_back(v);
            };
            if (up[l] >= 0.0f) emit(1.0f);
            if (down[l] >= 0.0f) emit(-1.0f);
        }
    }
}

template <int Dim>
void CapSet<Dim>::findVertices(std::vector<Vertex>& vertices) {
    vertices.clear();
    sort();
    pad();
    pairCount_ = 0;
    if constexpr (Dim == 3) {
        for (std::size_t i = 0; i + 1 < count_; ++i) findPairs(i, i + 1);
    } else {
        if (pairs_.size() < count_) pairs_.resize(2 * count_);
        for (std::uint32_t i = 0; i < count_; ++i) pairs_[pairCount_++] = {i, i};
    }
    keepLive(vertices);
}

template <int Dim>
bool CapSet<Dim>::addLater(const std::array<float, Dim>& axis, float height, std::uint32_t body,
                           std::vector<Vertex>& vertices) {
    if (height >= 1.0f) return true;
    if (height <= -1.0f) {
        vertices.clear();
        return false;
    }
    vertices.erase(std::remove_if(vertices.begin(), vertices.end(),
                                  [&](const Vertex& v) {
                                      float along = 0;
                                      for (std::size_t d = 0; d < Dim; ++d)
                                          along += v.direction[d] * axis[d];
                                      return along > height + kSlack;
                                  }),
                   vertices.end());
    add(axis, height, body);
    pad();
    pairCount_ = 0;
    const std::size_t last = count_ - 1;
    if constexpr (Dim == 3) {
        findPairs(last, 0);  // never crosses itself: too parallel
    } else {
        if (pairs_.empty()) pairs_.resize(1);
        pairs_[pairCount_++] = {static_cast<std::uint32_t>(last), static_cast<std::uint32_t>(last)};
    }
    keepLive(vertices);
    return true;
}

template class CapSet<2>;
template class CapSet<3>;

}  // namespace vdbpack
