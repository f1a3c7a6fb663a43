#include "vdbpack/mesh/welding.h"

namespace vdbpack {

Welder::Welder(std::size_t expected) {
    vertices_.reserve(expected);
    std::size_t slots = 64;
    while (slots < 2 * expected) slots *= 2;
    resize(slots);
}

std::uint32_t Welder::find(const Vec<3>& point, std::uint64_t h) {
    if (2 * (vertices_.size() + 1) > slots_.size()) resize(2 * slots_.size());
    const auto hash = static_cast<std::uint32_t>(h);
    for (std::size_t at = hash & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
        Slot& slot = slots_[at];
        if (slot.index == kNone) {
            slot = {static_cast<std::uint32_t>(vertices_.size()), hash};
            vertices_.push_back(point);
            return slot.index;
        }
        if (slot.hash == hash && vertices_[slot.index] == point) return slot.index;
    }
}

/// Indices have 32 bits, so the lower half of a hash places a point in any table.
void Welder::resize(std::size_t slots) {
    std::vector<Slot> before(slots);
    before.swap(slots_);
    for (const Slot& slot : before) {
        if (slot.index == kNone) continue;
        std::size_t at = slot.hash & (slots - 1);
        while (slots_[at].index != kNone) at = (at + 1) & (slots - 1);
        slots_[at] = slot;
    }
}

namespace {

/// Drops vertices that no triangle names.
void dropUnused(TriangleMesh& mesh) {
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
    if (kept == mesh.vertices.size()) return;
    mesh.vertices.resize(kept);
    for (auto& t : mesh.triangles)
        for (auto& v : t) v = newIndex[v];
}

}  // namespace

TriangleMesh welded(TriangleMesh mesh) {
    Welder welder(mesh.vertices.size());
    std::vector<std::uint32_t> newIndex(mesh.vertices.size());
    for (std::size_t v = 0; v < newIndex.size(); ++v) newIndex[v] = welder.add(mesh.vertices[v]);
    if (welder.size() < mesh.vertices.size()) {
        mesh.vertices = welder.takeVertices();
        for (auto& t : mesh.triangles)
            for (auto& v : t) v = newIndex[v];
    }
    dropUnused(mesh);
    return mesh;
}

}  // namespace vdbpack
