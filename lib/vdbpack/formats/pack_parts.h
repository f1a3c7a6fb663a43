// Packs that several ranks have shares of, or that are written in pieces.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/row_spans.h"

#include <string>
#include <vector>

namespace vdbpack {

class PackView;

/// The share that this rank has of a pack: its ids count the rows of all.
template <int Dim>
struct PackShare {
    Ranks* ranks;
    const Pack<Dim>& pack;
    std::vector<RowSpan> spans;  ///< rows of the spheres
    std::size_t pieces;          ///< of all ranks, as for `startsOfPieces`
};

/// Whether `writeShare` writes a format: .csv, yade:, .data, .pvtp, .vtkhdf, .vdb or points:.
/// @throws ParameterError if not.
void checkShareFormat(const std::string& file);

/// The name of a piece of a file: NAME_0003.EXT.
std::string pieceName(const std::string& file, std::size_t piece, const std::string& extension);

/// Write a pack of which each rank has a share, as `writeShare` says; null: this one has all.
/// @throws IoError
void writePvtp(Ranks* ranks, const PackView& pack, const PackWriteOptions& options,
               const std::string& path);
void writeVtkHdf(Ranks* ranks, const PackView& pack, const PackWriteOptions& options,
                 const std::string& path);

/// Writes the pack of all ranks; called by all. Text files are one file with its rows in order, the
/// same for any number of ranks. .vtkhdf is one file, .pvtp and .vdb one piece a rank:
/// NAME_0000.vtp and so on beside NAME.pvtp, and NAME_0000.vdb, of which the first has the level
/// sets.
/// @return the files, on each rank. @throws ParameterError, IoError
template <int Dim>
std::vector<std::string> writeShare(const PackShare<Dim>& share, const std::string& file,
                                    const PackWriteOptions& options);

}  // namespace vdbpack
