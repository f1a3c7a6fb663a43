// Options of a command from a TOML file, and the file that repeats a run.
#pragma once

#include "vdbpack/options/option.h"

#include <CLI/CLI.hpp>

#include <istream>
#include <string>
#include <vector>

namespace vdbpack {

/// Where the value of an option of that name holds a file: `fileIn`, or another table.
using FileLookup = FileIn (*)(const std::string& option);

/// Reads TOML: the options of the running command by their long names, under [command] or at the
/// top; tables of other commands are passed over. Names of files are relative to its folder, unless
/// it comes from a pipe.
class RecipeFormat : public CLI::ConfigBase {
public:
    RecipeFormat(const CLI::App& app, FileLookup fileIn) : app_(app), fileIn_(fileIn) {}

    /// @throws CLI::ConfigError with line, name and remedy
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

private:
    const CLI::App& app_;
    FileLookup fileIn_;
};

/// TOML with all that was given for the options of a command, by the command line or a recipe, and
/// the defaults that decide the result. What only concerns what is printed, how fast and where the
/// options came from is left out. For `seed`, and in names, {seed} stands for that of each run.
/// @param app      the command after it was parsed, with `options`.
/// @param folder  that the recipe will be in, by which names of files are given; empty: the working
///                folder.
std::string recipeText(const CLI::App& app, const std::vector<Option>& options,
                       const std::string& folder);

/// A part as it stands in a parts file: its name, and its options as the command line would have
/// them.
struct PartWords {
    std::string name;
    std::vector<std::string> arguments;  ///< the domain first
};

/// Reads a file with a table [[part]] for each part: `name`, `domain`, and options of `pack` by
/// their long names (flags: true). Names of files are relative to the file's folder.
/// @throws IoError, InputError
std::vector<PartWords> readPartsFile(const std::string& file, FileLookup fileIn);

}  // namespace vdbpack
