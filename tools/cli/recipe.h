// Options of a command from a TOML file, and the file that repeats a run.
#pragma once

#include <CLI/CLI.hpp>

#include <istream>
#include <string>
#include <vector>

/// Reads TOML: the options of the running command by their long names, under [command] or at the
/// top; tables of other commands are passed over. Names of files are relative to its folder, unless
/// it comes from a pipe.
class RecipeFormat : public CLI::ConfigBase {
public:
    explicit RecipeFormat(const CLI::App& app) : app_(app) {}

    /// @throws CLI::ConfigError with line, name and remedy
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

private:
    const CLI::App& app_;
};

/// TOML with all that was given for the options of a command that ran, by the command line or a
/// recipe, and the defaults that decide the result. What only concerns what is printed, how fast
/// and where the options came from is left out. For `seed`, and in names, {seed} stands for that of
/// each run.
/// @param folder  that the recipe will be in, by which names of files are given; empty: the working
///                folder.
std::string recipeText(const CLI::App& command, const std::string& folder);
