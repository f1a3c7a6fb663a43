// Data files of LAMMPS (read_data, write_data) and LIGGGHTS, atom styles sphere, granular and
// bpm/sphere. Source: LAMMPS manual, read_data.
#include "vdbpack/core/error.h"
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
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// Sections with one line per item, and the name under which the header counts the items. All
/// other sections (Bodies, PairIJ Coeffs, those of fixes) end at a line that begins with a word.
struct CountedSection {
    const char* name;
    const char* counted;
};
constexpr CountedSection kCountedSections[] = {
    {"Atoms", "atoms"},
    {"Velocities", "atoms"},
    {"Masses", "atom types"},
    {"Atom Type Labels", "atom types"},
    {"Pair Coeffs", "atom types"},
    {"Ellipsoids", "ellipsoids"},
    {"Lines", "lines"},
    {"Triangles", "triangles"},
    {"Bodies", "bodies"},
    {"Bonds", "bonds"},
    {"Bond Type Labels", "bond types"},
    {"Bond Coeffs", "bond types"},
    {"Angles", "angles"},
    {"Angle Type Labels", "angle types"},
    {"Angle Coeffs", "angle types"},
    {"BondBond Coeffs", "angle types"},
    {"BondAngle Coeffs", "angle types"},
    {"Dihedrals", "dihedrals"},
    {"Dihedral Type Labels", "dihedral types"},
    {"Dihedral Coeffs", "dihedral types"},
    {"MiddleBondTorsion Coeffs", "dihedral types"},
    {"EndBondTorsion Coeffs", "dihedral types"},
    {"AngleTorsion Coeffs", "dihedral types"},
    {"AngleAngleTorsion Coeffs", "dihedral types"},
    {"BondBond13 Coeffs", "dihedral types"},
    {"Impropers", "impropers"},
    {"Improper Type Labels", "improper types"},
    {"Improper Coeffs", "improper types"},
    {"AngleAngle Coeffs", "improper types"},
};

std::string_view withoutComment(std::string_view line) {
    return trimmed(line.substr(0, line.find('#')));
}

bool isNumber(std::string_view word) {
    double ignored = 0;
    return parseNumber(word, ignored);
}

std::string joined(Cells::const_iterator begin, Cells::const_iterator end) {
    std::string text;
    for (auto word = begin; word != end; ++word) {
        if (!text.empty()) text += ' ';
        text += *word;
    }
    return text;
}

class DataFile {
public:
    DataFile(const std::string& path, const PackReadOptions& options)
        : file_(path), unit_(options.unit) {}

    Pack<3> read() {
        readTitle();
        std::string_view line;
        std::string section;     // empty: still in the header
        std::uint64_t left = 0;  // lines of a counted section
        bool counted = false;    // whether `section` is one
        while (nextContent(line)) {
            const bool number = isNumber(words_.front());
            const std::string name = number ? "" : joined(words_.begin(), words_.end());
            if (left > 0) {
                if (!number && isSection(name))
                    fail(
                        fmt::format("section {} begins where {} more lines of {} are expected; "
                                    "correct the counts in the header",
                                    name, left, section));
                --left;
                continue;
            }
            if (number && section.empty()) {
                takeHeaderLine();
                continue;
            }
            if (number && counted)
                fail(
                    fmt::format("section {} has more lines than the header announces; correct "
                                "the counts in the header",
                                section));
            if (number) continue;
            if (counts_.count("atoms") == 0) failHeader();
            section = name;
            if (name == "Atoms") {
                Pack<3> pack = readAtoms(line);
                pack.cell = cell_;
                return pack;
            }
            const auto count = counts_.find(countOf(name));
            counted = name != "Bodies" && count != counts_.end();
            left = counted ? count->second : 0;
        }
        const auto atoms = counts_.find("atoms");
        if (atoms == counts_.end()) failHeader();
        if (atoms->second == 0) return {};
        throw InputError(
            fmt::format("{}: ends without a section Atoms for the {} atoms of its header; the file "
                        "is cut short",
                        file_.path(), atoms->second));
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(fmt::format("{}: line {}: {}", file_.path(), file_.lineNumber(), what));
    }
    [[noreturn]] void failHeader() const {
        throw InputError(file_.path() +
                         ": is not a LAMMPS data file: no line 'N atoms' in its header; name the "
                         "format before the file if it is another (csv:FILE)");
    }

