// The command line of vdb_pack.
#pragma once

#include "vdbpack/run/convert.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/run_mesh.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What was asked for.
struct CliOptions {
    enum class Command { pack, voids, carve, densify, verify, measure, convert, mesh };
    Command command = Command::pack;
    vdbpack::PackRecipe pack;
    std::vector<std::uint64_t> seeds{1};  ///< of pack: one run each
    std::string table;                    ///< .csv with a row a run; empty: none
    vdbpack::VoidsRecipe voids;
    vdbpack::CarveRecipe carve;
    vdbpack::DensifyRecipe densify;
    vdbpack::VerifyRecipe verify;
    vdbpack::MeasureRecipe measure;
    vdbpack::ConvertRecipe convert;
    vdbpack::MeshRecipe mesh;
    std::string config;  ///< file that options were read from; empty: none
    bool json = false;
    bool quiet = false;
    bool dryRun = false;
};

/// Parses the command line.
/// @param exitCode  set when nothing is returned: 0 after --help or --version, 2 for misuse.
/// @return nothing if there is nothing to do; the text is printed already.
std::optional<CliOptions> parseCommandLine(int argc, char** argv, int& exitCode);
