#include "vdbpack/mesh/formats/mesh_io.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/mesh_reader.h"
#include "vdbpack/mesh/welding.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <new>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

namespace vdbpack {

namespace {

/// Coordinates beyond this are no bone in any unit, and their squares lose the digits, mm.
constexpr double kLargest = 1e9;

/// Why a file of another format is not read as a mesh, and what to do.
[[noreturn]] void refuseFormat(const std::string& path, const std::string& extension) {
    static const std::set<std::string> kImages{".nii", ".nrrd", ".nhdr", ".mha", ".mhd",
                                               ".dcm", ".hdr",  ".img",  ".tif", ".tiff"};
    std::error_code ignored;
    const bool isFolder = std::filesystem::is_directory(path, ignored);
    if (isFolder || kImages.count(extension) > 0 || endsWith(lowered(path), ".nii.gz"))
        throw InputError(fmt::format(
            "{}: {}, not a mesh. A domain can be an image, with a label or a threshold; what else "
            "needs a mesh takes its surface as .stl",
            path, isFolder ? "is a folder, perhaps a series of images" : "is an image"));
    for (const char* scan : {".isq", ".rsq", ".aim"})
        if (startsWith(extension, scan))
            throw InputError(path +
                             ": is a scan of SCANCO, which is not read; convert it to .nrrd or "
                             ".mha, with 3D Slicer "
                             "or with IOScanco of ITK (Python: itk-ioscanco), and set `threshold`");
    static const std::set<std::string> kOtherImages{".mif", ".mih", ".mnc", ".mgh",
                                                    ".mgz", ".vti", ".inr", ".gipl"};
    if (kOtherImages.count(extension) > 0)
        throw InputError(path +
                         ": is an image of a format that is not read; convert it to .nii.gz, "
                         ".nrrd or .mha, and set `threshold` or `label`");
    if (extension == ".raw" || extension == ".zraw")
        throw InputError(path +
                         ": holds the pixels of an image without their number and size; give the "
                         "header beside it (.mhd, .nhdr)");
    static const std::set<std::string> kPacks{".csv", ".data", ".dump", ".lammpstrj", ".xyz"};
    if (kPacks.count(extension) > 0)
        throw InputError(path +
                         ": is a table or a pack, and no mesh; a pack is read as `existing`, or by "
                         "densify, carve, measure and convert");
    if (extension.empty() || extension == ".toml") requireThere(path);
    if (extension == ".toml")
        throw InputError(path + ": holds options (`config`) or parts (`parts`) and no mesh");
    throw InputError(
        path + ": format " + quotedExcerpt(extension) +
        " is not read as a mesh; convert it to .stl, .obj, .ply, .off, .gts, .vtp or .vtk");
}

/// The axes that a header or comment near the beginning of a file states.
std::optional<ImageSpace> statedSpace(std::string_view head) {
    if (head.find("SPACE=RAS") != std::string_view::npos) return ImageSpace::ras;
    if (head.find("SPACE=LPS") != std::string_view::npos) return ImageSpace::lps;
    return std::nullopt;
}

/// Turns the mesh into the axes of the world by half a turn about z.
void turnMesh(TriangleMesh& mesh, const std::string& path, ImageSpace world,
              const Callbacks& callbacks) {
    for (Vec<3>& v : mesh.vertices)
        for (int d = 0; d < 2; ++d) v[d] = 0 - v[d];
    const bool isLps = world == ImageSpace::lps;
    callbacks.warn(fmt::format(
        "{}: states SPACE={}. Its x and y are given the other sign, since the axes of images are "
        "{} here; set `space` {} to keep the coordinates as they are",
        path, isLps ? "RAS" : "LPS", isLps ? "LPS" : "RAS", isLps ? "ras" : "lps"));
}

void warnOfCrossed(const CrossedFaces& crossed, const std::string& path, double factor,
                   const Callbacks& callbacks) {
    if (crossed.count == 0) return;
    const Vec<3> at = crossed.firstAt * factor;
    callbacks.warn(fmt::format(
        "{}: the outlines of {} faces cross themselves, first at ({:.6g}, {:.6g}, {:.6g}). "
        "Their triangles overlap: export the mesh as triangles",
        path, crossed.count, at[0], at[1], at[2]));
}

}  // namespace

TriangleMesh readMesh(const std::string& path, const MeshReadOptions& options,
                      const Callbacks& callbacks, MeshGroups* groups) {
    if (!std::isfinite(options.scale) || options.scale <= 0)
        throw ParameterError(
            fmt::format("scale {} is not a positive number; use one such as 0.1", options.scale));
    const std::string extension = extensionOf(path);
    void (*read)(MeshReader&) = nullptr;
    if (extension == ".stl") read = readStlMesh;
    if (extension == ".obj") read = readObjMesh;
    if (extension == ".ply") read = readPlyMesh;
    if (extension == ".off") read = readOffMesh;
    if (extension == ".gts") read = readGtsMesh;
    if (extension == ".vtk") read = readVtkMesh;
    if (extension == ".vtp") read = readVtpMesh;
    if (read == nullptr) refuseFormat(path, extension);
    double factor = millimetersPer(options.unit) * options.scale;
    TriangleMesh mesh;
    try {
        InputFile file(path);
        if (file.size() == 0) file.fail("is empty; export the mesh again");
        file.skipByteOrderMark();
        MeshReader reader{file, kLargest / factor};
        const std::string_view head = file.peek(1000);
        reader.statedSpace = statedSpace(head);
        // Maya writes this comment whatever the shape was made in.
        if (head.find("uses centimeters as units") != std::string_view::npos &&
            options.unit == Unit::millimeter)
            callbacks.warn(path +
                           ": states centimeters and is read in mm; set `unit` cm if its "
                           "lengths are 10 times as large");
        read(reader);
        splitPolygons(reader);
        if (reader.statedUnit) {
            factor = millimetersPer(*reader.statedUnit) * options.scale;
            if (options.unit != Unit::millimeter && options.unit != *reader.statedUnit)
                callbacks.warn(fmt::format(
                    "{}: states that its lengths are in {}, so that `unit` {} has no effect; set "
                    "`scale` if the file is wrong",
                    path, unitName(*reader.statedUnit), unitName(options.unit)));
        }
        mesh = std::move(reader.mesh);
        if (groups != nullptr) *groups = std::move(reader.groups);
        if (mesh.triangles.empty()) file.fail("has no triangles; a closed surface is needed");
        if (extension != ".stl") mesh = welded(std::move(mesh));
        warnOfCrossed(reader.crossed, path, factor, callbacks);
        if (reader.statedSpace.value_or(options.space) != options.space)
            turnMesh(mesh, path, options.space, callbacks);
    } catch (const std::bad_alloc&) {
        throw ResourceError(path + ": not enough memory to read it; simplify the mesh");
    }
    if (factor != 1.0)
        for (auto& v : mesh.vertices) v *= factor;
    return mesh;
}

}  // namespace vdbpack
