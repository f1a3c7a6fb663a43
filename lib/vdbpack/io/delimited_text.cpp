#include "vdbpack/io/delimited_text.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/stated_unit.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>

namespace vdbpack {

namespace {

constexpr const char* kOpenQuote = "a quote is not closed; close it";

/// The most frequent of comma, semicolon and tab outside quotes, or else the blank.
char separatorOf(std::string_view line) {
    line = trimmed(line);
    std::array<std::size_t, 3> counts{};
    constexpr std::string_view kSeparators = ",;\t";
    bool inQuotes = false;
    for (const char c : line) {
        inQuotes = inQuotes != (c == '"');
        const auto at = kSeparators.find(c);
        if (!inQuotes && at != std::string_view::npos) ++counts[at];
    }
    const auto most = std::max_element(counts.begin(), counts.end());
    return *most > 0 ? kSeparators[static_cast<std::size_t>(most - counts.begin())] : ' ';
}

/// Excel's line for the separator, which the header shows as well.
bool isSeparatorLine(std::string_view content) {
    return startsWith(content, "sep=") && content.size() <= 5;
}

}  // namespace

DelimitedText::DelimitedText(const std::string& path) : file_(path) {
    file_.skipByteOrderMark();
}

bool DelimitedText::split(std::string_view line, char separator, Cells& cells) {
    cells.clear();
    storage_.clear();
    // It never grows beyond the line, so views of it stay valid.
    storage_.reserve(line.size());
    const bool blanks = separator == ' ';
    if (blanks) line = trimmed(line);
    const auto endOfCell = [&](std::size_t from) {
        if (!blanks) return std::min(line.find(separator, from), line.size());
        while (from < line.size() && line[from] != ' ' && line[from] != '\t') ++from;
        return from;
    };
    std::size_t at = 0;
    for (;;) {
        std::size_t begin = at;
        while (begin < line.size() && (line[begin] == ' ' || (blanks && line[begin] == '\t')))
            ++begin;
        if (begin < line.size() && line[begin] == '"') {
            const std::size_t start = storage_.size();
            for (++begin;; ++begin) {
                if (begin >= line.size()) return false;
                if (line[begin] == '"' && (begin + 1 >= line.size() || line[begin + 1] != '"'))
                    break;
                if (line[begin] == '"') ++begin;
                storage_ += line[begin];
            }
            cells.push_back(std::string_view(storage_).substr(start));
            at = endOfCell(begin);
        } else {
            at = endOfCell(blanks ? begin : at);
            cells.push_back(trimmed(line.substr(begin, at - std::min(begin, at))));
        }
        if (at >= line.size()) return true;
        ++at;
    }
}

bool DelimitedText::namesCoordinates(std::string_view line) {
    Cells cells;
    if (!split(line, separatorOf(line), cells)) return false;
    static const std::vector<std::string> kNames = axisNames(0);
    return std::any_of(cells.begin(), cells.end(), [](std::string_view cell) {
        const std::string name = columnName(cell).quantity;
        return std::find(kNames.begin(), kNames.end(), name) != kNames.end() || name == "coord1" ||
               name == "coor1";
    });
}

void DelimitedText::setHeader(const std::string& line, std::uint64_t number) {
    headerLine_ = number;
    separator_ = separatorOf(line);
    Cells cells;
    if (!split(line, separator_, cells))
        throw InputError(fmt::format("{}: line {}: {}", file_.path(), number, kOpenQuote));
    names_.assign(cells.begin(), cells.end());
}

void DelimitedText::readHeader(const std::string& columns, const std::string& alternative) {
    struct Line {
        std::string text;
        std::uint64_t number = 0;
    };
    std::optional<Line> header;
    Line comment;  // the last that names columns
    std::uint64_t begin = file_.offset();
    std::string_view line;
    for (; !header && file_.nextLine(line); begin = file_.offset()) {
        const std::uint64_t number = file_.lineNumber();
        const auto content = trimmed(line);
        if (content.empty() || isSeparatorLine(content)) continue;
        if (content.front() != '#') {
            if (comment.number > 0 && !namesCoordinates(line)) {
                file_.seek(begin, number - 1);
                break;
            }
            // Tabs at its ends stay: beside them are cells without a text.
            header = {std::string(line), number};
            break;
        }
        line.remove_prefix(line.find('#') + 1);
        if (namesCoordinates(line)) comment = {std::string(line), number};
    }
    if (!header && comment.number > 0) header = comment;
    if (!header)
        throw InputError(fmt::format("{}: is empty; the first line must name the columns {}",
                                     file_.path(), columns));
    setHeader(header->text, header->number);
    double number = 0;
    if (std::all_of(names_.begin(), names_.end(),
                    [&](const std::string& name) { return parseNumber(name, number); }))
        throw InputError(fmt::format(
            "{}: line {}: holds numbers where the columns must be named; put a line {} above it{}",
            file_.path(), headerLine_, columns, alternative));
}

void DelimitedText::takeNames(std::vector<std::string> names) {
    names_ = std::move(names);
    std::string_view line;
    for (std::uint64_t begin = file_.offset(); file_.nextLine(line); begin = file_.offset()) {
        const auto content = trimmed(line);
        if (content.empty() || content.front() == '#' || isSeparatorLine(content)) continue;
        headerLine_ = file_.lineNumber();
        separator_ = separatorOf(line);
        Cells cells;
        if (!split(line, separator_, cells)) file_.failAtLine(kOpenQuote);
        if (cells.size() != names_.size())
            file_.failAtLine(fmt::format("has {} cells, and `columns` names {}; name each of them",
                                         cells.size(), names_.size()));
        const bool isRow = std::any_of(cells.begin(), cells.end(), [](std::string_view cell) {
            double number = 0;
            return parseNumber(cell, number);
        });
        if (isRow) file_.seek(begin, headerLine_ - 1);
        return;
    }
}

bool DelimitedText::nextRow(Cells& cells) {
    std::string_view line;
    while (file_.nextLine(line)) {
        const auto content = trimmed(line);
        if (content.empty()) continue;
        const bool comment = content.front() == '#';
        if (comment && !refuseAmbiguousComments_) continue;
        const bool closed = split(line, names_.empty() ? separatorOf(line) : separator_, cells);
        if (comment && closed && cells.size() == names_.size())
            file_.failAtLine(
                "may be a comment or a row; remove it, or put its first cell in quotes");
        if (comment) continue;
        if (!closed) file_.failAtLine(kOpenQuote);
        if (!names_.empty() && cells.size() != names_.size())
            file_.failAtLine(
                fmt::format("has {} cells where line {} names {} columns; complete the line or cut "
                            "the file there",
                            cells.size(), headerLine_, names_.size()));
        return true;
    }
    return false;
}

std::string canonicalName(std::string_view name) {
    std::string result = lowered(name.substr(0, name.find_first_of("[(")));
    const auto kept = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || (c & 0x80) != 0;
    };
    result.erase(std::remove_if(result.begin(), result.end(), [&](char c) { return !kept(c); }),
                 result.end());
    return result;
}

