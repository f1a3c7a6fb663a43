// Packs as the content of a file, ours or another program's.
#pragma once

#include "support/message_of.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

namespace vdbpack::test {

/// The file of this name, which a format and a colon may precede, in a folder.
inline std::string inFolder(const TemporaryFolder& scratch, const std::string& file) {
    const auto colon = file.find(':');
    return colon == std::string::npos
               ? scratch.file(file)
               : file.substr(0, colon + 1) + scratch.file(file.substr(colon + 1));
}

/// The pack in a file of this name (by extension; p.txt: YADE) and content.
inline Pack<3> readText(const std::string& name, const std::string& content) {
    const TemporaryFolder scratch;
    putContent(scratch.file(name), content);
    const auto prefix = name == "p.txt" ? std::string("yade:") : std::string();
    return readPack(prefix + (scratch.file(name)));
}

/// What is written to `target`, such as "p.csv" or "yade:p.txt".
template <int Dim>
std::string writtenText(const Pack<Dim>& pack, const std::string& target,
                        const PackWriteOptions& options = {}) {
    const TemporaryFolder scratch;
    writePack(pack, inFolder(scratch, target), options);
    return contentOf(scratch.file(target.substr(target.find(':') + 1)));
}

/// The pack that comes back from a file written to `target`.
template <int Dim>
Pack<3> readBack(const Pack<Dim>& pack, const std::string& target,
                 const PackWriteOptions& options = {}, const PackReadOptions& reading = {}) {
    const TemporaryFolder scratch;
    writePack(pack, inFolder(scratch, target), options);
    return readPack(inFolder(scratch, target), reading);
}

/// Numbers as the bytes of a file.
template <typename T>
std::string bytesOf(std::vector<T> values, bool bigEndian = false) {
    std::string out;
    for (T v : values) {
        char b[sizeof(T)];
        std::memcpy(b, &v, sizeof(T));
        if (bigEndian) std::reverse(b, b + sizeof(T));
        out.append(b, sizeof(T));
    }
    return out;
}

/// The same, with the warnings of the reader.
inline Pack<3> readText(const std::string& name, const std::string& content,
                        std::vector<std::string>& warnings) {
    const TemporaryFolder scratch;
    putContent(scratch.file(name), content);
    PackReadOptions options;
    options.callbacks = keepingWarnings({}, warnings);
    return readPack((name == "p.txt" ? "yade:" : "") + scratch.file(name), options);
}

/// The message of the InputError; empty if there is none.
inline std::string errorOf(const std::string& name, const std::string& content) {
    return messageOf<InputError>([&] { readText(name, content); });
}

}  // namespace vdbpack::test
