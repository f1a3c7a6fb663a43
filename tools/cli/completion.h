// What a shell offers when Tab is pressed.
#pragma once

#include <string>

namespace CLI {
class App;
}  // namespace CLI

/// A script for bash, zsh or fish that completes commands, options and their words; files
/// elsewhere.
/// @param shell  "bash", "zsh" or "fish".  @throws ParameterError for others
std::string completionScript(const CLI::App& app, const std::string& shell);
