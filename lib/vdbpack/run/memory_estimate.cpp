#include "vdbpack/run/memory_estimate.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/io/text.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/view/view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

// Bytes of memory, from peaks of whole runs (GNU time, GCC 12): box:150 with 3,840,375 spheres 530
// MiB, hip.ply with 1,000,676 found by a target count 430 MiB, mandible.ply in voxels of 0.07 mm
// (338 million) 3180 MiB, box:180 densified to 237,621 spheres 142 MiB.
constexpr double kProgram = 50e6, kTriangle = 730, kDrawnSphere = 75, kImageVoxel = 23;
/// A page without spheres, and what a sphere adds to its view, which is made after the picture and
/// takes less memory (box:290,290,290 with 992,479 spheres: 227 MB with a page, 173 MB without).
constexpr double kPage = 2e6, kPageSphere = 14;
/// A voxel while the field is built, or copied to be written; half of that stays. In a narrow band
/// of our own that is not written.
constexpr double kFieldVoxel = 8.6, kBandVoxel = 5.2;
/// A sphere that is placed or read, and measured; one that is moved; what triangles beside it, a
/// second pack and a list of pairs add.
constexpr double kSphere = 135, kMoved = 460, kBesideMesh = 75, kSecondPack = 100, kPairs = 140;

// Bytes in a file: a sphere or a void as text, a sphere in binary formats, the pairs of a sphere, a
// triangle; for each voxel's face of the walls of voids, a contour and level sets; a voxel of a
// field.
constexpr double kText = 125, kBinary = 60, kPairsText = 250, kStlTriangle = 50;
constexpr double kUsdTriangle = 38;
constexpr double kFace = 125, kCutFace = 40, kVoxel = 1.5;
/// For each voxel along the wall of a shape: memory of its contour, and of its level set or fog
/// volume; and bytes in a file of those.
constexpr double kShapeContour = 330, kShapeGrid = 150, kShapeFile = 18;
/// Triangles of a contour for each voxel's face; bytes of its picture.
constexpr double kContourTriangles = 3.1, kDrawnFace = 500;
/// Share of them that is left where they are joined.
constexpr double kJoined = 0.37;

/// Bytes of a voxel of a label map: in memory, as a number of a .nii, and compressed, measured.
constexpr double kLabelVoxel = 4.2, kLabelNumber = 2, kPackedLabel = 0.06;

/// Parts of a smaller share are not listed; files this much smaller than estimated may still fit.
constexpr double kListedShare = 0.02, kFileTolerance = 0.8;

/// Voxels along the wall of a shape, whose level set is made where it is written.
double shapeFaces(const Extent& e) {
    return e.shapeVoxel > 0 ? e.area / (e.shapeVoxel * e.shapeVoxel) : 0;
}

/// Whether an output of a shape is made from its level set; the .vdb of a pack is not.
bool isShapeLevelSet(const OutputTarget& output) {
    return output.isSolid() && output.kind != OutputKind::pack;
}

double shapeBytes(const Extent& e, const std::vector<OutputTarget>& outputs) {
    double each = 0;
    if (e.voids.count > 0) return 0;  // it comes with theirs
    for (const OutputTarget& output : outputs)
        if (isShapeLevelSet(output))
            each = std::max(each, output.extension() == ".stl" ? kShapeContour : kShapeGrid);
    return each * shapeFaces(e);
}

double fileBytes(const OutputTarget& output, const Extent& e) {
    const std::string format = output.extension();
    if (output.kind == OutputKind::voidList) return kText * e.voids.count;
    if (output.listsPairs()) return kPairsText * e.count;
    if (output.kind == OutputKind::materials) return 1000;
    if (output.kind == OutputKind::labels)
        return (format == ".nii" ? kLabelNumber : kPackedLabel) * e.labelVoxels;
    const bool cut = e.voids.count > 0;
    const double faces =
        cut ? (e.area + e.voids.wall) / std::pow(e.voids.voxelSize, 2) : shapeFaces(e);
    if (format == ".stl")
        return faces > 0 ? kFace * faces : kStlTriangle * static_cast<double>(e.field.triangles);
    if (faces > 0 && !cut && isShapeLevelSet(output)) return kShapeFile * faces;
    const double surface = holdsSurface(output.text)
                               ? kUsdTriangle * (cut ? kJoined * kContourTriangles * faces
                                                     : static_cast<double>(e.field.triangles))
                               : 0;
    const bool text = format != ".vdb" && format != ".vtp" && format != ".pvtp" &&
                      format != ".vtkhdf" && format != ".hdf" && format != ".ply" &&
                      format != ".npz";
    const double levelSets = cut ? kCutFace * faces : kVoxel * e.field.voxels();
    return (text ? kText : kBinary) * e.count + surface + (output.isSolid() ? levelSets : 0);
}

double sphereBytes(const Extent& e, const RunSettings& settings) {
    double each = e.densifying ? kMoved : kSphere;
    if (e.field.triangles > 0) each += kBesideMesh;
    if (e.searching) each += kSecondPack;
    if (std::any_of(settings.outputs.begin(), settings.outputs.end(),
                    [](const OutputTarget& output) { return output.listsPairs(); }))
        each += kPairs;
    return each * e.count;
}

}  // namespace

