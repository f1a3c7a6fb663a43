#include "vdbpack/run/output_size.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/run/memory_estimate.h"
#include "vdbpack/run/outputs.h"

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Layers of voxels outside of the wall.
constexpr double kOutside = 3;

/// A row of a format, bytes for each sphere; the largest seen for bones in mm.
struct Row {
    const char* name;  ///< prefix or extension
    double bytes;
};
constexpr Row kRows[] = {{"contacts:", 310}, {"lammps-bonds:", 195}, {"lammps:", 118},
                         {"liggghts:", 118}, {"yade:", 86},          {"blender:", 44},
                         {"points:", 27},    {".csv", 124},          {".vtp", 77},
                         {".vdb", 27},       {".ply", 32.5},         {".xyz", 126},
                         {".npz", 73},       {".data", 118},         {".svg", 110}};
/// A void in a list, a voxel of a level set, a voxel deep inside, a voxel's face of a contour.
constexpr double kListedVoid = 190, kVoxel = 4.4, kDeepVoxel = 1, kFace = 150;

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool matches(const std::string& output, const Row& row) {
    return row.name[0] == '.' ? endsWith(output, row.name) : output.rfind(row.name, 0) == 0;
}

}  // namespace

double bandVoxels(const Extent& e) {
    const FieldPlan& f = e.field;
    if (f.triangles == 0) return 0;
    const double h = f.voxelSize, cube = h * h * h;
    return (std::min(f.volume, f.area * (f.depth + h)) + f.area * kOutside * h) / cube;
}

double voidFaces(const Extent& e) {
    const PlannedVoids& v = e.voids;
    if (!(v.voxelSize > 0) || !(e.domainVolume > 0) || e.dim != 3) return 0;
    const double a = v.length, b = v.radius;
    // Thomsen's formula for the area of an ellipsoid.
    const double each =
        4 * kPi * std::pow((2 * std::pow(a * b, 1.6) + std::pow(b, 3.2)) / 3, 1 / 1.6);
    const double outside = std::exp(-v.count * Measure<3>::ball(b) * a / b / e.domainVolume);
    return v.count * each * outside / (v.voxelSize * v.voxelSize);
}

double outputBytes(const std::string& output, const Extent& e) {
    const auto starts = [&](const char* prefix) { return output.rfind(prefix, 0) == 0; };
    if (starts("list:")) return kListedVoid * e.voids.count;
    // The walls of the level sets, in voxels of theirs.
    const bool cut = e.voids.voxelSize > 0 && e.voids.count > 0 && e.dim == 3;
    const bool inMesh = e.field.triangles > 0;
    const double h = cut ? e.voids.voxelSize : e.field.voxelSize;
    double wall = h > 0 ? e.domainArea / (h * h) : 0;
    double band = 2 * kOutside * wall, deep = 0;
    if (h > 0 && inMesh && !cut) deep = std::max(0.0, bandVoxels(e) - band);
    if (cut) {
        const double faces = voidFaces(e);
        band = std::min(6 * faces, e.domainVolume / (h * h * h)) + 6 * wall;
        wall += faces;
    }
    const bool levelSet = isSolidOutput(output);
    if (levelSet && !endsWith(output, ".vdb")) {
        // The surface of a mesh is written as it is, by triangles of 50 bytes.
        const bool surface = starts("surface:") || (!cut && filePart(output) == output);
        return surface && inMesh ? 84 + 50 * static_cast<double>(e.field.triangles) : kFace * wall;
    }
    const double grids = levelSet ? kVoxel * band * (cut ? 2 : 1) + kDeepVoxel * deep : 0;
    if (starts("levelsets:") || starts("fog:")) return grids;
    const auto* row = std::find_if(std::begin(kRows), std::end(kRows),
                                   [&](const Row& r) { return matches(output, r); });
    return grids + (row == std::end(kRows) ? 0 : row->bytes * e.count);
}

}  // namespace vdbpack
