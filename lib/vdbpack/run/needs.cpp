#include "vdbpack/run/needs.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/run/outputs.h"
#include "vdbpack/run/pack_stage.h"
#include "vdbpack/run/recipe.h"
#include "vdbpack/run/stages.h"
#include "vdbpack/run/void_stage.h"
#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

namespace vdbpack {

namespace {

// Peaks of whole runs (GNU time, GCC 12, 2 threads), from which the figures below follow: box:150
// with 3,840,375 spheres 530 MiB, hip.ply with 1,000,676 found by --target-count 430 MiB,
// mandible.ply in voxels of 0.07 mm (338 million) 3180 MiB, box:100 with 161,501 voids in voxels of
// 0.15 mm 3188 MiB.

constexpr double kProgram = 44e6, kPerThread = 1.5e6;
constexpr double kPerTriangle = 730;

/// The field: what is made of the band inside and outside at a time, and what is kept of it. A
/// voxel of the band, and a voxel of the wall, whose leaves are not full.
constexpr double kBandBuilt = 8.6, kWallBuilt = 97;
constexpr double kBandHeld = 4.3, kWallHeld = 33;
/// Layers of voxels outside of the wall.
constexpr double kOutside = 3;

/// A sphere while it is placed and measured: in a shape, beside triangles, in a plane; what a
/// second pack adds; and a sphere of a pack that stands.
constexpr double kPlaced = 135, kPlacedInMesh = 225, kPlacedInPlane = 105, kSecondPack = 100;
/// One that is moved: box:180 with uniform:1,2 densified to 0.64 (237,621 spheres, 142 MiB), and a
/// skull of 624,608 triangles with 1,071,128 spheres densified to 0.615 (1158 MiB).
constexpr double kMoved = 460, kMovedInMesh = 560;
constexpr double kGiven = 150, kGivenInMesh = 225, kStanding = 64;
/// A sphere with its pairs, when they are written.
constexpr double kPairs = 215;

/// Level sets of voids: edge of a leaf in voxels, all level sets of a leaf, a void at a leaf.
constexpr double kLeafSide = 8, kLeaf = 5300, kLeafInMesh = 6400, kAtLeaf = 24;
/// Beyond a void, in voxels.
constexpr double kVoidBand = 3;

/// A voxel of an image in which bone is measured.
constexpr double kImageVoxel = 23;

/// A picture: what is drawn, and a pixel.
constexpr double kDrawn = 75, kPixel = 4;

/// Solid fraction of spheres of one size, of sizes up to twice, and up to four times as large and
/// more; and the share of it that a wall takes for each mean radius (times area by volume).
constexpr double kDense[3] = {0.605, 0.655, 0.70}, kDenseInPlane = 0.87;
constexpr double kWallShare = 0.3, kLeastShare = 0.4;

/// Files this much smaller than told may still fit.
constexpr double kFileTolerance = 0.8;

double bandVoxels(const FieldPlan& f) {
    const double h = f.voxelSize, cube = h * h * h;
    return (std::min(f.volume, f.area * (f.depth + h)) + f.area * kOutside * h) / cube;
}

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// A row of a format, bytes, for sphere and file; the largest seen for bones in mm.
struct Row {
    const char* name;  ///< prefix or extension
    double bytes;
};
constexpr Row kRows[] = {{"contacts:", 310}, {"lammps-bonds:", 195}, {"lammps:", 118},
                         {"liggghts:", 118}, {"yade:", 86},          {"blender:", 44},
                         {"points:", 27},    {".csv", 124},          {".vtp", 77},
                         {".vdb", 27},       {".ply", 32.5},         {".xyz", 126},
                         {".npz", 73},       {".data", 118},         {".svg", 110}};
/// A void in a list, a voxel of a level set, a voxel's face of a contour.
constexpr double kListedVoid = 190, kVoxelInFile = 4.4, kDeepVoxelInFile = 1, kFaceInFile = 150;
/// A face of a contour while it is made and written.
constexpr double kFace = 145;

/// Faces of voxels that the walls of voids pass, where they are not inside of other voids.
double voidFaces(const Extent& e) {
    if (!(e.voidVoxel > 0) || !(e.domainVolume > 0) || e.dim != 3) return 0;
    const double a = e.voidLength, b = e.voidRadius;
    // Thomsen's formula for the area of an ellipsoid.
    const double each =
        4 * kPi * std::pow((2 * std::pow(a * b, 1.6) + std::pow(b, 3.2)) / 3, 1 / 1.6);
    const double outside = std::exp(-e.voids * Measure<3>::ball(b) * a / b / e.domainVolume);
    return e.voids * each * outside / (e.voidVoxel * e.voidVoxel);
}

double fileBytes(const std::string& output, const Extent& e) {
    const auto starts = [&](const char* prefix) { return output.rfind(prefix, 0) == 0; };
    if (starts("list:")) return kListedVoid * e.voids;
    // The walls of the level sets, in voxels of theirs.
    const bool cut = e.voidVoxel > 0 && e.voids > 0 && e.dim == 3;
    const double h = cut ? e.voidVoxel : e.field.voxelSize;
    double wall = h > 0 ? e.domainArea / (h * h) : 0;
    double band = 2 * kOutside * wall, deep = 0;
    if (h > 0 && e.field.triangles > 0 && !cut) deep = std::max(0.0, bandVoxels(e.field) - band);
    if (cut) {
        const double faces = voidFaces(e);
        band = std::min(6 * faces, e.domainVolume / (h * h * h)) + 6 * wall;
        wall += faces;
    }
    if (isSolidOutput(output) && !endsWith(output, ".vdb")) {
        // The surface of a mesh is written as it is, by triangles of 50 bytes.
        const bool surface = starts("surface:") || (!cut && filePart(output) == output);
        if (surface && e.field.triangles > 0)
            return 84 + 50 * static_cast<double>(e.field.triangles);
        return kFaceInFile * wall;
    }
    double bytes = 0;
    if (isSolidOutput(output))
        bytes = kVoxelInFile * band * (cut ? 2 : 1) + kDeepVoxelInFile * deep;
    if (starts("levelsets:") || starts("fog:")) return bytes;
    for (const Row& row : kRows)
        if (row.name[0] == '.' ? endsWith(output, row.name) : starts(row.name))
            return bytes + row.bytes * e.count;
    return bytes;
}

double meanOf(const std::string& spec, int dim, double otherwise) {
    return spec.empty() ? otherwise : SizeDistribution::parse(spec, dim).mean();
}

double fileSize(const std::string& name) {
    std::error_code failed;
    const auto bytes = std::filesystem::file_size(name, failed);
    return failed ? 0 : static_cast<double>(bytes);
}

/// Voids of a list, each as large as their mean volume (2D: area) and mean b tell.
template <int Dim>
void addListed(Extent& e, const VoidRecipe& r) {
    const auto list = readVoidList<Dim>(listFile(r));
    e.voids = static_cast<double>(list.size());
    if (list.empty()) return;
    double across = 0, volume = 0;
    for (const auto& v : list) {
        across += std::pow(v.b, Dim - 1);
        volume += v.a * std::pow(v.b, Dim - 1);
    }
    e.voidRadius = std::pow(across / e.voids, 1.0 / (Dim - 1));
    e.voidLength = volume / across;
    e.voidVoxel = voidVoxelFor(r, leastHalfAxis(list));
}

}  // namespace

void addVoids(Extent& e, const VoidRecipe& r, double largest) {
    const VoidMethod method = methodOf(r);
    if (method == VoidMethod::none || isThinning(method) || !(e.domainVolume > 0)) return;
    e.voidRadius = meanOf(r.radius, e.dim, 2 * largest);
    if (r.targetTbth && r.radius.empty()) e.voidRadius = 1.2 * *r.targetTbth;
    const double aspect = method == VoidMethod::mixed ? 1 : meanOf(r.aspect, e.dim, 2);
    e.voidLength = e.voidRadius * aspect;
    e.voidVoxel = plannedVoxel(r, e.dim);
    if (!(e.voidVoxel > 0)) e.voidVoxel = 0.75 * e.voidRadius / 4;
    if (r.targetTbth) e.voidVoxel = std::min(e.voidVoxel, *r.targetTbth / 4);
    const double ball =
        e.dim == 3 ? Measure<3>::ball(e.voidRadius) : Measure<2>::ball(e.voidRadius);
    // Those that reach in from outside, too.
    const double around = e.domainVolume + e.domainArea * e.voidLength;
    const double density = r.targetBvtv ? -std::log(*r.targetBvtv) / (ball * aspect)
                           : r.count    ? *r.count / e.domainVolume
                                        : -std::log(0.3) / (ball * aspect);
    switch (method) {
        case VoidMethod::grid: {
            const double side = r.cell.empty() ? 0 : std::strtod(r.cell.c_str(), nullptr);
            if (!(side > 0)) return;  // as many as a matrix has: few
            e.voids = e.domainVolume / std::pow(side, e.dim);
            e.voidRadius = e.voidLength = side / 2;
            if (!(r.voxelSize > 0)) e.voidVoxel = side / 2 / 4;
            break;
        }
        case VoidMethod::overlay:
            e.voids = 0.6 * e.domainVolume / (ball * std::pow(std::max(1.0, aspect), e.dim));
            if (r.count) e.voids = std::min(e.voids, *r.count);
            break;
        case VoidMethod::mixed:
        case VoidMethod::ellipses:
            e.voids =
                r.targetBvtv ? density * e.domainVolume : r.probability.value_or(0.02) * e.count;
            break;
        case VoidMethod::list:
            e.voidVoxel = r.voxelSize;
            e.voids = 0;
            // A pipe is read once, by what cuts them.
            if (std::error_code failed; !std::filesystem::is_regular_file(listFile(r), failed))
                break;
            e.dim == 3 ? addListed<3>(e, r) : addListed<2>(e, r);
            break;
        default:
            e.voids = density * around;
    }
}

Needs needsOf(const Extent& e) {
    Needs n;
    n.extent = e;
    n.program = kProgram + kPerThread * e.threads;
    n.mesh = kPerTriangle * static_cast<double>(e.field.triangles);
    n.image = kImageVoxel * e.imageVoxels;
    double built = 0, held = 0;
    if (e.field.triangles > 0 && e.field.voxelSize > 0) {
        const double band = bandVoxels(e.field);
        const double wall = e.field.area / (e.field.voxelSize * e.field.voxelSize);
        built = kBandBuilt * band + kWallBuilt * wall;
        held = kBandHeld * band + kWallHeld * wall;
    }
    double each = e.field.triangles > 0 ? kGivenInMesh : kGiven;
    if (e.placing) {
        each = e.dim == 2 ? kPlacedInPlane : e.field.triangles > 0 ? kPlacedInMesh : kPlaced;
        if (e.searching) each += kSecondPack;
    }
    if (e.densifying) each = std::max(each, e.field.triangles > 0 ? kMovedInMesh : kMoved);
    double voids = 0;
    if (e.voids > 0 && e.voidVoxel > 0) {
        const double h = e.voidVoxel, side = kLeafSide * h, tile = std::pow(side, e.dim);
        double entries = e.voids;
        const double length[3] = {e.voidLength, e.voidRadius, e.voidRadius};
        for (int d = 0; d < e.dim; ++d)
            entries *= 2 * (0.5 * (length[d] + e.voidRadius) + kVoidBand * h) / side + 1;
        const double leaves = std::min(entries, (e.domainVolume + e.domainArea * side) / tile) +
                              (e.dim == 3 ? e.domainArea * side / tile : 0);
        voids = entries * kAtLeaf + leaves * (e.field.triangles > 0 ? kLeafInMesh : kLeaf);
    }
    double pairs = 0, contour = 0;
    for (const auto& output : e.outputs) {
        if (isSolidOutput(output) && filePart(output).rfind(".vdb") == std::string::npos) {
            const double h = e.voids > 0 ? e.voidVoxel : e.field.voxelSize;
            contour = kFace * (voidFaces(e) + (h > 0 ? e.domainArea / (h * h) : 0));
        }
        if (output.rfind("contacts:", 0) == 0 || output.rfind("lammps-bonds:", 0) == 0)
            pairs = kPairs * e.count;
    }
    double picture = 0;
    if (!e.preview.file.empty() || endsWith(e.reportFile, ".html"))
        picture = kDrawn * e.count + kPixel * static_cast<double>(e.preview.width) *
                                         static_cast<double>(e.preview.height);
    struct Stage {
        double field, spheres, voids, picture;
        double sum() const { return field + spheres + voids + picture; }
    };
    const double standing = kStanding * e.count;
    const Stage stages[] = {{built, 0, 0, 0},
                            {held, each * e.count, 0, 0},
                            {held, standing, voids, 0},
                            {held, standing + pairs, 0.9 * voids + contour, picture}};
    const Stage& most =
        *std::max_element(std::begin(stages), std::end(stages),
                          [](const Stage& a, const Stage& b) { return a.sum() < b.sum(); });
    n.field = most.field;
    n.spheres = most.spheres;
    n.voids = most.voids;
    n.picture = most.picture;
    for (const auto& output : e.outputs) n.files.push_back({output, fileBytes(output, e)});
    return n;
}

Extent extentOf(const DomainSource& source, double detail, double reach, double voxelSize) {
    Extent e;
    e.dim = source.dim();
    e.field = source.plan(detail, reach, voxelSize);
    if (!source.isFile()) {
        const auto built = source.build(0, 0);
        e.domainVolume = built.space ? built.space->volume() : built.plane->volume();
        e.domainArea = built.space ? built.space->wallArea() : built.plane->wallArea();
    } else if (e.dim == 2) {
        // The slice is not known yet: no more than its rectangle.
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
    e.placing = true;
    e.outputs = recipe.outputs;
    e.preview = recipe.preview;
    e.reportFile = recipe.reportFile;
    e.threads = effectiveThreads(recipe.threads);
    e.searching = requested.targetCount > 0;
    const double ratio = sizes.max() / sizes.min();
    const double wall =
        e.domainVolume > 0 ? kWallShare * sizes.mean() * radii.scale * e.domainArea / e.domainVolume
                           : 0;
    const double dense = (e.dim == 2      ? kDenseInPlane
                          : ratio < 1.05  ? kDense[0]
                          : ratio <= 2.05 ? kDense[1]
                                          : kDense[2]) *
                         std::max(kLeastShare, 1 - wall);
    const double shell = 1 + 0.5 * recipe.gap / (sizes.mean() * radii.scale);
    e.count = e.searching
                  ? 1.02 * requested.targetCount
                  : dense * e.domainVolume / (sizes.meanBall(e.dim) * std::pow(shell, e.dim));
    if (recipe.maxCount > 0) e.count = std::min(e.count, static_cast<double>(recipe.maxCount));
    e.densifying = recipe.densify > 0;
    // More by a share that most of them are far from.
    if (e.densifying && !e.searching) e.count *= 1.05;
    addVoids(e, recipe.voids, sizes.max() * radii.scale);
    // Whoever wrote it: about so many.
    if (!recipe.existing.empty()) e.count += fileSize(recipe.existing) / 40;
    return e;
}

double memoryLimit(double limit) {
    return limit > 0 ? limit : residentMemory() + availableMemory();
}

void requireResources(const Needs& n, double limit) {
    const Extent& e = n.extent;
    if (n.memory() > limit) {
        struct Part {
            double bytes;
            std::string text;
            const char* remedy;
        };
        const Part parts[] = {
            {n.spheres,
             fmt::format("{} for about {:.3g} {}", bytesText(n.spheres), e.count,
                         e.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres),
             "ask for larger radii, for fewer with --target-count or --max-count, or clip the "
             "domain"},
            {n.field,
             fmt::format("{} for a field of about {:.2g} voxels of {:.4g} mm", bytesText(n.field),
                         e.field.triangles > 0 ? bandVoxels(e.field) : 0, e.field.voxelSize),
             "give a larger --voxel, larger radii, or check the unit of the mesh"},
            {n.voids,
             fmt::format("{} for about {:.3g} voids in voxels of {:.4g} mm", bytesText(n.voids),
                         e.voids, e.voidVoxel),
             "give a larger --void-voxel, larger voids, or clip the domain"},
            {n.picture,
             fmt::format("{} for a picture of {} x {}", bytesText(n.picture), e.preview.width,
                         e.preview.height),
             "give a smaller --preview-size"},
            {n.mesh, fmt::format("{} for {} triangles", bytesText(n.mesh), e.field.triangles),
             "take a mesh of fewer triangles"},
            {n.image,
             fmt::format("{} for an image of about {:.2g} voxels", bytesText(n.image),
                         e.imageVoxels),
             "give a larger --voxel"},
            {n.program, fmt::format("{} for the program", bytesText(n.program)),
             "that is the least there can be, raise the limit"}};
        const auto* most =
            std::max_element(std::begin(parts), std::end(parts),
                             [](const Part& a, const Part& b) { return a.bytes < b.bytes; });
        std::string list;
        for (const Part& part : parts)
            if (part.bytes > 0.02 * n.memory()) list += (list.empty() ? "" : ", ") + part.text;
        throw ResourceError(fmt::format(
            "would take about {} of memory, and {} may be taken (--memory-limit): {}; {}",
            bytesText(n.memory()), bytesText(limit), list, most->remedy));
    }
    // What one file system has to hold, all together.
    std::map<std::uint64_t, double> needed;
    for (const Needs::File& file : n.files) {
        std::uint64_t device = 0;
        const double there = availableSpace(filePart(file.name), &device);
        needed[device] += file.bytes;
        if (kFileTolerance * needed[device] > there)
            throw ResourceError(fmt::format(
                "{}: would take about {}{}, and {} are free there; write a smaller format (.vdb), "
                "fewer spheres, or to another disk",
                file.name, bytesText(file.bytes),
                needed[device] > 1.01 * file.bytes
                    ? fmt::format(", with the files before it {}", bytesText(needed[device]))
                    : std::string(),
                bytesText(there)));
    }
}

void requireRoom(const RunSettings& settings, Extent extent) {
    extent.outputs = settings.outputs;
    extent.preview = settings.preview;
    extent.reportFile = settings.reportFile;
    extent.threads = effectiveThreads(settings.threads);
    requireResources(needsOf(extent), memoryLimit(settings.memoryLimit));
}

void requireResources(const PackRecipe& recipe, const DomainSource& source) {
    const double limit = memoryLimit(recipe.memoryLimit);
    Extent extent = extentOf(recipe, source);
    if (extent.dim == 2 && source.isFile() && needsOf(extent).memory() > limit) {
        const double share = source.volume() / extent.domainVolume;
        extent.domainVolume *= share;
        if (!extent.searching) extent.count *= share;
        extent.voids *= share;
    }
    requireResources(needsOf(extent), limit);
}

nlohmann::ordered_json toJson(const Needs& n) {
    nlohmann::ordered_json json;
    const auto whole = [](double bytes) { return std::llround(std::min(bytes, 9e18)); };
    json["memory"] = {{"program", whole(n.program)}, {"mesh", whole(n.mesh)},
                      {"field", whole(n.field)},     {"spheres", whole(n.spheres)},
                      {"voids", whole(n.voids)},     {"picture", whole(n.picture)},
                      {"image", whole(n.image)}};
    json["files"] = nlohmann::ordered_json::array();
    for (const auto& file : n.files)
        json["files"].push_back({{"name", file.name}, {"bytes", whole(file.bytes)}});
    return json;
}

std::string summary(const Needs& n) {
    std::string parts;
    const auto add = [&](const char* name, double bytes) {
        if (bytes > 0.02 * n.memory())
            parts += fmt::format("{}{} {}", parts.empty() ? "" : ", ", name, bytesText(bytes));
    };
    add("spheres", n.spheres);
    add("field", n.field);
    add("voids", n.voids);
    add("picture", n.picture);
    add("image", n.image);
    add("mesh", n.mesh);
    std::string text = fmt::format("{:<11}about {} at most{}\n", "memory", bytesText(n.memory()),
                                   parts.empty() ? "" : " (" + parts + ')');
    for (const auto& file : n.files)
        text += fmt::format("{:<11}{} about {}\n", "file", file.name, bytesText(file.bytes));
    return text;
}

}  // namespace vdbpack
