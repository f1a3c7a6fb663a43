#include "vdbpack/formats/text_table.h"

#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace vdbpack {

Pack<3> readTable(InputFile& file, const TextTable& table) {
    const std::uint64_t begin = file.offset();
    const std::uint64_t lineBefore = file.lineNumber();
    const std::size_t columns = table.names.size();
    // Each cell takes a character and a separator.
    const auto room = std::min<std::uint64_t>(
        table.rows.value_or(0),
        (file.size() - begin) / (2 * std::max<std::size_t>(columns, 1)) + 1);
    // A column holds numbers until a cell is not one. Then the file is read once more: numbers
    // converted back to texts may differ from the texts in the file.
    std::vector<bool> isText(columns, false);
    Cells cells;
    const auto where = [&file] { return "line " + std::to_string(file.lineNumber()); };
    for (;;) {
        PackBuilder builder(file.path(), table.names, table.options);
        for (std::size_t c = 0; c < columns; ++c)
            if (isText[c]) builder.makeText(c);
        builder.reserve(static_cast<std::size_t>(room));
        bool again = false;
        for (std::uint64_t row = 0; row != table.rows; ++row) {
            if (!table.nextRow(cells)) {
                if (!table.rows) break;
                file.fail(
                    fmt::format("ends after {} of {} spheres; the file is cut short, or the number "
                                "in its header is wrong",
                                row, *table.rows));
            }
            builder.addRow();
            for (std::size_t c = 0; c < columns; ++c) {
                if (builder.parse(c, cells[c])) continue;
                if (!builder.isFurther(c)) builder.failCell(where(), c, cells[c]);
                isText[c] = again = true;
            }
            if (table.adjustRow) table.adjustRow(builder, cells);
            builder.checkRow(where);
        }
        if (!again) return builder.finish();
        file.seek(begin, lineBefore);
    }
}

void requireWords(const InputFile& file, const std::vector<std::string>& names, const Cells& words,
                  const char* remedy) {
    if (words.size() != names.size())
        file.failAtLine(fmt::format("has {} words where {} are expected ({:.200}); {}",
                                    words.size(), names.size(),
                                    fmt::format("{}", fmt::join(names, " ")), remedy));
}

bool nextWords(InputFile& file, const std::vector<std::string>& names, Cells& words) {
    std::string_view line;
    do {
        if (!file.nextLine(line)) return false;
        line = trimmed(line);
    } while (line.empty() || line.front() == '#');
    splitAtBlanks(line, words);
    requireWords(file, names, words);
    return true;
}

}  // namespace vdbpack
