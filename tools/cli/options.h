// The command line of vdb_pack.
#pragma once

#include "vdbpack/run/run.h"
#include "vdbpack/run/run_convert.h"
#include "vdbpack/run/run_image.h"
#include "vdbpack/run/run_mesh.h"
#include "vdbpack/run/run_view.h"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

/// Runs of one recipe.
struct Study {
    std::vector<std::uint64_t> seeds{1};  ///< one run each
    std::string table;                    ///< .csv with a row a run; empty: none

    bool isOne() const { return seeds.size() == 1 && table.empty(); }
};

struct PackJob : vdbpack::PackRecipe {
    Study study;
    bool dryRun = false;
};

struct VoidsJob : vdbpack::VoidsRecipe {
    Study study;
};

struct ViewJob : vdbpack::ViewRecipe {
    bool opens = true;  ///< the page, where there is a display
};

/// The recipe of the command. All have `domain` and the fields of RunSettings.
using Job = std::variant<PackJob, VoidsJob, vdbpack::CarveRecipe, vdbpack::DensifyRecipe,
                         vdbpack::VerifyRecipe, vdbpack::MeasureRecipe, vdbpack::ConvertRecipe,
                         vdbpack::MeshRecipe, vdbpack::ImageRecipe, ViewJob>;

/// How the result is printed.
struct PrintOptions {
    bool json = false;
    bool quiet = false;
};

struct CliOptions {
    Job job;
    std::string config;  ///< file that options were read from; empty: none
    PrintOptions print;
    std::string afterwards;  ///< printed once the work is done; empty: nothing
};

/// Parses the command line. Without any words, `vdb_pack` prints the first steps on a terminal;
/// with
/// --man-pages FOLDER alone, which the build calls, it writes the manual pages.
/// @param exitCode  set when nothing is returned: 0 after --help or --version, 2 for misuse.
/// @return nothing if there is nothing to do; the text is printed already.
std::optional<CliOptions> parseCommandLine(int argc, char** argv, int& exitCode);

/// The recipe of a command ("pack") and its words, as after `vdb_pack`, for programs that call it.
/// @param unset  options that are not set, such as "--quiet", but must be those of the command.
/// @throws vdbpack::ParameterError with what is wrong; as reading the files that options name
Job jobOf(const std::vector<std::string>& words, const std::vector<std::string>& unset = {});
