#pragma once

namespace vdbpack {

/// "1.2.3"; built from a repository with its commit, "1.2.3+1a2b3c4d", and with ".changed" if files
/// differ from it.
const char* version();

}  // namespace vdbpack
