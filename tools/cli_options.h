// The command line of vdb_pack.
#pragma once

#include "vdbpack/run.h"

#include <optional>
#include <string>

/// What was asked for.
struct CliOptions {
    enum class Command { pack, verify, mesh };
    Command command = Command::pack;
    vdbpack::PackRecipe pack;
    vdbpack::VerifyRecipe verify;
    vdbpack::DomainRecipe mesh;
    bool json = false;
    bool quiet = false;
    bool dryRun = false;
};

/// Parses the command line.
/// @param exitCode  set when nothing is returned: 0 after --help or --version, 2 for misuse.
/// @return nothing if there is nothing to do; the text is printed already.
std::optional<CliOptions> parseCommandLine(int argc, char** argv, int& exitCode);
