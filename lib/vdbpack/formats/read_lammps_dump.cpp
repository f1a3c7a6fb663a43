// Text dumps of LAMMPS and LIGGGHTS (dump custom). Source: LAMMPS manual, dump and Howto_triclinic.
#include "vdbpack/core/vec.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::string_view kItem = "ITEM:";
constexpr const char* kRemedy = "write it with dump custom ... id type x y z radius";

/// The header of a frame, and the position of its atoms in the file.
struct Frame {
    std::uint64_t atoms = 0;
    std::vector<std::string> names;
    std::array<std::vector<double>, 3> bounds;  ///< numbers of the lines of BOX BOUNDS
    std::vector<std::string> boundary;          ///< of each axis ("pp"), or empty
    std::uint64_t offset = 0;                   ///< of the first atom
    std::uint64_t line = 0;                     ///< before it
};

/// The simulation box: a scaled position s is at origin + sum of s[i] * edge[i].
struct SimulationBox {
    Vec<3> origin;
    std::array<Vec<3>, 3> edge;
};

/// Names of the columns of a position, best first: wrapped into the box before unwrapped ones,
/// which continue across periodic boundaries.
struct PositionColumns {
    std::array<const char*, 3> names;
    bool scaled;
};
constexpr PositionColumns kPositions[] = {{{"x", "y", "z"}, false},
                                          {{"xs", "ys", "zs"}, true},
                                          {{"xu", "yu", "zu"}, false},
                                          {{"xsu", "ysu", "zsu"}, true}};

class DumpFile {
public:
    DumpFile(const std::string& path, const PackReadOptions& options)
        : file_(path), options_(options), knowsUnits_(options.unit != Unit::millimeter) {}

    Pack<3> read() {
        const Frame frame = lastFrame();
        TextTable table;
        table.names = frame.names;
        table.options = options_;
        table.rows = frame.atoms;
        const PositionColumns& position = positionOf(frame);
        std::array<std::size_t, 3> column{};
        for (std::size_t i = 0; i < 3; ++i) {
            const auto at = std::find(table.names.begin(), table.names.end(), position.names[i]);
            column[i] = static_cast<std::size_t>(at - table.names.begin());
            table.names[column[i]] = kPositions[0].names[i];
        }
        SimulationBox box;
        if (position.scaled) {
            box = boxOf(frame);
            table.adjustRow = [&box, column](PackBuilder& builder, const Cells& cells) {
                Vec<3> p = box.origin;
                for (std::size_t i = 0; i < 3; ++i) {
                    double share = 0;
                    parseNumber(cells[column[i]], share);
                    p += share * box.edge[i];
                }
                for (std::size_t i = 0; i < 3; ++i) builder.set(column[i], p.c[i]);
            };
        }
        table.nextRow = [&](Cells& cells) { return nextWords(file_, table.names, cells); };
        file_.seek(frame.offset, frame.line);
        Pack<3> pack = readTable(file_, table);
        if (!frame.bounds[0].empty())
            takeCell(pack, statedBox(frame), file_.path(), options_.callbacks);
        if (knowsUnits_) convertDensity(pack, options_.unit);
        return pack;
    }

private:
    [[noreturn]] void failBegun(const std::string& what) const {
        file_.fail(
            fmt::format("ends within the frame that begins in line {}: {}; remove that frame to "
                        "take the one before",
                        frameLine_, what));
    }

