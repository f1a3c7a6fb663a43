#include "cli/recipe.h"

#include "cli/recipe_paths.h"
#include "cli/suggest.h"

#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <string_view>
#include <system_error>

using vdbpack::trimmed;

namespace {

/// Of no consequence to what comes out.
constexpr const char* kPassing[] = {"help",    "config",  "json",  "quiet",
                                    "dry-run", "threads", "table", "memory-limit"};

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

class Reader {
public:
    Reader(const CLI::App& command, std::string file) : command_(command), file_(std::move(file)) {
        std::error_code ignored;
        if (std::filesystem::is_regular_file(file_, ignored))
            folder_ = std::filesystem::path(file_).parent_path().string();
    }

    void readTable(const toml::table& table, bool top) {
        for (const auto& [key, value] : table) {
            const std::string name(key.str());
            if (value.is_table()) {
                if (!top) fail(value, fmt::format("[{}] lies within another table", name));
                readCommand(name, value);
            } else {
                readOption(name, value);
            }
        }
    }
    const std::vector<CLI::ConfigItem>& items() const { return items_; }

private:
    void readCommand(const std::string& name, const toml::node& value) {
        if (name == command_.get_name()) return readTable(*value.as_table(), false);
        std::vector<std::string> commands;
        for (const auto* other : command_.get_parent()->get_subcommands({}))
            commands.push_back(other->get_name());
        if (std::find(commands.begin(), commands.end(), name) == commands.end())
            fail(value, fmt::format(
                            "[{}] is not a command of vdb_pack; options of this one belong to [{}]",
                            name, command_.get_name()));
    }
    void readOption(const std::string& name, const toml::node& value) {
        CLI::ConfigItem item;
        item.parents = {command_.get_name()};
        item.name = name;
        if (command_.get_option_no_throw(name) == nullptr &&
            command_.get_option_no_throw("--" + name) == nullptr)
            failName(name, value);
        if (const auto* array = value.as_array()) {
            for (const auto& each : *array) {
                if (!isPlain(each))
                    fail(each, name + ": may contain only texts, numbers, true and false");
                item.inputs.push_back(inputOf(name, each));
            }
            if (item.inputs.empty()) return;
        } else if (isPlain(value)) {
            item.inputs = {inputOf(name, value)};
        } else {
            fail(value, name + ": is a date or a time; give a text, a number, true or false");
        }
        items_.push_back(item);
    }
    std::string inputOf(const std::string& name, const toml::node& value) const {
        std::string text = nodeText(value);
        if (text.find('\0') != std::string::npos)
            fail(value, fmt::format("{}: its text contains the character U+0000; remove it", name));
        return fromRecipe(name, text, folder_);
    }
    [[noreturn]] void failName(const std::string& name, const toml::node& value) const {
        std::vector<std::string> names;
        for (const auto* option : command_.get_options())
            for (const auto& known : option->get_lnames()) names.push_back(known);
        const std::string like = mostLike(name, names);
        fail(value, fmt::format("'{}' is not an option of {}{}", name, command_.get_name(),
                                like.empty() ? "" : "; did you mean '" + like + "'?"));
    }
    [[noreturn]] void fail(const toml::node& where, const std::string& what) const {
        throw CLI::ConfigError(
            fmt::format("{}: line {}: {}", file_, where.source().begin.line, what));
    }

    const CLI::App& command_;
    std::string file_, folder_;
    std::vector<CLI::ConfigItem> items_;
};

/// Dots in lines that are comments.
std::ptrdiff_t commentDots(const std::string& text) {
    std::ptrdiff_t dots = 0;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (!line.empty() && line.front() == '#') dots += std::count(line.begin(), line.end(), '.');
    return dots;
}

/// Each dot may open a table within the one before, and tables are destroyed within each other: a
/// hundred thousand of them overflow the stack. Recipes nest once.
void requireShallow(const std::string& text, const std::string& file) {
    constexpr std::ptrdiff_t kMostDots = 2000;
    if (std::count(text.begin(), text.end(), '.') - commentDots(text) > kMostDots)
        throw CLI::ConfigError(
            fmt::format("{}: has more than {} dots and is not a recipe; give options of a "
                        "command, each by its name",
                        file, kMostDots));
}

/// A line of a text, counted from 1.
std::string lineOf(const std::string& text, std::size_t number) {
    std::istringstream lines(text);
    std::string line;
    for (std::size_t i = 0; i < number && std::getline(lines, line); ++i) continue;
    return line;
}

/// What to do about a line that is no TOML: values that are texts without quotes are what people
/// write, `radius = uniform:1,2`.
std::string remedyFor(const std::string& line) {
    const auto equals = line.find('=');
    if (equals == std::string::npos) return {};
    const std::string name(trimmed(std::string_view(line).substr(0, equals)));
    const std::string_view value = trimmed(std::string_view(line).substr(equals + 1));
    const bool beginsAsText =
        !value.empty() && (std::isalpha(static_cast<unsigned char>(value.front())) != 0 ||
                           std::string_view("./~").find(value.front()) != std::string_view::npos);
    const std::string_view word = value.substr(0, value.find_first_of(" \t#"));
    for (const std::string_view plain : {"true", "false", "inf", "nan"})
        if (word == plain) return {};
    return beginsAsText ? fmt::format(". Write texts in quotes: {} = \"{}\"", name, word) : "";
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
        Reader reader(*running.front(), file);
        reader.readTable(toml::parse(text), true);
        return reader.items();
    } catch (const toml::parse_error& e) {
        const auto line = e.source().begin.line;
        throw CLI::ConfigError(fmt::format("{}: line {}: {}{}", file, line, e.description(),
                                           remedyFor(lineOf(text, line))));
    }
}

std::string recipeText(const CLI::App& command, const std::string& folder) {
    std::string text = '[' + command.get_name() + "]\n";
    for (const auto* option : command.get_options()) {
        const auto& longs = option->get_lnames();
        const std::string name = longs.empty() ? option->get_name(true) : longs.front();
        if (std::find(std::begin(kPassing), std::end(kPassing), name) != std::end(kPassing))
            continue;
        if (name == "seed") {
            text += "seed = \"{seed}\"\n";
        } else if (option->get_expected_max() == 0) {
            text += option->count() > 0 ? name + " = true\n" : "";
        } else if (option->count() > 0) {
            auto values = option->results();
            for (auto& value : values) value = forRecipe(name, value, folder);
            text += name + " = " + tomlValue(values) + '\n';
        } else if (!option->get_default_str().empty()) {
            text += name + " = " + tomlValue(option->get_default_str()) + '\n';
        }
    }
    return text;
}
