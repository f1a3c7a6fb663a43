#include "vdbpack/formats/pack_target.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/text.h"

#include <optional>

namespace vdbpack {

namespace {

constexpr const char* kWritten =
    "use .vdb, .vtp, .pvtp, .vtkhdf, .ply, .csv, .xyz, .npz, .usda, .usdz, .data or lammps:FILE, "
    "lammps-bonds:FILE, yade:FILE, points:FILE.vdb, .svg for circles, .stl, levelsets: or "
    "fog:FILE.vdb for surfaces, blender:FILE.py, contacts:, materials: or list:FILE.csv, "
    "labels:FILE.nii.gz";
constexpr const char* kRead =
    "use .vdb, .vtp, .pvtp, .vtkhdf, .ply, .csv, .xyz, .npz, .data or lammps:FILE, .dump, "
    ".lammpstrj or dump:FILE, yade:FILE";

/// A prefix ("yade:f.txt") or an extension, the format that it names, and what handles the format.
struct FormatName {
    const char* name;
    PackFormat format;
    PackTarget::Write write;
    PackTarget::Read read;
    bool extension = true;  ///< not only a prefix
};
constexpr FormatName kFormatNames[] = {
    {"vdb", PackFormat::vdb, writeVdb, readVdb},
    {"vtp", PackFormat::vtp, writeVtp, readVtp},
    {"pvtp", PackFormat::pvtp, nullptr, readPvtp},
    {"vtkhdf", PackFormat::vtkhdf, nullptr, readVtkHdf},
    {"hdf", PackFormat::vtkhdf, nullptr, readVtkHdf},
    {"ply", PackFormat::ply, writePly, readPly},
    {"csv", PackFormat::csv, writeCsv, readCsv},
    {"points", PackFormat::points, writePoints, readVdb, false},
    {"npz", PackFormat::npz, writeNpz, readNpz},
    {"xyz", PackFormat::xyz, writeXyz, readXyz},
    {"extxyz", PackFormat::xyz, writeXyz, readXyz},
    {"usda", PackFormat::usd, writeUsd, nullptr},
    {"usd", PackFormat::usd, writeUsd, nullptr},
    {"usdz", PackFormat::usdz, writeUsdz, nullptr},
    {"svg", PackFormat::svg, writeSvg, nullptr},
    {"yade", PackFormat::yade, writeYade, readYade, false},
    {"data", PackFormat::lammpsData, writeLammps, readLammpsData},
    {"lammps", PackFormat::lammpsData, writeLammps, readLammpsData, false},
    {"liggghts", PackFormat::lammpsData, writeLammps, readLammpsData, false},
    {"lammps-bonds", PackFormat::lammpsBonds, writeLammpsBonds, readLammpsData, false},
    {"dump", PackFormat::lammpsDump, nullptr, readLammpsDump},
    {"lammpstrj", PackFormat::lammpsDump, nullptr, readLammpsDump},
};

/// @param name  without the dot of an extension.
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
    return PackTarget{known->format, file.substr(colon + 1), known->write, known->read};
}

/// By prefix, else by extension.
std::optional<PackTarget> knownTarget(const std::string& file) {
    if (auto known = prefixed(file)) return known;
    const auto* known = formatNamed(extensionOf(file).erase(0, 1));
    if (known == nullptr || !known->extension) return std::nullopt;
    return PackTarget{known->format, file, known->write, known->read};
}

/// The same; `formats` lists the known ones, for messages.
PackTarget target(const std::string& file, const char* formats) {
    if (auto known = knownTarget(file)) return *std::move(known);
    throw ParameterError(file + ": '" + extensionOf(file) + "' is not a pack format; " + formats);
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
    if (t.read == nullptr)
        throw ParameterError(file +
                             ": this format is written but not read; write the pack as .vtp or "
                             ".csv beside it, or export the spheres as one of these from the "
                             "program that made the file. To read a pack, " +
                             kRead);
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
