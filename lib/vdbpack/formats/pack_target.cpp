#include "vdbpack/formats/pack_target.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/text.h"

#include <optional>

namespace vdbpack {

namespace {

constexpr const char* kWritten =
    "use .vdb, .vtp, .pvtp, .vtkhdf, .ply, .csv, .xyz, .npz, .usda, .usdz, .data or lammps:FILE, "
    "lammps-bonds:FILE, yade:FILE, points:FILE.vdb, .svg for circles, .stl, levelsets: or "
    "fog:FILE.vdb for surfaces, "
    "blender:FILE.py, contacts:, materials: or list:FILE.csv, labels:FILE.nii.gz";
constexpr const char* kRead =
    "use .vdb, .vtp, .pvtp, .vtkhdf, .ply, .csv, .xyz, .npz, .usda, .usdz, .data or "
    "lammps:FILE, .dump, "
    ".lammpstrj or dump:FILE, yade:FILE";

/// A prefix ("yade:f.txt") or an extension, and the format that it names.
struct FormatName {
    const char* name;
    PackFormat format;
    bool extension = true;  ///< not only a prefix
};
constexpr FormatName kFormatNames[] = {
    {"vdb", PackFormat::vdb},
    {"vtp", PackFormat::vtp},
    {"pvtp", PackFormat::pvtp},
    {"vtkhdf", PackFormat::vtkhdf},
    {"hdf", PackFormat::vtkhdf},
    {"ply", PackFormat::ply},
    {"csv", PackFormat::csv},
    {"points", PackFormat::points, false},
    {"npz", PackFormat::npz},
    {"xyz", PackFormat::xyz},
    {"extxyz", PackFormat::xyz},
    {"usda", PackFormat::usd},
    {"usd", PackFormat::usd},
    {"usdz", PackFormat::usdz},
    {"svg", PackFormat::svg},
    {"yade", PackFormat::yade, false},
    {"data", PackFormat::lammpsData},
    {"lammps", PackFormat::lammpsData, false},
    {"liggghts", PackFormat::lammpsData, false},
    {"lammps-bonds", PackFormat::lammpsBonds, false},
    {"dump", PackFormat::lammpsDump},
    {"lammpstrj", PackFormat::lammpsDump},
};

const FormatName* formatNamed(const std::string& name) {
    for (const auto& known : kFormatNames)
        if (lowered(name) == known.name) return &known;
    return nullptr;
}

/// The format named by the prefix and the file after it, if there is such a prefix.
std::optional<PackTarget> prefixed(const std::string& file) {
    const auto colon = file.find(':');
    if (colon == std::string::npos) return std::nullopt;
    const auto* known = formatNamed(file.substr(0, colon));
    if (known == nullptr) return std::nullopt;
    if (colon + 1 == file.size())
        throw ParameterError(file + ": names a format but no file; write " + file + "FILE");
    return PackTarget{known->format, file.substr(colon + 1)};
}

/// The extension of a file without its dot; empty if there is none.
std::string extensionIn(const std::string& file) {
    const auto dot = file.rfind('.');
    const auto slash = file.rfind('/');
    const bool extended =
        dot != std::string::npos && (slash == std::string::npos || dot > slash + 1);
    return extended ? file.substr(dot + 1) : "";
}

/// By prefix, else by extension.
std::optional<PackTarget> knownTarget(const std::string& file) {
    if (auto known = prefixed(file)) return known;
    const auto* known = formatNamed(extensionIn(file));
    if (known == nullptr || !known->extension) return std::nullopt;
    return PackTarget{known->format, file};
}

/// The same; `formats` lists the known ones, for messages.
PackTarget target(const std::string& file, const char* formats) {
    if (auto known = knownTarget(file)) return *std::move(known);
    const std::string extension = extensionIn(file);
    throw ParameterError(file + ": '" + (extension.empty() ? "" : "." + extension) +
                         "' is not a pack format; " + formats);
}

}  // namespace

PackTarget targetToWrite(const std::string& file, int dim) {
    PackTarget t = target(file, kWritten);
    if (t.format == PackFormat::lammpsDump)
        throw ParameterError(file + ": dumps are read but not written; " + kWritten);
    if (t.format == PackFormat::svg && dim == 3)
        throw ParameterError(
            file + ": is a picture of circles; for spheres write .vtp or .vdb, or set `slice` z=V");
    return t;
}

PackTarget targetToRead(const std::string& file) {
    PackTarget t = target(file, kRead);
    if (t.format == PackFormat::svg)
        throw ParameterError(file + ": pictures are written but not read; " + kRead);
    return t;
}

std::string packPath(const std::string& file) {
    const auto known = prefixed(file);
    return known ? known->path : file;
}

bool holdsSurface(const std::string& file) {
    const auto known = knownTarget(file);
    return known && (known->format == PackFormat::usd || known->format == PackFormat::usdz);
}

void checkPackFormat(const std::string& file, int dim) {
    targetToWrite(file, dim);
}

}  // namespace vdbpack
