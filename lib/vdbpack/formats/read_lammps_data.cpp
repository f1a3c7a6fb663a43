// Data files of LAMMPS (read_data, write_data) and LIGGGHTS, atom styles sphere, granular and
// bpm/sphere. Source: LAMMPS manual, read_data.
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/text_table.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace vdbpack {

namespace {

/// What the header counts, as far as it matters here.
constexpr const char* kCounted[] = {"atoms", "atom types", "ellipsoids",
                                    "lines", "triangles",  "bodies"};

bool isNumber(std::string_view word) {
    double ignored = 0;
    return parseNumber(word, ignored);
}

class DataFile {
public:
    DataFile(const std::string& path, const PackReadOptions& options)
        : file_(path), options_(options), knowsDensity_(options.unit != Unit::millimeter) {}

    Pack<3> read() {
        readTitle();
        std::string_view line;
        bool inHeader = true;  // until a line begins with a word: other sections are passed over
        while (nextContent(line)) {
            const bool number = isNumber(words_.front());
            if (number && inHeader) takeHeaderLine();
            inHeader = inHeader && number;
            if (words_.size() != 1 || words_.front() != "Atoms") continue;
            if (counts_.count("atoms") == 0) failHeader();
            Pack<3> pack = readAtoms(line);
            if (box_.isTilted || hasBox_) takeCell(pack, box_, file_.path(), options_.callbacks);
            setPartNames(pack, std::move(partNames_));
            if (knowsDensity_) convertDensity(pack, options_.unit);
            warnOfVelocities(line);
            return pack;
        }
        const auto atoms = counts_.find("atoms");
        if (atoms == counts_.end()) failHeader();
        if (atoms->second == 0) return {};
        file_.fail(fmt::format(
            "ends without a section Atoms for the {} atoms of its header; the file is cut short",
            atoms->second));
    }

private:
    [[noreturn]] void failHeader() const {
        file_.fail(
            "is not a LAMMPS data file: no line 'N atoms' in its header; name the format before "
            "the file if it is another (csv:FILE)");
    }

    /// Moves to the next line that holds more than a comment; its words are in `words_`.
    bool nextContent(std::string_view& line) {
        while (file_.nextLine(line)) {
            takePartComment(line, partNames_);
            splitAtBlanks(line.substr(0, line.find('#')), words_);
            if (!words_.empty()) return true;
        }
        return false;
    }

    /// The first line is a comment, in which write_data records its units.
    void readTitle() {
        std::string_view line;
        if (!file_.nextLine(line)) file_.fail("is empty; a LAMMPS data file is needed");
        constexpr std::string_view kUnits = "units = ";
        const auto at = line.find(kUnits);
        if (at != std::string_view::npos)
            knowsDensity_ =
                takeLammpsUnits(trimmed(line.substr(at + kUnits.size())), options_.unit);
        options_.unit = unitIn(line, options_.unit, file_);
        const auto says = [&](const char* words) {
            return line.find(words) != std::string_view::npos;
        };
        if (says(kLammpsDensity)) knowsDensity_ = !says(kLammpsGiven);
        shifted_ = says(kLammpsIdShift);
        if (const auto boundary = line.find(kLammpsBoundary); boundary != std::string_view::npos)
            boundary_ = line.substr(boundary + std::string_view(kLammpsBoundary).size(), 5);
        for (const char* one : {"region", "part"})
            if (says((kLammpsTypeIs + std::string(one) + " + 1").c_str())) material_ = one;
        materials_ = MaterialNumbers(line, kLammpsTypeIs);
        if (materials_.regions > 0) material_ = "region";
        if (materials_.areCounted())
            options_.callbacks.warn(fmt::format(
                "{}: types are the {}, from which parts and regions are not read back, so that "
                "pairs between parts are not known; read the pack's .vtp or .vdb",
                file_.path(), materials_.formula));
        bonded_ = says(kLammpsBonded);
        origin_ = originIn(line);
    }

    void takeHeaderLine() {
        double tilt = 0;  // "0.5 0 0 xy xz yz", or edges in any direction: "1 0 0 avec"
        for (std::size_t k = 0; words_.size() == 6 && words_[5] == "yz" && k < 3; ++k)
            box_.isTilted |= parseNumber(words_[k], tilt) && tilt != 0;
        box_.isTilted |= words_.size() == 4 && words_.back() == "avec";
        for (std::size_t d = 0; words_.size() == 4 && d < 3; ++d) {
            double lo = 0, hi = 0;
            const char lowWord[] = {"xyz"[d], 'l', 'o', 0};
            if (words_[2] != lowWord || !parseNumber(words_[0], lo) || !parseNumber(words_[1], hi))
                continue;
            const auto axis = static_cast<int>(d);
            hasBox_ = true;
            box_.cell.box.lo[axis] = toMillimeters(lo, options_.unit);
            box_.cell.box.hi[axis] = toMillimeters(hi, options_.unit);
            box_.hasFlags = boundary_.size() == 5;
            box_.cell.wraps[d] = box_.hasFlags && boundary_[2 * d] == 'p';
        }
        const std::string what =
            fmt::format("{}", fmt::join(words_.begin() + 1, words_.end(), " "));
        for (const char* counted : kCounted) {
            if (what != counted) continue;
            std::int64_t count = 0;
            if (!parseNumber(words_.front(), count) || count < 0)
                file_.failAtLine(fmt::format("{} is not a number of {}; correct it",
                                             quotedExcerpt(words_.front()), what));
            counts_[what] = static_cast<std::uint64_t>(count);
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
            file_.failAtLine(
                fmt::format("atom style '{}' is not read, only those that are spheres: write the "
                            "file with atom_style sphere (LIGGGHTS: granular) or bpm/sphere",
                            style.substr(0, 40)));
        // Their lines may have as many numbers, with a flag in place of the diameter.
        if (style.empty())
            for (const char* other : {"ellipsoids", "lines", "triangles", "bodies"}) {
                const auto count = counts_.find(other);
                if (count != counts_.end() && count->second > 0)
                    file_.failAtLine(
                        fmt::format("the header announces {} {}, but only spheres are read; write "
                                    "the file with atom_style sphere",
                                    count->second, other));
            }
        return {"id", "type", "diameter", "density", "x", "y", "z"};
    }

    /// Finds charges or molecules, which other styles have in these columns.
    void requireSphere(std::string_view type, std::string_view density) const {
        const auto types = counts_.find("atom types");
        const bool counted = types != counts_.end() && types->second > 0;
        std::int64_t number = 0;
        if (parseNumber(type, number) &&
            (number < 1 || (counted && static_cast<std::uint64_t>(number) > types->second)))
            file_.failAtLine(fmt::format(
                "type {} is not one of the file's atom types; check the atom style", number));
        double rho = 0;
        if (!parseNumber(density, rho) || !(rho > 0) || !std::isfinite(rho))
            file_.failAtLine(fmt::format("density is {}, it must be positive; check the atom style",
                                         quotedExcerpt(density)));
    }

    Pack<3> readAtoms(std::string_view heading) {
        const auto comment = heading.find('#');
        const auto hint = comment == std::string_view::npos ? std::string_view{}
                                                            : trimmed(heading.substr(comment + 1));
        TextTable table;
        table.names = columnsOf(hint);
        table.options = options_;
        table.rows = counts_["atoms"];
        const std::uint64_t begin = file_.offset();
        const std::uint64_t lineBefore = file_.lineNumber();
        std::string_view line;
        if (table.rows > 0u && nextContent(line)) {
            if (words_.size() == table.names.size() + 3)
                table.names.insert(table.names.end(), {"ix", "iy", "iz"});
            file_.seek(begin, lineBefore);
        }
        const auto columnOf = [&](const char* name) {
            return static_cast<std::size_t>(
                std::find(table.names.begin(), table.names.end(), name) - table.names.begin());
        };
        const std::size_t type = columnOf("type");
        const std::size_t density = columnOf("density");
        if (!material_.empty()) table.names[type] = material_;
        table.nextRow = [&](Cells& cells) {
            if (!nextContent(line)) return false;
            cells = words_;
            requireWords(file_, table.names, cells,
                         "use atom_style sphere (LIGGGHTS: granular), or complete the file");
            requireSphere(cells[type], cells[density]);
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
        pack.origin = origin_;
        materials_.split(pack);
        if (table.names.back() == "molecule")
            pack.columns.pop_back();  // our writer puts all atoms into no molecule
        if (nextContent(line) && isNumber(words_.front()))
            file_.failAtLine(fmt::format("more atoms follow than the {} of the header; correct it",
                                         *table.rows));
        return pack;
    }

    /// A section that follows the atoms. @param line  the last one that was read.
    void warnOfVelocities(std::string_view line) {
        bool inSection = false, moves = false;
        do {
            const bool number = !words_.empty() && isNumber(words_.front());
            if (!number) inSection = !words_.empty() && words_.front() == "Velocities";
            double speed = 0;
            for (std::size_t k = 1; inSection && number && k < words_.size(); ++k)
                moves = moves || (parseNumber(words_[k], speed) && speed != 0);
        } while (!moves && nextContent(line));
        if (moves)
            options_.callbacks.warn(
                file_.path() +
                ": its section Velocities is not read; a dump with vx, vy and vz "
                "keeps velocities");
    }

    InputFile file_;
    PackReadOptions options_;  ///< with the unit of the file
    bool knowsDensity_;  ///< the unit of densities is the one that goes with the unit of lengths
    bool shifted_ = false, bonded_ = false;  ///< according to the title
    PackOrigin origin_;                      ///< according to the title
    std::string boundary_;                   ///< "p p f" according to the title, or empty
    StatedBox box_;                          ///< of the header
    bool hasBox_ = false;
    std::vector<std::string> partNames_;
    MaterialNumbers materials_;
    std::string material_;  ///< what types are one more than, according to the title; or empty
    std::map<std::string, std::uint64_t, std::less<>> counts_;  ///< of the header
    Cells words_;
};

}  // namespace

Pack<3> readLammpsData(const std::string& path, const PackReadOptions& options) {
    return DataFile(path, options).read();
}

}  // namespace vdbpack
