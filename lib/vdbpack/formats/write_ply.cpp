// Stanford polygon files with vertices only, binary.
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/row_writer.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <string>

namespace vdbpack {

void writePly(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    bool ids = true;
    for (std::size_t i = 0; i < pack.size() && ids; ++i)
        ids = pack.id(i) >= std::numeric_limits<std::int32_t>::min() &&
              pack.id(i) <= std::numeric_limits<std::int32_t>::max();
    // Positions rounded to 32 bits would make spheres overlap, the more the farther they are from
    // the origin. Radii have 32 bits, as some viewers require, unless that would change them.
    bool narrow = true;
    for (std::size_t i = 0; i < pack.size() && narrow; ++i)
        narrow = static_cast<double>(static_cast<float>(pack.radius(i))) == pack.radius(i);
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    header += fmt::format("comment {}{}\n", kUnitComment, unitName(options.unit));
    if (!options.generator.empty())
        header += fmt::format("comment {}: {}\n", kGeneratorKey, oneLine(options.generator));
    header += fmt::format("element vertex {}\n", pack.size());
    header += "property double x\nproperty double y\nproperty double z\n";
    header += fmt::format("property {} radius\n", narrow ? "float" : "double");
    // The format has no whole numbers beyond 32 bits: ids that do not fit are left out.
    if (ids) header += "property int id\n";
    header += "end_header\n";
    out.write(header);

    writeRows(out, pack.size(), [&pack, ids, narrow](std::string& text, std::size_t i) {
        for (const double c : pack.position(i)) appendLittleEndian(text, c);
        if (narrow)
            appendLittleEndian(text, static_cast<float>(pack.radius(i)));
        else
            appendLittleEndian(text, pack.radius(i));
        if (ids) appendLittleEndian(text, static_cast<std::int32_t>(pack.id(i)));
    });
}

}  // namespace vdbpack
