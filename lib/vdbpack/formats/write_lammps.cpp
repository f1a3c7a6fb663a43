// Data files for LAMMPS (read_data) and LIGGGHTS. Source: LAMMPS manual, read_data.
// Loading was tested with LAMMPS 29 Sep 2021 and LIGGGHTS 3.8.
#include "vdbpack/core/box.h"
#include "vdbpack/formats/bonded_pack.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/pack_text_rows.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/row_writer.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace vdbpack {

namespace {

/// Largest atom id and type in LAMMPS as it is usually built.
constexpr std::int64_t kLargestAtom = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kTitleLength = 240;  // both programs read lines of up to 255 characters

/// Ids of the atoms: positive, and unique.
class AtomIds {
public:
    /// @param rows  in the pack of all ranks, of which this one has a share; null: it has all.
    AtomIds(const PackView& pack, const std::vector<std::uint64_t>* rows)
        : pack_(pack), rows_(rows) {
        if (rows_) {
            for (std::size_t i = 0; i < pack.size(); ++i)
                counted_ = counted_ || static_cast<std::uint64_t>(pack.id(i)) != (*rows_)[i];
            shift_ = 1;
            return;
        }
        std::int64_t least = kLargestAtom, most = 0;
        std::vector<std::int64_t> ids(pack.size());
        for (std::size_t i = 0; i < pack.size(); ++i) {
            ids[i] = pack.id(i);
            least = std::min(least, ids[i]);
            most = std::max(most, ids[i]);
        }
        std::sort(ids.begin(), ids.end());
        const bool twice = std::adjacent_find(ids.begin(), ids.end()) != ids.end();
        shift_ = least == 0 ? 1 : 0;
        counted_ = twice || least < 0 || most + shift_ > kLargestAtom;
    }
    std::int64_t operator()(std::size_t i) const {
        if (rows_) return static_cast<std::int64_t>((*rows_)[i]) + 1;
        return counted_ ? static_cast<std::int64_t>(i) + 1 : pack_.id(i) + shift_;
    }
    const char* meaning() const {
        return counted_ ? "atoms are counted" : shift_ == 1 ? kLammpsIdShift : "atom = id";
    }

private:
    const PackView& pack_;
    const std::vector<std::uint64_t>* rows_;
    std::int64_t shift_ = 0;
    bool counted_ = false;
};

/// Types from 1 on: the pack's column `type`, or else material + 1. Spheres that were added to
/// those of a file have 0 in that column: their types follow after its largest one.
class AtomTypes {
public:
    explicit AtomTypes(const PackView& pack)
        : materials_(pack.attributes()), column_(columnOfNumbers(pack.attributes(), "type")) {
        if (column_ && !std::all_of(column_->numbers.begin(), column_->numbers.end(), [](double v) {
                return v >= 0 && v <= static_cast<double>(kLargestAtom) && std::trunc(v) == v;
            }))
            column_ = nullptr;
        if (column_)
            largest_ = static_cast<std::int64_t>(
                *std::max_element(column_->numbers.begin(), column_->numbers.end()));
        for (std::size_t i = 0; i < pack.size(); ++i) count_ = std::max(count_, (*this)(i));
    }
    std::int64_t operator()(std::size_t i) const {
        if (column_ && column_->numbers[i] > 0)
            return static_cast<std::int64_t>(column_->numbers[i]);
        return largest_ + 1 + (materials_.any() ? std::int64_t{materials_.of(i)} : 0);
    }
    std::int64_t count() const { return count_; }
    /// Empty: nothing that the pack knows.
    std::string meaning() const {
        return materials_.any() && largest_ == 0 ? kLammpsTypeIs + materials_.formula() + " + 1"
                                                 : "";
    }

private:
    Materials materials_;
    const Column* column_;
    std::int64_t largest_ = 0;  // of that column
    std::int64_t count_ = 1;
};

/// The density of each atom, in the unit that is written.
class AtomDensities {
public:
    AtomDensities(const PackView& pack, const PackWriteOptions& options)
        : densities_(pack.attributes(), options.particleDensity, options.materialDensity),
          unit_(options.unit) {}
    double operator()(std::size_t i) const {
        const double given = areGiven() ? densities_.unconverted()->numbers[i] : 0;
        return given > 0 ? given : densities_.of(i) / densityUnit(unit_).size;
    }
    /// Those of an input file, which are kept as they are.
    bool areGiven() const { return densities_.unconverted() != nullptr; }

private:
    SphereDensities densities_;
    Unit unit_;
};

struct Atoms {
    Atoms(const PackView& pack, const PackWriteOptions& options,
          const std::vector<std::uint64_t>* rows)
        : ids(pack, rows), types(pack), densities(pack, options) {}

