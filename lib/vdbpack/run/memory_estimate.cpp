#include "vdbpack/run/memory_estimate.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/run/output_size.h"
#include "vdbpack/run/outputs.h"
#include "vdbpack/run/pack_stage.h"
#include "vdbpack/run/stages.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace vdbpack {

namespace {

// Bytes, from peaks of whole runs (GNU time, GCC 12, 2 threads): box:150 with 3,840,375 spheres
// 530 MiB, hip.ply with 1,000,676 found by a target count 430 MiB, mandible.ply in voxels of
// 0.07 mm (338 million) 3180 MiB, box:100 with 161,501 voids in voxels of 0.15 mm 3188 MiB.

constexpr double kProgram = 44e6, kPerThread = 1.5e6;
constexpr double kPerTriangle = 730;
/// A voxel of the field's band, and one of the wall, whose leaves are not full: at the peak while
/// the field is built, and afterwards.
constexpr double kBandBuilt = 8.6, kWallBuilt = 97;
constexpr double kBandHeld = 4.3, kWallHeld = 33;
/// A sphere while it is placed and measured: in a shape, beside triangles, in a plane; what a
/// second pack adds.
constexpr double kPlaced = 135, kPlacedInMesh = 225, kPlacedInPlane = 105, kSecondPack = 100;
/// One that is moved: box:180 with uniform:1,2 densified to 0.64 (237,621 spheres, 142 MiB), and a
/// skull of 624,608 triangles with 1,071,128 spheres densified to 0.615 (1158 MiB).
constexpr double kMoved = 460, kMovedInMesh = 560;
/// One that was read and is measured; one of a complete pack; one with its pairs, to be written.
constexpr double kRead = 150, kReadInMesh = 225, kComplete = 64, kPairs = 215;
/// Level sets of voids: edge of a leaf in voxels, all level sets of a leaf, a void at a leaf; and
/// voxels beyond a void.
constexpr double kLeafSide = 8, kLeaf = 5300, kLeafInMesh = 6400, kAtLeaf = 24, kVoidBand = 3;
/// A voxel of an image; a drawn sphere; a pixel; a voxel's face of a contour.
constexpr double kImageVoxel = 23, kDrawn = 75, kPixel = 4, kFace = 145;

/// Solid fraction of spheres of one size, of sizes up to twice, and up to four times as large and
/// more; and the share of it lost to a wall for each mean radius (times area divided by volume).
constexpr double kDense[3] = {0.605, 0.655, 0.70}, kDenseInPlane = 0.87;
constexpr double kWallShare = 0.3, kLeastShare = 0.4;
/// A sphere in a file of unknown format.
constexpr double kSphereInFile = 40;

/// Files this much smaller than estimated may still fit.
constexpr double kFileTolerance = 0.8;
/// Parts of a smaller share are not listed.
constexpr double kListedShare = 0.02;

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

double bytesPerSphere(const Extent& e) {
    const bool inMesh = e.field.triangles > 0;
    double each = inMesh ? kReadInMesh : kRead;
    if (e.placing) {
        each = e.dim == 2 ? kPlacedInPlane : inMesh ? kPlacedInMesh : kPlaced;
        if (e.searching) each += kSecondPack;
    }
    return e.densifying ? std::max(each, inMesh ? kMovedInMesh : kMoved) : each;
}

double voidBytes(const Extent& e) {
    const PlannedVoids& v = e.voids;
    if (!(v.count > 0) || !(v.voxelSize > 0)) return 0;
    const double h = v.voxelSize, side = kLeafSide * h, tile = std::pow(side, e.dim);
    double entries = v.count;
    const double length[3] = {v.length, v.radius, v.radius};
    for (int d = 0; d < e.dim; ++d)
        entries *= 2 * (0.5 * (length[d] + v.radius) + kVoidBand * h) / side + 1;
    const double leaves = std::min(entries, (e.domainVolume + e.domainArea * side) / tile) +
                          (e.dim == 3 ? e.domainArea * side / tile : 0);
    return entries * kAtLeaf + leaves * (e.field.triangles > 0 ? kLeafInMesh : kLeaf);
}

/// What writing adds: the pairs of contact lists, and contours.
double writingBytes(const Extent& e) {
    double pairs = 0, contour = 0;
    for (const auto& output : e.outputs) {
        if (isSolidOutput(output) && filePart(output).rfind(".vdb") == std::string::npos) {
            const double h = e.voids.count > 0 ? e.voids.voxelSize : e.field.voxelSize;
            contour = kFace * (voidFaces(e) + (h > 0 ? e.domainArea / (h * h) : 0));
        }
        if (output.rfind("contacts:", 0) == 0 || output.rfind("lammps-bonds:", 0) == 0)
            pairs = kPairs * e.count;
    }
    return pairs + contour;
}

double pictureBytes(const Extent& e) {
    if (e.preview.file.empty() && !endsWith(e.reportFile, ".html")) return 0;
    return kDrawn * e.count +
           kPixel * static_cast<double>(e.preview.width) * static_cast<double>(e.preview.height);
}

/// What varies over a run.
struct Stage {
    double field, spheres, voids, picture;
    double sum() const { return field + spheres + voids + picture; }
};

/// The stage that needs most.
Stage peakOf(const Extent& e) {
    double built = 0, held = 0;
    if (e.field.triangles > 0 && e.field.voxelSize > 0) {
        const double band = bandVoxels(e);
        const double wall = e.field.area / (e.field.voxelSize * e.field.voxelSize);
        built = kBandBuilt * band + kWallBuilt * wall;
        held = kBandHeld * band + kWallHeld * wall;
    }
    const double complete = kComplete * e.count, voids = voidBytes(e), writing = writingBytes(e);
    const Stage stages[] = {
        {built, 0, 0, 0},                                          // domain
        {held, bytesPerSphere(e) * e.count, 0, 0},                 // pack, densify
        {held, complete, voids, 0},                                // voids
        {held, complete + writing, 0.9 * voids, pictureBytes(e)},  // write, picture
    };
    return *std::max_element(std::begin(stages), std::end(stages),
                             [](const Stage& a, const Stage& b) { return a.sum() < b.sum(); });
}

}  // namespace

