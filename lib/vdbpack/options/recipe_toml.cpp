#include "vdbpack/options/recipe_toml.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/recipe_paths.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

namespace vdbpack {

namespace {

/// A value as it would stand on the command line.
std::string nodeText(const toml::node& node) {
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* number = node.as_integer()) return fmt::format("{}", number->get());
    if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
    if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
    return {};
}

bool isPlain(const toml::node& node) {
    return node.is_string() || node.is_number() || node.is_boolean();
}

/// Reads values of a file, whose folder names of files are relative to.
class Values {
public:
    Values(std::string file, FileLookup fileIn) : file_(std::move(file)), fileIn_(fileIn) {
        std::error_code ignored;
        if (std::filesystem::is_regular_file(file_, ignored))
            folder_ = std::filesystem::path(file_).parent_path().string();
    }

    /// The texts of an option as they would stand on the command line; none for an empty list.
    /// Lists of numbers, or of rows of them, are one text with commas.
    std::vector<std::string> of(const std::string& option, const toml::node& value) const {
        std::vector<std::string> texts;
        std::string numbers;
        if (const auto* array = value.as_array(); array && addNumbers(*array, numbers)) {
            if (!numbers.empty()) texts.push_back(numbers);
        } else if (array) {
            for (const auto& each : *array) {
                if (!isPlain(each))
                    fail(each, option + ": may contain only texts, numbers, true and false");
                texts.push_back(textIn(option, each));
            }
        } else if (isPlain(value)) {
            texts.push_back(textIn(option, value));
        } else {
            fail(value, option + ": is a date or a table; give a text, a number, true or false");
        }
        return texts;
    }
    /// @return false for a list that holds anything else
    static bool addNumbers(const toml::array& array, std::string& text) {
        for (const auto& each : array) {
            const auto* row = each.as_array();
            if (row ? !addNumbers(*row, text) : !each.is_number()) return false;
            if (!row) text += (text.empty() ? "" : ",") + nodeText(each);
        }
        return true;
    }
    [[noreturn]] void fail(const toml::node& where, const std::string& what) const {
        throw InputError(fmt::format("{}: line {}: {}", file_, where.source().begin.line, what));
    }

private:
    std::string textIn(const std::string& option, const toml::node& value) const {
        const std::string text = nodeText(value);
        if (text.find('\0') != std::string::npos)
            fail(value,
                 fmt::format("{}: its text contains the character U+0000; remove it", option));
        try {
            return fromRecipe(fileIn_(option), text, folder_);
        } catch (const ParameterError& e) {
            fail(value, e.what());
        }
    }

    std::string file_, folder_;
    FileLookup fileIn_;
};

class Reader {
public:
    Reader(const CLI::App& command, const std::string& file, FileLookup fileIn)
        : command_(command), values_(file, fileIn) {}

    void readTable(const toml::table& table, bool top) {
        for (const auto& [key, value] : table) {
            const std::string name(key.str());
            if (value.is_table()) {
                if (!top) values_.fail(value, fmt::format("[{}] lies within another table", name));
                readCommand(name, value);
            } else {
                readOption(name, value);
            }
        }
    }
    /// The options. @throws InputError if the file holds those of another command alone.
    const std::vector<CLI::ConfigItem>& items() const {
        const std::string& own = command_.get_name();
        if (items_.empty() && other_)
            values_.fail(*other_->second,
                         fmt::format("this is a recipe of [{0}], without options of {1}; run "
                                     "vdb_pack {0} {2} with this file",
                                     other_->first, own, optionName("config")));
        return items_;
    }

private:
    void readCommand(const std::string& name, const toml::node& value) {
        if (name == command_.get_name()) return readTable(*value.as_table(), false);
        const auto others = command_.get_parent()->get_subcommands(
            [&](const CLI::App* other) { return other->get_name() == name; });
        if (others.empty())
            values_.fail(value,
                         fmt::format("[{}] is not a command of vdb_pack; options of this one "
                                     "belong to [{}]",
                                     name, command_.get_name()));
        other_.emplace(name, &value);
    }
    void readOption(const std::string& name, const toml::node& value) {
        CLI::ConfigItem item;
        item.parents = {command_.get_name()};
        item.name = name;
        if (command_.get_option_no_throw(name) == nullptr &&
            command_.get_option_no_throw(optionName(name)) == nullptr)
            failName(name, value);
        item.inputs = values_.of(name, value);
        if (!item.inputs.empty()) items_.push_back(item);
    }
    [[noreturn]] void failName(const std::string& name, const toml::node& value) const {
        std::vector<std::string> names;
        for (const auto* option : command_.get_options())
            for (const auto& known : option->get_lnames()) names.push_back(known);
        const std::string like = mostLike(name, names);
        values_.fail(value, fmt::format("'{}' is not an option of {}{}", name, command_.get_name(),
                                        like.empty() ? "" : "; did you mean '" + like + "'?"));
    }

