// Output files that several ranks write together.
#pragma once

#include "vdbpack/core/ranks.h"
#include "vdbpack/io/output_file.h"

#include <cstdint>
#include <memory>
#include <string>

namespace vdbpack {

/// A file that gets its name once all ranks have written their parts of it; see OutputFile.
///
/// Constructed and committed by all ranks. `ranks` null: this process writes it alone.
class SharedFile {
public:
    /// @throws IoError as OutputFile, and if the other ranks do not see the folder of the first.
    SharedFile(Ranks* ranks, const std::string& path);
    ~SharedFile();
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;

    /// A name by which the file can be opened until `commit`; of the first rank.
    const std::string& temporaryPath() const { return temporaryPath_; }

    /// Refuses a file of so many bytes, or more, where the disk or a limit has no room for it, as
    /// far as that can be known before. @throws IoError
    void requireRoom(std::uint64_t bytes);
    /// Unbuffered; from any number of threads. @throws IoError
    void writeAt(std::uint64_t offset, const void* data, std::size_t bytes);
    /// @throws IoError
    void commit();

private:
    Ranks* ranks_;
    std::string path_, temporaryPath_;
    std::unique_ptr<OutputFile> file_;  // of the first rank
    int descriptor_ = -1;
};

}  // namespace vdbpack
