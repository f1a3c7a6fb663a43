// Messages of the library in the words of the command line.
#pragma once

#include <string>

/// `message` with each parameter that the library quotes in backquotes (`memoryLimit`) replaced by
/// the option that sets it (--memory-limit). Names without an option stay as they are.
std::string withOptionNames(const std::string& message);
