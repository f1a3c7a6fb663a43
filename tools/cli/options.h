// The command line of vdb_pack.
#pragma once

#include "vdbpack/options/jobs.h"

#include <optional>
#include <string>

struct CliOptions {
    vdbpack::Job job;
    std::string config;  ///< file that options were read from; empty: none
    vdbpack::PrintOptions print;
    std::string afterwards;  ///< printed once the work is done; empty: nothing
};

/// Parses the command line. Without any words, `vdb_pack` prints the first steps on a terminal;
/// with --man-pages FOLDER alone, which the build calls, it writes the manual pages.
/// @param exitCode  set when nothing is returned: 0 after --help or --version, 2 for misuse.
/// @return nothing if there is nothing to do; the text is printed already.
std::optional<CliOptions> parseCommandLine(int argc, char** argv, int& exitCode);
