// A row of the table of options, bound to the field of a recipe that it sets.
#pragma once

#include "vdbpack/domain/domain_recipe.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

/// Which part of the text of an option names a file: recipes give names relative to their folder.
enum class FileIn {
    none,
    whole,     ///< FILE
    domain,    ///< FILE, or a shape such as box:1,2,3
    sizes,     ///< table:FILE, psd:FILE
    sample,    ///< NAME=FILE
    voids,     ///< list:FILE
    cavities,  ///< [outer=FILE,]inner=FILE
    pack,      ///< FILE, or FORMAT:FILE
    output     ///< the same with the formats that are written
};

/// What the text of an option is; decides its type in Python and its unit on a page.
enum class OptionKind { flag, text, number, numbers, length, count, choice };

/// Numbers that an option takes.
enum class Range { any, notNegative, positive };

/// One option of the command line, of recipes (TOML), of Python and of the page of a report.
struct Option {
    std::string name;         ///< long, without dashes; an argument in capitals: "DOMAIN"
    std::string fields;       ///< of recipes, as messages of the library name them, blanks between
    std::string shown;        ///< value and default in the help: "MM [automatic]"
    std::string group, help;  ///< a hidden option has no group
    OptionKind kind = OptionKind::text;
    FileIn file = FileIn::none;
    std::vector<std::string> words;  ///< that it takes, or may begin with
    std::string letter;              ///< a short name, without its dash
    std::string excludes, needs;     ///< names of other options
    bool repeats = false;
    bool required = false;
    bool inRecipes = true;  ///< else it has no influence on the result
    bool onPage = true;     ///< else a page has the same elsewhere
    /// Sets the field; of an option that repeats, adds to it. @throws ParameterError
    std::function<void(const std::string&)> set;
    std::function<std::vector<std::string>()> get;  ///< the field as texts; none: not given

    Option& as(std::string names) { return assign(fields, std::move(names)); }
    Option& naming(FileIn in) { return assign(file, in); }
    Option& of(OptionKind what) { return assign(kind, what); }
    Option& taking(std::vector<std::string> some) { return assign(words, std::move(some)); }
    Option& hiddenIf(bool hidden) { return hidden ? assign(group, std::string()) : *this; }
    Option& passing() { return assign(inRecipes, false); }
    Option& offPage() { return assign(onPage, false); }

private:
    template <class Value>
    Option& assign(Value& field, Value value) {
        field = std::move(value);
        return *this;
    }
};

/// Names of values, in the order in which they are listed; of several names of a value, the first
/// is written.
template <class Value>
using Names = std::vector<std::pair<std::string, Value>>;

/// The rows of one command. The recipe must outlive them.
class OptionList {
public:
    /// The group of the options that follow.
    void group(std::string name) { group_ = std::move(name); }

    Option& flag(const char* name, bool& field, std::string help);
    /// A text that is not empty.
    Option& text(const char* name, const char* shown, std::string& field, std::string help);
    /// One or several numbers, or a word in their place.
    Option& numbers(const char* name, const char* shown, std::string& field, std::string help) {
        return text(name, shown, field, std::move(help)).of(OptionKind::numbers);
    }
    /// Texts, one each time that the option is given.
    Option& texts(const char* name, const char* shown, std::vector<std::string>& field,
                  std::string help);
    /// @param field  a double, of which 0 is not shown on pages, or std::optional<double>.
    template <class Field>
    Option& number(const char* name, const char* shown, Field& field, Range range,
                   std::string help) {
        return add(
            name, shown, OptionKind::number, std::move(help),
            [&field, name, range](const std::string& text) { field = numberIn(name, text, range); },
            [&field] { return textOf(field); });
    }
    /// The same in mm.
    template <class Field>
    Option& length(const char* name, const char* shown, Field& field, Range range,
                   std::string help) {
        return number(name, shown, field, range, std::move(help)).of(OptionKind::length);
    }
    /// A whole number, also as 1e6. @param remedy  for the message about others; may be empty.
    /// @param field  of an integer type, or a double.
    template <class Whole>
    Option& count(const char* name, const char* shown, Whole& field, std::uint64_t least,
                  std::uint64_t most, std::string help, std::string remedy = {}) {
        return add(
            name, shown, OptionKind::count, std::move(help),
            [&field, least, most, name, remedy = std::move(remedy)](const std::string& text) {
                field = static_cast<Whole>(wholeNumber(name, text, least, most, remedy));
            },
            [&field, initial = field] {
                return field == initial ? std::string()
                                        : std::to_string(static_cast<std::uint64_t>(field));
            });
    }
    /// A threshold of grey values.
    Option& threshold(const char* name, std::optional<Threshold>& field, std::string help);
    /// One of some names.
    template <class Value>
    Option& choice(const char* name, const char* shown, Value& field, const Names<Value>& names,
                   std::string help) {
        std::vector<std::string> words;
        for (const auto& each : names) words.push_back(each.first);
        return add(
                   name, shown, OptionKind::choice, std::move(help),
                   [&field, name, names, words](const std::string& text) {
                       field = names[indexOf(name, text, words)].second;
                   },
                   [&field, names] {
                       for (const auto& [word, value] : names)
                           if (value == field) return word;
                       return std::string();
                   })
            .taking(words);
    }
    /// A text of any other kind. @param get  the value on pages; empty: none.
    Option& custom(const char* name, const char* shown, std::string help,
                   std::function<void(const std::string&)> set,
                   std::function<std::string()> get = {});

    std::vector<Option> take() { return std::move(rows_); }

private:
    Option& add(const char* name, const char* shown, OptionKind kind, std::string help,
                std::function<void(const std::string&)> set, std::function<std::string()> get);
    static double numberIn(const std::string& name, const std::string& text, Range range);
    static std::string textOf(const std::optional<double>& value);
    static std::string textOf(double value) {
        return value == 0 ? std::string() : textOf(std::optional<double>(value));
    }
    static std::uint64_t wholeNumber(const std::string& name, const std::string& text,
                                     std::uint64_t least, std::uint64_t most,
                                     const std::string& remedy);
    static std::size_t indexOf(const std::string& name, const std::string& text,
                               const std::vector<std::string>& words);

    std::string group_;
    std::vector<Option> rows_;
};

/// How texts for people show the name of an option, such as "target-count".
using OptionStyle = std::string (*)(const std::string& name);
/// The style of the command line: with two dashes, and arguments as they are.
std::string optionName(const std::string& name);

}  // namespace vdbpack