    /// Walks over all frames. @return the last one.
    Frame lastFrame() {
        Frame last;
        bool any = false;
        std::string_view item;
        while (nextItem(any, item)) {
            if (!begun_ || startsWith(item, "TIMESTEP")) {
                frame_ = {};
                counted_ = false;
                // Units and time may come before the time step.
                if (!begun_) frameLine_ = file_.lineNumber();
                begun_ = true;
            }
            if (startsWith(item, "NUMBER OF ATOMS")) {
                readCount();
            } else if (startsWith(item, "BOX BOUNDS")) {
                readBounds(item);
            } else if (startsWith(item, "UNITS")) {
                std::string_view line;
                if (!file_.nextLine(line)) failBegun("the units are missing");
                knowsUnits_ = takeLammpsUnits(trimmed(line), options_.unit) || knowsUnits_;
            } else if (startsWith(item, "ATOMS")) {
                passAtoms(item.substr(std::string_view("ATOMS").size()));
                last = frame_;
                any = true;
                begun_ = false;
            } else {
                skips_ = true;
            }
        }
        if (!any)
            file_.fail(
                "holds no whole frame of atoms (ITEM: ATOMS); check that it is a complete text "
                "dump of atoms");
        if (begun_) failBegun("it has no atoms");
        return last;
    }

    /// Moves on to the next item, past the lines of one that does not matter.
    /// @return false at the end of the file.
    bool nextItem(bool any, std::string_view& item) {
        std::string_view line;
        while (file_.nextLine(line)) {
            line = trimmed(line);
            if (startsWith(line, kItem)) {
                item = trimmed(line.substr(kItem.size()));
                skips_ = false;
                return true;
            }
            if (line.empty() || skips_) continue;
            if (!any && !begun_)
                file_.fail(
                    "is not a LAMMPS text dump: it does not begin with ITEM:; name the format "
                    "before the file if it is another (csv:FILE)");
            file_.failAtLine("more lines follow than the item announces; correct NUMBER OF ATOMS");
        }
        return false;
    }

    void readCount() {
        std::string_view line;
        std::int64_t atoms = 0;
        if (!file_.nextLine(line)) failBegun("the number of atoms is missing");
        if (!parseNumber(line, atoms) || atoms < 0)
            file_.failAtLine(fmt::format("'{}' is not a number of atoms; correct it",
                                         trimmed(line).substr(0, 40)));
        frame_.atoms = static_cast<std::uint64_t>(atoms);
        counted_ = true;
    }

    /// @param item  BOX BOUNDS, names of tilts ("xy xz yz") and the boundaries ("pp pp ff").
    void readBounds(std::string_view item) {
        std::string_view line;
        Cells words;
        splitAtBlanks(item, words);
        for (const std::string_view word : words)
            if (word.size() == 2 && word.find_first_not_of("pfsm") == std::string_view::npos)
                frame_.boundary.emplace_back(word);
        for (auto& bounds : frame_.bounds) {
            if (!file_.nextLine(line)) failBegun("bounds of the box are missing");
            splitAtBlanks(line, words);
            bounds.assign(std::min<std::size_t>(words.size(), 5), 0);
            for (std::size_t i = 0; i < bounds.size(); ++i)
                if (!parseNumber(words[i], bounds[i]))
                    file_.failAtLine(fmt::format("'{}' is not a bound of the box; correct it",
                                                 words[i].substr(0, 40)));
        }
    }

    /// Notes where the atoms begin, and passes over their lines.
    void passAtoms(std::string_view names) {
        if (!counted_)
            file_.failAtLine("ITEM: NUMBER OF ATOMS is missing before ITEM: ATOMS; add it");
        Cells words;
        splitAtBlanks(names, words);
        frame_.names.assign(words.begin(), words.end());
        frame_.offset = file_.offset();
        frame_.line = file_.lineNumber();
        std::string_view line;
        for (std::uint64_t i = 0; i < frame_.atoms; ++i) {
            if (!file_.nextLine(line))
                failBegun(fmt::format("{} of its {} atoms are there", i, frame_.atoms));
            if (startsWith(line, kItem))
                file_.failAtLine(
                    fmt::format("an item begins after {} of {} atoms; correct NUMBER OF ATOMS", i,
                                frame_.atoms));
        }
    }

