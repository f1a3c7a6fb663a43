// Private: what the name of a pack file says.
#pragma once

#include <string>

namespace vdbpack {

enum class PackFormat {
    vdb,
    points,
    vtp,
    pvtp,
    vtkhdf,
    ply,
    csv,
    xyz,
    npz,
    usd,
    usdz,
    svg,
    yade,
    lammpsData,
    lammpsBonds,
    lammpsDump
};

struct PackTarget {
    PackFormat format;
    std::string path;
};

/// @param dim  as for `checkPackFormat`. @throws ParameterError as that.
PackTarget targetToWrite(const std::string& file, int dim);
/// @throws ParameterError for a format that is not read, with the list of those that are.
PackTarget targetToRead(const std::string& file);

}  // namespace vdbpack
