// Small text files and what readers say about them.
#pragma once

#include "support/temporary_folder.h"

#include "vdbpack/core/error.h"

#include <fstream>
#include <string>

namespace vdbpack {

/// A file with this content, removed at the end of the test.
class TextFile {
public:
    explicit TextFile(const std::string& content, const std::string& name = "f.csv")
        : path_(folder_.file(name)) {
        std::ofstream(path_, std::ios::binary) << content;
    }
    const std::string& path() const { return path_; }

private:
    TemporaryFolder folder_;
    std::string path_;
};

/// The message of the `Failure` that `work` ends with; empty if it does not fail.
template <class Failure, class Work>
std::string messageOf(const Work& work) {
    try {
        work();
    } catch (const Failure& e) {
        return e.what();
    }
    return "";
}

}  // namespace vdbpack
