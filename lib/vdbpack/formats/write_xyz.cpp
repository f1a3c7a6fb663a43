// Extended XYZ, as ASE and OVITO read it: a count, a line that names the columns, a line per
// sphere.
#include "vdbpack/core/box.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/row_writer.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace vdbpack {

namespace {

/// A word of its own: blanks part the columns, colons their descriptions.
std::string asWord(std::string_view text) {
    std::string word(text);
    for (char& c : word)
        if (static_cast<unsigned char>(c) <= 0x20 || c == ':' || c == '"') c = '_';
    return word.empty() ? "_" : word;
}

}  // namespace

void writeXyz(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    const Box<3> box = pack.bounds();
    const Vec<3> size = box.size();
    const auto spaced = [](std::initializer_list<double> values) {
        std::string text;
        for (const double v : values) {
            if (!text.empty()) text += ' ';
            appendNumber(text, v);
        }
        return text;
    };

    const std::vector<std::string>* species = nullptr;
    for (const Column& column : pack.columns())
        if (column.name == kXyzSpecies && !column.texts.empty()) species = &column.texts;
    std::string properties = "species:S:1:pos:R:3:radius:R:1:id:I:1";
    UniqueNames unique{"species", "pos", "x", "y", "z", "radius", "id"};
    const auto describe = [&](std::string_view name, char type) {
        properties += fmt::format(":{}:{}:1", unique(asWord(name)), type);
    };
    pack.forEachAttribute(
        [&](std::string_view name, const auto& numbers) {
            describe(name, std::is_integral_v<ValueOf<decltype(numbers)>> ? 'I' : 'R');
        },
        [&](std::string_view name, const auto& texts) {
            if (&texts != species) describe(name, 'S');
        });
    std::string header = fmt::format("{}\n", pack.size());
    std::string periodic;
    for (int d = 0; d < 3; ++d)
        periodic += fmt::format("{}{}", d ? " " : "", pack.cell().isAlong(d) ? 'T' : 'F');
    header += fmt::format("Lattice=\"{}\" Origin=\"{}\" Properties={} pbc=\"{}\"",
                          spaced({size[0], 0, 0, 0, size[1], 0, 0, 0, size[2]}),
                          spaced({box.lo[0], box.lo[1], box.lo[2]}), properties, periodic);
    header += fmt::format(" {}={}", kUnitKey, unitName(options.unit));
    if (!options.generator.empty()) {
        std::string generator = oneLine(options.generator);
        std::replace(generator.begin(), generator.end(), '"', '\'');
        header += fmt::format(" {}=\"{}\"", kGeneratorKey, generator);
    }
    out.write(header + "\n");

    writeRows(out, pack.size(), [&](std::string& text, std::size_t i) {
        text += species ? asWord((*species)[i]) : std::string(kXyzNoSpecies);
        for (const double c : pack.position(i)) appendNumber(text += ' ', c);
        appendNumber(text += ' ', pack.radius(i));
        appendNumber(text += ' ', pack.id(i));
        pack.forEachAttribute(
            [&](std::string_view, const auto& numbers) {
                appendNumber(text += ' ', pack.value(numbers, i));
            },
            [&](std::string_view, const auto& texts) {
                if (&texts != species) text.append(" ").append(asWord(texts[i]));
            });
        text += '\n';
    });
}

}  // namespace vdbpack
