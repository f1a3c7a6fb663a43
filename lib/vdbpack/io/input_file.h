// Private: input files, read from front to end or at any offset.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// What ends messages about a file that was cut short.
inline constexpr const char* kDamaged = "; it is damaged or incomplete: copy or download it again";

/// Refuses, before the work, a file that is not there or may not be read; names with * pass.
/// @throws IoError
void requireThere(const std::string& path);

/// A file that is read, and whose size is known: pipes are read into memory when they are opened.
///
/// Reading from front to end goes through one buffer of a few MB, which grows only if a single
/// line or block is larger.
class InputFile {
public:
    /// @throws IoError if the file does not exist, cannot be read, or is a folder or a device.
    explicit InputFile(std::string path);
    ~InputFile();
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    const std::string& path() const { return path_; }
    /// Bytes in the file when it was opened; later ones are not read.
    std::uint64_t size() const { return size_; }

    /// Whether it is a pipe, whose bytes `peek` gives.
    bool inMemory() const { return inMemory_; }
    /// Fills `bytes` at `target` with the file's content from `offset` on.
    /// @throws InputError if the file ends before, IoError if reading fails.
    void readAt(std::uint64_t offset, void* target, std::size_t bytes) const;

    /// The unsigned number in at most 8 bytes from `offset` on. @throws as `readAt`
    std::uint64_t numberAt(std::uint64_t offset, std::size_t bytes, bool bigEndian) const;

    /// Offset of the next byte that has not been taken.
    std::uint64_t offset() const { return bufferOffset_ + at_; }
    std::uint64_t remaining() const { return size_ - offset(); }
    /// Up to `bytes` from the offset on, which is not moved; fewer at the end of the file. Valid
    /// until the next call of this, `take` or `nextLine`.
    std::string_view peek(std::size_t bytes);
    /// Takes `bytes`, valid as long as the bytes of `peek`; nullptr if the file ends before.
    const char* take(std::size_t bytes);
    /// Takes the byte order mark of UTF-8 if it comes next.
    void skipByteOrderMark();

    /// Takes the next line, without its end (LF or CR LF; CR where the text has no LF); valid as
    /// long as the bytes of `peek`.
    /// @return false at the end of the file.
    bool nextLine(std::string_view& line);
    /// Number of the last line taken, counted from 1.
    std::uint64_t lineNumber() const { return lineNumber_; }

    /// Moves to `offset`; the next line there counts as line `number` + 1.
    void seek(std::uint64_t offset, std::uint64_t number = 0);

    /// @throws InputError "path: line N: what" for the last line taken.
    [[noreturn]] void failAtLine(const std::string& what) const;
    /// @throws InputError "path: byte N: what".
    [[noreturn]] void failAtByte(std::uint64_t byte, const std::string& what) const;
    /// @throws InputError "path: what".
    [[noreturn]] void fail(const std::string& what) const;

private:
    void readPipe();
    /// Reads on until the buffer has `bytes` that are not taken, or the file ends.
    void fill(std::size_t bytes);

    std::string path_;
    int descriptor_ = -1;
    bool inMemory_ = false;  ///< the buffer has the whole file
    std::uint64_t size_ = 0;

    std::vector<char> buffer_;
    std::uint64_t bufferOffset_ = 0;  ///< of the buffer, in the file
    std::size_t at_ = 0;              ///< of the next byte, in the buffer
    std::size_t end_ = 0;             ///< of the bytes that were read, in the buffer
    std::uint64_t lineNumber_ = 0;
    char lineEnd_ = 0;  ///< the last character of each line; 0: not known yet
};

}  // namespace vdbpack
