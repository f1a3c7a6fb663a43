// YADE's text formats: x y z r and the material (ymport.textExt), or the clump (SpherePack.load).
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/pack_text_rows.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/row_writer.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <string>

namespace vdbpack {

PackTextRows yadeRows(const PackView& pack, const PackWriteOptions& options) {
    const Materials materials(pack.attributes());
    PackTextRows rows;
    rows.header = materials.any() ? "#format x_y_z_r_matId\n" : "#format x_y_z_r\n";
    rows.header += fmt::format("# {}{}\n", kUnitComment, unitName(options.unit));
    if (const PeriodicCell<3>& cell = pack.cell(); cell.all()) {
        // The lower corner is none of SpherePack's line; positions are those of any image.
        rows.header += kYadeCell;
        for (int d = 0; d < 3; ++d) appendNumber(rows.header += ' ', cell.length(d));
        rows.header += '\n';
    }
    if (pack.cell().any())
        rows.header += fmt::format("# {}: {}\n", kCellKey, cellText(pack.cell()));
    if (!options.generator.empty())
        rows.header += fmt::format("# {}: {}\n", kGeneratorKey, oneLine(options.generator));
    if (const std::string formula = materials.formula(); !formula.empty() && formula != "region")
        rows.header += fmt::format("{}{}\n", kYadeMaterials, formula);
    rows.header += partComments(pack.attributes());
    rows.append = [&pack, materials](std::string& text, std::size_t i) {
        for (const double c : pack.position(i)) {
            appendNumber(text, c);
            text += '\t';
        }
        appendNumber(text, pack.radius(i));
        if (materials.any()) appendNumber(text += '\t', std::int64_t{materials.of(i)});
        text += '\n';
    };
    return rows;
}

void writeSpherePack(const PackView& pack, const PackWriteOptions&, OutputFile& out) {
    const Column* clumps = nullptr;
    for (const Column& column : pack.columns())
        if (column.name == kYadeClump && !column.numbers.empty()) clumps = &column;
    if (const PeriodicCell<3>& cell = pack.cell(); cell.all()) {
        std::string line(kYadeCell);
        for (int d = 0; d < 3; ++d) appendNumber(line += ' ', cell.length(d));
        out.write(line + '\n');
    }
    writeRows(out, pack.size(), [&pack, clumps](std::string& text, std::size_t i) {
        for (const double c : pack.position(i)) {
            appendNumber(text, c);
            text += ' ';
        }
        appendNumber(text, pack.radius(i));
        const double clump = clumps ? clumps->numbers[i] : -1;
        text += fmt::format(" {:.0f}\n", clump);
    });
}

void writeYade(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    const PackTextRows rows = yadeRows(pack, options);
    out.write(rows.header);
    writeRows(out, pack.size(), rows.append);
}

}  // namespace vdbpack
