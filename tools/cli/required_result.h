// Runs must leave something.
#pragma once

#include "cli/options.h"

#include <string>

/// A word quoted for a shell, so that a command in a report can be run again.
std::string shellQuoted(const std::string& word);

/// Refuses a run that would compute for minutes and leave nothing, with the command that leaves a
/// file. @throws ParameterError
void requireResult(const CliOptions& options);
