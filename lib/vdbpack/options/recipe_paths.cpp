#include "vdbpack/options/recipe_paths.h"

#include "vdbpack/domain/domain_text.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/text.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string_view>
#include <system_error>

namespace vdbpack {

namespace {

namespace fs = std::filesystem;

using Rename = std::function<std::string(const std::string&)>;

bool isOneOf(const std::string& word, std::initializer_list<std::string_view> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

bool isShape(const std::string& domain) {
    const std::string kind = domain.substr(0, domain.find(':'));
    return kind.size() < domain.size() &&
           (isOneOf(kind, {"box", "ball", "cylinder", "rect", "disc", "periodic"}) ||
            namesUnknownShape(domain));
}

/// The file behind one of some beginnings, renamed; other values stay.
std::string renamedBehind(std::initializer_list<std::string_view> beginnings,
                          const std::string& value, const Rename& rename) {
    for (const std::string_view beginning : beginnings)
        if (startsWith(value, beginning))
            return std::string(beginning) + rename(value.substr(beginning.size()));
    return value;
}

/// "inner=FILE" or "outer=FILE,inner=FILE".
std::string renamedCavities(const std::string& value, const Rename& rename) {
    const std::string inner = ",inner=";
    const auto comma = value.find(inner);
    if (comma == std::string::npos) return renamedBehind({"inner=", "outer="}, value, rename);
    return renamedBehind({"outer="}, value.substr(0, comma), rename) + inner +
           rename(value.substr(comma + inner.size()));
}

std::string renamed(FileIn in, const std::string& value, const Rename& rename) {
    if (value.empty()) return value;
    switch (in) {
        case FileIn::none:
            return value;
        case FileIn::whole:
            return rename(value);
        case FileIn::domain:
            return isShape(value) ? value : rename(value);
        case FileIn::sizes:
            return renamedBehind({"table:", "psd:"}, value, rename);
        case FileIn::sample: {
            const auto mark = value.find('=');
            if (mark == std::string::npos || mark + 1 == value.size()) return value;
            return value.substr(0, mark + 1) + rename(value.substr(mark + 1));
        }
        case FileIn::voids:
            return renamedBehind({"list:"}, value, rename);
        case FileIn::cavities:
            return renamedCavities(value, rename);
        case FileIn::pack:
        case FileIn::output:
            break;
    }
    const std::string file = packPath(in == FileIn::output ? OutputTarget(value).file : value);
    return value.substr(0, value.size() - file.size()) + rename(file);
}

}  // namespace

std::string fromRecipe(FileIn in, const std::string& value, const std::string& folder) {
    if (folder.empty()) return value;
    // Names stay relative, so that the recipe of this run can move with its files, too.
    std::error_code lost;
    fs::path base = folder;
    if (base.is_absolute()) base = fs::proximate(base, lost);
    if (lost) base = folder;
    return renamed(in, value, [&base](const std::string& file) {
        if (fs::path(file).is_absolute()) return file;
        const fs::path whole = base / file, plain = whole.lexically_normal();
        // Behind symbolic links, ".." may lead elsewhere.
        std::error_code failed;
        const bool same = !fs::exists(whole, failed) || fs::equivalent(whole, plain, failed);
        return (same ? plain : whole).string();
    });
}

std::string forRecipe(FileIn in, const std::string& value, const std::string& folder) {
    if (folder.empty()) return value;
    const auto real = [](const fs::path& path) {
        std::error_code failed;
        const fs::path found = fs::weakly_canonical(fs::absolute(path, failed), failed);
        return failed ? fs::absolute(path) : found;
    };
    return renamed(in, value, [&](const std::string& file) {
        const fs::path given(file);
        if (given.is_absolute()) return file;
        const fs::path at = real(folder),
                       parent =
                           real(given.parent_path().empty() ? fs::path(".") : given.parent_path());
        const auto first = [](const fs::path& path) {
            const auto begin = path.begin();
            return begin == path.end() || std::next(begin) == path.end() ? fs::path()
                                                                         : *std::next(begin);
        };
        const fs::path target = parent / given.filename();
        return (first(at) == first(parent) ? target.lexically_relative(at) : target).string();
    });
}

}  // namespace vdbpack
