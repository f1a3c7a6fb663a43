// Private: the grids of a .vdb file, of any version that vdb_check.h lets pass.
#pragma once

#include <openvdb/Grid.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>

#include <cstddef>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace vdbpack {

/// Reads by OpenVDB through a stream that throws where a file ends too early, which OpenVDB's own
/// `io::File` does not notice; that class also warns on standard error of files that a newer
/// OpenVDB has written in the same layout.
class VdbArchive : private openvdb::io::Archive {
public:
    /// Reads the heads of all grids. The file has passed `checkVdbFile`.
    /// @throws IoError, std::exception if the file cannot be read.
    explicit VdbArchive(const std::string& path);

    /// The first grid by name whose head, without values, `wanted` accepts: with its values; null
    /// if there is none.
    openvdb::GridBase::Ptr find(const std::function<bool(const openvdb::GridBase&)>& wanted);
    /// Whether grid `head` is named so: by its name or, among several of one name, "name[1]".
    bool isNamed(const openvdb::GridBase& head, const std::string& name) const;
    /// The heads of the grids whose type is registered, ordered by name.
    std::vector<openvdb::GridBase::ConstPtr> heads() const;
    /// The names and types of all grids, for messages: at most 500 characters.
    std::string list() const;

private:
    struct Entry {
        openvdb::io::GridDescriptor descriptor;
        openvdb::GridBase::Ptr grid;  ///< null: its type is not registered
        bool isWhole = false;         ///< values included
    };

    void readHeader();
    void tagStream();
    Entry readEntry();
    void readValues(Entry& entry);

    std::ifstream stream_;
    openvdb::io::StreamMetadata::Ptr tag_;  ///< of the stream, which does not own it
    std::vector<Entry> entries_;
};

}  // namespace vdbpack
