#include "vdbpack/core/error.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/row_writer.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/mesh_io.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace vdbpack {

void writeStl(const TriangleMesh& mesh, const std::string& file, Unit unit,
              const std::string& generator) {
    constexpr std::size_t kHeader = 80;
    if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max())
        throw ParameterError(
            fmt::format("{}: {} triangles are more than the format counts; take larger voxels",
                        file, mesh.triangles.size()));
    for (const auto& v : mesh.vertices)
        for (int d = 0; d < 3; ++d)
            if (!(std::abs(v[d]) < 1e30))
                throw ParameterError(file + ": a vertex is not finite; correct the mesh");
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t v : t)
            if (v >= mesh.vertices.size())
                throw ParameterError(
                    fmt::format("{}: a triangle names vertex {} of {}; correct the mesh", file, v,
                                mesh.vertices.size()));
    // Readers take "solid" at the beginning for the text format.
    std::string header =
        fmt::format("binary; {}{}; {}", kUnitComment, unitName(unit), oneLine(generator));
    header.resize(kHeader, ' ');

    appendLittleEndian(header, static_cast<std::uint32_t>(mesh.triangles.size()));
    OutputFile out(file);
    out.write(header);
    writeRows(out, mesh.triangles.size(), [&](std::string& bytes, std::size_t i) {
        const auto& t = mesh.triangles[i];
        const Vec<3>&a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        const Vec<3> normal = normalized(cross(b - a, c - a));
        for (int d = 0; d < 3; ++d) appendLittleEndian(bytes, static_cast<float>(normal[d]));
        for (const Vec<3>* v : {&a, &b, &c})
            for (int d = 0; d < 3; ++d)
                appendLittleEndian(bytes, static_cast<float>(fromMillimeters((*v)[d], unit)));
        appendLittleEndian(bytes, std::uint16_t{0});
    });
    out.commit();
}

}  // namespace vdbpack
