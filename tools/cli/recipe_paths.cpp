#include "cli/recipe_paths.h"

#include "vdbpack/domain/domain_text.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/outputs.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string_view>
#include <system_error>

using namespace vdbpack;
namespace fs = std::filesystem;

namespace {

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

std::string renamed(const std::string& option, const std::string& value, const Rename& rename) {
    if (value.empty()) return value;
    if (isOneOf(option, {"DOMAIN", "domain", "like-domain"}))
        return isShape(value) ? value : rename(value);
    if (isOneOf(option, {"report", "preview", "table", "void-matrix", "void-field", "bvtv-field",
                         "shell-field", "size-field", "parts", "like"}))
        return rename(value);
    if (isOneOf(option, {"radius", "shell-radius", "void-radius", "void-aspect"}))
        return renamedBehind({"table:", "psd:"}, value, rename);
    if (option == "sample") {
        const auto mark = value.find('=');
        if (mark == std::string::npos || mark + 1 == value.size()) return value;
        return value.substr(0, mark + 1) + rename(value.substr(mark + 1));
    }
    if (option == "voids") return renamedBehind({"list:"}, value, rename);
    if (isOneOf(option, {"cavities", "shells"})) return renamedCavities(value, rename);
    if (isOneOf(option, {"output", "existing", "PACK", "FILE"})) {
        const std::string file = option == "output" ? filePart(value) : packPath(value);
        const std::string behind = option == "output" ? packPath(file) : file;
        return value.substr(0, value.size() - behind.size()) + rename(behind);
    }
    return value;
}

}  // namespace

std::string fromRecipe(const std::string& option, const std::string& value,
                       const std::string& folder) {
    if (folder.empty()) return value;
    // Names stay relative, so that the recipe of this run can move with its files, too.
    std::error_code lost;
    fs::path base = folder;
    if (base.is_absolute()) base = fs::proximate(base, lost);
    if (lost) base = folder;
    return renamed(option, value, [&base](const std::string& file) {
        if (fs::path(file).is_absolute()) return file;
        const fs::path whole = base / file, plain = whole.lexically_normal();
        // Behind symbolic links, ".." may lead elsewhere.
        std::error_code failed;
        const bool same = !fs::exists(whole, failed) || fs::equivalent(whole, plain, failed);
        return (same ? plain : whole).string();
    });
}

std::string forRecipe(const std::string& option, const std::string& value,
                      const std::string& folder) {
    if (folder.empty()) return value;
    const auto real = [](const fs::path& path) {
        std::error_code failed;
        const fs::path found = fs::weakly_canonical(fs::absolute(path, failed), failed);
        return failed ? fs::absolute(path) : found;
    };
    return renamed(option, value, [&](const std::string& file) {
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
