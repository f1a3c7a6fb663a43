// Private: the pack formats, each with its writer and its reader. A further one is a row here.
#pragma once

#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/pack_target.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/io/output_file.h"

#include <string>

namespace vdbpack {

/// Refuses what no format can hold: attributes of the wrong length, spheres that are not finite or
/// have no positive radius. @throws ParameterError
template <int Dim>
void checkPack(const Pack<Dim>& pack);

/// Each writes into `out`, which the caller commits. @throws IoError
void writeCsv(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeYade(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeSpherePack(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeSvg(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writePly(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeVtp(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeXyz(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeNpz(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeVdb(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
/// The points of a .vdb, without level sets.
void writePoints(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeUsd(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeUsdz(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeLammps(const PackView& pack, const PackWriteOptions& options, OutputFile& out);
void writeLammpsBonds(const PackView& pack, const PackWriteOptions& options, OutputFile& out);

/// Each reads the file at `path`. @throws IoError, InputError
Pack<3> readCsv(const std::string& path, const PackReadOptions& options);
/// A table, or what the beginning of the file says that it is.
Pack<3> readTextFile(const std::string& path, const PackReadOptions& options);
Pack<3> readYade(const std::string& path, const PackReadOptions& options);
Pack<3> readMfix(const std::string& path, const PackReadOptions& options);
Pack<3> readMercury(const std::string& path, const PackReadOptions& options);
Pack<3> readGeo(const std::string& path, const PackReadOptions& options);
Pack<3> readPly(const std::string& path, const PackReadOptions& options);
Pack<3> readVtp(const std::string& path, const PackReadOptions& options);
Pack<3> readVtu(const std::string& path, const PackReadOptions& options);
Pack<3> readPvtp(const std::string& path, const PackReadOptions& options);
Pack<3> readPvtu(const std::string& path, const PackReadOptions& options);
Pack<3> readVtk(const std::string& path, const PackReadOptions& options);
Pack<3> readVtkHdf(const std::string& path, const PackReadOptions& options);
Pack<3> readXyz(const std::string& path, const PackReadOptions& options);
Pack<3> readNpz(const std::string& path, const PackReadOptions& options);
Pack<3> readVdb(const std::string& path, const PackReadOptions& options);
Pack<3> readLammpsData(const std::string& path, const PackReadOptions& options);
Pack<3> readLammpsDump(const std::string& path, const PackReadOptions& options);

/// A prefix ("yade:f.txt") or an extension, the format that it names, and what handles the format.
struct FormatName {
    const char* name;
    PackFormat format;
    PackTarget::Write write;
    PackTarget::Read read;
    bool extension = true;  ///< not only a prefix
};
inline constexpr FormatName kFormatNames[] = {
    {"vdb", PackFormat::vdb, writeVdb, readVdb},
    {"vtp", PackFormat::other, writeVtp, readVtp},
    {"pvtp", PackFormat::pvtp, nullptr, readPvtp},
    {"vtu", PackFormat::other, nullptr, readVtu},
    {"pvtu", PackFormat::other, nullptr, readPvtu},
    {"vtk", PackFormat::other, nullptr, readVtk},
    {"vtkhdf", PackFormat::vtkhdf, nullptr, readVtkHdf},
    {"hdf", PackFormat::vtkhdf, nullptr, readVtkHdf},
    {"ply", PackFormat::other, writePly, readPly},
    {"csv", PackFormat::csv, writeCsv, readCsv},
    {"tsv", PackFormat::other, nullptr, readCsv},
    {"txt", PackFormat::other, nullptr, readTextFile},
    {"dat", PackFormat::other, nullptr, readTextFile},
    {"input", PackFormat::other, nullptr, readTextFile},
    {"restart", PackFormat::other, nullptr, readMercury},
    {"geo", PackFormat::other, nullptr, readGeo},
    {"points", PackFormat::points, writePoints, readVdb, false},
    {"npz", PackFormat::other, writeNpz, readNpz},
    {"xyz", PackFormat::other, writeXyz, readXyz},
    {"extxyz", PackFormat::other, writeXyz, readXyz},
    {"usda", PackFormat::usd, writeUsd, nullptr},
    {"usd", PackFormat::usd, writeUsd, nullptr},
    {"usdz", PackFormat::usdz, writeUsdz, nullptr},
    {"svg", PackFormat::svg, writeSvg, nullptr},
    {"yade", PackFormat::yade, writeYade, readYade, false},
    {"spherepack", PackFormat::spherePack, writeSpherePack, readYade, false},
    {"data", PackFormat::lammpsData, writeLammps, readLammpsData},
    {"lammps", PackFormat::lammpsData, writeLammps, readLammpsData, false},
    {"liggghts", PackFormat::lammpsData, writeLammps, readLammpsData, false},
    {"lammps-bonds", PackFormat::lammpsBonds, writeLammpsBonds, readLammpsData, false},
    {"dump", PackFormat::lammpsDump, nullptr, readLammpsDump},
    {"lammpstrj", PackFormat::lammpsDump, nullptr, readLammpsDump},
};

}  // namespace vdbpack
