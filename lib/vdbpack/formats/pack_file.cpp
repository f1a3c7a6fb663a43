#include "vdbpack/formats/pack_file.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

constexpr const char* kWritten =
    "use .vdb, .vtp, .ply, .csv, .xyz, .npz, .data or lammps:FILE, lammps-bonds:FILE, yade:FILE, "
    "points:FILE.vdb, .svg for circles, .stl, levelsets: or fog:FILE.vdb for surfaces, "
    "blender:FILE.py, contacts: or list:FILE.csv";
constexpr const char* kRead =
    "use .vdb, .vtp, .ply, .csv, .xyz, .npz, .data or lammps:FILE, .dump, .lammpstrj or dump:FILE, "
    "yade:FILE";

enum class Format {
    vdb,
    points,
    vtp,
    ply,
    csv,
    xyz,
    npz,
    svg,
    yade,
    lammpsData,
    lammpsBonds,
    lammpsDump
};

/// A prefix ("yade:f.txt") or extension and what it stands for.
struct FormatName {
    const char* name;
    Format format;
    bool extension = true;  ///< not only a prefix
};
constexpr FormatName kFormatNames[] = {
    {"vdb", Format::vdb},
    {"vtp", Format::vtp},
    {"ply", Format::ply},
    {"csv", Format::csv},
    {"points", Format::points, false},
    {"npz", Format::npz},
    {"xyz", Format::xyz},
    {"extxyz", Format::xyz},
    {"svg", Format::svg},
    {"yade", Format::yade, false},
    {"data", Format::lammpsData},
    {"lammps", Format::lammpsData, false},
    {"liggghts", Format::lammpsData, false},
    {"lammps-bonds", Format::lammpsBonds, false},
    {"dump", Format::lammpsDump},
    {"lammpstrj", Format::lammpsDump},
};

struct Target {
    Format format;
    std::string path;
};

const FormatName* formatNamed(const std::string& name) {
    for (const auto& known : kFormatNames)
        if (lowered(name) == known.name) return &known;
    return nullptr;
}

/// The format named by the prefix and the file after it, if there is such a prefix.
std::optional<Target> prefixed(const std::string& file) {
    const auto colon = file.find(':');
    if (colon == std::string::npos) return std::nullopt;
    const auto* known = formatNamed(file.substr(0, colon));
    if (known == nullptr) return std::nullopt;
    if (colon + 1 == file.size())
        throw ParameterError(file + ": names a format but no file; write " + file + "FILE");
    return Target{known->format, file.substr(colon + 1)};
}

/// Format by prefix, else by extension. `formats` lists the known ones, for messages.
Target target(const std::string& file, const char* formats) {
    if (auto known = prefixed(file)) return *std::move(known);
    const auto dot = file.rfind('.');
    const auto slash = file.rfind('/');
    const bool extended =
        dot != std::string::npos && (slash == std::string::npos || dot > slash + 1);
    const std::string extension = extended ? file.substr(dot + 1) : "";
    const auto* known = formatNamed(extension);
    if (known != nullptr && known->extension) return {known->format, file};
    throw ParameterError(file + ": '" + (extended ? "." + extension : "") +
                         "' is not a pack format; " + formats);
}

Target targetToWrite(const std::string& file, int dim) {
    Target t = target(file, kWritten);
    if (t.format == Format::lammpsDump)
        throw ParameterError(file + ": dumps are read but not written; " + kWritten);
    if (t.format == Format::svg && dim == 3)
        throw ParameterError(
            file + ": is a picture of circles; for spheres write .vtp or .vdb, or set `slice` z=V");
    return t;
}

}  // namespace

template <int Dim>
void checkPack(const Pack<Dim>& pack) {
    const std::size_t n = pack.spheres.size();
    forEachAttribute(pack, [n](std::string_view name, const auto& values) {
        if (!values.empty() && values.size() != n)
            throw ParameterError(fmt::format(
                "pack attribute '{}' has {} values for {} spheres; give one each, or none", name,
                values.size(), n));
    });
    for (std::size_t i = 0; i < n; ++i) {
        const auto& s = pack.spheres[i];
        // Larger ones do not fit a float in every unit.
        bool sound = s.radius > 1e-30 && s.radius < 1e30;
        for (int d = 0; d < Dim; ++d) sound = sound && std::abs(s.center[d]) < 1e30;
        if (!sound)
            throw ParameterError(fmt::format(
                "{} {} has radius {} mm and x = {} mm; a positive radius and finite lengths below "
                "1e30 mm are needed",
                Measure<Dim>::kSphere, i, s.radius, s.center[0]));
    }
    if (!(std::abs(pack.sliceHeight) < 1e30))
        throw ParameterError("the height of the slice is not finite; give it in mm");
}

template void checkPack<2>(const Pack<2>&);
template void checkPack<3>(const Pack<3>&);

