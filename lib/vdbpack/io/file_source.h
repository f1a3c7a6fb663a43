// A file read from front to end, by lines or by bytes. Private to mesh/.
#pragma once

#include "vdbpack/core/error.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

/// A regular file behind one buffer that is refilled from front to end. The buffer is a few MB,
/// and larger only if a single line or block is.
class FileSource {
public:
    /// @throws IoError if the file does not exist, is no regular file or cannot be read.
    explicit FileSource(const std::string& path);
    ~FileSource();
    FileSource(const FileSource&) = delete;
    FileSource& operator=(const FileSource&) = delete;

    const std::string& path() const { return path_; }
    std::uint64_t size() const { return size_; }
    /// Of the next byte that is not yet taken.
    std::uint64_t offset() const { return bufferOffset_ + at_; }
    std::uint64_t remaining() const { return size_ > offset() ? size_ - offset() : 0; }
    /// Number of the line taken last, counted from 1.
    std::size_t line() const { return line_; }

    /// Up to `n` bytes from here on, which stay to be taken. Valid until the next call.
    std::string_view peek(std::size_t n);
    /// Takes `n` bytes; nullptr where the file ends before. Valid until the next call.
    const char* take(std::size_t n);
    /// Takes a line, its end (LF or CR LF; CR where the text has no LF) cut off. False at the end
    /// of the file. Valid until the next call.
    bool takeLine(std::string_view& text);

    /// An InputError for the line taken last: "path: line N: what".
    [[noreturn]] void failAtLine(const std::string& what) const;
    /// An InputError at a byte: "path: byte N: what".
    [[noreturn]] void failAtByte(std::uint64_t byte, const std::string& what) const;
    [[noreturn]] void fail(const std::string& what) const;

private:
    /// Reads on until at least `n` bytes lie in the buffer or the file ends.
    void fill(std::size_t n);

    std::string path_;
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
    std::vector<char> buffer_;
    std::uint64_t bufferOffset_ = 0;  ///< in the file
    std::size_t at_ = 0;
    std::size_t end_ = 0;
    bool atEnd_ = false;
    std::size_t line_ = 0;
    char lineEnd_ = 0;  ///< 0: not known yet
};

/// Takes words (separated by blanks) and numbers off the front of a text.
class Words {
public:
    explicit Words(std::string_view text) : text_(text) {}
    /// The next word; empty at the end.
    std::string_view next();
    /// What follows the words taken so far.
    std::string_view rest() const { return text_; }

private:
    std::string_view text_;
};

/// The number that all of `word` spells; false for any other text. Independent of the locale; a
/// number too large for double is infinite, one too small is 0.
bool parseReal(std::string_view word, double& value);
bool parseInteger(std::string_view word, std::int64_t& value);

/// `text` in quotes for a message, unprintable bytes and all but the first 40 left out.
std::string quoted(std::string_view text);

}  // namespace vdbpack
