// Private to densify: the wall near each sphere, approximated by planes.
#pragma once

#include "vdbpack/core/parallel.h"
#include "vdbpack/densify/body.h"
#include "vdbpack/domain/domain.h"

#include <tbb/concurrent_vector.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdbpack {

/// A piece of wall: the domain lies where n (x - point) > 0.
struct WallPlane {
    float nx = 0, ny = 0, nz = 0;
    std::uint32_t x = 0, y = 0, z = 0;  ///< low bits of the point

    float distance(const Body& body) const {
        return nx * difference(body.x, x) + ny * difference(body.y, y) + nz * difference(body.z, z);
    }
    /// How far a ball whose center is at `distance` crosses the plane, divided by that distance.
    float overlap(float distance, float radius) const {
        return (radius - distance) * inverse(std::max(distance, 0.1f * radius));
    }
};

/// Planes for the spheres that are near a wall: queried once, then valid for a short way.
/// Lengths in quanta unless stated otherwise. Thread-safe for different spheres.
template <int Dim>
class WallPlanes {
public:
    static constexpr std::uint32_t kNone = 0xffffffff;
    static constexpr int kMostPlanes = 8;

    struct Wall {
        std::uint32_t count = 0;
        float seen = 0;                     ///< there is no other wall within this distance
        std::uint32_t x = 0, y = 0, z = 0;  ///< of this position
        std::array<WallPlane, kMostPlanes> planes;

        const WallPlane* begin() const { return planes.data(); }
        const WallPlane* end() const { return planes.data() + count; }
    };
    /// What is known about the wall near a sphere.
    struct Vicinity {
        std::uint32_t wall = kNone;  ///< its number; kNone: no wall is near
        float roam = -1;             ///< way that the sphere may go before the next query
    };

    /// @param domain   must outlive this.
    /// @param quantum  mm.
    WallPlanes(const Domain<Dim>& domain, double quantum);
    ~WallPlanes();

    const Wall& operator[](std::uint32_t wall) const { return walls_[wall]; }

    /// Takes over a wall that is known elsewhere. @return its number
    std::uint32_t add(const Wall& wall) {
        return static_cast<std::uint32_t>(walls_.push_back(wall) - walls_.begin());
    }

    /// How far a sphere may go along a wall before the next query, in its radii.
    void setSlide(float slide) { slide_ = slide; }
    /// Whether a sphere that has used up its way needs a new query.
    /// @param margin  a wall farther from the sphere's surface than this need not be known.
    bool isDue(const Body& body, const Vicinity& vicinity, float margin) const;
    /// Queries the wall around a sphere at `home`, and how far it may go from there.
    void ask(const Home& home, const Body& body, float margin, Vicinity& vicinity);
    /// Whether the sphere, enlarged by the factor `grow`, lies inside by the exact wall.
    bool allows(const Home& home, const Body& body, double grow);

    /// In mm.
    Vec<Dim> position(const Home& home) const;
    DomainSampler<Dim>& sampler() { return *asker().sampler; }

private:
    /// What a thread queries with.
    struct Asker {
        std::unique_ptr<DomainSampler<Dim>> sampler;
        std::vector<WallPoint<Dim>> points;
    };
    Asker& asker();
    /// Adds planes for `points` (nearest first) that no plane before covers.
    /// @param x, radius  of the sphere, mm and quanta. @param within  whether x is inside.
    void addPlanes(const Vec<Dim>& x, double radius, bool within,
                   std::vector<WallPoint<Dim>>& points, Wall& wall) const;

    const Domain<Dim>& domain_;
    double quantum_;
    double fieldError_, fieldDepth_;
    float slide_ = 0.3f;
    tbb::concurrent_vector<Wall> walls_;
    PerThread<Asker> askers_;
};

}  // namespace vdbpack
