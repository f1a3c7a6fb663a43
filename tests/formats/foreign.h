// Files of other programs, given as text.
#pragma once

#include "formats/scratch.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"

#include <string>

namespace vdbpack {

/// The pack in a file of this name (by extension; p.txt: YADE) and content.
inline Pack<3> readText(const std::string& name, const std::string& content) {
    const Scratch scratch;
    putContent(scratch / name, content);
    const auto prefix = name == "p.txt" ? std::string("yade:") : std::string();
    return readPack(prefix + (scratch / name));
}

/// The message of the InputError.
inline std::string errorOf(const std::string& name, const std::string& content) {
    try {
        readText(name, content);
    } catch (const InputError& e) {
        return e.what();
    }
    return "no error";
}

}  // namespace vdbpack
