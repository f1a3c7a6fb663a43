#include "vdbpack/io/shared_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

namespace vdbpack {

SharedFile::SharedFile(Ranks* ranks, const std::string& path) : ranks_(ranks), path_(path) {
    const bool isFirst = !ranks || ranks->isFirst();
    if (isFirst) {
        // HDF5 needs a name in the folder, too.
        file_ = std::make_unique<OutputFile>(path, true);
        temporaryPath_ = file_->temporaryPath();
    }
    if (ranks) {
        const auto names =
            gathered(ranks, std::vector<char>(temporaryPath_.begin(), temporaryPath_.end()));
        temporaryPath_.assign(names.front().begin(), names.front().end());
    }
    descriptor_ = ::open(temporaryPath_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0)
        throw IoError(path_ + ": its folder is not the same for all processes (" +
                      std::strerror(errno) + "); name a folder on a disk that they share");
}

SharedFile::~SharedFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

void SharedFile::requireRoom(std::uint64_t bytes) {
    const auto fail = [&](int cause) {
        throw IoError(path_ + ": writing failed: " + std::strerror(cause) +
                      "; a previous file of that name is unchanged");
    };
    if (static_cast<double>(bytes) > availableSpace(path_)) fail(ENOSPC);
    if (::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0 ||
        ::ftruncate(descriptor_, 0) != 0)
        fail(errno);
}

void SharedFile::writeAt(std::uint64_t offset, const void* data, std::size_t bytes) {
    const char* from = static_cast<const char*>(data);
    while (bytes > 0) {
        const ssize_t n = ::pwrite(descriptor_, from, bytes, static_cast<off_t>(offset));
        if (n < 0) {
            if (errno == EINTR) continue;
            throw IoError(path_ + ": writing failed: " + std::strerror(errno) +
                          "; a previous file of that name is unchanged");
        }
        from += n;
        offset += static_cast<std::uint64_t>(n);
        bytes -= static_cast<std::size_t>(n);
    }
}

void SharedFile::commit() {
    while (::fsync(descriptor_) != 0)
        if (errno != EINTR)
            throw IoError(path_ + ": flushing failed: " + std::strerror(errno) +
                          "; a previous file of that name is unchanged");
    anyOver(ranks_, false);  // all have written
    if (file_) file_->commit();
    anyOver(ranks_, false);  // the file has its name
}

}  // namespace vdbpack
