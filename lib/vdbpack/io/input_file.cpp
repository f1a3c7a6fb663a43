#include "vdbpack/io/input_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 22;
/// How a text ends its lines is decided by this many bytes from its beginning.
constexpr std::size_t kLineEndSample = std::size_t{1} << 16;

[[noreturn]] void failReading(const std::string& path, int cause) {
    const std::string similar = cause == ENOENT ? similarFile(path) : "";
    throw IoError(path + ": cannot be read: " + std::strerror(cause) +
                  (similar.empty() ? "; check the name and the permissions" : similar));
}

/// '\n' (alone or after '\r'), or '\r' where there is no '\n', as old Mac software writes it.
char lineEndOf(std::string_view beginning) {
    const bool newline = beginning.find('\n') != std::string_view::npos;
    return !newline && beginning.find('\r') != std::string_view::npos ? '\r' : '\n';
}

}  // namespace

void requireThere(const std::string& path) {
    if (path.find('*') == std::string::npos && ::access(path.c_str(), R_OK) != 0)
        failReading(path, errno);
}

InputFile::InputFile(std::string path) : path_(std::move(path)) {
    requireFileName(path_);
    descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0) failReading(path_, errno);
    try {
        struct stat info {};
        if (::fstat(descriptor_, &info) != 0) failReading(path_, errno);
        if (S_ISDIR(info.st_mode)) failReading(path_, EISDIR);
        // A pipe ends, a device need not.
        if (S_ISCHR(info.st_mode) || S_ISBLK(info.st_mode))
            throw IoError(path_ + ": is a device; give a file or a pipe");
        if (S_ISREG(info.st_mode))
            size_ = static_cast<std::uint64_t>(info.st_size);
        else
            readPipe();
    } catch (...) {
        ::close(descriptor_);
        throw;
    }
}

InputFile::~InputFile() {
    ::close(descriptor_);
}

void InputFile::readPipe() {
    inMemory_ = true;
    for (;;) {
        buffer_.resize(end_ + kBufferBytes);
        const ssize_t n = ::read(descriptor_, buffer_.data() + end_, kBufferBytes);
        if (n == 0) break;
        if (n < 0 && errno != EINTR) failReading(path_, errno);
        end_ += static_cast<std::size_t>(std::max<ssize_t>(n, 0));
    }
    buffer_.resize(end_);
    size_ = end_;
}

void InputFile::readAt(std::uint64_t offset, void* target, std::size_t bytes) const {
    const auto failEnd = [&] {
        throw InputError(path_ + ": ends at byte " + std::to_string(size_) + " where " +
                         std::to_string(bytes) + " bytes from byte " + std::to_string(offset) +
                         " on were expected" + kDamaged);
    };
    if (offset > size_ || bytes > size_ - offset) failEnd();
    if (inMemory_) {
        if (bytes > 0) std::memcpy(target, buffer_.data() + offset, bytes);
        return;
    }
    auto* to = static_cast<char*>(target);
    while (bytes > 0) {
        const ssize_t n = ::pread(descriptor_, to, bytes, static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) failReading(path_, errno);
        if (n == 0) failEnd();  // another program shortened the file meanwhile
        to += n;
        offset += static_cast<std::uint64_t>(n);
        bytes -= static_cast<std::size_t>(n);
    }
}

std::uint64_t InputFile::numberAt(std::uint64_t offset, std::size_t bytes, bool bigEndian) const {
    unsigned char raw[8] = {};
    readAt(offset, raw, bytes);
    return unsignedNumber(raw, bytes, bigEndian);
}

void InputFile::fill(std::size_t bytes) {
    if (end_ - at_ >= bytes || bufferOffset_ + end_ >= size_) return;
    if (at_ > 0) {
        std::memmove(buffer_.data(), buffer_.data() + at_, end_ - at_);
        bufferOffset_ += at_;
        end_ -= at_;
        at_ = 0;
    }
    // No more than the rest of the file, however many bytes were requested.
    const auto target = static_cast<std::size_t>(
        std::min<std::uint64_t>(std::max(bytes, kBufferBytes), size_ - bufferOffset_));
    if (buffer_.size() < target) buffer_.resize(target);
    readAt(bufferOffset_ + end_, buffer_.data() + end_, target - end_);
    end_ = target;
}

std::string_view InputFile::peek(std::size_t bytes) {
    fill(bytes);
    return {buffer_.data() + at_, std::min(bytes, end_ - at_)};
}

const char* InputFile::take(std::size_t bytes) {
    if (bytes > remaining()) return nullptr;
    fill(bytes);
    const char* const data = buffer_.data() + at_;
    at_ += bytes;
    return data;
}

void InputFile::skipByteOrderMark() {
    if (peek(3) == "\xEF\xBB\xBF") take(3);
}

bool InputFile::nextLine(std::string_view& line) {
    if (lineEnd_ == 0) lineEnd_ = lineEndOf(peek(kLineEndSample));
    std::size_t searched = 0;
    for (;;) {
        const char* const begin = buffer_.data() + at_;
        const std::size_t have = end_ - at_;
        const void* const found =
            have > searched ? std::memchr(begin + searched, lineEnd_, have - searched) : nullptr;
        if (found != nullptr) {
            auto length = static_cast<std::size_t>(static_cast<const char*>(found) - begin);
            at_ += length + 1;
            if (length > 0 && begin[length - 1] == '\r') --length;
            line = {begin, length};
            ++lineNumber_;
            return true;
        }
        if (bufferOffset_ + end_ >= size_) {
            if (have == 0) return false;
            at_ = end_;
            line = {begin, begin[have - 1] == '\r' ? have - 1 : have};
            ++lineNumber_;
            return true;
        }
        searched = have;
        // A line longer than the buffer doubles it.
        fill(have < buffer_.size() ? have + 1 : 2 * have);
    }
}

void InputFile::seek(std::uint64_t offset, std::uint64_t number) {
    lineNumber_ = number;
    if (inMemory_ || (offset >= bufferOffset_ && offset - bufferOffset_ <= end_)) {
        at_ = static_cast<std::size_t>(std::min<std::uint64_t>(offset - bufferOffset_, end_));
        return;
    }
    bufferOffset_ = std::min(offset, size_);
    at_ = end_ = 0;
}

void InputFile::failAtLine(const std::string& what) const {
    throw InputError(path_ + ": line " + std::to_string(lineNumber_) + ": " + what);
}

void InputFile::failAtByte(std::uint64_t byte, const std::string& what) const {
    throw InputError(path_ + ": byte " + std::to_string(byte) + ": " + what);
}

void InputFile::fail(const std::string& what) const {
    throw InputError(path_ + ": " + what);
}

}  // namespace vdbpack
