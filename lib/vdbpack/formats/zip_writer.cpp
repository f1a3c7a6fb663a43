#include "vdbpack/formats/zip_writer.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/byte_order.h"

namespace vdbpack {

namespace {

constexpr std::uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50,
                        kEnd64 = 0x06064b50, kLocator64 = 0x07064b50;
constexpr std::uint64_t kIn64 = 0xffffffff;  // the number is in the 64-bit extension
constexpr std::uint16_t kExtra64 = 1, kExtraPadding = 0x1986;
constexpr std::uint64_t kLocalBytes = 30, kExtraBytes = 4, kAlignment = 64;

void put16(std::string& bytes, std::uint64_t value) {
    appendLittleEndian(bytes, static_cast<std::uint16_t>(value));
}
void put32(std::string& bytes, std::uint64_t value) {
    appendLittleEndian(bytes, static_cast<std::uint32_t>(value));
}

}  // namespace

/// Bytes to be added to the local header of a member, so that what follows is aligned.
std::uint64_t ZipWriter::padding(std::size_t nameBytes) const {
    const std::uint64_t data = offset_ + kLocalBytes + nameBytes + kExtraBytes;
    return (kAlignment - data % kAlignment) % kAlignment;
}

void ZipWriter::begin(const std::string& name, std::uint64_t size, std::uint32_t crc) {
    const bool wide = form_ == Form::zip64;
    if (!wide && offset_ + size + 1000 > kIn64)
        throw IoError(out_.path() + ": takes more than the 4 GiB that .usdz holds; write .usda");
    const std::uint64_t version = wide ? 45 : 10;
    std::string common;               // of local and central header
    put16(common, wide ? 0x800 : 0);  // names in UTF-8
    put16(common, 0);                 // stored
    put32(common, 0x210000);          // 1980-01-01: files do not depend on when they are written
    put32(common, crc);
    put32(common, wide ? kIn64 : size);
    put32(common, wide ? kIn64 : size);
    put16(common, name.size());
    std::string sizes;
    appendLittleEndian(sizes, size);
    appendLittleEndian(sizes, size);

    std::string local;
    put32(local, kLocal);
    put16(local, version);
    local += common;
    const std::uint64_t pad = padding(name.size());
    put16(local, wide ? kExtraBytes + sizes.size() : kExtraBytes + pad);
    local += name;
    put16(local, wide ? kExtra64 : kExtraPadding);
    put16(local, wide ? sizes.size() : pad);
    if (wide)
        local += sizes;
    else
        local.append(pad, '\0');

    put32(directory_, kCentral);
    put16(directory_, 0x0300 + version);  // made on Unix
    put16(directory_, version);
    directory_ += common;
    put16(directory_, wide ? 28 : 0);
    put16(directory_, 0);               // comment
    put16(directory_, 0);               // disk
    put16(directory_, 0);               // internal attributes
    put32(directory_, 0100644u << 16);  // an ordinary file
    put32(directory_, wide ? kIn64 : offset_);
    directory_ += name;
    if (wide) {
        put16(directory_, kExtra64);
        put16(directory_, 24);
        directory_ += sizes;
        appendLittleEndian(directory_, offset_);
    }

    out_.write(local);
    offset_ += local.size() + size;
    ++members_;
}

void ZipWriter::finish() {
    const bool wide = form_ == Form::zip64;
    std::string end;
    if (wide) {
        put32(end, kEnd64);
        appendLittleEndian(end, std::uint64_t{44});
        put16(end, 0x032d);
        put16(end, 45);
        put32(end, 0);
        put32(end, 0);
        appendLittleEndian(end, members_);
        appendLittleEndian(end, members_);
        appendLittleEndian(end, static_cast<std::uint64_t>(directory_.size()));
        appendLittleEndian(end, offset_);
        put32(end, kLocator64);
        put32(end, 0);
        appendLittleEndian(end, offset_ + directory_.size());
        put32(end, 1);
    }
    put32(end, kEnd);
    put32(end, 0);
    put16(end, wide ? 0xffff : members_);
    put16(end, wide ? 0xffff : members_);
    put32(end, wide ? kIn64 : directory_.size());
    put32(end, wide ? kIn64 : offset_);
    put16(end, 0);
    out_.write(directory_);
    out_.write(end);
}

}  // namespace vdbpack
