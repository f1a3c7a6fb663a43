#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/version.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_axes.h"
#include "vdbpack/run/run.h"

namespace vdbpack {

MeshResult runMesh(const MeshRecipe& recipe, const Callbacks& caller) {
    for (const OutputTarget& output : recipe.outputs)
        if (output.extension() != ".stl")
            throw ParameterError(output.text + ": surfaces are written as STL; name it .stl");
    checkFiles(recipe.outputs, {}, domainInputs(recipe.domain));
    const Callbacks callbacks = withinMemory(caller, recipe.memoryLimit);
    MeshResult result;
    result.source = recipe.domain.source;
    withThreads(recipe.threads, [&] {
        std::shared_ptr<const RepairReport> repair;
        result.mesh = readDomainMesh(recipe.domain, callbacks, repair);
        const TriangleMesh& mesh = result.mesh;
        const MeshAnalysis analysis = analyzeMesh(mesh);
        result.health = analysis.health;
        if (const auto axes = principalAxes(mesh, analysis))
            result.axes = std::make_shared<const PrincipalAxes<3>>(*axes);
        if (repair) result.repair = *repair;
        const DomainRecipe& domain = recipe.domain;
        result.fitness = repair ? fitnessOf(mesh, *repair, domain, callbacks)
                                : fitnessOf(mesh, result.health, domain, callbacks);
        for (const OutputTarget& output : recipe.outputs) {
            writeStl(mesh, output.file, Unit::millimeter, std::string("vdb_pack ") + version());
            result.files.push_back(output.file);
        }
    });
    using Verdict = MeshFitness::Verdict;
    const Verdict verdict = result.fitness.verdict;
    result.passed = !recipe.check || verdict == Verdict::yes ||
                    (verdict == Verdict::withRepair && result.repair);
    return result;
}

}  // namespace vdbpack
