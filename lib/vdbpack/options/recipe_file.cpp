#include "vdbpack/options/recipe_file.h"

#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/recipes.h"
#include "vdbpack/report/found_value.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <toml++/toml.h>

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <utility>

namespace vdbpack {

namespace {

constexpr const char* kMark = "# Written by vdb_pack";
constexpr const char* kHash = ", hash ";

/// Whether there is a file that somebody else wrote.
bool isForeign(const std::string& file) {
    std::ifstream in(file);
    std::string line;
    return in && std::getline(in, line) && line.compare(0, std::string(kMark).size(), kMark) != 0;
}

/// A name as one word of a shell, on one line: a line break would end the comment.
std::string shellWord(const std::string& name) {
    const auto isControl = [](char c) { return (c >= 0 && c < 0x20) || c == 0x7f; };
    const bool quotes = name.find_first_of("'\"\\$`!") != std::string::npos;
    if (!quotes && std::none_of(name.begin(), name.end(), isControl))
        return name.find_first_of(" #&;|<>()[]{}*?~") == std::string::npos ? name
                                                                           : '"' + name + '"';
    std::string word = "$'";
    for (const char c : name) {
        if (isControl(c))
            word += fmt::format("\\{:03o}", static_cast<int>(c));
        else
            word += (c == '\'' || c == '\\' ? "\\" : "") + std::string(1, c);
    }
    return word + '\'';
}

/// Whether the text is UTF-8, as TOML must be: JSON must as well.
bool isUtf8(const std::string& text) {
    try {
        (void)nlohmann::json(text).dump();
        return true;
    } catch (const nlohmann::json::type_error&) {
        return false;
    }
}

/// Whether a recipe is there whose run wrote none of these outputs.
bool isOfOthers(const std::string& file, const std::vector<OutputTarget>& outputs,
                const std::string& task) {
    const auto nameOf = [](const std::string& output) {
        return std::filesystem::path(filePart(output)).filename();
    };
    const auto isOurs = [&](const toml::node& node) {
        const std::string stated = node.value_or(std::string());
        return std::any_of(outputs.begin(), outputs.end(), [&](const OutputTarget& output) {
            return nameOf(output.text) == nameOf(stated) ||
                   nameOf(output.text) == nameOf(interruptedName(stated));
        });
    };
    try {
        const toml::table all = toml::parse_file(file);
        const auto stated = all[task]["output"];
        if (const toml::array* const list = stated.as_array())
            return std::none_of(list->begin(), list->end(), isOurs);
        return stated.node() != nullptr && !isOurs(*stated.node());
    } catch (const toml::parse_error&) {
        return false;  // none is there, or none that can be read
    }
}

}  // namespace

std::string recipeFileText(const std::string& toml, const std::string& file, const Report& report) {
    std::string text = fmt::format(
        "{} {}: this repeats the run; names of files are relative to this one\n"
        "#   vdb_pack {} --config {}\n",
        kMark, report.version, report.task, shellWord(file));
    if (report.interrupted)
        text += fmt::format(
            "# The run that left it was interrupted at {} {}: this gives all of them.\n",
            grouped(report.count), report.dim == 2 ? "circles" : "spheres");
    else if (report.count > 0 || report.task == "pack")
        text += fmt::format("# and gave {} {}{}{:016x}\n", grouped(report.count),
                            report.dim == 2 ? "circles" : "spheres", kHash, report.hash);
    if (report.repeatedHash)
        text += fmt::format("# The recipe that was repeated states another one: {:016x}\n",
                            *report.repeatedHash);
    for (const auto& sentence : report.chosen) text += "# chosen: " + sentence + '\n';
    return text + withSeed(withValues(toml, report.found), report.seed);
}

std::optional<std::uint64_t> statedHash(const std::string& file) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line) && line.compare(0, 1, "#") == 0;)
        if (const auto at = line.rfind(kHash); at != std::string::npos)
            return std::strtoull(line.c_str() + at + std::string(kHash).size(), nullptr, 16);
    return std::nullopt;
}

bool holdsPartsText(const std::string& recipe) {
    std::ifstream in(recipe);
    for (std::string line; std::getline(in, line);)
        if (startsWith(line, "# ") && endsWith(line, " was:")) return true;
    return false;
}

void leaveRecipe(const std::string& toml, const std::vector<OutputTarget>& outputs, Report& report,
                 const Callbacks& callbacks) {
    std::string file = recipeFileFor(outputs);
    if (toml.empty() || file.empty()) return;
    if (isOfOthers(file, outputs, report.task))
        file = filePart(outputs.front().text) + ".recipe.toml";
    std::string text = recipeFileText(toml, file, report);
    if (!isUtf8(text)) {
        callbacks.warn(
            file +
            ": no recipe is written, since it would contain a name that is not UTF-8; rename the "
            "file or folder");
        return;
    }
    report.recipe = std::move(text);
    if (file.size() - (file.find_last_of('/') + 1) > NAME_MAX) {
        callbacks.warn(file +
                       ": no recipe is written, since its name would be too long; give a shorter "
                       "name to the first output");
        return;
    }
    if (isForeign(file)) {
        callbacks.warn(file +
                       ": was not written by vdb_pack and is kept; to get a recipe that "
                       "repeats this run, move this file");
        return;
    }
    OutputFile out(file);
    out.write(report.recipe);
    out.commit();
    report.files.push_back(file);
}

}  // namespace vdbpack
