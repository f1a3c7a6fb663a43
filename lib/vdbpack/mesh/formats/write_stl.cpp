#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/row_writer.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/triangle_crossing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

namespace vdbpack {

namespace {

/// A direction that leads out of all triangles at a vertex, about as fast out of each, where there
/// is one (perceptron of Rosenblatt 1958, doi:10.1037/h0042519, from the mean of the normals).
template <class Normals>
Vec<3> outwardOf(const Normals& begin, const Normals& end) {
    constexpr int kSteps = 64;
    constexpr double kFast = 0.2, kTurn = 0.3;
    Vec<3> way = normalized(std::accumulate(begin, end, Vec<3>{}));
    for (int step = 0; step < kSteps; ++step) {
        const auto slowest = std::min_element(begin, end, [&](const Vec<3>& a, const Vec<3>& b) {
            return dot(way, a) < dot(way, b);
        });
        if (slowest == end || dot(way, *slowest) > kFast) break;
        way = normalized(way + *slowest * kTurn);
    }
    return way;
}

}  // namespace

TriangleMesh roundedOutward(TriangleMesh mesh, Unit unit) {
    const ShellAnalysis analysis = analyzeShells(mesh);
    // Lists of triangles at each vertex: the list of vertex v begins at first[v].
    std::vector<std::size_t> first(mesh.vertices.size() + 1, 0);
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t v : t) ++first[v + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Vec<3>> normals(first.back());
    auto next = first;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto c = cornersOf(mesh, mesh.triangles[i]);
        const Shell& shell = analysis.shells[analysis.shellOfTriangle[i]];
        const bool isOutward = (shell.signedVolume > 0) == (shell.depth % 2 == 0);
        const Vec<3> normal = normalized(cross(c[1] - c[0], c[2] - c[0])) * (isOutward ? 1. : -1.);
        for (const std::uint32_t v : mesh.triangles[i]) normals[next[v]++] = normal;
    }
    forAll(mesh.vertices.size(), [&](std::size_t v) {
        const Vec<3> x = mesh.vertices[v];
        const auto begin = normals.begin() + static_cast<std::ptrdiff_t>(first[v]);
        const auto end = normals.begin() + static_cast<std::ptrdiff_t>(first[v + 1]);
        const Vec<3> middle = outwardOf(begin, end);
        const double largest = std::max({std::fabs(x[0]), std::fabs(x[1]), std::fabs(x[2])});
        const double step = largest * std::numeric_limits<float>::epsilon() / 4;
        double best = -std::numeric_limits<double>::infinity();
        /// Takes a place rounded if that lies farther out of the innermost triangle than the last.
        const auto tryAt = [&](Vec<3> out) {
            for (double& c : out.c)
                c = static_cast<double>(static_cast<float>(fromMillimeters(c, unit))) *
                    millimetersPer(unit);
            double inmost = std::numeric_limits<double>::infinity();
            for (auto normal = begin; normal != end; ++normal)
                inmost = std::min(inmost, dot(out - x, *normal));
            if (inmost > best) {
                best = inmost;
                mesh.vertices[v] = out;
            }
            return inmost >= 0;
        };
        // Farther out until no triangle is crossed; at a saddle too sharp for that, to the place
        // around that crosses least.
        for (int k = 0; k < 32; ++k)
            if (tryAt(x + middle * (k * step))) return;
        constexpr int kAround = 11;
        for (int k = 0; k < kAround * kAround * kAround; ++k) {
            const auto offset = [](int n) { return 4.0 * (n % kAround - kAround / 2); };
            const Vec<3> around{{offset(k), offset(k / kAround), offset(k / (kAround * kAround))}};
            if (tryAt(x + around * step)) return;
        }
    });
    return mesh;
}

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
