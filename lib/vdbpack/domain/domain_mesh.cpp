// The mesh of a domain: read, repaired, its shells chosen.
#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_source.h"
#include "vdbpack/domain/pose.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/repair/mesh_repair.h"

#include <fmt/format.h>

#include <utility>

namespace vdbpack {

namespace {

TriangleMesh scaledMesh(TriangleMesh mesh, double factor) {
    if (factor != 1)
        for (Vec<3>& v : mesh.vertices) v *= factor;
    return mesh;
}

TriangleMesh readOne(const DomainRecipe& recipe, const std::string& file,
                     const Callbacks& callbacks, std::shared_ptr<const RepairReport>& report) {
    MeshReadOptions options;
    options.unit = recipe.unit;
    options.scale = recipe.scale;
    options.space = recipe.space;
    TriangleMesh mesh = recipe.mesh && file == recipe.source
                            ? scaledMesh(*recipe.mesh, recipe.scale * millimetersPer(recipe.unit))
                            : readMesh(file, options, callbacks);
    if (!recipe.repair) return mesh;
    RepairOptions repair = repairOptions(recipe);
    repair.name = file;
    RepairedMesh repaired = repairMesh(std::move(mesh), repair, callbacks);
    const RepairReport& done = repaired.report;
    for (const auto& warning : repairWarnings(done, file)) callbacks.warn(warning);
    report = std::make_shared<const RepairReport>(done);
    return std::move(repaired.mesh);
}

/// A vertex of one mesh that lies on the wrong side of the other, if any.
const Vec<3>* strayVertex(const TriangleMesh& vertices, const TriangleMesh& solid, bool inside) {
    const MeshSides sides(solid, false);
    for (const auto& t : vertices.triangles)
        for (const std::uint32_t v : t)
            if (sides.inside(vertices.vertices[v]) != inside) return &vertices.vertices[v];
    return nullptr;
}

}  // namespace

std::vector<std::string> domainInputs(const DomainRecipe& recipe) {
    return {isInMemory(recipe) ? "" : recipe.source, recipe.cavities.inner, recipe.pose.file};
}

RepairOptions repairOptions(const DomainRecipe& recipe) {
    RepairOptions options;
    options.nested = recipe.cavities.fill ? NestedShells::solid : NestedShells::cavity;
    options.components = recipe.repairComponents;
    options.voxelSize = recipe.repairVoxel;
    options.name = recipe.source;
    return options;
}

namespace {

TriangleMesh joinedMesh(const DomainRecipe& recipe, const Callbacks& callbacks,
                        std::shared_ptr<const RepairReport>& report) {
    const Cavities& cavities = recipe.cavities;
    const std::string& file = recipe.source;
    if (!cavities.outer.empty() && cavities.outer != file)
        throw ParameterError(fmt::format(
            "`cavities` names {} as the outer surface and the domain is {}: give one of the two",
            cavities.outer, file));
    TriangleMesh mesh = readOne(recipe, file, callbacks, report);
    if (cavities.fill) return outermostShells(mesh, analyzeShells(mesh));
    if (cavities.inner.empty()) return mesh;

    std::shared_ptr<const RepairReport> innerReport;
    const TriangleMesh inner = readOne(recipe, cavities.inner, callbacks, innerReport);
    const Vec<3>* stray = strayVertex(inner, mesh, true);
    const bool outside = stray != nullptr;
    if (!stray) stray = strayVertex(mesh, inner, false);
    if (!stray) return joinedAsCavity(mesh, inner);
    if (!recipe.repair)
        throw InputError(fmt::format(
            "{}: protrudes from {}: the {} surface has a point at ({:.6g}, {:.6g}, {:.6g}) {} the "
            "other; set `repair` to subtract the inner volume from the outer one",
            cavities.inner, file, outside ? "inner" : "outer", (*stray)[0], (*stray)[1],
            (*stray)[2], outside ? "outside" : "inside"));
    RepairOptions options;
    options.voxelSize = recipe.repairVoxel;
    options.name = cavities.inner;
    RepairedMesh cut = subtractMesh(mesh, inner, options, callbacks);
    if (report) cut.report.before = report->before;
    report = std::make_shared<const RepairReport>(cut.report);
    return std::move(cut.mesh);
}

}  // namespace

TriangleMesh readDomainMesh(const DomainRecipe& recipe, const Callbacks& callbacks,
                            std::shared_ptr<const RepairReport>& report) {
    TriangleMesh mesh = joinedMesh(recipe, callbacks, report);
    place(mesh, recipe, callbacks);
    return mesh;
}

}  // namespace vdbpack