    AtomIds ids;
    AtomTypes types;
    AtomDensities densities;
};

/// Bonds of a file: their pairs, each with its type where there are several.
struct BondRows {
    std::vector<Contact> pairs;
    std::vector<std::uint32_t> types;  ///< of each; empty: 1
    std::uint32_t typeCount = 1;
    /// For bond_style bpm/rotational, which takes the length of each bond as it is, so that many
    /// may have the same type.
    bool isBpm = false;
};

BondRows bondRows(const PackView& pack, const BondOptions& options) {
    BondRows rows;
    pack.withPack([&](const auto& own) {
        rows.pairs = bondedPairs(own, options);
        if constexpr (std::is_same_v<decltype(own), const Pack<3>&>) {
            if (options.classes == 1) return;
            for (const Bond& bond : bondsIn(own, options)) rows.types.push_back(bond.number);
            rows.isBpm = options.classes > 0;
            rows.typeCount = rows.isBpm
                                 ? options.classes
                                 : std::max(1u, static_cast<std::uint32_t>(rows.types.size()));
        }
    });
    return rows;
}

/// What the title begins with. @param bonded  bonds have a tolerance of their own.
std::string generatorOf(const PackWriteOptions& options, bool bonded) {
    const std::string text = oneLine(options.generator);
    if (!bonded || text.empty()) return text;
    return generatorWith(
        text.substr(0, text.find(';')),
        {originIn(text).axes, options.bonds.tolerance, options.bonds.interfaceTolerance});
}

/// @param bonds  null: atoms alone.
PackTextRows atomRows(const PackView& pack, const PackWriteOptions& options, const AllAtoms& all,
                      const std::shared_ptr<const Atoms>& atoms, const BondRows* bonds) {
    const bool isBpm = bonds && bonds->isBpm;
    std::string title = generatorOf(options, bonds != nullptr).substr(0, 100);
    if (!title.empty()) title += "; ";
    title += fmt::format("atom_style {}; {}",
                         isBpm   ? "bpm/sphere"
                         : bonds ? kLammpsBonded
                                 : "sphere or granular",
                         atoms->ids.meaning());
    if (const std::string types = atoms->types.meaning(); !types.empty()) title += "; " + types;
    title += fmt::format("{}{}", kLammpsDensity,
                         atoms->densities.areGiven()
                             ? kLammpsGiven
                             : fmt::format("in {}", densityUnit(options.unit).name));
    std::string boundary;
    if (const PeriodicCell<3>& cell = pack.cell(); cell.any()) {
        boundary = kLammpsBoundary;
        for (int d = 0; d < 3; ++d)
            boundary += fmt::format("{}{}", d ? " " : "", cell.isAlong(d) ? 'p' : 'f');
    }
    title = title.substr(0, kTitleLength - 30 - boundary.size()) + boundary +
            fmt::format("; {}{}", kUnitComment, unitName(options.unit));

    PackTextRows rows;
    std::string& header = rows.header;
    header = title + '\n' + partComments(pack.attributes()) + '\n';
    header += fmt::format("{} atoms\n{} atom types\n", all.count, all.types);
    if (bonds)
        header += fmt::format("{} bonds\n{} bond types\n", bonds->pairs.size(), bonds->typeCount);
    header += '\n';
    for (int d = 0; d < 3; ++d) {
        const char axis = "xyz"[d];
        appendNumber(header, all.box.lo[d]);
        appendNumber(header += ' ', all.box.hi[d]);
        header += fmt::format(" {}lo {}hi\n", axis, axis);
    }
    // Without a style after it: LIGGGHTS does not accept `Atoms # sphere` as a section.
    if (all.count > 0)
        header += isBpm   ? "\nAtoms # bpm/sphere\n\n"
                  : bonds ? "\nAtoms # hybrid\n\n"
                          : "\nAtoms\n\n";
    rows.append = [&pack, atoms, isBpm, bonded = bonds && !isBpm](std::string& text,
                                                                  std::size_t i) {
        const auto number = [&text](double v) { appendNumber(text += ' ', v); };
        appendNumber(text, atoms->ids(i));
        if (isBpm) text += " 0";  // of no molecule
        appendNumber(text += ' ', atoms->types(i));
        const auto p = pack.position(i);
        if (bonded)
            for (const double c : p) number(c);
        number(2 * pack.radius(i));
        number(atoms->densities(i));
        if (bonded)
            text += " 0";  // of no molecule
        else
            for (const double c : p) number(c);
        text += '\n';
    };
    return rows;
}

/// @param bonds  null: atoms alone.
void writeAtoms(const PackView& pack, const PackWriteOptions& options, const BondRows* bonds,
                OutputFile& out) {
    const auto atoms = std::make_shared<Atoms>(pack, options, nullptr);
    const PackTextRows rows =
        atomRows(pack, options, {pack.size(), atoms->types.count(), pack.bounds()}, atoms, bonds);
    out.write(rows.header);
    writeRows(out, pack.size(), rows.append);
    if (!bonds || bonds->pairs.empty()) return;
    out.write(std::string("\nBonds\n\n"));
    writeRows(out, bonds->pairs.size(), [&](std::string& text, std::size_t b) {
        appendNumber(text, static_cast<std::int64_t>(b) + 1);
        appendNumber(text += ' ', std::int64_t{bonds->types.empty() ? 1 : bonds->types[b]});
        appendNumber(text += ' ', atoms->ids(bonds->pairs[b].i));
        appendNumber(text += ' ', atoms->ids(bonds->pairs[b].j));
        text += '\n';
    });
}

}  // namespace

AllAtoms allAtoms(const PackView& pack) {
    return {pack.size(), AtomTypes(pack).count(), pack.bounds()};
}

PackTextRows lammpsRows(const PackView& pack, const PackWriteOptions& options, const AllAtoms& all,
                        const std::vector<std::uint64_t>& rows) {
    return atomRows(pack, options, all, std::make_shared<Atoms>(pack, options, &rows), nullptr);
}

void writeLammps(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    writeAtoms(pack, options, nullptr, out);
}

void writeLammpsBonds(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    const BondRows bonds = bondRows(pack, options.bonds);
    writeAtoms(pack, options, &bonds, out);
}

}  // namespace vdbpack
