#include "vdbpack/core/output_file.h"

#include "vdbpack/core/error.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace vdbpack {

namespace {
constexpr std::size_t kBufferBytes = 1 << 20;
}

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
    struct stat info {};
    if (::stat(path_.c_str(), &info) == 0 && S_ISDIR(info.st_mode))
        throw IoError(path_ + ": is a folder; name a file");
    temporaryPath_ = path_ + ".XXXXXX.tmp";
    descriptor_ = ::mkstemps(temporaryPath_.data(), 4);
    if (descriptor_ < 0) {
        const int cause = errno;
        const auto slash = path_.find_last_of('/');
        const std::string folder = slash == std::string::npos ? "." : path_.substr(0, slash + 1);
        throw IoError(path_ + ": cannot create a file in folder '" + folder +
                      "': " + std::strerror(cause) + "; create the folder or choose another one");
    }
    // mkstemp makes files private; give them the permissions any new file would get.
    const mode_t mask = ::umask(0);
    ::umask(mask);
    ::fchmod(descriptor_, 0666 & ~mask);
    buffer_.reserve(kBufferBytes);
}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!committed_) ::unlink(temporaryPath_.c_str());
}

void OutputFile::fail(const char* action) const {
    const int cause = errno;
    throw IoError(path_ + ": " + action + " failed: " + std::strerror(cause) +
                  "; the former file, if any, is untouched");
}

void OutputFile::write(const void* data, std::size_t bytes) {
    if (buffer_.size() + bytes > kBufferBytes) flushBuffer();
    buffer_.append(static_cast<const char*>(data), bytes);
    if (buffer_.size() >= kBufferBytes) flushBuffer();
}

void OutputFile::flushBuffer() {
    std::size_t done = 0;
    while (done < buffer_.size()) {
        const ssize_t n = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
        if (n < 0) {
            if (errno == EINTR) continue;
            fail("writing");
        }
        done += static_cast<std::size_t>(n);
    }
    buffer_.clear();
}

void OutputFile::commit() {
    flushBuffer();
    // A library may have replaced the file behind the name: flush what is there now.
    const int named = ::open(temporaryPath_.c_str(), O_RDONLY | O_CLOEXEC);
    if (named < 0) fail("writing");
    const bool flushed = ::fsync(named) == 0;
    if (!flushed) {
        const int cause = errno;
        ::close(named);
        errno = cause;
        fail("flushing");
    }
    ::close(named);
    if (::rename(temporaryPath_.c_str(), path_.c_str()) != 0) fail("renaming");
    committed_ = true;
}

}  // namespace vdbpack
