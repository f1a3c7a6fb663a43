// Private: zip archives of members that are stored as they are.
#pragma once

#include "vdbpack/io/output_file.h"

#include <cstdint>
#include <string>

namespace vdbpack {

/// Writes an archive. Sources: PKWARE's APPNOTE 6.3; the specification of USDZ.
///
/// Without a library: members that are only stored take one pass and no temporary file, and the
/// bytes do not depend on the version of a library or on the clock.
class ZipWriter {
public:
    enum class Form {
        zip64,  ///< all sizes have 64 bits, so that large files take no path of their own
        usdz    ///< members begin at multiples of 64 bytes; sizes have 32 bits
    };
    ZipWriter(OutputFile& out, Form form) : out_(out), form_(form) {}

    /// Begins a member; its `size` bytes are to be written to the file next.
    /// @param crc  of these bytes, as `crc32_z` computes it.
    /// @throws IoError, also for a .usdz beyond 4 GiB.
    void begin(const std::string& name, std::uint64_t size, std::uint32_t crc);
    void finish();

private:
    std::uint64_t padding(std::size_t nameBytes) const;

    OutputFile& out_;
    Form form_;
    std::string directory_;
    std::uint64_t offset_ = 0, members_ = 0;
};

}  // namespace vdbpack