    /// Moves to the next line that holds more than a comment; its words are in `words_`.
    bool nextContent(std::string_view& line) {
        while (file_.nextLine(line)) {
            splitAtBlanks(withoutComment(line), words_);
            if (!words_.empty()) return true;
        }
        return false;
    }

    /// The first line is a comment, in which write_data records its units.
    void readTitle() {
        std::string_view line;
        if (!file_.nextLine(line))
            throw InputError(file_.path() + ": is empty; a LAMMPS data file is needed");
        constexpr std::string_view kUnits = "units = ";
        const auto at = line.find(kUnits);
        if (at != std::string_view::npos)
            takeLammpsUnits(trimmed(line.substr(at + kUnits.size())), unit_);
        if (!parseUnitComment(line, unit_))
            fail(fmt::format("unknown unit in '{}'; use m, cm, mm or um",
                             trimmed(line).substr(0, 80)));
        const auto says = [&](const char* words) {
            return line.find(words) != std::string_view::npos;
        };
        shifted_ = says(kLammpsIdShift);
        if (const auto boundary = line.find(kLammpsBoundary); boundary != std::string_view::npos)
            boundary_ = line.substr(boundary + std::string_view(kLammpsBoundary).size(), 5);
        for (const char* one : {"region", "part"})
            if (says((kLammpsTypeIs + std::string(one) + " + 1").c_str())) material_ = one;
        bonded_ = says(kLammpsBonded);
    }

    static const char* countOf(std::string_view section) {
        for (const auto& s : kCountedSections)
            if (section == s.name) return s.counted;
        return "";
    }
    static bool isSection(std::string_view name) { return *countOf(name) != '\0'; }

    void takeHeaderLine() {
        for (std::size_t d = 0; words_.size() == 4 && boundary_.size() == 5 && d < 3; ++d) {
            double lo = 0, hi = 0;
            const char lowWord[] = {"xyz"[d], 'l', 'o', 0};
            if (words_[2] != lowWord || !parseNumber(words_[0], lo) || !parseNumber(words_[1], hi))
                continue;
            const auto axis = static_cast<int>(d);
            cell_.box.lo[axis] = toMillimeters(lo, unit_);
            cell_.box.hi[axis] = toMillimeters(hi, unit_);
            cell_.wraps[d] = boundary_[2 * d] == 'p' && cell_.length(axis) > 0;
        }
        const std::string what = joined(words_.begin() + 1, words_.end());
        for (const auto& s : kCountedSections) {
            if (what != s.counted) continue;
            std::int64_t count = 0;
            if (!parseNumber(words_.front(), count) || count < 0)
                fail(fmt::format("'{}' is not a number of {}; correct it",
                                 words_.front().substr(0, 40), what));
            counts_[what] = static_cast<std::uint64_t>(count);
            return;
        }
    }

    /// Columns of an atom's line without image flags; `hint` is what follows "Atoms #".
    std::vector<std::string> columnsOf(std::string_view hint) const {
        const std::string style(hint.substr(0, hint.find_first_of(" \t")));
        if (style == "hybrid" && bonded_)
            return {"id", "type", "x", "y", "z", "diameter", "density", "molecule"};
        if (style == "bpm/sphere")
            return {"id", "molecule", "type", "diameter", "density", "x", "y", "z"};
        if (!style.empty() && style != "sphere" && style != "granular")
            fail(
                fmt::format("atom style '{}' is not read, only those that are spheres: write the "
                            "file with atom_style sphere (LIGGGHTS: granular) or bpm/sphere",
                            style.substr(0, 40)));
        // Their lines may have as many numbers, with a flag in place of the diameter.
        if (style.empty())
            for (const char* other : {"ellipsoids", "lines", "triangles", "bodies"}) {
                const auto count = counts_.find(other);
                if (count != counts_.end() && count->second > 0)
                    fail(
                        fmt::format("the header announces {} {}, but only spheres are read; write "
                                    "the file with atom_style sphere",
                                    count->second, other));
            }
        return {"id", "type", "diameter", "density", "x", "y", "z"};
    }

