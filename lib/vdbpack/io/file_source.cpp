#include "vdbpack/io/file_source.h"

#include "vdbpack/io/line_end.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <limits>

namespace vdbpack {

namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 22;

bool isBlank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

}  // namespace

FileSource::FileSource(const std::string& path) : path_(path) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0)
        throw IoError(path + ": cannot be opened: " + std::strerror(errno) +
                      "; check the name of the file");
    // A pipe or a device has no size to check counts against.
    if (!S_ISREG(info.st_mode)) throw IoError(path + ": is not a regular file; name a mesh file");
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0)
        throw IoError(path + ": cannot be opened: " + std::strerror(errno) +
                      "; check its permissions");
    size_ = static_cast<std::uint64_t>(info.st_size);
    buffer_.resize(static_cast<std::size_t>(
        std::min<std::uint64_t>(kBufferBytes, std::max<std::uint64_t>(size_, 1))));
}

FileSource::~FileSource() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

void FileSource::fill(std::size_t n) {
    if (end_ - at_ >= n || atEnd_) return;
    if (at_ > 0) {
        std::memmove(buffer_.data(), buffer_.data() + at_, end_ - at_);
        bufferOffset_ += at_;
        end_ -= at_;
        at_ = 0;
    }
    if (n > buffer_.size()) {
        // No more than the file can fill, whatever was asked for.
        const std::uint64_t most = end_ + std::max<std::uint64_t>(size_ - bufferOffset_ - end_, 1);
        buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(n, most)));
    }
    while (end_ < std::min(n, buffer_.size()) && !atEnd_) {
        const ssize_t got = ::read(descriptor_, buffer_.data() + end_, buffer_.size() - end_);
        if (got < 0) {
            if (errno == EINTR) continue;
            throw IoError(path_ + ": reading at byte " + std::to_string(bufferOffset_ + end_) +
                          " failed: " + std::strerror(errno));
        }
        if (got == 0) atEnd_ = true;
        end_ += static_cast<std::size_t>(got);
    }
}

std::string_view FileSource::peek(std::size_t n) {
    fill(n);
    return {buffer_.data() + at_, std::min(n, end_ - at_)};
}

const char* FileSource::take(std::size_t n) {
    if (n > remaining()) return nullptr;
    fill(n);
    if (end_ - at_ < n) return nullptr;
    const char* data = buffer_.data() + at_;
    at_ += n;
    return data;
}

bool FileSource::takeLine(std::string_view& text) {
    if (lineEnd_ == 0) lineEnd_ = lineEndOf(peek(kLineEndSample));
    std::size_t searched = 0;
    for (;;) {
        const char* const begin = buffer_.data() + at_;
        const std::size_t have = end_ - at_;
        const void* const newline =
            have > searched ? std::memchr(begin + searched, lineEnd_, have - searched) : nullptr;
        if (newline != nullptr) {
            std::size_t length =
                static_cast<std::size_t>(static_cast<const char*>(newline) - begin);
            at_ += length + 1;
            if (length > 0 && begin[length - 1] == '\r') --length;
            text = {begin, length};
            ++line_;
            return true;
        }
        if (atEnd_) {
            if (have == 0) return false;
            at_ = end_;
            text = {begin, have};
            ++line_;
            return true;
        }
        searched = have;
        // A line longer than the buffer doubles it.
        fill(have < buffer_.size() ? have + 1 : 2 * have);
    }
}

void FileSource::failAtLine(const std::string& what) const {
    throw InputError(path_ + ": line " + std::to_string(line_) + ": " + what);
}

void FileSource::failAtByte(std::uint64_t byte, const std::string& what) const {
    throw InputError(path_ + ": byte " + std::to_string(byte) + ": " + what);
}

void FileSource::fail(const std::string& what) const {
    throw InputError(path_ + ": " + what);
}

std::string_view Words::next() {
    std::size_t begin = 0;
    while (begin < text_.size() && isBlank(text_[begin])) ++begin;
    std::size_t end = begin;
    while (end < text_.size() && !isBlank(text_[end])) ++end;
    const std::string_view word = text_.substr(begin, end - begin);
    text_.remove_prefix(end);
    return word;
}

bool parseReal(std::string_view word, double& value) {
    if (!word.empty() && word.front() == '+') {
        word.remove_prefix(1);
        if (!word.empty() && word.front() == '-') return false;
    }
    const char* const end = word.data() + word.size();
    const auto result = std::from_chars(word.data(), end, value);
    if (result.ptr != end || word.empty()) return false;
    if (result.ec == std::errc::result_out_of_range) {
        // from_chars does not say which end of the range was left.
        const std::size_t exponent = word.find_first_of("eE");
        const bool tiny = exponent != std::string_view::npos
                              ? word.substr(exponent + 1, 1) == "-"
                              : word.find_first_not_of("-0.") > word.find('.');
        value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
        return true;
    }
    return result.ec == std::errc{};
}

bool parseInteger(std::string_view word, std::int64_t& value) {
    if (!word.empty() && word.front() == '+') {
        word.remove_prefix(1);
        if (!word.empty() && word.front() == '-') return false;
    }
    const char* const end = word.data() + word.size();
    const auto result = std::from_chars(word.data(), end, value);
    return result.ec == std::errc{} && result.ptr == end && !word.empty();
}

std::string quoted(std::string_view text) {
    constexpr std::size_t kLongest = 40;
    std::string out = "'";
    for (const char c : text.substr(0, kLongest)) out += c >= 0x20 && c < 0x7f ? c : '?';
    return out + (text.size() > kLongest ? "...'" : "'");
}

}  // namespace vdbpack
