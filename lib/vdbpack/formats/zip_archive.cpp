#include "vdbpack/formats/zip_archive.h"

#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <new>

namespace vdbpack {

namespace {

/// Deflate expands by less than this factor.
constexpr std::uint64_t kMostDeflated = 1032;

std::string shown(const ZipArchive::Member& member) {
    return "member " + quotedExcerpt(member.name);
}

}  // namespace

ZipArchive::ZipArchive(const std::string& path) : file_(path) {
    zip_error_t error;
    zip_error_init(&error);
    // Of a pipe, the bytes that `InputFile` holds in memory.
    zip_source_t* const source =
        file_.inMemory()
            ? zip_source_buffer_create(file_.peek(file_.size()).data(), file_.size(), 0, &error)
            : zip_source_file_create(path.c_str(), 0, -1, &error);
    if (source == nullptr) throw std::bad_alloc();
    archive_ = zip_open_from_source(source, ZIP_RDONLY, &error);
    if (archive_ != nullptr) return;
    zip_source_free(source);
    failWith(&error, "is not a complete zip archive");
}

ZipArchive::~ZipArchive() {
    if (archive_ != nullptr) zip_discard(archive_);
}

void ZipArchive::failWith(zip_error* error, const std::string& what) const {
    const int code = zip_error_code_zip(error);
    const std::string reason = zip_error_strerror(error);
    zip_error_fini(error);
    if (code == ZIP_ER_MEMORY) throw std::bad_alloc();
    file_.fail(fmt::format("{} ({})", what, reason));
}

std::uint64_t ZipArchive::members() const {
    return static_cast<std::uint64_t>(zip_get_num_entries(archive_, 0));
}

ZipArchive::Member ZipArchive::member(std::uint64_t index) const {
    Member member;
    member.index = index;
    zip_stat_t stat;
    // Names as they stand: numpy writes UTF-8.
    if (zip_stat_index(archive_, index, ZIP_FL_ENC_RAW, &stat) != 0)
        file_.fail(fmt::format("member {} of the archive is damaged", index));
    member.name = stat.name;
    member.packed = stat.comp_size;
    member.size = stat.size;
    if (stat.encryption_method != ZIP_EM_NONE)
        file_.fail(shown(member) + " is encrypted; save it without");
    const bool stored = stat.comp_method == ZIP_CM_STORE;
    if (!stored && stat.comp_method != ZIP_CM_DEFLATE)
        file_.fail(fmt::format("{} is compressed by method {}; store or deflate it", shown(member),
                               stat.comp_method));
    if (stored ? member.packed != member.size : member.size / kMostDeflated > member.packed + 64)
        file_.fail(shown(member) + " does not fit into the file; it is damaged or cut short");
    return member;
}

/// The unpacked bytes of a member, from front to end.
class ZipArchive::Stream {
public:
    Stream(const ZipArchive& archive, const Member& member)
        : archive_(archive),
          member_(member),
          stream_(zip_fopen_index(archive.archive_, member.index, 0), &zip_fclose) {
        if (!stream_) fail(zip_get_error(archive_.archive_));
    }
    /// @return whether all `bytes` were there.
    bool read(char* target, std::size_t bytes) {
        for (std::size_t done = 0; done < bytes;) {
            const auto n = zip_fread(stream_.get(), target + done, bytes - done);
            if (n < 0) fail(zip_file_get_error(stream_.get()));
            if (n == 0) return false;
            done += static_cast<std::size_t>(n);
        }
        return true;
    }

private:
    [[noreturn]] void fail(zip_error* error) const {
        archive_.failWith(error, shown(member_) + " cannot be read; the file is damaged");
    }

    const ZipArchive& archive_;
    const Member& member_;
    std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> stream_;
};

std::string ZipArchive::beginning(const Member& member, std::uint64_t bytes) {
    std::string beginning(static_cast<std::size_t>(std::min(bytes, member.size)), '\0');
    if (!Stream(*this, member).read(beginning.data(), beginning.size()))
        file_.fail(shown(member) + " is not as long as it claims; the file is damaged");
    return beginning;
}

std::string ZipArchive::content(const Member& member) {
    // Members that share their bytes would unpack to any size.
    if (member.packed > file_.size() - taken_)
        file_.fail(
            shown(member) +
            ", beside those before it, does not fit into the file; it is damaged or cut short");
    taken_ += member.packed;
    std::string bytes(static_cast<std::size_t>(member.size), '\0');
    Stream stream(*this, member);
    char beyond = 0;
    // Reading on to the end is what compares the checksum.
    if (!stream.read(bytes.data(), bytes.size()) || stream.read(&beyond, 1))
        file_.fail(shown(member) + " is not as long as it claims; the file is damaged");
    return bytes;
}

}  // namespace vdbpack
