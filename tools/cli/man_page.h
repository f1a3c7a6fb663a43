// Manual pages, from what --help knows.
#pragma once

#include <string>

namespace CLI {
class App;
}

/// The page of the program or of one of its commands, as man reads it (roff).
/// @param app  with commands, or one of them.
std::string manPage(const CLI::App& app);

/// Writes the pages of the program and of its commands, vdb_pack.1, vdb_pack-pack.1, ..., into a
/// folder, which is made if need be. @throws vdbpack::IoError
void writeManPages(const CLI::App& program, const std::string& folder);
