// What the fuzz targets share: inputs as files, and what every reader of a file keeps to.
#pragma once

#include "vdbpack/core/error.h"
#include "vdbpack/core/pack.h"

#include <stdlib.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>

namespace vdbpack::fuzz {

/// Ends the run: the fuzzer keeps the input as a found case.
[[noreturn]] inline void report(const std::string& what) {
    std::fprintf(stderr, "broken promise: %s\n", what.c_str());
    std::abort();
}

/// One file in memory that is written again for each input.
class InputAsFile {
public:
    explicit InputAsFile(const std::string& name) {
        const char* const memory = "/dev/shm";
        std::string folder =
            (std::filesystem::is_directory(memory) ? std::filesystem::path(memory)
                                                   : std::filesystem::temp_directory_path()) /
            "vdbpack-fuzz-XXXXXX";
        if (::mkdtemp(folder.data()) == nullptr) report("no folder for the input");
        folder_ = folder;
        path_ = folder_ / name;
    }
    ~InputAsFile() {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    InputAsFile(const InputAsFile&) = delete;
    InputAsFile& operator=(const InputAsFile&) = delete;

    const std::string& write(const std::uint8_t* data, std::size_t size) {
        std::FILE* const file = std::fopen(path_.c_str(), "wb");
        if (file == nullptr) report("the input cannot be written");
        const bool whole = size == 0 || std::fwrite(data, 1, size, file) == size;
        if (std::fclose(file) != 0 || !whole) report("the input cannot be written");
        return path_;
    }
    const std::string& write(const std::string& text) {
        return write(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    }

private:
    std::filesystem::path folder_;
    std::string path_;
};

/// Calls `read`, which may refuse its input: by an InputError or IoError that names `path`. Small
/// files ask for no resources, and every other exception ends the run.
template <class Read>
void readOrRefuse(const std::string& path, const Read& read) {
    try {
        read();
    } catch (const ResourceError& e) {
        report(std::string("ResourceError: ") + e.what());
    } catch (const ParameterError& e) {
        report(std::string("ParameterError: ") + e.what());
    } catch (const Error& e) {
        if (std::strstr(e.what(), path.c_str()) == nullptr)
            report(std::string("the message does not name the file: ") + e.what());
    }
}

/// What a pack that was read holds.
inline void requireSound(const Pack<3>& pack) {
    const std::size_t n = pack.spheres.size();
    for (const auto& s : pack.spheres)
        if (!isFinite(s.center) || !(s.radius > 0) || !std::isfinite(s.radius))
            report("a sphere is not finite or has no radius");
    forEachAttribute(pack, [n](std::string_view, const auto& values) {
        if (!values.empty() && values.size() != n)
            report("an attribute has not one value a sphere");
    });
}

}  // namespace vdbpack::fuzz
