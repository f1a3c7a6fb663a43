// Output files that are complete or absent.
#pragma once

#include <cstdint>
#include <string>

namespace vdbpack {

/// A file that gets its name only when it is complete and on the disk.
///
/// Until `commit`, a previous file at `path` is unchanged. Without `commit` no file remains, not
/// even if the process is killed, provided that the file system supports files without a name
/// (O_TMPFILE). On other file systems the file has a temporary name, `path` with six letters and
/// `.tmp`, which the destructor or `removeTemporaryFiles` removes. If several processes write the
/// same file at once, the result is the complete file of one of them. A symbolic link is followed:
/// its target is replaced, and need not exist. The permissions of a previous file are kept.
///
/// Write through `write` (buffered), or give `temporaryPath` to a library that needs a file name
/// (then do not call `write`).
class OutputFile {
public:
    /// @throws IoError if the folder does not exist or cannot be written to, or if `path` is a
    /// folder, a device, a pipe, a stream or write-protected, or its name is too long.
    /// @param shown  whether other processes are to open `temporaryPath`: it is a name in the
    ///               folder then.
    explicit OutputFile(std::string path, bool shown = false);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    const std::string& path() const { return path_; }
    /// A name by which the file can be opened until `commit`.
    const std::string& temporaryPath() const { return temporaryPath_; }

    /// @throws IoError with the file and the cause (disk full, ...).
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
    int slot_ = -1;       ///< of the temporary name in the list of names to remove; -1: none
    bool named_ = false;  ///< has a temporary name
};

/// Removes the temporary names of all files that are being written. For signal handlers that end
/// the process right afterwards: async-signal-safe.
void removeTemporaryFiles() noexcept;

/// The target of `path` after following symbolic links, which need not exist.
/// @throws IoError if the links form a cycle.
std::string followLinks(const std::string& path);

}  // namespace vdbpack
