// Private: the members of a zip archive, read by libzip.
#pragma once

#include "vdbpack/io/input_file.h"

#include <cstdint>
#include <memory>
#include <string>

struct zip;
struct zip_error;

namespace vdbpack {

/// A zip archive that is read. Time and memory are in proportion to the file, whatever its
/// directory announces.
class ZipArchive {
public:
    struct Member {
        std::uint64_t index = 0;
        std::string name;
        std::uint64_t packed = 0;  ///< bytes in the file
        std::uint64_t size = 0;    ///< bytes that these unpack to
    };

    /// @throws InputError if the file is no zip archive or is damaged, IoError.
    explicit ZipArchive(const std::string& path);
    ~ZipArchive();
    ZipArchive(const ZipArchive&) = delete;
    ZipArchive& operator=(const ZipArchive&) = delete;

    std::uint64_t members() const;
    /// @throws InputError if it cannot be read: encrypted, of a method other than numpy's, or of
    /// sizes that are impossible.
    Member member(std::uint64_t index) const;
    /// The first bytes of a member, at most `bytes`. @throws InputError, IoError
    std::string beginning(const Member& member, std::uint64_t bytes);
    /// The bytes of a member, checked against its checksum. To be called once per member: those
    /// that share their bytes would unpack to any size. @throws InputError, IoError
    std::string content(const Member& member);

private:
    class Stream;

    /// @throws InputError "file: what (the cause)"
    [[noreturn]] void failWith(zip_error* error, const std::string& what) const;

    InputFile file_;
    zip* archive_ = nullptr;
    std::uint64_t taken_ = 0;  ///< bytes of the file that members took
};

}  // namespace vdbpack
