#include "vdbpack/field/vdb_archive.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <sstream>
#include <string_view>
#include <utility>

namespace vdbpack {

using openvdb::GridBase;
using openvdb::io::GridDescriptor;

VdbArchive::VdbArchive(const std::string& path) : stream_(path, std::ios::binary) {
    if (!stream_) {
        const int cause = errno;
        throw IoError(path + ": cannot be read: " + std::strerror(cause) +
                      (cause == ENOENT ? similarFile(path) : ""));
    }
    stream_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    readHeader();
    openvdb::MetaMap().readMeta(stream_);
    const std::int32_t count = readGridCount(stream_);
    for (std::int32_t i = 0; i < count; ++i) entries_.push_back(readEntry());
    std::stable_sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
        return a.descriptor.uniqueName() < b.descriptor.uniqueName();
    });
}

void VdbArchive::readHeader() {
    // Identifier and version in 4 bytes each, versions of the library, a flag, the file's
    // identifier.
    std::string head(8 + 4 + 8 + 1 + 36, '\0');
    stream_.read(head.data(), static_cast<std::streamsize>(head.size()));
    std::uint32_t version = 0;
    std::memcpy(&version, head.data() + 8, sizeof version);
    version = std::min(version, std::uint32_t{openvdb::OPENVDB_FILE_VERSION});
    std::memcpy(head.data() + 8, &version, sizeof version);
    std::istringstream known(head);
    Archive::readHeader(known);
}

void VdbArchive::tagStream() {
    tag_ = std::make_shared<openvdb::io::StreamMetadata>();
    setStreamMetadataPtr(stream_, tag_, /*transfer=*/false);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
}

VdbArchive::Entry VdbArchive::readEntry() {
    tagStream();
    Entry entry;
    const std::streampos begin = stream_.tellg();
    const std::string name = openvdb::readString(stream_);
    std::string type = openvdb::readString(stream_);
    // How its floats are saved is no part of a grid's type.
    if (constexpr std::string_view kHalf = "_HalfFloat"; endsWith(type, kHalf))
        type.resize(type.size() - kHalf.size());
    entry.descriptor = GridDescriptor(name, type);
    if (!GridBase::isRegistered(type)) {
        openvdb::readString(stream_);  // the parent of an instance
        std::int64_t offsets[3] = {};
        stream_.read(reinterpret_cast<char*>(offsets), sizeof offsets);
        entry.descriptor.setEndPos(offsets[2]);
    } else {
        stream_.seekg(begin);
        entry.grid = entry.descriptor.read(stream_);
        if (!inputHasGridOffsets()) {
            readValues(entry);
            return entry;
        }
        readGridCompression(stream_);
        entry.grid->readMeta(stream_);
        entry.grid->readTransform(stream_);
    }
    entry.descriptor.seekToEnd(stream_);
    return entry;
}

void VdbArchive::readValues(Entry& entry) {
    if (entry.isWhole) return;
    if (inputHasGridOffsets()) entry.descriptor.seekToGrid(stream_);
    tagStream();
    readGrid(entry.grid, entry.descriptor, stream_);
    entry.isWhole = true;
    if (!entry.descriptor.isInstance()) return;
    const auto parent = std::find_if(entries_.begin(), entries_.end(), [&entry](const Entry& e) {
        return e.descriptor.uniqueName() == entry.descriptor.instanceParentName();
    });
    if (parent == entries_.end() || !parent->grid || parent->grid->type() != entry.grid->type() ||
        parent->descriptor.isInstance())
        throw InputError(
            fmt::format("grid '{}' is an instance of a grid that the file does not hold",
                        entry.grid->getName()));
    readValues(*parent);
    entry.grid->setTree(parent->grid->baseTreePtr());
}

GridBase::Ptr VdbArchive::find(const std::function<bool(const GridBase&)>& wanted) {
    for (Entry& entry : entries_) {
        if (!entry.grid || !wanted(*entry.grid)) continue;
        readValues(entry);
        return entry.grid;
    }
    return nullptr;
}

bool VdbArchive::isNamed(const GridBase& head, const std::string& name) const {
    if (head.getName() == name) return true;
    const auto entry = std::find_if(entries_.begin(), entries_.end(),
                                    [&head](const Entry& e) { return e.grid.get() == &head; });
    return GridDescriptor::nameAsString(entry->descriptor.uniqueName()) == name;
}

std::vector<GridBase::ConstPtr> VdbArchive::heads() const {
    std::vector<GridBase::ConstPtr> found;
    for (const Entry& entry : entries_)
        if (entry.grid) found.push_back(entry.grid);
    return found;
}

std::string VdbArchive::list() const {
    std::string text;
    for (const Entry& entry : entries_) {
        if (text.size() > 500) return text + ", ...";
        const std::string type = entry.grid ? entry.grid->valueType() : entry.descriptor.gridType();
        text += fmt::format(
            "{}'{}' ({}{})", text.empty() ? "" : ", ",
            GridDescriptor::nameAsString(entry.descriptor.uniqueName()).substr(0, 80),
            type.substr(0, 80), entry.grid ? "" : ", a type that this build does not read");
    }
    return text;
}

}  // namespace vdbpack