    const CLI::App& command_;
    Values values_;
    std::vector<CLI::ConfigItem> items_;
    /// A command with options in the file that is not the one that runs.
    std::optional<std::pair<std::string, const toml::node*>> other_;
};

/// Each dot may open a table within the one before, and tables are destroyed within each other: a
/// hundred thousand of them overflow the stack. Recipes nest once.
void requireShallow(const std::string& text, const std::string& file) {
    constexpr std::ptrdiff_t kMostDots = 2000;
    std::ptrdiff_t dots = 0;
    for (const std::string& line : splitAt(text, '\n'))
        if (!startsWith(line, "#")) dots += std::count(line.begin(), line.end(), '.');
    if (dots > kMostDots)
        throw InputError(
            fmt::format("{}: has more than {} dots and is not a recipe; give options of a "
                        "command, each by its name",
                        file, kMostDots));
}

/// What to do about a line that is no TOML: values that are texts without quotes are what people
/// write, `radius = uniform:1,2`.
std::string remedyFor(const std::string& line) {
    if (trimmed(line) == "[part]") return ". Write [[part]], in two brackets, for each part";
    const auto equals = line.find('=');
    if (equals == std::string::npos) return {};
    const std::string name(trimmed(std::string_view(line).substr(0, equals)));
    const std::string_view value = trimmed(std::string_view(line).substr(equals + 1));
    const std::string_view word = value.substr(0, value.find_first_of(" \t#"));
    // Also what begins as a number and goes on: 49+50, 22=vert.nii.gz, 0.5,1.
    const bool beginsAsText =
        !value.empty() && (std::isalpha(static_cast<unsigned char>(value.front())) != 0 ||
                           std::string_view("./~").find(value.front()) != std::string_view::npos ||
                           (std::isdigit(static_cast<unsigned char>(value.front())) != 0 &&
                            word.find_first_of("+=,:/") != std::string_view::npos));
    for (const std::string_view plain : {"true", "false", "inf", "nan"})
        if (word == plain) return {};
    return beginsAsText ? fmt::format(". Write texts in quotes: {} = \"{}\"", name, word) : "";
}

/// What is wrong with a text that is no TOML, with its line and what to do.
std::string refusalOf(const toml::parse_error& e, const std::string& file,
                      const std::string& text) {
    const auto line = e.source().begin.line;
    auto lines = splitAt(text, '\n');
    lines.resize(std::max<std::size_t>(lines.size(), line));
    return fmt::format("{}: line {}: {}{}", file, line, e.description(),
                       line > 0 ? remedyFor(lines[line - 1]) : "");
}

/// As a value of TOML: a number without quotes where it is read back as the same text.
std::string tomlValue(const std::string& text) {
    try {
        const auto parsed = toml::parse("x = " + text);
        if (parsed.size() == 1 && parsed["x"].is_number() && nodeText(*parsed.get("x")) == text)
            return text;
    } catch (const toml::parse_error&) {
        // A text.
    }
    std::ostringstream out;
    out << toml::value<std::string>(text);
    return out.str();
}

std::string tomlValue(const std::vector<std::string>& texts) {
    if (texts.size() == 1) return tomlValue(texts.front());
    std::string list;
    for (const auto& text : texts) list += (list.empty() ? "" : ", ") + tomlValue(text);
    return '[' + list + ']';
}

}  // namespace

