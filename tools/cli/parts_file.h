// The parts of a pack from a TOML file.
#pragma once

#include <functional>
#include <string>
#include <vector>

/// A part as it stands in the file: its name, and its options as the command line would have them.
struct PartWords {
    std::string name;
    std::vector<std::string> arguments;  ///< the domain first
};

/// Reads a file with a table [[part]] for each part: `name`, `domain`, and options of `pack` by
/// their long names (flags: true). Names of files are relative to the file's folder.
/// @throws vdbpack::IoError, vdbpack::InputError
std::vector<PartWords> readPartsFile(const std::string& file);