double Estimate::memory() const {
    double sum = 0;
    for (const Part& part : parts) sum += part.bytes;
    return sum;
}

Estimate estimate(const Extent& e) {
    const Stage peak = peakOf(e);
    const PreviewRecipe& p = e.preview;
    Estimate all;
    all.extent = e;
    all.parts = {
        {"program", kProgram + kPerThread * e.threads, "the program",
         "that is the least there can be, raise `memoryLimit`"},
        {"mesh", kPerTriangle * static_cast<double>(e.field.triangles),
         fmt::format("{} triangles", e.field.triangles), "use a mesh of fewer triangles"},
        {"field", peak.field,
         fmt::format("a field of about {:.2g} voxels of {:.4g} mm", bandVoxels(e),
                     e.field.voxelSize),
         "choose a larger `voxelSize` or larger radii, or check the unit of the mesh"},
        {"spheres", peak.spheres,
         fmt::format("about {:.3g} {}", e.count,
                     e.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres),
         "choose larger radii, fewer spheres by `targetCount` or `maxCount`, or clip the domain"},
        {"voids", peak.voids,
         fmt::format("about {:.3g} voids in voxels of {:.4g} mm", e.voids.count, e.voids.voxelSize),
         "choose a larger `voids.voxelSize` or larger voids, or clip the domain"},
        {"picture", peak.picture, fmt::format("a picture of {} x {}", p.width, p.height),
         "choose a smaller picture (`preview.width`)"},
        {"image", kImageVoxel * e.imageVoxels,
         fmt::format("an image of about {:.2g} voxels", e.imageVoxels),
         "choose a larger `voxelSize`"},
    };
    for (const auto& output : e.outputs) all.files.push_back({output, outputBytes(output, e)});
    return all;
}

namespace {

void complete(Extent& extent, const RunSettings& settings) {
    extent.outputs = settings.outputs;
    extent.preview = settings.preview;
    extent.reportFile = settings.reportFile;
    extent.threads = effectiveThreads(settings.threads);
}

}  // namespace

Extent extentOf(const DomainSource& source, double detail, double reach, double voxelSize) {
    Extent e;
    e.dim = source.dim();
    e.field = source.plan(detail, reach, voxelSize);
    if (!source.isFile()) {
        const auto built = source.build(0, 0);
        e.domainVolume = built.space ? built.space->volume() : built.plane->volume();
        e.domainArea = built.space ? built.space->wallArea() : built.plane->wallArea();
    } else if (e.dim == 2) {
        // The slice is not known yet: at most its rectangle.
        const Vec<3> size = source.fileBounds().size();
        e.domainVolume = size[0] * size[1];
        e.domainArea = 2 * (size[0] + size[1]);
    } else {
        e.domainVolume = source.clippedVolume();
        e.domainArea = e.field.area;
    }
    return e;
}

