// Extended XYZ, as ASE and OVITO write it: frames of a count, a line that names the columns and a
// line per sphere.
#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// The value of a key in the second line: in quotes, braces or plain. Empty if there is none.
std::string_view valueOf(std::string_view line, std::string_view key) {
    const auto lower = [](char c) { return static_cast<char>(std::tolower(c)); };
    for (std::size_t at = 0; at < line.size();) {
        while (at < line.size() && (line[at] == ' ' || line[at] == '\t')) ++at;
        const std::size_t begin = at;
        while (at < line.size() && line[at] != ' ' && line[at] != '\t' && line[at] != '=') ++at;
        const auto word = line.substr(begin, at - begin);
        if (at >= line.size() || line[at] != '=') continue;
        ++at;
        std::string_view value;
        const char quote = at < line.size() ? line[at] : ' ';
        if (quote == '"' || quote == '{') {
            const auto end = std::min(line.find(quote == '"' ? '"' : '}', at + 1), line.size());
            value = line.substr(at + 1, end - at - 1);
            at = std::min(end + 1, line.size());
        } else {
            const auto end = std::min(line.find_first_of(" \t", at), line.size());
            value = line.substr(at, end - at);
            at = end;
        }
        if (std::equal(word.begin(), word.end(), key.begin(), key.end(),
                       [&](char a, char b) { return lower(a) == lower(b); }))
            return value;
    }
    return {};
}

class XyzFile {
public:
    XyzFile(const std::string& path, const PackReadOptions& options)
        : file_(path), options_(options) {}

    Pack<3> read() {
        std::string_view line;
        Pack<3> pack;
        bool any = false;
        // Of several frames the last one.
        while (nextNotEmpty(line)) {
            std::int64_t count = 0;
            if (!parseNumber(line, count) || count < 0)
                fail(fmt::format("'{}' is not a number of particles; an .xyz file begins with one",
                                 trimmed(line).substr(0, 40)));
            pack = readFrame(static_cast<std::uint64_t>(count));
            any = true;
        }
        if (!any) throw InputError(file_.path() + ": is empty; an .xyz file is needed");
        return pack;
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(fmt::format("{}: line {}: {}", file_.path(), file_.lineNumber(), what));
    }

    bool nextNotEmpty(std::string_view& line) {
        while (file_.nextLine(line))
            if (!trimmed(line).empty()) return true;
        return false;
    }

    /// Names of the columns by `species:S:1:pos:R:3:...`.
    std::vector<std::string> columnsOf(std::string_view properties) const {
        std::vector<std::string_view> words;
        for (std::size_t at = 0; at <= properties.size();) {
            const auto end = std::min(properties.find(':', at), properties.size());
            words.push_back(properties.substr(at, end - at));
            at = end + 1;
        }
        if (properties.empty() || words.size() % 3 != 0)
            fail(
                "does not describe the columns; write it as extended XYZ, with "
                "Properties=species:S:1:pos:R:3:radius:R:1");
        std::vector<std::string> names;
        // A row takes two bytes for each of its columns.
        const std::uint64_t most = (file_.size() - file_.offset()) / 2 + 100;
        for (std::size_t w = 0; w < words.size(); w += 3) {
            const std::string name(words[w]);
            std::int64_t count = 0;
            if (name.empty() || words[w + 1].size() != 1 ||
                std::string_view("SRIL").find(words[w + 1]) == std::string_view::npos ||
                !parseNumber(words[w + 2], count) || count < 1 || count > 1000)
                fail(fmt::format("'{}:{}:{}' describes no column; write name:S, R, I or L:count",
                                 name.substr(0, 40), words[w + 1].substr(0, 40),
                                 words[w + 2].substr(0, 40)));
            if (names.size() + static_cast<std::uint64_t>(count) > most)
                fail(
                    fmt::format("announces more than {} columns, too many for what follows; "
                                "correct it",
                                most));
            if (name == "pos" && count == 3)
                names.insert(names.end(), {"x", "y", "z"});
            else if (count == 1)
                names.push_back(name);
            else
                for (std::int64_t c = 0; c < count; ++c)
                    names.push_back(fmt::format("{}_{}", name, c));
        }
        return names;
    }

    /// The cell by `pbc`, `Lattice` and `Origin`. A lattice that is no box has none of ours.
    PeriodicCell<3> cellOf(std::string_view description, Unit unit) const {
        Cells wraps, lattice, origin;
        splitAtBlanks(valueOf(description, "pbc"), wraps);
        splitAtBlanks(valueOf(description, "Lattice"), lattice);
        splitAtBlanks(valueOf(description, "Origin"), origin);
        PeriodicCell<3> cell;
        if (wraps.size() != 3 || lattice.size() != 9) return cell;
        for (std::size_t k = 0; k < 9; ++k) {
            const std::size_t d = k / 4;
            double v = 0, lo = 0;
            if (!parseNumber(lattice[k], v) || !std::isfinite(v)) return {};
            if (k % 4 != 0 && v != 0) return {};
            if (k % 4 != 0) continue;
            if (origin.size() == 3 && !parseNumber(origin[d], lo)) return {};
            const auto axis = static_cast<int>(d);
            cell.box.lo[axis] = toMillimeters(lo, unit);
            cell.box.hi[axis] = toMillimeters(lo + v, unit);
            cell.wraps[d] = v > 0 && (wraps[d] == "T" || wraps[d] == "True" || wraps[d] == "1");
        }
        return cell;
    }

    Pack<3> readFrame(std::uint64_t count) {
        std::string_view line;
        if (!file_.nextLine(line))
            throw InputError(file_.path() +
                             ": ends before the line that describes the columns; "
                             "the file is cut short");
        TextTable table;
        table.names = columnsOf(valueOf(line, "Properties"));
        table.unit = options_.unit;
        table.expectedRows = count;
        const auto unit = valueOf(line, kUnitKey);
        if (!unit.empty() && !parseUnitComment(kUnitComment + std::string(unit), table.unit))
            fail(fmt::format("unknown unit '{}'; use m, cm, mm or um", unit.substr(0, 40)));
        table.nextRow = [&](std::uint64_t row, Cells& cells) {
            if (row == count) return false;
            if (!file_.nextLine(line))
                throw InputError(
                    fmt::format("{}: ends after {} of {} particles; the file is cut short",
                                file_.path(), row, count));
            splitAtBlanks(line, cells);
            if (cells.size() != table.names.size())
                fail(
                    fmt::format("has {} words where Properties announces {}; complete the line, "
                                "or correct the number of particles",
                                cells.size(), table.names.size()));
            return true;
        };
        const PeriodicCell<3> cell = cellOf(line, table.unit);
        Pack<3> pack = readTable(file_, table);
        pack.cell = cell;
        auto& columns = pack.columns;
        columns.erase(std::remove_if(columns.begin(), columns.end(),
                                     [](const Column& c) {
                                         return c.name == kXyzSpecies &&
                                                std::all_of(c.texts.begin(), c.texts.end(),
                                                            [](const std::string& t) {
                                                                return t == kXyzNoSpecies;
                                                            }) &&
                                                c.numbers.empty();
                                     }),
                      columns.end());
        return pack;
    }

    InputFile file_;
    PackReadOptions options_;
};

}  // namespace

Pack<3> readXyz(const std::string& path, const PackReadOptions& options) {
    return XyzFile(path, options).read();
}

}  // namespace vdbpack
