// Runs must leave something.
#pragma once

#include "cli/options.h"

/// Refuses a run that would compute for minutes and leave nothing, with the command that leaves a
/// file. @throws ParameterError
void requireResult(const CliOptions& options);