Extent extentOf(const DomainSource& source, double detail, double reach, double voxelSize) {
    Extent e;
    e.dim = source.dim();
    e.field = source.plan(detail, reach, voxelSize);
    if (!source.isFile()) {
        const auto built = source.build(0, 0);
        e.volume = built.space ? built.space->volume() : built.plane->volume();
        e.area = built.space ? built.space->wallArea() : built.plane->wallArea();
        if (built.space) {
            e.isBox = built.space->facts().kind == "box";
            e.shapeVoxel = shapeVoxelSize(built.space->bounds());
        }
    } else if (e.dim == 2) {
        // The slice is not known yet: at most its rectangle.
        const Vec<3> size = source.fileBounds().size();
        e.volume = size[0] * size[1];
        e.area = 2 * (size[0] + size[1]);
    } else {
        e.volume = source.clippedVolume();
        e.area = e.field.area;
    }
    return e;
}

double Estimate::memory() const {
    double sum = 0;
    for (const Part& part : parts) sum += part.bytes;
    return sum;
}

std::string Estimate::memoryText() const {
    std::string text;
    for (const Part& part : parts)
        if (part.bytes > kListedShare * memory())
            text += (text.empty() ? "" : ", ") + bytesText(part.bytes) + " for " + part.what;
    return text;
}

Estimate estimate(const Extent& e, const RunSettings& settings) {
    Estimate all;
    const bool written =
        std::any_of(settings.outputs.begin(), settings.outputs.end(),
                    [](const OutputTarget& output) { return output.usesLevelSets(); });
    const double built =
        (e.field.watertight && !written ? kBandVoxel : kFieldVoxel) * e.field.voxels();
    const double spheres = sphereBytes(e, settings);
    double voids = stampBytes(e) + kMoved * e.voids.packed;
    for (const auto& output : settings.outputs)
        all.files.push_back({output.text, fileBytes(output, e)});
    const bool hasView = isPage(settings.reportFile) && e.count > 0 && !settings.ranks;
    const double viewed = std::min(e.count, static_cast<double>(ViewOptions().mostSpheres));
    if (hasView) all.files.push_back({settings.reportFile, kPage + kPageSphere * viewed});
    // Contours are complete in memory before they are written.
    for (const auto& file : all.files)
        if ((endsWith(file.name, ".stl") || holdsSurface(file.name)) && e.voids.count > 0)
            voids += file.bytes;
    const double contour =
        e.solid && e.voids.voxelSize > 0
            ? kContourTriangles * (e.area + e.voids.wall) / std::pow(e.voids.voxelSize, 2)
            : 0;
    const double shape = shapeBytes(e, settings.outputs);
    const bool draws = !settings.preview.file.empty() || isPage(settings.reportFile);
    const double drawn = e.count > 0 || e.dim == 2 || !(e.voids.voxelSize > 0)
                             ? 0
                             : (e.area + e.voids.wall) / std::pow(e.voids.voxelSize, 2);
    const double picture = draws ? kDrawnSphere * e.count + kDrawnFace * drawn : 0;
    all.parts = {
        {"program", kProgram, "the program", "that is the least there can be, raise `memoryLimit`"},
        {"mesh", kTriangle * (static_cast<double>(e.field.triangles) + contour),
         contour > 0 ? fmt::format("{} triangles and about {:.2g} of the solid's contour",
                                   e.field.triangles, contour)
                     : fmt::format("{} triangles", e.field.triangles),
         contour > 0 ? "choose a larger `voids.voxelSize`" : "use a mesh of fewer triangles"},
        // Building it takes twice as much, before there is anything else.
        {"field", shape > 0 ? shape : std::max(built / 2, built - spheres - voids - picture),
         shape > 0 ? fmt::format("a level set in voxels of {:.4g} mm", e.shapeVoxel)
                   : fmt::format("a field of about {:.2g} voxels of {:.4g} mm", e.field.voxels(),
                                 e.field.voxelSize),
         shape > 0 ? "leave the level set out"
                   : "choose a larger `voxelSize` or larger radii, or check the unit of the mesh"},
        {"spheres", spheres,
         fmt::format("about {:.3g} {}", e.count,
                     e.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres),
         "choose larger radii, fewer spheres by `targetCount` or `maxCount`, or clip the domain"},
        {"voids", voids,
         fmt::format("about {:.3g} voids in voxels of {:.4g} mm", e.voids.count, e.voids.voxelSize),
         "choose a larger `voids.voxelSize` or larger voids, or clip the domain"},
        {"picture", picture, drawn > 0 ? "a picture of the contour" : "a picture",
         "leave the picture out"},
        {"labels", kLabelVoxel * e.labelVoxels,
         fmt::format("a label map of about {:.2g} voxels", e.labelVoxels),
         "choose a larger `voxelSpacing`"},
        {"image", kImageVoxel * e.imageVoxels,
         fmt::format("an image of about {:.2g} voxels", e.imageVoxels),
         "choose a larger `voxelSize`"},
        {"specimen", kImageVoxel * e.voids.specimenVoxels,
         fmt::format("a specimen of about {:.2g} voxels in which voids are measured",
                     e.voids.specimenVoxels),
         "choose a larger `voids.voxelSize` or a larger `targetTbth`"},
    };
    return all;
}

namespace {

/// What makes a file smaller.
std::string smallerFile(const std::string& name) {
    if (extensionOf(filePart(name)) != ".vdb") return "a smaller format (.vdb), or fewer spheres";
    if (startsWith(name, "points:")) return "or fewer spheres";
    return OutputTarget(name).isSolid() && filePart(name) != name
               ? "or with larger voxels"
               : "without level sets (points:FILE.vdb), or fewer spheres";
}

}  // namespace

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
            throw ResourceError(fmt::format(
                "{}: would take about {}, and {} are free there. Write to another disk, {}",
                file.name, bytesText(file.bytes), bytesText(available), smallerFile(file.name)));
}

void requireResources(const Extent& extent, const RunSettings& settings) {
    requireResources(estimate(extent, settings), settings.memoryLimit);
}

}  // namespace vdbpack
