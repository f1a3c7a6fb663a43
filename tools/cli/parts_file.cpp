#include "cli/parts_file.h"

#include "cli/recipe_paths.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <filesystem>
#include <fstream>

using namespace vdbpack;

namespace {

/// A value as it would stand on the command line; nothing for a table or a date.
std::string textOf(const toml::node& node) {
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* number = node.as_integer()) return fmt::format("{}", number->get());
    if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
    return {};
}

PartWords partOf(const toml::table& table, const std::string& file) {
    const std::string folder = std::filesystem::path(file).parent_path().string();
    PartWords part;
    std::string domain;
    const auto fail = [&](const toml::node& where, const std::string& what) {
        throw InputError(fmt::format("{}: line {}: {}", file, where.source().begin.line, what));
    };
    const auto inFolder = [&](const toml::node& where, const std::string& option,
                              const std::string& text) {
        try {
            return fromRecipe(option, text, folder);
        } catch (const ParameterError& e) {
            fail(where, e.what());
            throw;
        }
    };
    for (const auto& [key, value] : table) {
        const std::string option(key.str());
        const auto add = [&](const toml::node& node) {
            const std::string text = textOf(node);
            if (text.empty()) fail(node, fmt::format("'{}' needs a text or a number", option));
            part.arguments.push_back("--" + option);
            part.arguments.push_back(inFolder(node, option, text));
        };
        if (option == "name") {
            part.name = textOf(value);
        } else if (option == "domain") {
            domain = inFolder(value, "DOMAIN", textOf(value));
        } else if (const auto* flag = value.as_boolean()) {
            if (flag->get()) part.arguments.push_back("--" + option);
        } else if (const auto* list = value.as_array()) {
            for (const toml::node& node : *list) add(node);
        } else {
            add(value);
        }
    }
    if (domain.empty()) {
        std::string keys;
        for (const auto& [key, value] : table)
            keys += (keys.empty() ? "" : ", ") + std::string(key.str());
        throw InputError(fmt::format(
            "{}: line {}: a part has no `domain`, the name of its file or shape; it has {}", file,
            table.source().begin.line, keys.empty() ? "nothing" : keys));
    }
    part.arguments.insert(part.arguments.begin(), domain);
    return part;
}

}  // namespace

std::vector<PartWords> readPartsFile(const std::string& file) {
    if (!std::ifstream(file)) throw IoError(file + ": cannot be opened for reading");
    std::vector<PartWords> parts;
    try {
        const toml::table all = toml::parse_file(file);
        for (const auto& [key, value] : all)
            if (key.str() != "part")
                throw InputError(fmt::format("{}: line {}: '{}' is not [[part]]", file,
                                             key.source().begin.line, std::string(key.str())));
        if (const auto* list = all["part"].as_array())
            for (const toml::node& node : *list)
                if (const auto* table = node.as_table()) parts.push_back(partOf(*table, file));
    } catch (const toml::parse_error& e) {
        throw InputError(fmt::format("{}: line {}: {}", file, e.source().begin.line,
                                     std::string(e.description())));
    }
    if (parts.empty())
        throw InputError(file + ": has no part; write a table [[part]] with `domain` for each");
    return parts;
}
