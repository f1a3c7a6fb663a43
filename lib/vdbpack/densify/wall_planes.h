// Private to densify: the wall near each sphere, as planes that hold it in.
#pragma once

#include "vdbpack/densify/octet.h"
#include "vdbpack/domain/domain.h"

#include <tbb/concurrent_vector.h>
#include <tbb/enumerable_thread_specific.h>

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
    /// How far a ball whose center is that far away crosses it, as a share of that.
    float overlap(float distance, float radius) const {
        return (radius - distance) / std::max(distance, 0.1f * radius);
    }
};

/// Planes for the spheres that are near a wall: asked for once, then good for a short way.
/// Lengths in quanta unless they say otherwise. Questions may come from many threads.
template <int Dim>
class WallPlanes {
public:
    static constexpr std::uint32_t kNone = 0xffffffff;
    static constexpr int kMostPlanes = 8;

    struct Wall {
        std::uint32_t count = 0;
        float seen = 0;                     ///< no wall but these planes was nearer than that,
        std::uint32_t x = 0, y = 0, z = 0;  ///< from here
        std::array<WallPlane, kMostPlanes> planes;

        const WallPlane* begin() const { return planes.data(); }
        const WallPlane* end() const { return planes.data() + count; }
    };
    /// What is known of a sphere's wall.
    struct Place {
        std::uint32_t wall = kNone;  ///< its number; none: none is near
        float roam = -1;             ///< way that it may go before it must ask
    };

    /// @param domain   must outlive this.
    /// @param quantum  mm.
    WallPlanes(const Domain<Dim>& domain, double quantum);
    ~WallPlanes();

    const Wall& operator[](std::uint32_t wall) const { return walls_[wall]; }

    /// How far a sphere goes along a wall before it asks anew, in its radii.
    void setSlide(float slide) { slide_ = slide; }
    /// Whether a sphere that has used up its way must ask again.
    /// @param margin  gap to the wall from which on the wall need not be known.
    bool isDue(const Body& body, const Place& place, float margin) const;
    /// Asks for the wall about a sphere at `home`, and tells how far it may go from there.
    void ask(const Home& home, const Body& body, float margin, Place& place);
    /// Whether the wall itself lets the sphere be there, larger by the factor `grow`.
    bool allows(const Home& home, const Body& body, double grow);

    /// In mm.
    Vec<Dim> position(const Home& home) const;
    DomainSampler<Dim>& sampler() { return *asker().sampler; }

private:
    /// What a thread asks with.
    struct Asker {
        std::unique_ptr<DomainSampler<Dim>> sampler;
        std::vector<WallPoint<Dim>> points;
    };
    Asker& asker();

    const Domain<Dim>& domain_;
    double quantum_;
    double fieldError_, fieldDepth_;
    float slide_ = 0.3f;
    tbb::concurrent_vector<Wall> walls_;
    tbb::enumerable_thread_specific<Asker> askers_;
};

extern template class WallPlanes<2>;
extern template class WallPlanes<3>;

}  // namespace vdbpack