    Pack<3> readAtoms(std::string_view heading) {
        const auto comment = heading.find('#');
        const auto hint = comment == std::string_view::npos ? std::string_view{}
                                                            : trimmed(heading.substr(comment + 1));
        TextTable table;
        table.names = columnsOf(hint);
        table.unit = unit_;
        const std::uint64_t count = counts_["atoms"];
        table.expectedRows = count;

        const std::uint64_t begin = file_.offset();
        const std::uint64_t lineBefore = file_.lineNumber();
        std::string_view line;
        if (count > 0 && nextContent(line)) {
            if (words_.size() == table.names.size() + 3)
                table.names.insert(table.names.end(), {"ix", "iy", "iz"});
            file_.seek(begin, lineBefore);
        }
        const std::string columns = fmt::format("{}", fmt::join(table.names, " "));
        const auto columnOf = [&](const char* name) {
            return static_cast<std::size_t>(
                std::find(table.names.begin(), table.names.end(), name) - table.names.begin());
        };
        const std::size_t type = columnOf("type");
        const std::size_t density = columnOf("density");
        if (!material_.empty()) table.names[type] = material_;
        const auto types = counts_.find("atom types");
        const auto largestType = types != counts_.end() && types->second > 0
                                     ? types->second
                                     : std::numeric_limits<std::uint64_t>::max();

        table.nextRow = [&](std::uint64_t row, Cells& cells) {
            if (row == count) return false;
            do {
                if (!file_.nextLine(line))
                    throw InputError(
                        fmt::format("{}: ends after {} of {} atoms; the file is cut "
                                    "short, or its header is wrong",
                                    file_.path(), row, count));
                splitAtBlanks(withoutComment(line), cells);
            } while (cells.empty());
            if (cells.size() != table.names.size())
                fail(
                    fmt::format("has {} words where the {} numbers of atom {} of {} are expected "
                                "({}); use atom_style sphere (LIGGGHTS: granular), or complete "
                                "the file",
                                cells.size(), table.names.size(), row + 1, count, columns));
            // Charges or molecules, which other styles have in these columns, are found here.
            std::int64_t number = 0;
            if (parseNumber(cells[type], number) &&
                (number < 1 || static_cast<std::uint64_t>(number) > largestType))
                fail(
                    fmt::format("type {} is not one of the file's atom types; check that the "
                                "columns are {}",
                                number, columns));
            double rho = 0;
            if (!parseNumber(cells[density], rho) || !(rho > 0) || !std::isfinite(rho))
                fail(
                    fmt::format("density is '{}', it must be positive; check that the columns "
                                "are {}",
                                cells[density].substr(0, 40), columns));
            return true;
        };
        if (shifted_ || !material_.empty())
            table.adjustRow = [&](PackBuilder& builder, const Cells& cells) {
                std::int64_t number = 0;
                if (shifted_ && parseNumber(cells[0], number)) builder.set(0, number - 1);
                if (!material_.empty() && parseNumber(cells[type], number))
                    builder.set(type, number - 1);
            };
        Pack<3> pack = readTable(file_, table);
        if (table.names.back() == "molecule")
            pack.columns.pop_back();  // our writer puts all atoms into no molecule
        if (nextContent(line) && isNumber(words_.front()))
            fail(fmt::format("more atoms follow than the {} of the header; correct it", count));
        return pack;
    }

    InputFile file_;
    Unit unit_;
    bool shifted_ = false, bonded_ = false;  ///< according to the title
    std::string boundary_;                   ///< "p p f" according to the title, or empty
    PeriodicCell<3> cell_;                   ///< of the header, mm
    std::string material_;  ///< what types are one more than, according to the title; or empty
    std::map<std::string, std::uint64_t, std::less<>> counts_;  ///< of the header
    Cells words_;
};

}  // namespace

Pack<3> readLammpsData(const std::string& path, const PackReadOptions& options) {
    return DataFile(path, options).read();
}

}  // namespace vdbpack
