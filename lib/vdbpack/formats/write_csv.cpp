// Tables: one row per sphere, columns named in the first line.
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text_rows.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/row_writer.h"

#include <string>
#include <string_view>

namespace vdbpack {

void appendCell(std::string& text, std::string_view cell) {
    if (cell.find_first_of(",;\"\t\r\n") == std::string::npos) {
        text += cell;
        return;
    }
    text += '"';
    for (const char c : cell) {
        if (c == '"') text += '"';
        // Line ends inside a cell are legal, but few readers accept them.
        text += c == '\n' || c == '\r' ? ' ' : c;
    }
    text += '"';
}

PackTextRows csvRows(const PackView& pack) {
    PackTextRows rows;
    std::string& header = rows.header;
    header = "id,x,y,z,radius";
    const auto name = [&header](std::string_view column, const auto&) {
        appendCell(header += ',', column);
    };
    pack.forEachAttribute(name, name);
    // A table without rows names its further columns all the same.
    if (pack.size() == 0)
        for (const Column& column : pack.columns()) name(column.name, column);
    header += '\n';
    rows.append = [&pack](std::string& text, std::size_t i) {
        appendNumber(text, pack.id(i));
        for (const double c : pack.position(i)) appendNumber(text += ',', c);
        appendNumber(text += ',', pack.radius(i));
        pack.forEachAttribute(
            [&](std::string_view, const auto& numbers) {
                appendNumber(text += ',', pack.value(numbers, i));
            },
            [&](std::string_view, const auto& texts) { appendCell(text += ',', texts[i]); });
        text += '\n';
    };
    return rows;
}

void writeCsv(const PackView& pack, const PackWriteOptions&, OutputFile& out) {
    const PackTextRows rows = csvRows(pack);
    out.write(rows.header);
    writeRows(out, pack.size(), rows.append);
}

}  // namespace vdbpack
