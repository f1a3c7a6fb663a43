// Output files that are whole or absent.
#pragma once

#include <cstdint>
#include <string>

namespace vdbpack {

/// A file that is written beside its name, and takes its name when it is complete and on the disk.
///
/// Until `commit` the former file at `path` is untouched; without it nothing is left, not even by
/// a process that is killed where the file system knows files without a name (O_TMPFILE).
/// Elsewhere the file has a temporary name, `path` with six letters and `.tmp`, that the destructor
/// or `removeTemporaryFiles` removes. Of several processes that write the same file at once, one
/// leaves its own, whole. A symbolic link is followed: what it points to is replaced, and need not
/// exist. The permissions of a former file stay.
///
/// Write through `write` (buffered), or hand `temporaryPath` to a library that wants a file name
/// (then do not call `write`).
class OutputFile {
public:
    /// @throws IoError if the folder does not exist or cannot be written to, or if `path` is a
    /// folder, a device, a pipe, a stream or write-protected, or its name is too long.
    explicit OutputFile(std::string path);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    const std::string& path() const { return path_; }
    /// A name to open the file by, until `commit`.
    const std::string& temporaryPath() const { return temporaryPath_; }

    /// @throws IoError naming the file and the cause (disk full, ...).
    void write(const void* data, std::size_t bytes);
    void write(const std::string& text) { write(text.data(), text.size()); }

    /// Flushes to the disk and gives the file its name. @throws IoError
    void commit();

private:
    void createNamed();
    void flushBuffer();
    [[noreturn]] void fail(const char* action) const;

    std::string path_;
    std::string target_;  ///< what `path_` points to
    std::string folder_;  ///< of `target_`
    std::string temporaryPath_;
    std::string buffer_;
    int descriptor_ = -1;
    int slot_ = -1;  ///< of the name that is to be removed; -1: it has none, or is not in the list
    bool named_ = false;  ///< has a name of its own
};

/// Removes the names of all files that are being written. For handlers of signals that end the
/// process at once afterwards: calls nothing that a handler must not call.
void removeTemporaryFiles() noexcept;

/// What `path` ends at when symbolic links are followed, whether it exists or not.
/// @throws IoError for links that go in circles.
std::string followLinks(const std::string& path);

}  // namespace vdbpack
