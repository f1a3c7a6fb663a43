#include "vdbpack/measure/morphometry/morphometry.h"

#include "vdbpack/core/error.h"
#include "vdbpack/measure/morphometry/border.h"
#include "vdbpack/measure/morphometry/components.h"
#include "vdbpack/measure/morphometry/curvature.h"
#include "vdbpack/measure/morphometry/euler.h"
#include "vdbpack/measure/morphometry/local_thickness.h"
#include "vdbpack/measure/morphometry/mean_intercept.h"
#include "vdbpack/measure/morphometry/phase_tally.h"
#include "vdbpack/measure/morphometry/surface_distance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

constexpr int kDirections = 500;
/// Along which lines from voxel to voxel are laid.
constexpr int kVoxelDirections = 100;

void check(const VoxelImage& image) {
    if (!(image.voxelSize > 0) || !std::isfinite(image.voxelSize))
        throw ParameterError(
            fmt::format("image: voxel size {} mm; give a positive one", image.voxelSize));
    std::uint64_t count = 1;
    for (const std::int64_t n : image.size) {
        if (n < 1 || static_cast<std::uint64_t>(n) > kLargestImage / count)
            throw ParameterError(fmt::format(
                "image: size {} x {} x {}; give at least one voxel each way and at most {} in all",
                image.size[0], image.size[1], image.size[2], kLargestImage));
        count *= static_cast<std::uint64_t>(n);
    }
    if (image.distance.size() != count)
        throw ParameterError(fmt::format("image: {} distances for {} x {} x {} voxels; give {}",
                                         image.distance.size(), image.size[0], image.size[1],
                                         image.size[2], count));
    if (!image.label.empty() && image.label.size() != count)
        throw ParameterError(fmt::format("image: {} labels for {} voxels; give {} or none",
                                         image.label.size(), count, count));
    if (!image.depth.empty() && (image.depth.size() != count || image.label.empty()))
        throw ParameterError(fmt::format(
            "image: {} depths and {} labels for {} voxels; give {} of each, or no depths",
            image.depth.size(), image.label.size(), count, count));
    const auto bad = std::find_if(image.distance.begin(), image.distance.end(),
                                  [](float d) { return !std::isfinite(d); });
    if (bad != image.distance.end()) {
        const auto at = static_cast<std::int64_t>(bad - image.distance.begin());
        throw InputError(fmt::format(
            "image: voxel ({}, {}, {}) has the distance {}; give finite distances, clamped far "
            "from the surface",
            at % image.size[0], at / image.size[0] % image.size[1],
            at / (image.size[0] * image.size[1]), *bad));
    }
}

/// The pore space below the wall: all else is made solid.
VoxelImage poresBelowWall(const VoxelImage& image) {
    VoxelImage pores;
    pores.size = image.size;
    pores.voxelSize = image.voxelSize;
    pores.origin = image.origin;
    pores.label = image.label;
    pores.distance.reserve(image.voxels());
    for (std::size_t i = 0; i < image.voxels(); ++i)
        pores.distance.push_back(std::min(image.distance[i], image.depth[i]));
    return pores;
}

/// Of the pore space, the part that is nearer to the wall than to the solid.
double shareNearWall(const VoxelImage& pores, const SurfaceDistance& surface) {
    std::uint64_t all = 0, near = 0;
    for (std::size_t voxel = 0; voxel < pores.voxels(); ++voxel) {
        if (pores.distance[voxel] < 0 || !pores.inTotal(voxel)) continue;
        ++all;
        // Beyond a point of the wall there is no total volume.
        near += surface.points[surface.nearest[voxel]].label == 0;
    }
    return all > 0 ? static_cast<double>(near) / static_cast<double>(all) : 0;
}

/// Of the pores of a sample that was cut, no diameter counts as more than the sample is wide.
void limitPores(const VoxelImage& image, std::vector<float>& thickness) {
    std::array<std::int64_t, 3> low = image.size, high{-1, -1, -1};
    for (std::int64_t z = 0, voxel = 0; z < image.size[2]; ++z)
        for (std::int64_t y = 0; y < image.size[1]; ++y)
            for (std::int64_t x = 0; x < image.size[0]; ++x, ++voxel) {
                if (!image.inTotal(static_cast<std::size_t>(voxel))) continue;
                const std::array<std::int64_t, 3> at{x, y, z};
                for (std::size_t j = 0; j < 3; ++j) {
                    low[j] = std::min(low[j], at[j]);
                    high[j] = std::max(high[j], at[j]);
                }
            }
    std::int64_t side = high[0] - low[0] + 1;
    for (std::size_t j = 1; j < 3; ++j) side = std::min(side, high[j] - low[j] + 1);
    const auto limit = static_cast<float>(std::max<std::int64_t>(side, 0));
    for (std::size_t voxel = 0; voxel < thickness.size(); ++voxel)
        if (!(image.distance[voxel] < 0)) thickness[voxel] = std::min(thickness[voxel], limit);
}

