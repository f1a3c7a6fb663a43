#include "vdbpack/mesh/welding.h"

#include <algorithm>

namespace vdbpack {

std::uint32_t Welder::find(const Vec<3>& point, std::uint64_t h) {
    if (2 * (vertices_.size() + 1) > slots_.size()) grow();
    for (std::size_t slot = h & (slots_.size() - 1);; slot = (slot + 1) & (slots_.size() - 1)) {
        const std::uint32_t at = slots_[slot];
        if (at == kNone) {
            const auto index = static_cast<std::uint32_t>(vertices_.size());
            vertices_.push_back(point);
            slots_[slot] = index;
            return index;
        }
        if (vertices_[at] == point) return at;
    }
}

void Welder::grow() {
    slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), kNone);
    for (std::uint32_t i = 0; i < vertices_.size(); ++i) {
        std::size_t slot = hash(vertices_[i]) & (slots_.size() - 1);
        while (slots_[slot] != kNone) slot = (slot + 1) & (slots_.size() - 1);
        slots_[slot] = i;
    }
}

namespace {

/// Drops vertices that no triangle names. @return their number.
std::size_t dropUnused(TriangleMesh& mesh) {
    constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> newIndex(mesh.vertices.size(), kUnused);
    for (const auto& t : mesh.triangles)
        for (const auto v : t) newIndex[v] = 0;
    std::uint32_t kept = 0;
    for (std::size_t v = 0; v < newIndex.size(); ++v) {
        if (newIndex[v] == kUnused) continue;
        mesh.vertices[kept] = mesh.vertices[v];
        newIndex[v] = kept++;
    }
    const std::size_t dropped = mesh.vertices.size() - kept;
    if (dropped == 0) return 0;
    mesh.vertices.resize(kept);
    for (auto& t : mesh.triangles)
        for (auto& v : t) v = newIndex[v];
    return dropped;
}

}  // namespace

TriangleMesh welded(TriangleMesh mesh, WeldingCounts* counts) {
    std::size_t merged = 0;
    {
        Welder welder;
        std::vector<std::uint32_t> newIndex(mesh.vertices.size());
        for (std::size_t v = 0; v < newIndex.size(); ++v)
            newIndex[v] = welder.add(mesh.vertices[v]);
        merged = mesh.vertices.size() - welder.size();
        if (merged > 0) {
            mesh.vertices = welder.takeVertices();
            for (auto& t : mesh.triangles)
                for (auto& v : t) v = newIndex[v];
        }
    }
    const std::size_t unused = dropUnused(mesh);
    if (counts != nullptr) *counts = {merged, unused};
    return mesh;
}

}  // namespace vdbpack
