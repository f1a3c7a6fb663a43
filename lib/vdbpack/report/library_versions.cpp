#include "vdbpack/report/library_versions.h"

#include "vdbpack/field/vdb_init.h"

#include <blosc.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <png.h>
#include <tbb/version.h>
#include <zlib.h>

#if !defined(VDBPACK_EMBREE)
#elif VDBPACK_EMBREE >= 4
#include <embree4/rtcore_config.h>
#else
#include <embree3/rtcore_config.h>
#endif

namespace vdbpack {

std::vector<std::pair<std::string, std::string>> libraryVersions() {
    return {
        {"OpenVDB", openVdbVersion()},
        {"TBB", TBB_runtime_version()},
        {"Blosc", BLOSC_VERSION_STRING},
        {"zlib", zlibVersion()},
        {"libpng", PNG_LIBPNG_VER_STRING},
#ifdef VDBPACK_EMBREE
        {"Embree", RTC_VERSION_STRING},
#endif
        {"fmt",
         fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100)},
        {"nlohmann-json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR,
                                      NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH)},
        {"compiler", __VERSION__},
    };
}

}  // namespace vdbpack
