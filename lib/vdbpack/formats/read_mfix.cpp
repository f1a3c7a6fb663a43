// particle_input.dat and particle_output.dat of MFiX, version 2.0. Source: read_particle_input.f of
// MFiX 21.3, which counts the lines of the header.
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// Takes so many lines that are not blank; the words of the last one.
void takeLines(InputFile& file, int count, Cells& words) {
    std::string_view line;
    for (; count > 0; count -= words.empty() ? 0 : 1) {
        if (!file.nextLine(line)) file.fail("ends within its header; the file is cut short");
        splitAtBlanks(line, words);
    }
}

/// The word after `keyword` in the next line.
std::string valueOf(InputFile& file, const char* keyword, Cells& words) {
    takeLines(file, 1, words);
    if (words.size() < 2 || !startsWith(lowered(words[0]), keyword))
        file.failAtLine(fmt::format("'{}:' expected, found {}; keep the lines of MFiX's header",
                                    keyword, quotedExcerpt(words[0])));
    return lowered(words[1]);
}

}  // namespace

Pack<3> readMfix(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    TextTable table;
    table.options = options;
    Cells words;
    takeLines(file, 1, words);
    if (words.size() != 2 || words[1] != "2.0")
        file.failAtLine(
            "'Version 2.0' expected; write the particles in this version, or name the columns of "
            "version 1.0 with `columns` x,y,z,radius,density,u,v,w");
    takeLines(file, 17, words);  // instructions
    std::int64_t dimension = 0, particles = -1;
    parseNumber(valueOf(file, "dimension", words), dimension);
    parseNumber(valueOf(file, "particles", words), particles);
    if ((dimension != 2 && dimension != 3) || particles < 0)
        file.failAtLine("a dimension of 2 or 3 and a number of particles expected");
    table.rows = static_cast<std::uint64_t>(particles);
    takeLines(file, 3, words);
    // "Diameter: T", a column, or "Diameter: F 0.001", the same for all.
    std::vector<std::pair<std::string, std::string>> constants;
    for (const std::string text : {"coordinates x y z", "phase_id Phase_ID", "diameter diameter",
                                   "density density", "velocity u v w"}) {
        std::vector<std::string> names = splitAt(text, ' ');
        const bool isVector = names.size() > 2;
        const std::string option = valueOf(file, names[0].c_str(), words);
        if (isVector && dimension == 2) names.pop_back();
        if (option == "t")
            table.names.insert(table.names.end(), names.begin() + 1, names.end());
        else if (option != "f" || (!isVector && words.size() < 3))
            file.failAtLine(fmt::format("T, or F and a number, expected after {}", names[0]));
        else if (!isVector)
            constants.emplace_back(names[1], std::string(words[2]));
    }
    takeLines(file, 6, words);  // temperature, species and user scalars; names of columns
    // Columns of temperature, species and user scalars are there only if the case has them.
    const std::uint64_t begin = file.offset(), before = file.lineNumber();
    std::string_view line;
    if (file.nextLine(line)) splitAtBlanks(line, words);
    file.seek(begin, before);
    for (std::size_t c = table.names.size(), n = 0; c < words.size(); ++c, ++n)
        table.names.push_back(fmt::format("scalar_{}", n));
    if (dimension == 2) constants.emplace_back("z", "0");
    const std::vector<std::string> inRow = table.names;
    for (const auto& constant : constants) table.names.push_back(constant.first);
    table.nextRow = [&](Cells& cells) {
        if (!nextWords(file, inRow, cells)) return false;
        for (const auto& constant : constants) cells.push_back(constant.second);
        return true;
    };
    Pack<3> pack = readTable(file, table);
    if (options.unit != Unit::millimeter) convertDensity(pack, options.unit);
    return pack;
}

}  // namespace vdbpack
