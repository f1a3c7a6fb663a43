// Small files with a given content, and the content of any file.
#pragma once

#include "support/temporary_folder.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace vdbpack::test {

inline std::string contentOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline bool isPng(const std::string& path) {
    return contentOf(path).rfind("\x89PNG\r\n\x1a\n", 0) == 0;
}

/// Writes a whole file. An existing file is removed first: file systems flush a file that is
/// truncated and rewritten to the disk at once, which would dominate the time of thousands of
/// variants.
inline void putContent(const std::string& path, const std::string& content) {
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary) << content;
}

/// A file with this content, removed at the end of the test.
class TextFile {
public:
    explicit TextFile(const std::string& content, const std::string& name = "f.csv")
        : path_(folder_.file(name)) {
        putContent(path_, content);
    }
    const std::string& path() const { return path_; }

private:
    TemporaryFolder folder_;
    std::string path_;
};

}  // namespace vdbpack::test
