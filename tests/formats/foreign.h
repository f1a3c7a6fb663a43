// Files of other programs, given as text.
#pragma once

#include "support/message_of.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"

#include <string>

namespace vdbpack::test {

/// The pack in a file of this name (by extension; p.txt: YADE) and content.
inline Pack<3> readText(const std::string& name, const std::string& content) {
    const TemporaryFolder scratch;
    putContent(scratch.file(name), content);
    const auto prefix = name == "p.txt" ? std::string("yade:") : std::string();
    return readPack(prefix + (scratch.file(name)));
}

/// The message of the InputError; empty if there is none.
inline std::string errorOf(const std::string& name, const std::string& content) {
    return messageOf<InputError>([&] { readText(name, content); });
}

}  // namespace vdbpack::test
