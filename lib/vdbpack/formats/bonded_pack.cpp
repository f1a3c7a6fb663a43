#include "vdbpack/formats/bonded_pack.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_text_rows.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/row_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbpack {

template <int Dim>
std::vector<Contact> bondedPairs(const Pack<Dim>& pack, const BondOptions& options) {
    if (!(options.interfaceTolerance >= 0 && options.interfaceTolerance <= 1))
        throw ParameterError(
            fmt::format("`interfaceTolerance` {}: must be a share of a radius, 0 to 1",
                        options.interfaceTolerance));
    const Materials materials(pack);
    const double across = std::max(options.tolerance, options.interfaceTolerance);
    auto pairs =
        listContacts(pack.spheres, materials.hasParts() ? across : options.tolerance, pack.cell);
    if (!materials.hasParts() || across <= options.tolerance) return pairs;
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                               [&](const Contact& c) {
                                   const double smaller =
                                       std::min(pack.spheres[c.i].radius, pack.spheres[c.j].radius);
                                   return c.gap >= options.tolerance * smaller &&
                                          materials.partOf(c.i) == materials.partOf(c.j);
                               }),
                pairs.end());
    return pairs;
}

template std::vector<Contact> bondedPairs(const Pack<2>&, const BondOptions&);
template std::vector<Contact> bondedPairs(const Pack<3>&, const BondOptions&);

std::vector<Bond> bondsIn(const Pack<3>& pack, const BondOptions& options) {
    BondLaw law = options.law;
    if (const Column* const moduli = columnOfNumbers(pack, kModulusColumn))
        law.moduli = moduli->numbers;
    auto bonds = bondsOf(pack, bondedPairs(pack, options), law);
    if (options.classes == 1 || bonds.empty()) return bonds;
    const auto [least, most] =
        std::minmax_element(bonds.begin(), bonds.end(),
                            [](const Bond& a, const Bond& b) { return a.normal < b.normal; });
    const double low = least->normal, ratio = std::log(most->normal / low);
    for (std::size_t k = 0; k < bonds.size(); ++k) {
        const double share = ratio > 0 ? std::log(bonds[k].normal / low) / ratio : 0;
        bonds[k].number = 1 + (options.classes == 0
                                   ? static_cast<std::uint32_t>(k)
                                   : std::min(static_cast<std::uint32_t>(share * options.classes),
                                              options.classes - 1));
    }
    return bonds;
}

void writeBonds(const Pack<3>& pack, const std::vector<Bond>& bonds, const std::string& file,
                Unit unit) {
    const PackView view(pack, unit);
    const Materials materials(pack);
    const double per = fromMillimeters(1, unit);  // units of length per mm
    OutputFile out(file);
    out.write(
        std::string("i,j,nx,ny,nz,length,arm_i,arm_j,radius,area,modulus,k_n,k_t,k_bending,"
                    "k_torsion,tensile,shear,class,region_i,region_j"));
    out.write(std::string(materials.hasParts() ? ",part_i,part_j\n" : "\n"));
    writeRows(out, bonds.size(), [&](std::string& text, std::size_t row) {
        const Bond& b = bonds[row];
        appendNumber(text, view.id(b.i));
        appendNumber(text += ',', view.id(b.j));
        for (int d = 0; d < 3; ++d) appendNumber(text += ',', b.direction[d]);
        for (const double length : {b.length, b.armI, b.armJ, b.radius})
            appendNumber(text += ',', fromMillimeters(length, unit));
        for (const double value :
             {b.area() * per * per, b.modulus / (per * per), b.normal / per, b.tangential / per,
              b.bending * per, b.torsion * per, b.tensile, b.shear})
            appendNumber(text += ',', value);
        appendNumber(text += ',', std::int64_t{b.number});
        for (const std::uint32_t end : {b.i, b.j})
            appendNumber(text += ',', std::int64_t{view.region().empty() ? 0 : view.region()[end]});
        if (materials.hasParts())
            for (const std::uint32_t end : {b.i, b.j})
                appendNumber(text += ',', std::int64_t{materials.partOf(end)});
        text += '\n';
    });
    out.commit();
}

