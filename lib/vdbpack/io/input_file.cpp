#include "vdbpack/io/input_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/line_end.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::size_t kChunkBytes = 1 << 20;

[[noreturn]] void failReading(const std::string& path, int cause) {
    throw IoError(path + ": cannot be read: " + std::strerror(cause) +
                  "; check the name and the permissions");
}

}  // namespace

InputFile::InputFile(std::string path) : path_(std::move(path)) {
    descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0) failReading(path_, errno);
    try {
        struct stat info {};
        if (::fstat(descriptor_, &info) != 0) failReading(path_, errno);
        if (S_ISDIR(info.st_mode)) failReading(path_, EISDIR);
        if (S_ISREG(info.st_mode)) {
            size_ = static_cast<std::uint64_t>(info.st_size);
            return;
        }
        // Pipes end; devices need not.
        if (S_ISCHR(info.st_mode) || S_ISBLK(info.st_mode))
            throw IoError(path_ + ": is a device; give a file or a pipe");
        inMemory_ = true;
        for (;;) {
            const std::size_t before = memory_.size();
            memory_.resize(before + kChunkBytes);
            const ssize_t n = ::read(descriptor_, memory_.data() + before, kChunkBytes);
            memory_.resize(before + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
            if (n == 0) break;
            if (n < 0 && errno != EINTR) failReading(path_, errno);
        }
        size_ = memory_.size();
    } catch (...) {
        ::close(descriptor_);
        throw;
    }
}

InputFile::~InputFile() {
    ::close(descriptor_);
}

void InputFile::readAt(std::uint64_t offset, void* target, std::size_t bytes) const {
    const auto ends = [&] {
        throw InputError(path_ + ": ends at byte " + std::to_string(size_) + " where " +
                         std::to_string(bytes) + " bytes from byte " + std::to_string(offset) +
                         " on were expected; the file is cut short or damaged");
    };
    if (offset > size_ || bytes > size_ - offset) ends();
    if (inMemory_) {
        if (bytes > 0) std::memcpy(target, memory_.data() + offset, bytes);
        return;
    }
    auto* to = static_cast<char*>(target);
    while (bytes > 0) {
        const ssize_t n = ::pread(descriptor_, to, bytes, static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) failReading(path_, errno);
        if (n == 0) ends();  // somebody shortened the file meanwhile
        to += n;
        offset += static_cast<std::uint64_t>(n);
        bytes -= static_cast<std::size_t>(n);
    }
}

bool InputFile::nextLine(std::string_view& line) {
    std::size_t searched = position_;
    for (;;) {
        // The first chunk is longer than what tells how lines end.
        if (lineEnd_ == 0 && !chunk_.empty()) lineEnd_ = lineEndOf(chunk_);
        const void* found =
            searched < chunk_.size()
                ? std::memchr(chunk_.data() + searched, lineEnd_, chunk_.size() - searched)
                : nullptr;
        const std::uint64_t chunkEnd = chunkOffset_ + chunk_.size();
        if (found != nullptr || chunkEnd >= size_) {
            if (found == nullptr && position_ >= chunk_.size()) return false;
            const std::size_t end =
                found != nullptr
                    ? static_cast<std::size_t>(static_cast<const char*>(found) - chunk_.data())
                    : chunk_.size();
            line = std::string_view(chunk_).substr(position_, end - position_);
            if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
            position_ = std::min(end + 1, chunk_.size());
            ++lineNumber_;
            return true;
        }
        // Drop what was handed out, keep the unfinished line, and double what is read for it.
        chunk_.erase(0, position_);
        chunkOffset_ += position_;
        position_ = 0;
        searched = chunk_.size();
        const auto more = static_cast<std::size_t>(std::min<std::uint64_t>(
            std::max(kChunkBytes, chunk_.size()), size_ - chunkOffset_ - chunk_.size()));
        chunk_.resize(searched + more);
        readAt(chunkOffset_ + searched, chunk_.data() + searched, more);
    }
}

void InputFile::seek(std::uint64_t offset, std::uint64_t number) {
    chunk_.clear();
    chunkOffset_ = std::min(offset, size_);
    position_ = 0;
    lineNumber_ = number;
}

}  // namespace vdbpack
