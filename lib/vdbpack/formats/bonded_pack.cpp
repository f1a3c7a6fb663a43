#include "vdbpack/formats/bonded_pack.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/row_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace vdbpack {

template <int Dim>
std::vector<Contact> bondedPairs(const Pack<Dim>& pack, const BondOptions& options) {
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
    return bondsOf(pack, bondedPairs(pack, options), law);
}

void writeBonds(const Pack<3>& pack, const std::vector<Bond>& bonds, const std::string& file,
                Unit unit) {
    const PackView view(pack, unit);
    const Materials materials(pack);
    const double per = fromMillimeters(1, unit);  // units of length per mm
    OutputFile out(file);
    out.write(
        std::string("i,j,nx,ny,nz,length,arm_i,arm_j,radius,area,modulus,k_n,k_t,k_bending,"
                    "k_torsion,region_i,region_j"));
    out.write(std::string(materials.hasParts() ? ",part_i,part_j\n" : "\n"));
    writeRows(out, bonds.size(), [&](std::string& text, std::size_t row) {
        const Bond& b = bonds[row];
        appendNumber(text, view.id(b.i));
        appendNumber(text += ',', view.id(b.j));
        for (int d = 0; d < 3; ++d) appendNumber(text += ',', b.direction[d]);
        for (const double length : {b.length, b.armI, b.armJ, b.radius})
            appendNumber(text += ',', fromMillimeters(length, unit));
        for (const double value : {b.area() * per * per, b.modulus / (per * per), b.normal / per,
                                   b.tangential / per, b.bending * per, b.torsion * per})
            appendNumber(text += ',', value);
        for (const std::uint32_t end : {b.i, b.j})
            appendNumber(text += ',', std::int64_t{view.region().empty() ? 0 : view.region()[end]});
        if (materials.hasParts())
            for (const std::uint32_t end : {b.i, b.j})
                appendNumber(text += ',', std::int64_t{materials.partOf(end)});
        text += '\n';
    });
    out.commit();
}

}  // namespace vdbpack
