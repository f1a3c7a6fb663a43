#include "vdbpack/io/output_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/text.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <random>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::size_t kWriteBytes = 1 << 20;
/// Number of temporary names to try, and how many bytes of the file's name they begin with.
constexpr int kNames = 100;
constexpr std::size_t kLongestStem = 200;
constexpr int kMostLinks = 40;

/// Names that a signal handler removes. It may run at any moment on any thread: only the holder of
/// a slot accesses its name.
struct Slot {
    enum State : int { free, held, ready };
    std::atomic<int> state{free};
    std::array<char, PATH_MAX> name{};
};
std::array<Slot, 32> slots;
static_assert(std::atomic<int>::is_always_lock_free);

/// @return the slot; -1 if all are in use or the name is too long: then only the destructor of the
/// file removes it.
int keepName(const std::string& name) {
    if (name.size() >= PATH_MAX) return -1;
    for (std::size_t i = 0; i < slots.size(); ++i) {
        int expected = Slot::free;
        if (!slots[i].state.compare_exchange_strong(expected, Slot::held)) continue;
        std::memcpy(slots[i].name.data(), name.c_str(), name.size() + 1);
        slots[i].state = Slot::ready;
        return static_cast<int>(i);
    }
    return -1;
}

void forgetName(int slot) {
    if (slot < 0) return;
    int expected = Slot::ready;
    // If it is not ready, a signal handler is about to end the process.
    slots[static_cast<std::size_t>(slot)].state.compare_exchange_strong(expected, Slot::free);
}

std::string temporaryName(const std::string& target) {
    static const char kLetters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
    static std::atomic<unsigned> calls{0};
    // Several processes may write the same file, so their temporary names must differ.
    std::random_device seed;
    std::mt19937 random(seed() ^ static_cast<unsigned>(::getpid()) ^ (calls++ << 16));
    std::uniform_int_distribution<std::size_t> letter(0, sizeof kLetters - 2);
    const auto slash = target.find_last_of('/');
    const std::size_t begin = slash == std::string::npos ? 0 : slash + 1;
    std::string name = target.substr(0, begin + std::min(target.size() - begin, kLongestStem));
    name += '.';
    for (int i = 0; i < 6; ++i) name += kLetters[letter(random)];
    return name + ".tmp";
}

/// Whether a path is an open file descriptor of a process.
bool isStream(const std::string& path) {
    const auto begins = [&](const char* with) { return path.rfind(with, 0) == 0; };
    return begins("/proc/") || begins("/dev/fd/") || path == "/dev/stdin" ||
           path == "/dev/stdout" || path == "/dev/stderr";
}

std::string folderOf(const std::string& path) {
    const auto slash = path.find_last_of('/');
    return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

}  // namespace

std::string followLinks(const std::string& path) {
    std::string at = path;
    for (int links = 0; links <= kMostLinks; ++links) {
        std::array<char, PATH_MAX> to{};
        const ssize_t n = ::readlink(at.c_str(), to.data(), to.size());
        if (n < 0 || static_cast<std::size_t>(n) >= to.size()) return at;
        const std::string next(to.data(), static_cast<std::size_t>(n));
        const auto slash = at.find_last_of('/');
        at = !next.empty() && next[0] == '/' ? next
             : slash == std::string::npos    ? next
                                             : at.substr(0, slash + 1) + next;
    }
    throw IoError(path + ": symbolic links form a cycle; name another file");
}

