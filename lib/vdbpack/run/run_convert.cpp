#include "vdbpack/core/error.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/io/text.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/solid_stage.h"

#include <optional>
#include <utility>

namespace vdbpack {

namespace {

/// Refuses outputs for which spheres without a domain have nothing.
void checkWithoutDomain(const ConvertRecipe& recipe, const Callbacks& callbacks) {
    if (!recipe.domain.source.empty()) return;
    for (const OutputTarget& output : recipe.outputs)
        if (output.isSolid() && (output.file != output.text || output.extension() == ".stl"))
            throw ParameterError(output.text +
                                 ": spheres alone have no surface; set their `domain`, or name "
                                 "a level set of a .vdb with `packGrid`");
    for (const OutputTarget& output : recipe.outputs) {
        if (output.extension() != ".vdb" || output.file != output.text) continue;
        if (holdsLevelSet(output.file))
            throw ParameterError(output.text +
                                 ": holds level sets, which the spheres alone would replace; "
                                 "write to another file, or set `domain`");
        if (extensionOf(recipe.pack) == ".vdb" && holdsLevelSet(recipe.pack))
            callbacks.warn(output.text + ": gets the spheres of " + recipe.pack +
                           ", not its level sets; set `domain` for that of the domain");
    }
}

template <int Dim>
void convertPack(const ConvertRecipe& recipe, Pack<Dim> pack, ConvertResult& result,
                 const Callbacks& callbacks) {
    checkOutputKinds(recipe.outputs, RunKind::convert, {}, Dim);
    checkWithoutDomain(recipe, callbacks);
    RunOutputs<Dim> have;
    have.pack = &pack;
    PackWriteOptions& write = have.options;
    write.unit = recipe.outUnit;
    write.images = recipe.images;
    write.generator = std::string("vdb_pack ") + VDBPACK_VERSION;
    write.bonds = bondOptionsOf(recipe);
    const RadiusStatistics radius = radiusStatistics(pack.spheres);
    const auto source = domainAround(recipe.domain, Dim, callbacks);
    const auto built =
        buildAround(source, Dim, radius, pack.spheres.size(), radius.max, recipe, callbacks);
    std::optional<double> solid;
    if (source) {
        have.domain = ofDim<Dim>(built).get();
        if (have.domain->cell().any()) pack.cell = have.domain->cell();
        if (built.mesh) {
            write.levelSets = {built.mesh->grid()};
            have.wall = &built.mesh->wall();
        }
        if constexpr (Dim == 2) write.frame = have.domain->bounds();
        solid = solidFraction(pack.spheres, *have.domain);
    }
    if constexpr (Dim == 3) {
        std::vector<const DomainSource*> sources;
        if (source) {
            sources.push_back(&*source);
            have.labels.solids.push_back(solidTest(built.space));
        }
        warnOfUnusedSpacing(recipe.outputs, sources, callbacks);
        have.labels.grid = labelGridOf(recipe.outputs, sources, recipe.memoryLimit);
        have.labels.space = recipe.domain.space;
    }
    callbacks.stopIfCancelled();
    const SphereDensity density = particleDensity(recipe.density, solid);
    write.particleDensity = density.all;
    write.materialDensity = density.ofRegions;
    result.kind = Measure<Dim>::kSpheres;
    result.count = pack.spheres.size();
    result.hash = packHash(pack);
    addGreyValues(recipe.grey, recipe.domain, {}, pack, callbacks);
    result.files = writeOutputs(recipe.outputs, have, callbacks);
    PreviewOptions preview = recipe.preview;
    preview.space = recipe.domain.space;
    if (drawGiven(preview, recipe.pack, pack, source ? &*source : nullptr, built))
        result.files.push_back(recipe.preview.file);
}

/// The solid as a level set; a mesh in voxels as requested, else as many as are usual.
std::shared_ptr<const VdbGrid> levelSetOf(const ConvertRecipe& recipe, bool isMesh,
                                          const Callbacks& callbacks) {
    if (!isMesh) return levelSetGrid(recipe.pack, recipe.packGrid, 1, recipe.packUnit);
    DomainRecipe solid;
    solid.source = recipe.pack;
    solid.unit = recipe.packUnit;
    solid.space = recipe.domain.space;
    double voxel = recipe.domain.voxelSize;
    return fieldOfMesh(std::move(solid), 0, recipe, voxel, callbacks)->grid();
}

/// Refuses what needs spheres.
void requireNoSpheres(const ConvertRecipe& recipe) {
    if (!recipe.domain.source.empty())
        throw ParameterError("`domain` " + recipe.domain.source + ": goes with a pack, and " +
                             recipe.pack + " is a solid; leave it out");
    if (!recipe.grey.empty())
        throw ParameterError("`samples` are taken over spheres, and " + recipe.pack +
                             " holds none; leave them out");
    if (!recipe.density.empty())
        throw ParameterError("`density` is that of spheres, and " + recipe.pack +
                             " holds none; leave it out");
    for (const OutputTarget& output : recipe.outputs)
        if (!output.isSolid())
            throw ParameterError(output.text + ": holds spheres, and " + recipe.pack +
                                 " has none; write .stl, .vdb or fog:FILE.vdb");
}

/// A level set or a mesh.
void convertSolid(const ConvertRecipe& recipe, ConvertResult& result, const Callbacks& callbacks) {
    const std::string generator = std::string("vdb_pack ") + VDBPACK_VERSION;
    RunOutputs<3> have;
    have.options.unit = recipe.outUnit;
    have.options.generator = generator;
    const bool isMesh = extensionOf(recipe.pack) != ".vdb";
    std::optional<TriangleMesh> mesh;
    result.kind = isMesh ? "mesh" : "level set";
    if (isMesh) {
        MeshReadOptions read;
        read.unit = recipe.packUnit;
        read.space = recipe.domain.space;
        mesh = readMesh(recipe.pack, read, callbacks);
        result.count = mesh->triangles.size();
    }
    requireNoSpheres(recipe);
    for (const OutputTarget& output : recipe.outputs) {
        callbacks.report("write", 0, 0);
        // A mesh needs no detour over voxels.
        if (isMesh && output.extension() == ".stl") {
            writeStl(*mesh, output.file, recipe.outUnit, generator);
            result.files.push_back(output.file);
            continue;
        }
        if (have.options.levelSets.empty())
            have.options.levelSets = {levelSetOf(recipe, isMesh, callbacks)};
        const auto written = writeOutput(output, have);
        result.files.insert(result.files.end(), written.begin(), written.end());
    }
    if (recipe.preview.file.empty()) return;
    if (!isMesh) mesh = levelSetMesh(*levelSetOf(recipe, isMesh, callbacks), recipe.pack);
    PreviewOptions preview = recipe.preview;
    preview.space = recipe.domain.space;
    drawGiven(preview, recipe.pack, *mesh);
    result.files.push_back(recipe.preview.file);
}

}  // namespace

ConvertResult runConvert(const ConvertRecipe& recipe, const Callbacks& callbacks) {
    if (recipe.outputs.empty() && recipe.preview.file.empty())
        throw ParameterError(
            "there is nothing to write; name a file in `outputs` or `preview.file`");
    requireDomain(recipe);
    checkSettings(recipe, RunKind::convert, {}, inputFiles(recipe));
    ConvertResult result;
    std::vector<std::string> warnings;
    const Callbacks heard = keepingWarnings(withinMemory(callbacks, recipe.memoryLimit), warnings);
    withThreads(recipe.threads, [&] {
        auto pack = readInputPackUnlessSolid(recipe, heard);
        if (!pack)
            convertSolid(recipe, result, heard);
        else if (isPlane(*pack))
            convertPack(recipe, asCircles(*pack), result, heard);
        else
            convertPack(recipe, std::move(*pack), result, heard);
    });
    result.warnings = std::move(warnings);
    return result;
}

}  // namespace vdbpack
