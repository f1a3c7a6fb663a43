#include "vdbpack/options/option.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <system_error>

namespace vdbpack {

namespace {

/// "block-side" as the library writes the names of fields: "blockSide".
std::string fieldName(const std::string& option) {
    std::string name;
    for (std::size_t i = 0; i < option.size(); ++i)
        if (option[i] == '-' && i + 1 < option.size())
            name += static_cast<char>(std::toupper(static_cast<unsigned char>(option[++i])));
        else
            name += option[i];
    return name;
}

}  // namespace

std::string optionName(const std::string& name) {
    const bool isArgument = std::isupper(static_cast<unsigned char>(name.front())) != 0;
    return isArgument ? name : std::string(2, '-') + name;
}

Option& OptionList::add(const char* name, const char* shown, OptionKind kind, std::string help,
                        std::function<void(const std::string&)> set,
                        std::function<std::string()> get) {
    Option option;
    option.name = name;
    option.fields = fieldName(name);
    option.shown = shown;
    option.group = group_;
    option.help = std::move(help);
    option.kind = kind;
    option.set = std::move(set);
    option.get = [get = std::move(get)]() -> std::vector<std::string> {
        std::string text = get ? get() : std::string();
        if (text.empty()) return {};
        return {std::move(text)};
    };
    rows_.push_back(std::move(option));
    return rows_.back();
}

Option& OptionList::flag(const char* name, bool& field, std::string help) {
    return add(
        name, "", OptionKind::flag, std::move(help), [&field](const std::string&) { field = true; },
        [&field] { return field ? "yes" : ""; });
}

Option& OptionList::text(const char* name, const char* shown, std::string& field,
                         std::string help) {
    return add(
        name, shown, OptionKind::text, std::move(help),
        [&field, name](const std::string& text) {
            if (text.empty()) throw ParameterError(fmt::format("`{}`: must not be empty", name));
            field = text;
        },
        [&field] { return field; });
}

Option& OptionList::texts(const char* name, const char* shown, std::vector<std::string>& field,
                          std::string help) {
    Option& option = custom(name, shown, std::move(help),
                            [&field](const std::string& text) { field.push_back(text); });
    option.get = [&field] { return field; };
    option.repeats = true;
    return option;
}

Option& OptionList::custom(const char* name, const char* shown, std::string help,
                           std::function<void(const std::string&)> set,
                           std::function<std::string()> get) {
    return add(name, shown, OptionKind::text, std::move(help), std::move(set), std::move(get));
}

Option& OptionList::threshold(const char* name, std::optional<Threshold>& field, std::string help) {
    return custom(
               name, "V|otsu", std::move(help),
               [&field, name](const std::string& text) {
                   field = startsWith(text, "otsu") ? Threshold::parse(text)
                                                    : numberIn(name, text, Range::any);
               },
               [&field] { return field ? field->text() : std::string(); })
        .of(OptionKind::numbers);
}

double OptionList::numberIn(const std::string& name, const std::string& text, Range range) {
    double value = 0;
    if (!parseReal(text, value))
        throw ParameterError(
            fmt::format("`{}`: '{}' is not a number{}", name, text, numberRemedy(text)));
    const bool fits = range == Range::any || (range == Range::positive ? value > 0 : value >= 0);
    if (!(fits && std::isfinite(value)))
        throw ParameterError(fmt::format("`{}`: '{}' must be a {}", name, text,
                                         range == Range::positive ? "positive number"
                                         : range == Range::any    ? "finite number"
                                                                  : "number of 0 or more"));
    return value;
}

std::string OptionList::textOf(const std::optional<double>& value) {
    return value ? fmt::format("{:.10g}", *value) : std::string();
}

std::uint64_t OptionList::wholeNumber(const std::string& name, const std::string& text,
                                      std::uint64_t least, std::uint64_t most,
                                      const std::string& remedy) {
    std::uint64_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, failed] = std::from_chars(text.data(), end, value);
    bool whole = failed == std::errc() && stop == end;
    // 1e6 is one, too, as far as doubles are exact.
    if (double number = 0; !whole && failed != std::errc::result_out_of_range &&
                           parseReal(text, number) && number >= 0 && number <= 0x1p53 &&
                           number == std::floor(number)) {
        value = static_cast<std::uint64_t>(number);
        whole = true;
    }
    // 5.000 is 5000 to some, 5 to others.
    if (const std::size_t point = text.find('.');
        whole && point != std::string::npos && point <= 3 && text.size() > point + 3 &&
        text.find_first_not_of("0123456789.") == std::string::npos) {
        std::string digits = text;
        digits.erase(std::remove(digits.begin(), digits.end(), '.'), digits.end());
        throw ParameterError(
            fmt::format("`{}`: '{}' is a whole number with decimals; write {} or {}", name, text,
                        digits, value));
    }
    if (whole && value >= least && value <= most) return value;
    throw ParameterError(fmt::format("`{}`: '{}' must be a whole number from {} to {}{}{}", name,
                                     text, least, most, remedy.empty() ? "" : "; ", remedy));
}

std::size_t OptionList::indexOf(const std::string& name, const std::string& text,
                                const std::vector<std::string>& words) {
    const auto found = std::find(words.begin(), words.end(), text);
    if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
    throw ParameterError(
        fmt::format("`{}`: '{}' is not one of {}", name, text, fmt::join(words, ", ")));
}

}  // namespace vdbpack
