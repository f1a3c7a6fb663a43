// What a shell offers when Tab is pressed.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// The words that an option knows, as `choices` left them; empty if it takes anything.
std::vector<std::string> wordsOf(const CLI::Option& option);

/// Marks an option as one of some words.
void setWords(CLI::Option& option, const std::vector<std::string>& words);

/// A script for bash, zsh or fish that completes commands, options and their words; files
/// elsewhere.
/// @param shell  "bash", "zsh" or "fish".  @throws ParameterError for others
std::string completionScript(const CLI::App& app, const std::string& shell);