/// Local thickness of both phases, or nothing where there is no surface. Leaves the points of
/// `surface` alone.
std::vector<float> bothThicknesses(const VoxelImage& image, SurfaceDistance& surface,
                                   Morphometry& m) {
    std::vector<float> thickness;
    if (!surface.points.empty()) {
        thickness.assign(image.voxels(), 0.0f);
        paintThickness(image, surface, Phase::solid, thickness);
    }
    if (!m.walled) {
        if (!thickness.empty()) {
            paintThickness(image, surface, Phase::pores, thickness);
            limitPores(image, thickness);
        }
        return thickness;
    }
    surface.nearest = {};
    const VoxelImage pores = poresBelowWall(image);
    const SurfaceDistance walls = surfaceDistance(pores);
    if (walls.points.empty()) return thickness;
    thickness.resize(image.voxels(), 0.0f);
    paintThickness(pores, walls, Phase::pores, thickness);
    m.border.poresNearWall = shareNearWall(pores, walls);
    return thickness;
}

/// Sets what follows from voxels and thicknesses.
void setPhases(SolidMeasures& part, const PhaseTallies& tallies, double voxelSize) {
    const double cube = voxelSize * voxelSize * voxelSize;
    part.totalVolume = static_cast<double>(tallies.voxels()) * cube;
    part.solidVolume = static_cast<double>(tallies.solid.voxels) * cube;
    part.solidFraction =
        static_cast<double>(tallies.solid.voxels) / static_cast<double>(tallies.voxels());
    part.thickness = tallies.solid.statistics(voxelSize);
    part.separation = tallies.pores.statistics(voxelSize);
    if (part.thickness) part.number = part.solidFraction / part.thickness->mean;
}

void setEuler(SolidMeasures& part, const EulerNumbers& euler) {
    part.eulerNumber = euler.whole;
    part.deltaEuler = euler.share;
    part.connectivity = 1 - euler.share;
    part.connectivityDensity = part.connectivity / part.totalVolume;
}

/// Sets surface and anisotropy of the voxels of a label.
void setSurface(SolidMeasures& part, const VoxelImage& image, const SurfaceDistance& surface,
                int label) {
    double area = 0;
    for (const SurfacePoint& p : surface.points)
        if (label == kAllLabels || label == p.label) area += static_cast<double>(p.area);
    part.solidSurface = area * image.voxelSize * image.voxelSize;
    const auto directions = halfSphereDirections(kDirections);
    part.anisotropy =
        fitAnisotropy(directions, crossingRates(surface, directions, label), image.voxelSize);
    if (!part.anisotropy) return;
    const auto few = halfSphereDirections(kVoxelDirections);
    part.voxelAnisotropy =
        fitAnisotropy(few, voxelCrossingRates(image, few, label), image.voxelSize);
}

/// Sets the structure model index; volume and surface must be set.
/// @param curvature  of `curvatureIntegrals`.
void setStructureModel(SolidMeasures& part, const std::vector<double>& curvature, double voxelSize,
                       int label) {
    part.structureModelIndex.reset();
    const double area = part.solidSurface;
    if (curvature.empty() || !(area > 0)) return;
    double growth = 0;
    for (std::size_t l = 1; l < curvature.size(); ++l)
        if (label == kAllLabels || label == static_cast<int>(l)) growth += curvature[l];
    part.structureModelIndex = 6 * part.solidVolume * (growth * voxelSize) / (area * area);
}

}  // namespace

void setVolumes(Morphometry& m, double total, double solid) {
    if (m.structureModelIndex && m.solidVolume > 0) *m.structureModelIndex *= solid / m.solidVolume;
    m.totalVolume = total;
    m.solidVolume = solid;
    m.solidFraction = solid / total;
    if (m.thickness) m.number = m.solidFraction / m.thickness->mean;
    m.connectivityDensity = m.connectivity / total;
}

Morphometry measureMorphometry(const VoxelImage& image) {
    check(image);
    Morphometry m;
    m.voxelSize = image.voxelSize;
    m.walled = !image.depth.empty();
    m.border = borderShares(image);
    SurfaceDistance surface = surfaceDistance(image);
    std::vector<PhaseTallies> phases;
    {
        const std::vector<float> thickness = bothThicknesses(image, surface, m);
        phases = tallyPhases(image, thickness);
    }
    PhaseTallies all;
    std::size_t present = 0;
    for (const PhaseTallies& p : phases) {
        all.add(p);
        present += p.voxels() > 0;
    }
    m.voxels = all.voxels();
    if (m.voxels == 0)
        throw InputError(fmt::format(
            "image: all {} voxels have label 0, so that there is no total volume; label those "
            "that belong to it 1 or more, or give no labels",
            image.voxels()));
    setPhases(m, all, m.voxelSize);
    setSurface(m, image, surface, kAllLabels);
    const std::vector<double> curvature = curvatureIntegrals(image);
    setStructureModel(m, curvature, m.voxelSize, kAllLabels);
    setEuler(m, eulerNumbers(image));
    m.largestComponent = largestComponentShare(image);
    for (std::size_t label = 1; label < phases.size(); ++label) {
        if (image.label.empty() || phases[label].voxels() == 0) continue;
        RegionMorphometry region;
        static_cast<SolidMeasures&>(region) = m;  // the only region is the whole
        region.label = static_cast<int>(label);
        if (present > 1) {
            setPhases(region, phases[label], m.voxelSize);
            setSurface(region, image, surface, region.label);
            setStructureModel(region, curvature, m.voxelSize, region.label);
            setEuler(region, eulerNumbers(image, region.label));
        }
        m.regions.push_back(region);
    }
    return m;
}

}  // namespace vdbpack
