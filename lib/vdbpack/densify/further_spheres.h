// Private to densify: radii and regions of the spheres that are added to a pack.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/densify/densify.h"

#include <cstdint>
#include <map>
#include <vector>

namespace vdbpack {

/// Spheres to be added, in random order.
struct FurtherSpheres {
    std::vector<double> radii;          ///< mm
    std::vector<std::int32_t> regions;  ///< empty: all are in one region
};

/// Draws the further spheres of a stage.
inline RandomStream furtherStream(std::uint64_t seed, std::uint64_t stage) {
    return {seed ^ 0x64656e73696679ull, stage};
}

template <int Dim>
std::vector<Sphere<Dim>> grownBy(double shell, std::vector<Sphere<Dim>> spheres) {
    for (auto& s : spheres) s.radius += shell;
    return spheres;
}

/// Draws further spheres, such that all spheres together follow the size distribution, and every
/// region keeps its share of the volume.
template <int Dim>
class FurtherSizes {
public:
    /// @param spheres  the first pack: its moving spheres have the sizes to be kept.
    /// @param options  must outlive this.
    FurtherSizes(const std::vector<Sphere<Dim>>& spheres, const DensifyOptions& options);

    /// Radii of the moving spheres, sorted, mm.
    const std::vector<double>& radii() const { return radii_; }

    /// Spheres of a total volume (2D: area) of at least `volume` mm^Dim.
    FurtherSpheres draw(double volume, RandomStream& random) const;

private:
    double quantile(const std::vector<double>& own, double u) const;
    std::vector<double> counted() const;
    std::vector<double> missing(double count) const;
    std::vector<double> missingWithVolume(double volume, const std::vector<double>& own) const;
    std::vector<double> drawRadii(double volume, const std::vector<double>& own,
                                  RandomStream& random) const;

    /// The moving spheres of a region: radii, sorted, mm; and their volume, mm^Dim.
    struct Region {
        std::vector<double> radii;
        double volume = 0;
    };
    const DensifyOptions& options_;
    std::vector<double> radii_;
    std::map<std::int32_t, Region> regions_;
};

}  // namespace vdbpack