std::vector<CLI::ConfigItem> RecipeFormat::from_config(std::istream& input) const {
    const auto running = app_.get_subcommands();
    if (running.empty()) return {};
    const std::string file = app_.get_config_ptr()->as<std::string>();
    std::error_code ignored;
    if (std::filesystem::is_character_file(file, ignored) ||
        std::filesystem::is_block_file(file, ignored))
        throw CLI::ConfigError(file + ": is a device; give a file or a pipe");
    const std::string text{std::istreambuf_iterator<char>(input), {}};
    try {
        requireShallow(text, file);
        Reader reader(*running.front(), file, fileIn_);
        const toml::table all = toml::parse(text);
        reader.readTable(all, true);
        return reader.items();
    } catch (const InputError& e) {
        throw CLI::ConfigError(e.what());
    } catch (const toml::parse_error& e) {
        throw CLI::ConfigError(refusalOf(e, file, text));
    }
}

std::string recipeText(const CLI::App& app, const std::vector<Option>& options,
                       const std::string& folder) {
    std::string text = '[' + app.get_name() + "]\n";
    for (const Option& option : options) {
        const CLI::Option* const parsed = app.get_option_no_throw(optionName(option.name));
        if (!option.inRecipes || parsed == nullptr) continue;
        if (option.name == "seed") {
            text += "seed = \"{seed}\"\n";
        } else if (option.kind == OptionKind::flag) {
            text += parsed->count() > 0 ? option.name + " = true\n" : "";
        } else if (parsed->count() > 0) {
            auto values = parsed->results();
            for (auto& value : values) value = forRecipe(option.file, value, folder);
            text += option.name + " = " + tomlValue(values) + '\n';
        } else if (option.kind == OptionKind::choice) {
            text += option.name + " = " + tomlValue(option.get()) + '\n';
        }
    }
    return text;
}

namespace {

PartWords partOf(const toml::table& table, const std::string& file, FileLookup fileIn) {
    const Values values(file, fileIn);
    PartWords part;
    std::string domain;
    for (const auto& [key, value] : table) {
        const std::string name(key.str());
        if (const auto* flag = value.as_boolean()) {
            if (flag->get()) part.arguments.push_back(optionName(name));
            continue;
        }
        const auto texts = values.of(name, value);
        if (name == "name" || name == "domain") {
            (name == "name" ? part.name : domain) = texts.empty() ? "" : texts.front();
            continue;
        }
        for (const std::string& text : texts) {
            part.arguments.push_back(optionName(name));
            part.arguments.push_back(text);
        }
    }
    if (domain.empty()) {
        std::string keys;
        for (const auto& [key, value] : table)
            keys += (keys.empty() ? "" : ", ") + std::string(key.str());
        values.fail(table, "a part has no `domain`, the name of its file or shape; it has " +
                               (keys.empty() ? "nothing" : keys));
    }
    part.arguments.insert(part.arguments.begin(), domain);
    return part;
}

}  // namespace

std::vector<PartWords> readPartsFile(const std::string& file, FileLookup fileIn) {
    requireThere(file);
    std::vector<PartWords> parts;
    std::ifstream input(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(input), {}};
    try {
        requireShallow(text, file);
        const toml::table all = toml::parse(text);
        for (const auto& [key, value] : all)
            if (key.str() != "part")
                throw InputError(fmt::format("{}: line {}: '{}' is not [[part]]", file,
                                             key.source().begin.line, std::string(key.str())));
        if (const auto* list = all["part"].as_array())
            for (const toml::node& node : *list)
                if (const auto* table = node.as_table())
                    parts.push_back(partOf(*table, file, fileIn));
    } catch (const toml::parse_error& e) {
        throw InputError(refusalOf(e, file, text));
    }
    if (parts.empty())
        throw InputError(file + ": has no part; write a table [[part]] with `domain` for each");
    return parts;
}

}  // namespace vdbpack
