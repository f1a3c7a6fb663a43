// Private: what the name of a pack file says.
#pragma once

#include "vdbpack/core/pack.h"

#include <string>

namespace vdbpack {

class OutputFile;
class PackView;
struct PackReadOptions;
struct PackWriteOptions;

/// The formats that something treats apart, and all others.
enum class PackFormat {
    other,
    vdb,
    points,
    pvtp,
    vtkhdf,
    csv,
    usd,
    usdz,
    svg,
    yade,
    spherePack,
    lammpsData,
    lammpsBonds,
    lammpsDump
};

struct PackTarget {
    using Write = void (*)(const PackView&, const PackWriteOptions&, OutputFile&);
    using Read = Pack<3> (*)(const std::string&, const PackReadOptions&);

    PackFormat format;
    std::string path;
    Write write;  ///< null: the format is written in pieces or by HDF5, or not at all
    Read read;    ///< null: the format is not read
};

/// @param dim  as for `checkPackFormat`. @throws ParameterError as `checkPackFormat`.
PackTarget targetToWrite(const std::string& file, int dim);
/// @throws ParameterError for a format that is not read, with the list of formats that are read.
PackTarget targetToRead(const std::string& file);

}  // namespace vdbpack
