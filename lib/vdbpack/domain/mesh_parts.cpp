#include "vdbpack/domain/mesh_parts.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/pose.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/welding.h"

#include <fmt/format.h>

#include <map>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::size_t kMostParts = 100;

/// The triangles by the names that they have in their file, in its order.
std::vector<NamedMesh> groupsOf(const TriangleMesh& mesh, const MeshGroups& names) {
    std::vector<NamedMesh> parts;
    std::map<std::string, std::size_t> known;
    std::size_t next = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        while (next < names.size() && names[next].second <= t) ++next;
        const std::string& name = names[next > 0 ? next - 1 : 0].first;
        const std::size_t part = known.emplace(name, parts.size()).first->second;
        if (part == parts.size()) parts.push_back({name, {}});
        parts[part].mesh.triangles.push_back(mesh.triangles[t]);
    }
    return parts;
}

/// The connected components, by decreasing volume.
std::vector<NamedMesh> componentsOf(const TriangleMesh& mesh, const std::string& file) {
    const ShellAnalysis analysis = analyzeShells(mesh);
    std::vector<NamedMesh> parts;
    for (const Shell& shell : analysis.shells) {
        if (shell.depth > 0)
            throw InputError(
                file +
                ": a component lies inside another one; give the parts by names (`partsBy` "
                "group), or as files in `parts`");
        parts.push_back({fmt::format("component {}", parts.size()), {}});
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        parts[analysis.shellOfTriangle[t]].mesh.triangles.push_back(mesh.triangles[t]);
    return parts;
}

}  // namespace

std::vector<NamedMesh> meshParts(const DomainRecipe& domain, const Callbacks& callbacks) {
    if (isImage(domain))
        throw ParameterError(
            "`partsBy` is for meshes; parts of an image are its labels (`label` all)");
    MeshReadOptions read;
    read.unit = domain.unit;
    read.scale = domain.scale;
    read.space = domain.space;
    MeshGroups names;
    TriangleMesh mesh = readMesh(domain.source, read, callbacks, &names);
    place(mesh, domain, callbacks);
    std::vector<NamedMesh> parts;
    if (domain.partsBy == PartsBy::component)
        parts = componentsOf(mesh, domain.source);
    else if (!names.empty())
        parts = groupsOf(mesh, names);
    if (parts.size() < 2 || parts.size() > kMostParts)
        throw InputError(fmt::format(
            "{}: has {} parts; 2 to {} are packed. `partsBy` group takes `solid` of an ASCII .stl, "
            "`o` and `g` of an .obj, and component takes surfaces that do not touch",
            domain.source, parts.size(), kMostParts));
    for (NamedMesh& part : parts) {
        part.mesh.vertices = mesh.vertices;  // `welded` drops those that are not used
        part.mesh = welded(std::move(part.mesh));
    }
    return parts;
}

}  // namespace vdbpack
