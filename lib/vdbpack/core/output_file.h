// Output files that are whole or absent.
#pragma once

#include <cstdint>
#include <string>

namespace vdbpack {

/// A file written under a temporary name in its folder and renamed when complete.
///
/// Until `commit` the former file at `path` is untouched; without it the temporary file is
/// removed by the destructor. Write through `write` (buffered), or hand `temporaryPath` to a
/// library that wants a file name (then do not call `write`).
class OutputFile {
public:
    /// @throws IoError if the folder does not exist or cannot be written to.
    explicit OutputFile(std::string path);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    const std::string& path() const { return path_; }
    const std::string& temporaryPath() const { return temporaryPath_; }

    /// @throws IoError naming the file and the cause (disk full, ...).
    void write(const void* data, std::size_t bytes);
    void write(const std::string& text) { write(text.data(), text.size()); }

    /// Flushes to the disk and renames to `path`. @throws IoError
    void commit();

private:
    void flushBuffer();
    [[noreturn]] void fail(const char* action) const;

    std::string path_;
    std::string temporaryPath_;
    std::string buffer_;
    int descriptor_ = -1;
    bool committed_ = false;
};

}  // namespace vdbpack