namespace {

/// A force or moment for LAMMPS at which nothing breaks.
constexpr double kUnbreakable = 1e30;

/// Means of the bonds of a class.
struct BondClass {
    double count = 0, normal = 0, tangential = 0, bending = 0, torsion = 0, tensile = 0, shear = 0;
};

std::vector<BondClass> classesOf(const std::vector<Bond>& bonds, std::size_t count) {
    std::vector<BondClass> classes(count);
    for (const Bond& b : bonds) {
        BondClass& c = classes[b.number - 1];
        const double n = ++c.count;
        const auto add = [n](double& mean, double value) { mean += (value - mean) / n; };
        add(c.normal, b.normal), add(c.tangential, b.tangential), add(c.bending, b.bending);
        add(c.torsion, b.torsion), add(c.tensile, b.tensile), add(c.shear, b.shear);
    }
    return classes;
}

}  // namespace

void checkBondClasses(const std::string& output, const BondOptions& options) {
    if (options.classes == 1)
        throw ParameterError(
            output +
            ": bonds of one class share no stiffness; set `bondClasses` to 0, a class for each "
            "bond, or to a number of classes");
}

void writeBondCoefficients(const std::vector<Bond>& bonds, const BondOptions& options,
                           const std::string& file, Unit unit) {
    checkBondClasses("bond-coeffs:" + file, options);
    const double per = fromMillimeters(1, unit);  // units of length per mm
    const bool strong = options.law.breakingStrain.has_value();
    OutputFile out(file);
    const auto write = [&out](const std::string& text) { out.write(text); };
    if (options.classes == 0) {
        write(
            fmt::format("# after read_data of lammps-bonds; N and {0}: type, k_n / 2, length\n"
                        "bond_style harmonic\n",
                        unitName(unit)));
        writeRows(out, bonds.size(), [&](std::string& text, std::size_t k) {
            appendNumber(text += "bond_coeff ", std::int64_t{bonds[k].number});
            appendNumber(text += ' ', bonds[k].normal / per / 2);
            appendNumber(text += ' ', fromMillimeters(bonds[k].length, unit));
            text += '\n';
        });
        return out.commit();
    }
    write(fmt::format(
        "# for read_data of lammps-bonds; N and {}: type, k_n, k_t, torsion, bending, forces and\n"
        "# moments at which bonds break, four damping coefficients\n"
        "bond_style bpm/rotational smooth no{}\n",
        unitName(unit), strong ? "" : " break no"));
    const auto classes = classesOf(bonds, options.classes);
    for (std::size_t k = 0; k < classes.size(); ++k) {
        const BondClass& c = classes[k];
        write(fmt::format("bond_coeff {} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {} {} 0 0 0 0\n",
                          k + 1, c.normal / per, c.tangential / per, c.torsion * per,
                          c.bending * per, strong ? c.tensile : kUnbreakable,
                          strong ? c.shear : kUnbreakable, kUnbreakable, kUnbreakable));
    }
    out.commit();
}

void writeInterfaces(const std::vector<InterfaceReport>& interfaces, const std::string& file,
                     Unit unit) {
    const double per = fromMillimeters(1, unit);
    OutputFile out(file);
    out.write(
        std::string("part_a,part_b,bonds,area,bonds_per_area,bonds_per_area_a,"
                    "bonds_per_area_b\n"));
    writeRows(out, interfaces.size(), [&](std::string& text, std::size_t row) {
        const InterfaceReport& one = interfaces[row];
        appendCell(text, one.parts[0]);
        appendCell(text += ',', one.parts[1]);
        appendNumber(text += ',', static_cast<std::int64_t>(one.pairs));
        appendNumber(text += ',', one.area * per * per);
        for (const double density : {one.perArea(), one.bulk[0], one.bulk[1]})
            appendNumber(text += ',', density / (per * per));
        text += '\n';
    });
    out.commit();
}

}  // namespace vdbpack
