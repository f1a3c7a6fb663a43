#include "vdbpack/run/run_mesh.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/write_stl.h"
#include "vdbpack/run/outputs.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace vdbpack {

MeshResult runMesh(const MeshRecipe& recipe, const Callbacks& caller) {
    for (const auto& output : recipe.outputs)
        if (extensionOf(output) != ".stl")
            throw ParameterError(output + ": surfaces are written as STL; name it .stl");
    checkFiles(recipe.outputs, {}, domainInputs(recipe.domain));
    const Callbacks callbacks = withinMemory(caller, recipe.memoryLimit);
    MeshResult result;
    withThreads(recipe.threads, [&] {
        std::shared_ptr<const RepairReport> repair;
        const TriangleMesh mesh = readDomainMesh(recipe.domain, callbacks, repair);
        result.health = checkMesh(mesh);
        if (repair) result.repair = *repair;
        for (const auto& output : recipe.outputs) {
            writeStl(mesh, output, Unit::millimeter, "vdb_pack " VDBPACK_VERSION);
            result.files.push_back(output);
        }
    });
    return result;
}

nlohmann::json toJson(const MeshResult& result) {
    nlohmann::json json = toJson(result.health);
    if (result.repair) json["repair"] = toJson(*result.repair);
    if (!result.files.empty()) json["files"] = result.files;
    return json;
}

std::string summary(const MeshResult& result) {
    const auto row = [](const char* name, const std::string& value) {
        return fmt::format("{:<22}{}\n", name, value);
    };
    std::string text;
    if (result.repair) {
        const RepairReport& r = *result.repair;
        text += toText(r.before) + "\n" + row("repair", describe(r));
        if (r.changes && r.changes->before != r.changes->after)
            text += row("before and after", describe(*r.changes));
        text += row("ambiguous volume",
                    fmt::format("{:.4g} mm³, {:.2g} % of the repaired volume", r.doubtfulVolume,
                                100 * r.doubtfulVolume / r.volume));
        if (r.overlapVolume > 0)
            text += row("overlapping volume",
                        fmt::format("{:.4g} mm³, enclosed more than once", r.overlapVolume));
        if (r.invertedVolume > 0)
            text += row("inverted volume",
                        fmt::format("{:.4g} mm³, treated as outside", r.invertedVolume));
        text += "\nrepaired mesh\n";
    }
    text += toText(result.health);
    for (const auto& file : result.files) text += row("written", file);
    return text;
}

}  // namespace vdbpack
