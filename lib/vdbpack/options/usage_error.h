// Messages about wrong usage of the command line.
#pragma once

#include "vdbpack/options/option.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace vdbpack {

/// What was wrong with the command line, with the word that was probably meant.
/// @param arguments  as given, without the program's name.
/// @param style      of the options that stand in the text, but for those in backquotes.
std::string usageError(const CLI::App& app, const CLI::ParseError& error,
                       const std::vector<std::string>& arguments, OptionStyle style = optionName);

/// That a command has no option `word`, as `optionName` writes it, with the one that was probably
/// meant.
std::string unknownOption(const CLI::App& app, const CLI::App& command, const std::string& word,
                          OptionStyle style = optionName);

}  // namespace vdbpack
