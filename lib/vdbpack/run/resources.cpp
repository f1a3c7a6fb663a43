// Memory and disk space of a run, and its refusal.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/text.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/view/view.h"
#include "vdbpack/voids/tile_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace vdbpack {

namespace {

// Bytes of memory, from peaks of whole runs (GCC 12): ball:5 67 MB, box:150 with 4,000,060 spheres
// by a target count 433 MiB, box:630 with 10.2 million 1021 MiB, the hip with 998,214 312 MiB,
// skull_seg3d with 300,000 512 MiB, mandible in voxels of 0.07 mm (338 million) 3180 MiB, box:180
// densified to 237,621 spheres 142 MiB.
constexpr double kProgram = 67e6, kTriangle = 600, kDrawnSphere = 75, kImageVoxel = 23;
/// A voxel while the field is built, or copied to be cut or written; half of that stays. In a
/// narrow band of our own that is not.
constexpr double kFieldVoxel = 8.6, kBandVoxel = 5.2;
/// A sphere that is placed or read, and measured; one that is moved; what triangles beside it and a
/// list of pairs add.
constexpr double kSphere = 102, kMoved = 460, kBesideMesh = 95, kPairs = 140;
/// What cutting takes at the least; a leaf of the level sets `surface`, `voids` and `solid` and the
/// tile it is made from. For each voxel along the wall of a shape, its contour or its level set; of
/// a contour, its picture.
constexpr double kCutting = 12e6, kLeaf = 6600, kShapeContour = 330, kShapeGrid = 150,
                 kDrawnFace = 500;
/// Triangles of a contour for each voxel along the wall, and the share left where they are joined.
constexpr double kContourTriangles = 3.1, kJoined = 0.37;

// Bytes in a file: a sphere or a void as text, a sphere in binary formats, the pairs of a sphere, a
// triangle in .stl and in scenes; for each voxel along the walls of voids, a contour and level
// sets, along the wall of a shape its level set; a voxel of a field; a page, and a sphere in it.
constexpr double kText = 125, kBinary = 60, kPairsText = 250, kStlTriangle = 50, kUsdTriangle = 38;
constexpr double kFace = 125, kCutFace = 40, kShapeFace = 18, kVoxel = 1.5;
constexpr double kPage = 2e6, kPageSphere = 14;
/// Bytes of a voxel of a label map: in memory, as a number of a .nii, and compressed, measured.
constexpr double kLabelVoxel = 4.2, kLabelNumber = 2, kPackedLabel = 0.06;

constexpr double kFileTolerance = 0.8;  ///< files this much smaller than estimated may still fit

/// Whether an output of a shape is made from its level set; the .vdb of a pack is not.
bool isShapeLevelSet(const OutputTarget& output) {
    return output.isSolid() && output.kind != OutputKind::pack;
}

/// Voxels along the walls of a level set of voids, else of a shape; 0: there is none.
double wallFaces(const Extent& e) {
    const double voxel = e.voids.count > 0 ? e.voids.voxelSize : e.shapeVoxel;
    return voxel > 0 ? (e.area + e.voids.wall) / (voxel * voxel) : 0;
}

/// Memory of the level set of a shape that is written; with voids it comes with theirs.
double shapeBytes(const Extent& e, const std::vector<OutputTarget>& outputs) {
    double each = 0;
    for (const OutputTarget& output : outputs)
        if (isShapeLevelSet(output) && !(e.voids.count > 0) && e.shapeVoxel > 0)
            each = std::max(each, output.extension() == ".stl" ? kShapeContour : kShapeGrid);
    return each * wallFaces(e);
}

double fileBytes(const OutputTarget& output, const Extent& e) {
    static const std::set<std::string> kBinaries{".vdb", ".vtp", ".pvtp", ".vtkhdf",
                                                 ".hdf", ".ply", ".npz"};
    const std::string format = output.extension();
    const OutputKind kind = output.kind;
    const double spheres = e.kept * e.count;
    if (kind == OutputKind::voidList) return kText * e.voids.count;
    if (output.listsPairs()) return kPairsText * spheres;
    if (kind == OutputKind::materials) return 1000;
    if (kind == OutputKind::labels)
        return (format == ".nii" ? kLabelNumber : kPackedLabel) * e.labelVoxels;
    const bool cut = e.voids.count > 0;
    const double faces = wallFaces(e), triangles = static_cast<double>(e.field.triangles);
    if (format == ".stl") return faces > 0 ? kFace * faces : kStlTriangle * triangles;
    if (faces > 0 && !cut && isShapeLevelSet(output)) return kShapeFace * faces;
    double bytes = (kBinaries.count(format) > 0 ? kBinary : kText) * spheres;
    if (holdsSurface(output.text))
        bytes += kUsdTriangle * (cut ? kJoined * contourTriangles(e) : triangles);
    if (output.isSolid()) bytes += cut ? kCutFace * faces : kVoxel * e.field.voxels();
    return bytes;
}

std::vector<Estimate::File> filesOf(const Extent& e, const RunSettings& settings) {
    std::vector<Estimate::File> files;
    for (const auto& output : settings.outputs)
        files.push_back({output.text, fileBytes(output, e)});
    if (isPage(settings.reportFile) && e.count > 0 && !settings.ranks) {
        const double shown =
            std::min(e.kept * e.count, static_cast<double>(ViewOptions().mostSpheres));
        files.push_back({settings.reportFile, kPage + kPageSphere * shown});
    }
    return files;
}

}  // namespace

