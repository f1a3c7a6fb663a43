// Private: the writers and readers of the pack formats.
#pragma once

#include "vdbpack/formats/pack_file.h"
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
Pack<3> readYade(const std::string& path, const PackReadOptions& options);
Pack<3> readPly(const std::string& path, const PackReadOptions& options);
Pack<3> readVtp(const std::string& path, const PackReadOptions& options);
Pack<3> readPvtp(const std::string& path, const PackReadOptions& options);
Pack<3> readVtkHdf(const std::string& path, const PackReadOptions& options);
Pack<3> readXyz(const std::string& path, const PackReadOptions& options);
Pack<3> readNpz(const std::string& path, const PackReadOptions& options);
Pack<3> readVdb(const std::string& path, const PackReadOptions& options);
Pack<3> readLammpsData(const std::string& path, const PackReadOptions& options);
Pack<3> readLammpsDump(const std::string& path, const PackReadOptions& options);

}  // namespace vdbpack
