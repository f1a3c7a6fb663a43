#include "vdbpack/formats/text_table.h"

#include <algorithm>

namespace vdbpack {

Pack<3> readTable(InputFile& file, const TextTable& table) {
    const std::uint64_t begin = file.offset();
    const std::uint64_t lineBefore = file.lineNumber();
    const std::size_t columns = table.names.size();
    // Each cell takes a character and a separator.
    const auto room = std::min<std::uint64_t>(
        table.expectedRows, (file.size() - begin) / (2 * std::max<std::size_t>(columns, 1)) + 1);

    // A column holds numbers until a cell is not one. Then the file is read once more: numbers
    // converted back to texts may differ from the texts in the file.
    std::vector<bool> isText(columns, false);
    Cells cells;
    const auto where = [&file] { return "line " + std::to_string(file.lineNumber()); };
    for (;;) {
        PackBuilder builder(file.path(), table.names, table.unit);
        for (std::size_t c = 0; c < columns; ++c)
            if (isText[c]) builder.makeText(c);
        builder.reserve(static_cast<std::size_t>(room));
        bool again = false;
        for (std::uint64_t row = 0; table.nextRow(row, cells); ++row) {
            builder.addRow();
            for (std::size_t c = 0; c < columns; ++c) {
                if (builder.parse(c, cells[c])) continue;
                if (!builder.isFurther(c)) builder.failCell(where(), c, cells[c]);
                isText[c] = again = true;
            }
            if (table.adjustRow) table.adjustRow(builder, cells);
            if (!builder.problem().empty()) builder.failRow(where());
        }
        if (!again) return builder.finish();
        file.seek(begin, lineBefore);
    }
}

}  // namespace vdbpack