OutputFile::OutputFile(std::string path, bool shown)
    : path_(std::move(path)), target_(followLinks(path_)) {
    folder_ = folderOf(target_);
    requireFileName(path_);
    if (isStream(path_))
        throw IoError(path_ + ": is a stream, which cannot be replaced by a file; name a file");
    if (target_.size() - (target_.find_last_of('/') + 1) > NAME_MAX)
        throw IoError(fmt::format("{}: the name is longer than {} bytes; choose a shorter one",
                                  path_, NAME_MAX));
    struct stat former {};
    const bool exists = ::stat(target_.c_str(), &former) == 0;
    if (exists && S_ISDIR(former.st_mode)) throw IoError(path_ + ": is a folder; name a file");
    if (exists && !S_ISREG(former.st_mode))
        throw IoError(path_ +
                      ": is a device or a pipe, which cannot be replaced by a file; name a file");
    if (exists && ::faccessat(AT_FDCWD, target_.c_str(), W_OK, AT_EACCESS) != 0 && errno == EACCES)
        throw IoError(path_ + ": is write-protected; name another file, or allow writing to it");
    // Memory is allocated first: if that fails, there is no file to remove.
    buffer_.reserve(kWriteBytes);
    temporaryPath_.reserve(64);
    // If possible, a file without a name, which leaves nothing after a crash.
    if (!shown) descriptor_ = ::open(folder_.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) {
        temporaryPath_ = "/proc/self/fd/" + std::to_string(descriptor_);
        if (::access(temporaryPath_.c_str(), W_OK) != 0) {  // no /proc: it could not get a name
            ::close(descriptor_);
            descriptor_ = -1;
        }
    }
    if (descriptor_ < 0) createNamed();
    if (exists) {
        const int kept = ::fchmod(descriptor_, former.st_mode & 07777);
        static_cast<void>(kept);  // fails on file systems without modes
    }
}

void OutputFile::createNamed() {
    for (int attempt = 0; attempt < kNames && descriptor_ < 0; ++attempt) {
        temporaryPath_ = temporaryName(target_);
        // Before the file exists, since a signal may arrive in between.
        slot_ = keepName(temporaryPath_);
        descriptor_ = ::open(temporaryPath_.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666);
        if (descriptor_ >= 0) break;
        const int cause = errno;
        forgetName(slot_);
        slot_ = -1;
        errno = cause;
        if (cause != EEXIST) break;
    }
    if (descriptor_ < 0) {
        const int cause = errno;
        throw IoError(path_ + ": cannot create a file in folder '" + folder_ +
                      "': " + std::strerror(cause) +
                      "; choose another folder, or create this one if it is missing");
    }
    named_ = true;
}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (named_) ::unlink(temporaryPath_.c_str());
    forgetName(slot_);
}

void OutputFile::fail(const char* action) const {
    const int cause = errno;
    throw IoError(path_ + ": " + action + " failed: " + std::strerror(cause) +
                  "; a previous file of that name is unchanged");
}

void OutputFile::write(const void* data, std::size_t bytes) {
    if (buffer_.size() + bytes > kWriteBytes) flushBuffer();
    buffer_.append(static_cast<const char*>(data), bytes);
    if (buffer_.size() >= kWriteBytes) flushBuffer();
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
    while (::fsync(descriptor_) != 0)
        if (errno != EINTR) fail("flushing");
    for (int attempt = 0; !named_; ++attempt) {
        std::string name = temporaryName(target_);
        slot_ = keepName(name);
        if (::linkat(AT_FDCWD, temporaryPath_.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) ==
            0) {
            temporaryPath_ = std::move(name);
            named_ = true;
            break;
        }
        const int cause = errno;
        forgetName(slot_);
        slot_ = -1;
        errno = cause;
        if (cause != EEXIST || attempt == kNames) fail("naming");
    }
    // A network drive may report only now that it is full.
    const int closed = ::close(descriptor_);
    descriptor_ = -1;
    if (closed != 0) fail("closing");
    if (::rename(temporaryPath_.c_str(), target_.c_str()) != 0) fail("renaming");
    named_ = false;
    forgetName(slot_);
    slot_ = -1;
    // Lets the name survive a loss of power, too. Some file systems do not support this; the file
    // is complete under its name in any case.
    const int folder = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        const int flushed = ::fsync(folder);
        static_cast<void>(flushed);
        ::close(folder);
    }
}

void removeTemporaryFiles() noexcept {
    for (Slot& slot : slots) {
        int expected = Slot::ready;
        // The slot stays held, so that no other file gets it meanwhile.
        if (slot.state.compare_exchange_strong(expected, Slot::held)) ::unlink(slot.name.data());
    }
}

}  // namespace vdbpack