double stampBytes(const Extent& e) {
    const VoidExtent& v = e.voids;
    if (!(v.count > 0) || !(v.voxelSize > 0)) return 0;
    const double side = kTileSide * v.voxelSize, band = kStampBand * v.voxelSize;
    // A wall enters as many leaves as a layer of its band and one leaf has.
    const double layer = side + band + std::max(band, v.reach);
    const double leaves = (std::min(v.wall * layer, e.volume + e.area * side) + e.area * side) /
                          std::pow(side, e.dim);
    return kLeaf * leaves;
}

double contourTriangles(const Extent& extent) {
    return kContourTriangles * wallFaces(extent);
}

Estimate estimate(const Extent& e, const RunSettings& settings) {
    const auto& outputs = settings.outputs;
    Estimate all{{}, filesOf(e, settings)};
    const double count = settings.ranks ? e.count / settings.ranks->count() : e.count;
    const bool pairs = std::any_of(outputs.begin(), outputs.end(),
                                   [](const OutputTarget& output) { return output.listsPairs(); });
    const double spheres =
        count * ((e.densifying ? kMoved : kSphere) + (e.field.triangles > 0 ? kBesideMesh : 0) +
                 (pairs ? kPairs : 0));
    double voids = stampBytes(e) + (e.voids.foam ? kMoved * e.voids.count : 0);
    if (e.voids.count > 0) voids += kCutting;
    // Contours are complete in memory before they are written.
    for (const auto& file : all.files)
        if ((endsWith(file.name, ".stl") || holdsSurface(file.name)) && e.voids.count > 0)
            voids += file.bytes;
    const double triangles = static_cast<double>(e.field.triangles) +
                             (e.solid && e.voids.count > 0 ? contourTriangles(e) : 0);
    const bool draws = !settings.preview.file.empty() || isPage(settings.reportFile);
    const bool drawsVoids = e.voids.count > 0 && !(e.count > 0) && e.dim == 3;
    const double picture =
        draws ? kDrawnSphere * e.count + (drawsVoids ? kDrawnFace * wallFaces(e) : 0) : 0;
    const double shape = shapeBytes(e, outputs);
    const bool written = e.voids.count > 0 || std::any_of(outputs.begin(), outputs.end(),
                                                          [](const OutputTarget& output) {
                                                              return output.usesLevelSets();
                                                          });
    const double built =
        (e.field.watertight && !written ? kBandVoxel : kFieldVoxel) * e.field.voxels();
    // Building the field takes twice as much, before there is anything else.
    const double field = std::max(built / 2, built - spheres - voids - picture);
    all.parts = {
        {"program", kProgram, "the program", "that is the least there can be, raise `memoryLimit`"},
        {"mesh", kTriangle * triangles, fmt::format("{:.3g} triangles", triangles),
         e.solid ? "choose a larger `voids.voxelSize`" : "use a mesh of fewer triangles"},
        {"field", field,
         fmt::format("a field of about {:.2g} voxels of {:.4g} mm", e.field.voxels(),
                     e.field.voxelSize),
         "choose a larger `voxelSize` or larger radii, or check the unit of the mesh"},
        {"levelSet", shape, fmt::format("a level set in voxels of {:.4g} mm", e.shapeVoxel),
         "leave the level set out"},
        {"spheres", spheres,
         fmt::format("about {:.3g} {}", count,
                     e.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres),
         "choose larger radii, fewer spheres by `targetCount` or `maxCount`, or clip the domain"},
        {"voids", voids,
         fmt::format("about {:.3g} voids in voxels of {:.4g} mm", e.voids.count, e.voids.voxelSize),
         "choose a larger `voids.voxelSize` or larger voids, or clip the domain"},
        {"picture", picture, "a picture", "leave the picture out"},
        {"labels", kLabelVoxel * e.labelVoxels,
         fmt::format("a label map of about {:.2g} voxels", e.labelVoxels),
         "choose a larger `voxelSpacing`"},
        {"image", kImageVoxel * std::max(e.imageVoxels, e.solidVoxels),
         fmt::format("an image of about {:.2g} voxels", std::max(e.imageVoxels, e.solidVoxels)),
         e.solidVoxels > e.imageVoxels
             ? "leave `measureSolid` out, or choose a larger `voids.voxelSize`"
         : e.voids.count > 0 ? "choose a larger `voids.voxelSize` or a larger `targetTbth`"
                             : "choose a larger `voxelSize`"},
    };
    return all;
}

void requireResources(const Estimate& e, double limit) {
    limit = memoryLimit(limit);
    if (e.memory() > limit) {
        const auto most =
            std::max_element(e.parts.begin(), e.parts.end(),
                             [](const auto& a, const auto& b) { return a.bytes < b.bytes; });
        throw ResourceError(fmt::format(
            "would take about {} of memory, and {} may be taken (`memoryLimit`): {}; {}",
            bytesText(e.memory()), bytesText(limit), e.memoryText(), most->remedy));
    }
    for (const auto& file : e.files)
        if (const double available = availableSpace(filePart(file.name));
            kFileTolerance * file.bytes > available)
            throw ResourceError(
                fmt::format("{}: would take about {}, and {} are free there. Write to another "
                            "disk, or fewer spheres or larger voxels",
                            file.name, bytesText(file.bytes), bytesText(available)));
}

void requireResources(const Extent& extent, const RunSettings& settings) {
    for (const OutputTarget& output : settings.outputs) {
        if (output.kind != OutputKind::blender &&
            !(output.isSolid() && output.extension() == ".vdb"))
            continue;
        const bool isMesh = extent.field.triangles > 0, isShape = isShapeLevelSet(output);
        for (const double voxel : {isMesh ? extent.field.voxelSize : 0, extent.voids.voxelSize,
                                   isShape ? extent.shapeVoxel : 0})
            requireVdbVoxel(voxel, settings.outUnit, output.file);
    }
    requireResources(estimate(extent, settings), settings.memoryLimit);
}

}  // namespace vdbpack
