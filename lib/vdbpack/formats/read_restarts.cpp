// Particles in files of DEM programs from which they start: .restart of MercuryDPM (source:
// BaseInteractable.cc, BaseParticle.cc) and .geo of GenGeo and ESyS-Particle (LSMGeometry 1.2).
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
#include <limits>
#include <string>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

/// The words after `key` in a row of keys and values; none if it has not so many.
Cells after(const Cells& words, std::string_view key, std::size_t count) {
    const auto at = std::find(words.begin(), words.end(), key);
    if (static_cast<std::size_t>(words.end() - at) <= count) return {};
    return {at + 1, at + 1 + static_cast<std::ptrdiff_t>(count)};
}

/// Number `i` of such words; NaN if there is none.
double numberOf(const Cells& words, std::size_t i) {
    double number = std::numeric_limits<double>::quiet_NaN();
    if (i < words.size()) parseNumber(words[i], number);
    return number;
}

/// Adds what a row such as "PeriodicBoundary id 0 normal 1 0 0 ... distanceLeft 0 distanceRight 9"
/// says; anything but faces across an axis counts as tilted.
void addPeriods(const Cells& words, Unit unit, StatedBox& box) {
    const Cells normal = after(words, "normal", 3);
    std::size_t axis = 0;
    while (axis < 2 && std::abs(numberOf(normal, axis)) != 1) ++axis;
    const double sign = numberOf(normal, axis);
    const double left = sign * numberOf(after(words, "distanceLeft", 1), 0);
    const double right = sign * numberOf(after(words, "distanceRight", 1), 0);
    box.cell.wraps[axis] = true;
    box.isTilted = box.isTilted || words[0] != "PeriodicBoundary" || std::abs(sign) != 1;
    box.cell.box.lo[static_cast<int>(axis)] = toMillimeters(std::min(left, right), unit);
    box.cell.box.hi[static_cast<int>(axis)] = toMillimeters(std::max(left, right), unit);
}

/// A row of a particle of MercuryDPM as cells.
bool takeParticle(InputFile& file, Cells& words, Cells& cells) {
    std::string_view line;
    if (!file.nextLine(line)) return false;
    splitAtBlanks(line, words);
    cells.clear();
    const std::string type = words.empty() ? "" : lowered(words[0]);
    for (const char* other : {"superquadric", "clump", "multi", "nonspherical"})
        if (type.find(other) != std::string::npos)
            file.failAtLine(quotedExcerpt(words[0]) +
                            " is no sphere; write the particles as spheres, or their surface");
    using Field = std::pair<std::string_view, std::size_t>;
    for (const auto& [key, count] :
         {Field("position", 3), {"radius", 1}, {"id", 1}, {"indSpecies", 1}, {"velocity", 3}}) {
        const Cells values = after(words, key, count);
        if (values.empty())
            file.failAtLine(
                fmt::format("{} is missing in a particle; write the file with MercuryDPM "
                            "1.0 or later",
                            key));
        cells.insert(cells.end(), values.begin(), values.end());
    }
    return true;
}

}  // namespace

Pack<3> readMercury(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    TextTable table;
    table.options = options;
    table.names = {"x",          "y",          "z",          "radius",    "id",
                   "indSpecies", "velocity_0", "velocity_1", "velocity_2"};
    StatedBox box;
    box.hasFlags = true;
    box.cell.box.lo = Box<3>::filled(std::numeric_limits<double>::infinity());
    box.cell.box.hi = Box<3>::filled(-std::numeric_limits<double>::infinity());
    Cells words;
    std::string_view line;
    while (!table.rows && file.nextLine(line)) {
        splitAtBlanks(line, words);
        std::int64_t count = 0;
        if (words.size() == 2 && words[0] == "Particles" && parseInteger(words[1], count) &&
            count >= 0)
            table.rows = static_cast<std::uint64_t>(count);
        else if (!words.empty() && (words[0].find("eriodicBoundary") != words[0].npos ||
                                    words[0] == "LeesEdwardsBoundary"))
            addPeriods(words, options.unit, box);
    }
    if (!table.rows)
        file.fail(
            "has no line 'Particles N' of MercuryDPM; restart files of LAMMPS and LIGGGHTS are "
            "read by these programs only: write_data makes a data file of one");
    table.nextRow = [&](Cells& cells) { return takeParticle(file, words, cells); };
    Pack<3> pack = readTable(file, table);
    takeCell(pack, box, path, options.callbacks);
    return pack;
}

Pack<3> readGeo(const std::string& path, const PackReadOptions& options) {
    InputFile file(path);
    TextTable table;
    table.options = options;
    table.names = {"x", "y", "z", "r", "id", "tag"};
    StatedBox box;
    Cells words;
    std::string_view line;
    if (!file.nextLine(line) || !startsWith(line, "LSMGeometry"))
        file.fail(
            "does not begin with LSMGeometry, as files of GenGeo do. Of a geometry of gmsh, make "
            "a surface (gmsh -2 -format stl); save points of Houdini as .vdb");
    while (file.nextLine(line)) {
        splitAtBlanks(line, words);
        const std::string_view keyword = words.empty() ? std::string_view() : words[0];
        const Cells corners = after(words, "BoundingBox", 6);
        const Cells wraps = after(words, "PeriodicBoundaries", 3);
        for (std::size_t d = 0; d < 3; ++d) {
            const int axis = static_cast<int>(d);
            if (!wraps.empty()) box.cell.wraps[d] = numberOf(wraps, d) != 0;
            if (corners.empty()) continue;
            box.cell.box.lo[axis] = toMillimeters(numberOf(corners, d), options.unit);
            box.cell.box.hi[axis] = toMillimeters(numberOf(corners, 3 + d), options.unit);
        }
        if (keyword != "BeginParticles") continue;
        std::int64_t count = -1;
        if (!file.nextLine(line) || trimmed(line) != "Simple" || !file.nextLine(line) ||
            !parseNumber(line, count) || count < 0)
            file.failAtLine("'Simple' and the number of particles expected after BeginParticles");
        table.rows = static_cast<std::uint64_t>(count);
        break;
    }
    if (!table.rows) file.fail("has no BeginParticles; the file is cut short");
    table.nextRow = [&](Cells& cells) { return nextWords(file, table.names, cells); };
    Pack<3> pack = readTable(file, table);
    box.hasFlags = true;
    takeCell(pack, box, path, options.callbacks);
    return pack;
}

}  // namespace vdbpack
