// The words of a command line to the recipe of a command, by the table of options.
#pragma once

#include "vdbpack/options/jobs.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// A command of the parser, with the recipe that its options fill in.
struct Command {
    CLI::App* app;
    std::unique_ptr<Job> job;
    std::vector<Option> options;  ///< bound to `job`
};

/// Adds all commands to a parser. `print` must outlive them.
std::vector<Command> addCommands(CLI::App& app, PrintOptions& print);

/// The command that was parsed, with what its options alone do not set in its recipe: parts of
/// other files, and the texts that repeat the run. Nothing: none was parsed.
/// @param words  of the command line, without the program's name.
/// @throws CLI::ParseError; as `readPartsFile`
std::optional<Job> parsedJob(std::vector<Command>& commands, const std::vector<std::string>& words);

/// The recipe of a command ("pack") and its words, as after `vdb_pack`, for programs that call it.
/// @param unset  options that are not set, such as "quiet", but must be options of the command.
/// @param style  how errors show unknown options; others stand in them for `withOptionNames`.
/// @throws ParameterError with what is wrong; as reading the files that options name
Job jobOf(const std::vector<std::string>& words, const std::vector<std::string>& unset = {},
          OptionStyle style = optionName);

/// A word as a shell takes it.
std::string shellQuoted(const std::string& word);

/// The words that an option of the parser takes; empty if it takes anything.
std::vector<std::string> wordsOf(const CLI::Option& option);

}  // namespace vdbpack
