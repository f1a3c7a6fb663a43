#include "vdbpack/formats/material_file.h"

#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_text_rows.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/output_file.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

/// Sums over the spheres of a material.
struct Sums {
    std::int64_t spheres = 0;
    double volume = 0, density = 0, modulus = 0;
};

}  // namespace

template <int Dim>
void writeMaterials(const Pack<Dim>& pack, const std::string& file,
                    const PackWriteOptions& options) {
    const Materials materials(pack);
    const SphereDensities densities(pack, options.particleDensity, options.materialDensity);
    const Column* modulus = columnOfNumbers(pack, kModulusColumn);
    std::map<std::int32_t, Sums> all;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        Sums& sums = all[materials.of(i)];
        const double volume = std::pow(pack.spheres[i].radius, Dim);
        ++sums.spheres;
        sums.volume += volume;
        sums.density += volume * densities.of(i);
        if (modulus) sums.modulus += volume * modulus->numbers[i];
    }
    // Rows can be counted: a number that does not occur has one as well.
    constexpr std::int32_t kMostRows = 1'000'000;
    if (!all.empty() && all.rbegin()->first < kMostRows)
        for (std::int32_t m = all.rbegin()->first; m-- > 0;) all[m];
    std::string text = "material,part,region,density_class,spheres,density_kg_m3";
    const std::vector<std::string>& names = partNames(pack);
    text += modulus ? ",modulus_MPa" : "";
    text += names.empty() ? "\n" : ",part_name\n";
    for (const auto& [material, sums] : all) {
        const Materials::Kind kind = materials.kindOf(material);
        appendNumber(text, std::int64_t{material});
        for (const std::int32_t n : {kind.part, kind.region, kind.densityClass})
            appendNumber(text += ',', std::int64_t{n});
        appendNumber(text += ',', sums.spheres);
        text += ',';
        const bool any = sums.spheres > 0;
        // Means, without what sums are rounded by.
        if (!densities.unconverted())
            text += fmt::format("{:.9g}", any ? sums.density / sums.volume : densities.of(kind));
        if (modulus) text += fmt::format(",{:.9g}", any ? sums.modulus / sums.volume : 0.0);
        const auto part = static_cast<std::size_t>(kind.part);
        if (!names.empty()) appendCell(text += ',', part < names.size() ? names[part] : "");
        text += '\n';
    }
    OutputFile out(file);
    out.write(text);
    out.commit();
}

template void writeMaterials<2>(const Pack<2>&, const std::string&, const PackWriteOptions&);
template void writeMaterials<3>(const Pack<3>&, const std::string&, const PackWriteOptions&);

}  // namespace vdbpack
