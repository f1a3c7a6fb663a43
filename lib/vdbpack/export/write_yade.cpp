// YADE's text format (ymport.text, ymport.textExt): x y z r and, with regions, matId.
#include "vdbpack/core/error.h"
#include "vdbpack/export/input_file.h"
#include "vdbpack/export/numbers.h"
#include "vdbpack/export/pack_builder.h"
#include "vdbpack/export/pack_formats.h"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

void writeYade(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    const bool regions = !pack.region().empty();
    out.write(regions ? std::string("#format x_y_z_r_matId\n") : std::string("#format x_y_z_r\n"));
    out.write(fmt::format("# {}{}\n", kUnitComment, unitName(options.unit)));
    if (!options.generator.empty())
        out.write(fmt::format("# {}: {}\n", kGeneratorKey, oneLine(options.generator)));
    writeRows(out, pack.size(), [&pack, regions](std::string& text, std::size_t i) {
        for (const double c : pack.position(i)) {
            appendNumber(text, c);
            text += '\t';
        }
        appendNumber(text, pack.radius(i));
        if (regions) appendNumber(text += '\t', std::int64_t{pack.region()[i]});
        text += '\n';
    });
}

Pack<3> readYade(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    Unit unit = options.unit;
    std::vector<std::string> names = {"x", "y", "z", "r"};
    std::unique_ptr<PackBuilder> builder;
    std::vector<std::string_view> cells;
    std::string_view line;
    const auto where = [&] { return fmt::format("line {}", file.lineNumber()); };
    while (file.nextLine(line)) {
        line = trimmed(line);
        if (line.empty()) continue;
        if (line.front() == '#') {
            constexpr std::string_view kFormat = "#format";
            if (line.substr(0, kFormat.size()) == kFormat) {
                const auto format = trimmed(line.substr(kFormat.size()));
                if (format == "x_y_z_r")
                    names = {"x", "y", "z", "r"};
                else if (format == "x_y_z_r_matId")
                    names = {"x", "y", "z", "r", "region"};
                else
                    throw InputError(
                        fmt::format("{}: {}: format '{}' is not supported; use x_y_z_r or "
                                    "x_y_z_r_matId",
                                    path, where(), format.substr(0, 80)));
                if (builder)
                    throw InputError(fmt::format(
                        "{}: {}: the format line must come before the spheres", path, where()));
            } else if (!builder && !parseUnitComment(line, unit)) {
                throw InputError(fmt::format("{}: {}: unknown unit in '{}'; use m, cm, mm or um",
                                             path, where(), line.substr(0, 80)));
            }
            continue;
        }
        if (!builder) builder = std::make_unique<PackBuilder>(path, names, unit);
        cells.clear();
        for (std::size_t at = 0; at < line.size();) {
            const auto begin = line.find_first_not_of(" \t", at);
            if (begin == std::string_view::npos) break;
            at = std::min(line.find_first_of(" \t", begin), line.size());
            cells.push_back(line.substr(begin, at - begin));
        }
        if (cells.size() != names.size())
            throw InputError(
                fmt::format("{}: {}: has {} numbers where {} are expected; check the "
                            "#format line, or cut the file there",
                            path, where(), cells.size(), names.size()));
        builder->addRow();
        for (std::size_t c = 0; c < cells.size(); ++c)
            if (!builder->parse(c, cells[c])) builder->failCell(where(), c, cells[c]);
        if (!builder->problem().empty()) builder->failRow(where());
    }
    return builder ? builder->finish() : Pack<3>{};
}

}  // namespace vdbpack
