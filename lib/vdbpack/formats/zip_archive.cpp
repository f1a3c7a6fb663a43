#include "vdbpack/formats/zip_archive.h"

#include "vdbpack/core/error.h"
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

/// The file as libzip reads it: pipes, which `InputFile` holds in memory, included.
struct ZipArchive::Source {
    explicit Source(const std::string& path) : file(path) { zip_error_init(&error); }
    ~Source() { zip_error_fini(&error); }
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;

    zip_int64_t read(void* data, zip_uint64_t length) {
        const std::uint64_t bytes = std::min<std::uint64_t>(length, file.size() - at);
        try {
            file.readAt(at, data, static_cast<std::size_t>(bytes));
        } catch (...) {
            thrown = std::current_exception();  // not through libzip, which is C
            zip_error_set(&error, ZIP_ER_READ, 0);
            return -1;
        }
        at += bytes;
        return static_cast<zip_int64_t>(bytes);
    }

    static zip_int64_t serve(void* state, void* data, zip_uint64_t length,
                             zip_source_cmd_t command) {
        Source& self = *static_cast<Source*>(state);
        switch (command) {
            case ZIP_SOURCE_SUPPORTS:
                return ZIP_SOURCE_SUPPORTS_SEEKABLE;
            case ZIP_SOURCE_OPEN:
                self.at = 0;
                return 0;
            case ZIP_SOURCE_READ:
                return self.read(data, length);
            case ZIP_SOURCE_SEEK: {
                const auto to = zip_source_seek_compute_offset(self.at, self.file.size(), data,
                                                               length, &self.error);
                if (to < 0) return -1;
                self.at = static_cast<std::uint64_t>(to);
                return 0;
            }
            case ZIP_SOURCE_TELL:
                return static_cast<zip_int64_t>(self.at);
            case ZIP_SOURCE_STAT: {
                auto* stat = static_cast<zip_stat_t*>(data);
                zip_stat_init(stat);
                stat->size = self.file.size();
                stat->valid = ZIP_STAT_SIZE;
                return sizeof *stat;
            }
            case ZIP_SOURCE_ERROR:
                return zip_error_to_data(&self.error, data, length);
            case ZIP_SOURCE_CLOSE:
            case ZIP_SOURCE_FREE:
                return 0;
            default:
                zip_error_set(&self.error, ZIP_ER_OPNOTSUPP, 0);
                return -1;
        }
    }

    InputFile file;
    std::uint64_t at = 0;
    zip_error_t error{};
    std::exception_ptr thrown;
};

ZipArchive::ZipArchive(const std::string& path) : source_(std::make_unique<Source>(path)) {
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* source = zip_source_function_create(&Source::serve, source_.get(), &error);
    if (source == nullptr) throw std::bad_alloc();
    archive_ = zip_open_from_source(source, ZIP_RDONLY, &error);
    if (archive_ != nullptr) return;
    zip_source_free(source);
    failWith(&error, "is not a complete zip archive");
}

ZipArchive::~ZipArchive() {
    if (archive_ != nullptr) zip_discard(archive_);
}

void ZipArchive::fail(const std::string& what) const {
    throw InputError(source_->file.path() + ": " + what);
}

void ZipArchive::failWith(zip_error* error, const std::string& what) const {
    const int code = zip_error_code_zip(error);
    const std::string reason = zip_error_strerror(error);
    zip_error_fini(error);
    if (source_->thrown) std::rethrow_exception(source_->thrown);
    if (code == ZIP_ER_MEMORY) throw std::bad_alloc();
    fail(fmt::format("{} ({})", what, reason));
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
        fail(fmt::format("member {} of the archive is damaged", index));
    member.name = stat.name;
    member.packed = stat.comp_size;
    member.size = stat.size;
    if (stat.encryption_method != ZIP_EM_NONE)
        fail(shown(member) + " is encrypted; save it without");
    const bool stored = stat.comp_method == ZIP_CM_STORE;
    if (!stored && stat.comp_method != ZIP_CM_DEFLATE)
        fail(fmt::format("{} is compressed by method {}; store or deflate it", shown(member),
                         stat.comp_method));
    if (stored ? member.packed != member.size : member.size / kMostDeflated > member.packed + 64)
        fail(shown(member) + " does not fit into the file; it is damaged or cut short");
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
        fail(shown(member) + " is not as long as it claims; the file is damaged");
    return beginning;
}

std::string ZipArchive::content(const Member& member) {
    // Members that share their bytes would unpack to any size.
    if (member.packed > source_->file.size() - taken_)
        fail(shown(member) +
             ", beside those before it, does not fit into the file; it is damaged or cut short");
    taken_ += member.packed;
    std::string bytes(static_cast<std::size_t>(member.size), '\0');
    Stream stream(*this, member);
    char beyond = 0;
    // Reading on to the end is what compares the checksum.
    if (!stream.read(bytes.data(), bytes.size()) || stream.read(&beyond, 1))
        fail(shown(member) + " is not as long as it claims; the file is damaged");
    return bytes;
}

}  // namespace vdbpack