Extent extentOf(const PackRecipe& recipe, const DomainSource& source) {
    const RequestedSizes requested = requestedSizes(recipe, source.dim());
    const SizeDistribution& sizes = requested.sizes;
    const FieldRadii radii = fieldRadii(recipe, requested, source);
    Extent e =
        extentOf(source, radii.detail, radii.reach, plannedVoxel(recipe.voids, source.dim()));
    complete(e, recipe);
    e.placing = true;
    e.searching = requested.targetCount > 0;
    e.densifying = recipe.densify > 0;
    const double ratio = sizes.max() / sizes.min(), mean = sizes.mean() * radii.scale;
    const double wall = e.domainVolume > 0 ? kWallShare * mean * e.domainArea / e.domainVolume : 0;
    const double dense = (e.dim == 2      ? kDenseInPlane
                          : ratio < 1.05  ? kDense[0]
                          : ratio <= 2.05 ? kDense[1]
                                          : kDense[2]) *
                         std::max(kLeastShare, 1 - wall);
    const double gap = std::pow(1 + 0.5 * recipe.gap / mean, e.dim);
    e.count = e.searching ? 1.02 * requested.targetCount
                          : dense * e.domainVolume / (sizes.meanBall(e.dim) * gap);
    if (recipe.maxCount > 0) e.count = std::min(e.count, static_cast<double>(recipe.maxCount));
    // More by a share that few packs reach.
    if (e.densifying && !e.searching) e.count *= 1.05;
    e.voids = planVoids(recipe.voids,
                        {e.dim, e.domainVolume, e.domainArea, e.count, sizes.max() * radii.scale});
    std::error_code failed;
    if (!recipe.existing.empty())
        if (const auto bytes = std::filesystem::file_size(recipe.existing, failed); !failed)
            e.count += static_cast<double>(bytes) / kSphereInFile;
    return e;
}

double memoryLimit(double limit) {
    return limit > 0 ? limit : residentMemory() + availableMemory();
}

namespace {

void requireMemory(const Estimate& e, double limit) {
    if (!(e.memory() > limit)) return;
    const auto most =
        std::max_element(e.parts.begin(), e.parts.end(),
                         [](const auto& a, const auto& b) { return a.bytes < b.bytes; });
    std::string list;
    for (const auto& part : e.parts)
        if (part.bytes > kListedShare * e.memory())
            list += (list.empty() ? "" : ", ") + bytesText(part.bytes) + " for " + part.what;
    throw ResourceError(
        fmt::format("would take about {} of memory, and {} may be taken (`memoryLimit`): {}; {}",
                    bytesText(e.memory()), bytesText(limit), list, most->remedy));
}

/// Adds up the files on each disk.
void requireSpace(const Estimate& e) {
    std::map<std::uint64_t, double> needed;
    for (const auto& file : e.files) {
        std::uint64_t device = 0;
        const double free = availableSpace(filePart(file.name), &device);
        needed[device] += file.bytes;
        if (kFileTolerance * needed[device] <= free) continue;
        const bool several = needed[device] > 1.01 * file.bytes;
        throw ResourceError(fmt::format(
            "{}: would take about {}{}, and {} are free there; write a smaller format (.vdb), "
            "fewer spheres, or to another disk",
            file.name, bytesText(file.bytes),
            several ? ", with the files before it " + bytesText(needed[device]) : "",
            bytesText(free)));
    }
}

}  // namespace

void requireResources(const Estimate& e, double limit) {
    requireMemory(e, limit);
    requireSpace(e);
}

void requireRoom(const RunSettings& settings, Extent extent) {
    complete(extent, settings);
    requireResources(estimate(extent), memoryLimit(settings.memoryLimit));
}

void requireResources(const PackRecipe& recipe, const DomainSource& source) {
    const double limit = memoryLimit(recipe.memoryLimit);
    Extent extent = extentOf(recipe, source);
    if (extent.dim == 2 && source.isFile() && estimate(extent).memory() > limit) {
        const double share = source.volume() / extent.domainVolume;
        extent.domainVolume *= share;
        if (!extent.searching) extent.count *= share;
        extent.voids.count *= share;
    }
    requireResources(estimate(extent), limit);
}

nlohmann::ordered_json toJson(const Estimate& e) {
    nlohmann::ordered_json json;
    const auto whole = [](double bytes) { return std::llround(std::min(bytes, 9e18)); };
    for (const auto& part : e.parts) json["memory"][part.name] = whole(part.bytes);
    json["files"] = nlohmann::ordered_json::array();
    for (const auto& file : e.files)
        json["files"].push_back({{"name", file.name}, {"bytes", whole(file.bytes)}});
    return json;
}

std::string summary(const Estimate& e) {
    std::string parts;
    for (const auto& part : e.parts)
        if (part.bytes > kListedShare * e.memory())
            parts +=
                (parts.empty() ? "" : ", ") + std::string(part.name) + " " + bytesText(part.bytes);
    std::string text =
        fmt::format("{:<11}about {} at most ({})\n", "memory", bytesText(e.memory()), parts);
    for (const auto& file : e.files)
        text += fmt::format("{:<11}{} about {}\n", "file", file.name, bytesText(file.bytes));
    return text;
}

}  // namespace vdbpack
