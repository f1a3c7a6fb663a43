// Private: files read line by line or by offset, never past their end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace vdbpack {

/// A file that is read. Pipes are read whole into memory first, so that every file has a size.
class InputFile {
public:
    /// @throws IoError if there is no such file or it cannot be read.
    explicit InputFile(std::string path);
    ~InputFile();
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    const std::string& path() const { return path_; }
    std::uint64_t size() const { return size_; }

    /// Fills `bytes` at `target` from `offset` on.
    /// @throws InputError if the file ends before, IoError if reading fails.
    void readAt(std::uint64_t offset, void* target, std::size_t bytes) const;

    /// The next line without its end (LF or CR LF; CR where the text has no LF), valid until the
    /// next call.
    /// @return false at the end of the file.
    bool nextLine(std::string_view& line);
    /// Number of the last line, counted from 1.
    std::uint64_t lineNumber() const { return lineNumber_; }
    /// Offset of the first byte after the last line.
    std::uint64_t nextOffset() const { return chunkOffset_ + position_; }
    /// Starts again with the line at `offset`, which counts as line `number` + 1.
    void seek(std::uint64_t offset, std::uint64_t number = 0);

private:
    std::string path_;
    int descriptor_ = -1;
    bool inMemory_ = false;
    std::string memory_;
    std::uint64_t size_ = 0;

    std::string chunk_;  ///< holds at least the rest of the current line
    std::uint64_t chunkOffset_ = 0;
    std::size_t position_ = 0;
    std::uint64_t lineNumber_ = 0;
    char lineEnd_ = 0;  ///< 0: not known yet
};

}  // namespace vdbpack
