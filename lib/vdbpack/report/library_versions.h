// What the program is made with.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

/// Names and versions of the libraries that the results depend on, and of the compiler.
std::vector<std::pair<std::string, std::string>> libraryVersions();

}  // namespace vdbpack
