// The walls that the spheres of a block know of.
#pragma once

#include "vdbpack/pack/front/block_state.h"

#include <cstdint>
#include <vector>

namespace vdbpack {

/// Tangent planes of the wall near spheres: what is pivoted about a sphere meets its planes.
template <int Dim>
class FrontWalls {
public:
    void clear() {
        planes_.clear();
        first_.clear();
    }
    /// The next sphere, which knows no wall yet.
    void addSphere() { first_.push_back(kNone); }

    /// Adds a plane to those that a sphere knows. @return its index.
    std::uint32_t add(std::uint32_t sphere, const TangentPlane<Dim>& plane) {
        planes_.push_back({plane, first_[sphere]});
        return first_[sphere] = static_cast<std::uint32_t>(planes_.size() - 1);
    }
    const TangentPlane<Dim>& operator[](std::uint32_t plane) const { return planes_[plane].plane; }

    /// Calls `visit(index, plane)` for the planes that a sphere knows, the latest first.
    template <class Visit>
    void forEach(std::uint32_t sphere, const Visit& visit) const {
        for (std::uint32_t p = first_[sphere]; p != kNone; p = planes_[p].next)
            visit(p, planes_[p].plane);
    }
    int count(std::uint32_t sphere) const {
        int n = 0;
        forEach(sphere, [&](std::uint32_t, const TangentPlane<Dim>&) { ++n; });
        return n;
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    struct Known {
        TangentPlane<Dim> plane;
        std::uint32_t next;  ///< of the same sphere
    };
    std::vector<Known> planes_;
    std::vector<std::uint32_t> first_;  ///< of each sphere
};

}  // namespace vdbpack
