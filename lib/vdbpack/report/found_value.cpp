#include "vdbpack/report/found_value.h"

#include "vdbpack/io/numbers.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace vdbpack {

void addThreshold(FoundValues& found, const DomainRecipe& domain) {
    const auto& threshold = domain.threshold;
    if (threshold && threshold->otsuFrom && threshold->value)
        found.push_back(
            {"threshold", threshold->text(), fmt::format("{:.10g}", *threshold->value)});
}

nlohmann::ordered_json toJson(const FoundValues& found) {
    auto json = nlohmann::ordered_json::array();
    for (const FoundValue& each : found) {
        const std::vector<double> numbers = parseNumberList(each.value).value();
        json.push_back({{"option", each.option}, {"word", each.word}});
        if (!each.part.empty()) json.back()["part"] = each.part;
        if (numbers.size() == 1)
            json.back()["value"] = numbers.front();
        else
            json.back()["value"] = numbers;
    }
    return json;
}

std::string textOf(const FoundValue& found) {
    return fmt::format("{}{}{} {} ({})", found.part, found.part.empty() ? "" : ": ", found.option,
                       found.value, found.word);
}

std::string foundRows(const FoundValues& found) {
    std::string rows;
    for (const FoundValue& each : found) rows += fmt::format("{:<11}{}\n", "found", textOf(each));
    return rows;
}

std::string withValues(std::string toml, const FoundValues& found) {
    for (const FoundValue& each : found) {
        const std::string words = fmt::format("\n{} = '{}'\n", each.option, each.word);
        const auto at = toml.find(words);
        if (at == std::string::npos || !each.part.empty()) continue;
        const char* const quote = each.value.find(',') != std::string::npos ? "'" : "";
        toml.replace(
            at, words.size(),
            fmt::format("\n{} = {}{}{}  # {}\n", each.option, quote, each.value, quote, each.word));
    }
    return toml;
}

}  // namespace vdbpack
