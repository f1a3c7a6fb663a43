#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_view.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/row_writer.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vdbpack {

template <int Dim>
void writeContacts(const Pack<Dim>& pack, const std::vector<Contact>& contacts,
                   const std::string& file, Unit unit) {
    const std::size_t n = pack.spheres.size();
    if ((!pack.id.empty() && pack.id.size() != n) ||
        (!pack.region.empty() && pack.region.size() != n))
        throw ParameterError(
            fmt::format("{}: pack has {} ids and {} regions for {} {}; give one each, or none",
                        file, pack.id.size(), pack.region.size(), n, Measure<Dim>::kSpheres));
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        const Contact& contact = contacts[c];
        if (contact.i >= n || contact.j >= n || contact.i == contact.j ||
            !std::isfinite(contact.gap))
            throw ParameterError(fmt::format(
                "{}: contact {} joins {} and {} over a gap of {} mm in a pack of {} {}; list the "
                "contacts of this pack",
                file, c, contact.i, contact.j, contact.gap, n, Measure<Dim>::kSpheres));
    }
    const PackView view(pack, unit);
    const Materials materials(pack);
    OutputFile out(file);
    out.write(std::string("i,j,gap,nx,ny,nz,region_i,region_j"));
    out.write(std::string(materials.hasParts() ? ",part_i,part_j\n" : "\n"));
    writeRows(out, contacts.size(), [&](std::string& text, std::size_t row) {
        const Contact& contact = contacts[row];
        appendNumber(text, view.id(contact.i));
        appendNumber(text += ',', view.id(contact.j));
        appendNumber(text += ',', fromMillimeters(contact.gap, unit));
        const auto normal = normalized(
            pack.cell.nearest(pack.spheres[contact.j].center - pack.spheres[contact.i].center));
        for (int d = 0; d < 3; ++d) appendNumber(text += ',', d < Dim ? normal[d] : 0.0);
        for (const std::uint32_t end : {contact.i, contact.j})
            appendNumber(text += ',', std::int64_t{view.region().empty() ? 0 : view.region()[end]});
        if (materials.hasParts())
            for (const std::uint32_t end : {contact.i, contact.j})
                appendNumber(text += ',', std::int64_t{materials.partOf(end)});
        text += '\n';
    });
    out.commit();
}

template void writeContacts<2>(const Pack<2>&, const std::vector<Contact>&, const std::string&,
                               Unit);
template void writeContacts<3>(const Pack<3>&, const std::vector<Contact>&, const std::string&,
                               Unit);

}  // namespace vdbpack