ColumnName columnName(std::string_view name) {
    const std::string low(trimmed(lowered(name)));
    const std::size_t open = low.find_first_of("[(");
    if (open != std::string::npos && open > 0) {
        const std::size_t close = std::min(low.find_first_of("])", open), low.size());
        const std::string within(trimmed(std::string_view(low).substr(open + 1, close - open - 1)));
        const std::string quantity = canonicalName(low);
        std::int64_t component = 0;
        return parseInteger(within, component) ? ColumnName{quantity + within, {}}
                                               : ColumnName{quantity, within};
    }
    // Units of length that are not read, and are not to be taken for a part of the name.
    constexpr std::string_view kOthers[] = {"nm",     "inch",  "px",    "pixel",
                                            "pixels", "voxel", "voxels"};
    const std::size_t at = low.find_last_of("/_ ");
    if (at != std::string::npos && at > 0) {
        const std::string last = low.substr(at + 1);
        if (low[at] == '/' || unitCalled(last) ||
            std::find(std::begin(kOthers), std::end(kOthers), last) != std::end(kOthers))
            return {canonicalName(low.substr(0, at)), last};
    }
    return {canonicalName(low), {}};
}

std::vector<std::string> axisNames(int axis) {
    const std::string a(1, "xyz"[axis]), number = std::to_string(axis);
    std::vector<std::string> names{a};
    for (const char* word : {"pos", "position", "p", "coord", "coordinate", "center", "centre"}) {
        names.push_back(word + a);
        names.push_back(a + word);
    }
    for (const char* word : {"points", "position", "positions", "pos", "coordinates"})
        names.push_back(word + number);
    return names;
}

}  // namespace vdbpack