    const PositionColumns& positionOf(const Frame& frame) const {
        const auto has = [&frame](const char* name) {
            return std::find(frame.names.begin(), frame.names.end(), name) != frame.names.end();
        };
        const auto found =
            std::find_if(std::begin(kPositions), std::end(kPositions), [&](const auto& position) {
                return std::all_of(position.names.begin(), position.names.end(), has);
            });
        if (found == std::end(kPositions))
            failColumns(frame, "columns x y z (or xs ys zs, xu yu zu, xsu ysu zsu)");
        const bool named = options_.radius > 0 || !options_.columns.empty();
        if (!(named || has("radius") || has("diameter") || has("r") || has("pscale") ||
              has("radii")))
            failColumns(frame, "column radius or diameter");
        return *found;
    }

    [[noreturn]] void failColumns(const Frame& frame, const char* missing) const {
        file_.fail(fmt::format("line {}: no {} among '{:.200}'; {}", frame.line, missing,
                               fmt::format("{}", fmt::join(frame.names, " ")), kRemedy));
    }

    SimulationBox boxOf(const Frame& frame) const {
        const auto& b = frame.bounds;
        const std::size_t numbers = b[0].size();
        if (numbers < 2 || numbers > 4 || b[1].size() != numbers || b[2].size() != numbers)
            file_.fail(
                fmt::format("line {}: scaled positions (xs ys zs) need the three lines of ITEM: "
                            "BOX BOUNDS, each of 2, 3 or 4 numbers; complete it, or {}",
                            frame.line, kRemedy));
        SimulationBox box;
        if (numbers == 4) {  // abc origin: the edges themselves
            for (int i = 0; i < 3; ++i) {
                const auto k = static_cast<std::size_t>(i);
                box.edge[k] = {{b[k][0], b[k][1], b[k][2]}};
                box.origin[i] = b[k][3];
            }
            return box;
        }
        const bool tilted = numbers == 3;
        const double xy = tilted ? b[0][2] : 0, xz = tilted ? b[1][2] : 0;
        const double yz = tilted ? b[2][2] : 0;
        // The bounds are those of the tilted box as a whole.
        const double xlo = b[0][0] - std::min({0.0, xy, xz, xy + xz});
        const double xhi = b[0][1] - std::max({0.0, xy, xz, xy + xz});
        const double ylo = b[1][0] - std::min(0.0, yz);
        const double yhi = b[1][1] - std::max(0.0, yz);
        box.origin = {{xlo, ylo, b[2][0]}};
        box.edge = {{{{xhi - xlo, 0, 0}}, {{xy, yhi - ylo, 0}}, {{xz, yz, b[2][1] - b[2][0]}}}};
        return box;
    }

    StatedBox statedBox(const Frame& frame) const {
        StatedBox stated;
        stated.hasFlags = frame.boundary.size() == 3;
        for (std::size_t d = 0; d < 3; ++d) {
            const std::vector<double>& bounds = frame.bounds[d];
            const auto axis = static_cast<int>(d);
            for (std::size_t k = 2; k < bounds.size(); ++k)
                stated.isTilted = stated.isTilted || bounds.size() > 3 || bounds[k] != 0;
            if (bounds.size() < 2) return {};
            stated.cell.box.lo[axis] = toMillimeters(bounds[0], options_.unit);
            stated.cell.box.hi[axis] = toMillimeters(bounds[1], options_.unit);
            stated.cell.wraps[d] = stated.hasFlags && frame.boundary[d] == "pp";
        }
        return stated;
    }

    InputFile file_;
    PackReadOptions options_;      ///< with the unit of the file
    bool knowsUnits_;              ///< of the unit of lengths, and of densities
    Frame frame_;                  ///< that is being read
    std::uint64_t frameLine_ = 0;  ///< where it begins
    bool begun_ = false;           ///< its header has begun
    bool counted_ = false;         ///< its header has a number of atoms
    bool skips_ = false;           ///< over the lines of an item that does not matter
};

}  // namespace

Pack<3> readLammpsDump(const std::string& path, const PackReadOptions& options) {
    return DumpFile(path, options).read();
}

}  // namespace vdbpack
