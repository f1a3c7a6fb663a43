// YADE's text format (ymport.textExt): x y z r and the material.
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

void writeYade(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    const PackTextRows rows = yadeRows(pack, options);
    out.write(rows.header);
    writeRows(out, pack.size(), rows.append);
}

}  // namespace vdbpack