double pointVoxelSize(double count, double measure, int dim) {
    if (!(count > 0) || !(measure > 0) || !std::isfinite(measure / count)) return 1;
    return std::exp2(std::round(std::log2(8 * measure / count) / dim));
}

std::string packPath(const std::string& file) {
    const auto known = prefixed(file);
    return known ? known->path : file;
}

void checkPackFormat(const std::string& file, int dim) {
    targetToWrite(file, dim);
}

template <int Dim>
void writePack(const Pack<Dim>& pack, const std::string& file, const PackWriteOptions& options) {
    const Target t = targetToWrite(file, Dim);
    checkPack(pack);
    if (!(options.pointVoxel >= 0) || !std::isfinite(options.pointVoxel))
        throw ParameterError(
            fmt::format("voxel edge of the point grid is {} mm; give a positive "
                        "length, or 0 to derive it",
                        options.pointVoxel));
    const auto checkDensity = [](double density) {
        if (!(density >= 0) || !std::isfinite(density))
            throw ParameterError(
                fmt::format("density of the spheres is {} kg/m³; give a positive one", density));
    };
    checkDensity(options.particleDensity);
    for (const auto& [region, density] : options.regionDensity) checkDensity(density);
    if (options.frame) {
        const Vec<2> size = options.frame->size();
        if (!(size[0] > 0 && size[0] < 1e30 && size[1] > 0 && size[1] < 1e30))
            throw ParameterError(
                fmt::format("the frame of the picture is {} x {} mm; give two positive lengths",
                            size[0], size[1]));
    }
    const PackView view(pack, options.unit);
    OutputFile out(t.path);
    switch (t.format) {
        case Format::vdb:
            writeVdb(view, options, out);
            break;
        case Format::vtp:
            writeVtp(view, options, out);
            break;
        case Format::ply:
            writePly(view, options, out);
            break;
        case Format::csv:
            writeCsv(view, out);
            break;
        case Format::points: {
            PackWriteOptions alone = options;
            alone.levelSets.clear();
            writeVdb(view, alone, out);
            break;
        }
        case Format::npz:
            writeNpz(view, options, out);
            break;
        case Format::xyz:
            writeXyz(view, options, out);
            break;
        case Format::svg:
            writeSvg(view, options, out);
            break;
        case Format::yade:
            writeYade(view, options, out);
            break;
        case Format::lammpsData:
            writeLammps(view, options, nullptr, out);
            break;
        case Format::lammpsBonds: {
            const auto bonds = listContacts(pack.spheres, options.contactTolerance);
            writeLammps(view, options, &bonds, out);
            break;
        }
        case Format::lammpsDump:
            break;  // refused above
    }
    out.commit();
}

template void writePack<2>(const Pack<2>&, const std::string&, const PackWriteOptions&);
template void writePack<3>(const Pack<3>&, const std::string&, const PackWriteOptions&);

Pack<3> readPack(const std::string& file, const PackReadOptions& options) {
    const Target t = target(file, kRead);
    try {
        switch (t.format) {
            case Format::vdb:
            case Format::points:
                return readVdb(t.path, options);
            case Format::vtp:
                return readVtp(t.path, options);
            case Format::ply:
                return readPly(t.path, options);
            case Format::csv:
                return readCsv(t.path, options);
            case Format::npz:
                return readNpz(t.path, options);
            case Format::xyz:
                return readXyz(t.path, options);
            case Format::lammpsData:
            case Format::lammpsBonds:
                return readLammpsData(t.path, options);
            case Format::lammpsDump:
                return readLammpsDump(t.path, options);
            case Format::yade:
                return readYade(t.path, options);
            case Format::svg:
                break;
        }
    } catch (const std::bad_alloc&) {
        throw ResourceError(t.path +
                            ": does not fit into memory; read it on a machine that has more");
    }
    throw ParameterError(file + ": pictures are written but not read; " + kRead);
}

Pack<2> asCircles(const Pack<3>& pack) {
    Pack<2> circles;
    circles.spheres.reserve(pack.spheres.size());
    if (!pack.spheres.empty()) circles.sliceHeight = pack.spheres.front().center[2];
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const auto& s = pack.spheres[i];
        // A height that was written in 32 bits and in another unit may come back slightly
        // different.
        const double tolerance = 1e-6 * std::max(s.radius, std::abs(circles.sliceHeight));
        if (std::abs(s.center[2] - circles.sliceHeight) > tolerance)
            throw InputError(fmt::format(
                "sphere {} lies at z = {} mm, sphere 0 at {} mm: these are not circles of one "
                "slice; treat the pack as spheres",
                i, s.center[2], circles.sliceHeight));
        circles.spheres.push_back({{{s.center[0], s.center[1]}}, s.radius});
    }
    static_cast<PackAttributes&>(circles) = pack;
    return circles;
}

}  // namespace vdbpack
