#include "vdbpack/core/error.h"
#include "vdbpack/core/version.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/bonded_pack.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/io/text.h"
#include "vdbpack/measure/density.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/preview/result_picture.h"
#include "vdbpack/run/given_solid.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/interfaces.h"
#include "vdbpack/run/run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

const std::string kGenerator = std::string("vdb_pack ") + version();

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

/// Counts the pairs that outputs list, and warns of parts that they hardly join.
void notePairs(const ConvertRecipe& recipe, const Pack<3>& pack, const BondOptions& options,
               ConvertResult& result, const Callbacks& callbacks) {
    warnOfUnusedBonds(recipe, callbacks);
    warnOfUnusedBonds(pack, pack.origin, options, callbacks);
    warnOfModuli(pack, options.law, callbacks);
    warnOfBondLaw(options.law, callbacks);
    if (std::none_of(recipe.outputs.begin(), recipe.outputs.end(),
                     [](const OutputTarget& output) { return output.listsPairs(); }))
        return;
    const auto pairs = bondedPairs(pack, options);
    warnOfTolerance(recipe.pack, pack.origin, options, callbacks);
    warnOfLooseParts(pack, pairs, callbacks);
    result.pairs = pairs.size();
    result.tolerance = options.tolerance;
    result.interfaceTolerance = options.interfaceTolerance;
}

/// Notes the density that files for LAMMPS take where none is known, and the modulus of bonds;
/// warns of what a .csv does not hold.
template <int Dim>
void noteMissing(const ConvertRecipe& recipe, const Pack<Dim>& pack, ConvertResult& result,
                 const Callbacks& callbacks) {
    warnOfDensity(recipe.density, "", callbacks);
    for (const OutputTarget& output : recipe.outputs)
        if (output.kind == OutputKind::pack &&
            (output.extension() == ".csv" || output.extension() == ".xyz") &&
            !partNames(pack).empty())
            callbacks.warn(fmt::format(
                "{}: holds neither the names of the parts ({}) nor axes; .vtp and .vdb keep them",
                output.file, fmt::join(partNames(pack), ", ")));
    warnOfLostOrigin(recipe.outputs, pack.origin, pack.cell.any(), callbacks);
    const bool isStated = columnOfNumbers(pack, kDensityColumn) || columnOfNumbers(pack, "density");
    const auto hasMasses = [](const OutputTarget& output) {
        return output.kind == OutputKind::materials ||
               (output.kind == OutputKind::pack && holdsMasses(output.text));
    };
    if (!isStated && std::any_of(recipe.outputs.begin(), recipe.outputs.end(), hasMasses))
        result.density = kDefaultDensity;
    if (!columnOfNumbers(pack, kModulusColumn) &&
        std::any_of(recipe.outputs.begin(), recipe.outputs.end(),
                    [](const OutputTarget& output) { return output.isOfBonds(); }))
        result.modulus = recipe.bonds.law.modulus;
}

/// Whether all outputs are label maps, which have a place for spheres outside of the domain.
bool takesGridAlone(const ConvertRecipe& recipe) {
    const auto& outputs = recipe.outputs;
    return std::all_of(outputs.begin(), outputs.end(), [](const OutputTarget& output) {
        return output.kind == OutputKind::labels;
    });
}

template <int Dim>
void convertPack(const ConvertRecipe& recipe, Pack<Dim> pack, ConvertResult& result,
                 const Callbacks& callbacks) {
    requireDomain(recipe);
    for (const OutputTarget& output : recipe.outputs) refuseBraces(output.text);
    checkOutputKinds(recipe.outputs, RunKind::convert, {}, Dim);
    checkWithoutDomain(recipe, callbacks);
    RunOutputs<Dim> have;
    have.pack = &pack;
    PackWriteOptions& write = have.options;
    write.unit = recipe.outUnit;
    write.images = recipe.images;
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
        const auto depths = have.domain->signedDistances(centersOf(pack));
        requireSameAxes(recipe.pack, pack.origin, *source);
        const bool fits = takesGridAlone(recipe) ||
                          !warnOfOutside(depths, pack, describe(recipe.domain), callbacks);
        if (fits && source->imageGrid()) pack.origin.axes = axesOf(*source);
    }
    write.generator = generatorWith(kGenerator, pack.origin);
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
    keepDensities(pack, pack.spheres.size(), write.particleDensity, write.materialDensity);
    noteMissing(recipe, pack, result, callbacks);
    if constexpr (Dim == 3) notePairs(recipe, pack, write.bonds, result, callbacks);
    result.files = writeOutputs(recipe.outputs, have, callbacks);
    PreviewOptions preview = recipe.preview;
    preview.space = recipe.domain.space;
    if (drawGiven(preview, recipe.pack, pack, source ? &*source : nullptr, built))
        result.files.push_back(recipe.preview.file);
}

/// Refuses what needs spheres, and a single file of what several parts are in.
void requireNoSpheres(const ConvertRecipe& recipe) {
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

bool isForEach(const std::string& name) {
    return name.find("{part}") != std::string::npos;
}

/// A name with that of a part in place of {part}.
std::string nameFor(const std::string& name, std::string part) {
    std::replace(part.begin(), part.end(), '/', '-');
    return withOption(name, "part", part);
}

/// A mesh, an image, a level set or a shape; of an image several labels.
class SolidConversion {
public:
    SolidConversion(const ConvertRecipe& recipe, ConvertResult& result, const Callbacks& callbacks)
        : recipe_(recipe), result_(result), callbacks_(callbacks) {
        // First, what is wrong with the file: it may hold damaged spheres.
        solids_ = givenSolids(recipe, result.found, callbacks);
        requireNoSpheres(recipe);
        const DomainSource& first = solids_.front().source();
        result.kind = isImage(first.recipe()) ? "image"
                      : first.levelSet()      ? "level set"
                      : first.mesh()          ? "mesh"
                                              : "shape";
        if (first.mesh() && !first.levelSet())
            for (const GivenSolid& solid : solids_)
                result.count += solid.source().mesh()->triangles.size();
        for (const OutputTarget& output : recipe.outputs) {
            refuseBraces(nameFor(output.text, ""));
            if (solids_.size() > 1 && !isForEach(output.text) && output.kind != OutputKind::contour)
                throw ParameterError(fmt::format(
                    "{}: holds one solid, and `label` {} names {} of them; write {{part}} into its "
                    "name for a file each, or join the labels by +",
                    output.text, recipe.domain.label, solids_.size()));
        }
    }

    void write() {
        for (const OutputTarget& output : recipe_.outputs) {
            callbacks_.report("write", 0, 0);
            if (isForEach(output.text))
                for (GivenSolid& solid : solids_)
                    write(OutputTarget(nameFor(output.text, solid.name())), solid);
            else if (solids_.size() == 1)
                write(output, solids_.front());
            else
                writeSurface(output, joinedSurface(solids_));
        }
        const PreviewOptions& preview = recipe_.preview;
        if (preview.file.empty()) return;
        if (!isForEach(preview.file)) return draw(preview.file, joinedSurface(solids_));
        for (GivenSolid& solid : solids_)
            draw(nameFor(preview.file, solid.name()), solid.surface());
    }

private:
    void write(const OutputTarget& output, GivenSolid& solid) {
        if (output.kind == OutputKind::contour) return writeSurface(output, solid.surface());
        RunOutputs<3> have;
        have.options.unit = recipe_.outUnit;
        have.options.generator = kGenerator;
        have.options.levelSets = {solid.levelSet()};
        const auto written = writeOutput(output, have);
        result_.files.insert(result_.files.end(), written.begin(), written.end());
    }
    void writeSurface(const OutputTarget& output, const TriangleMesh& mesh) {
        checkFiles({output}, {}, inputFiles(recipe_));
        writeStl(mesh, output.file, recipe_.outUnit, kGenerator);
        result_.files.push_back(output.file);
    }
    void draw(const std::string& file, const TriangleMesh& mesh) {
        PreviewOptions preview = recipe_.preview;
        preview.file = file;
        preview.space = recipe_.domain.space;
        preview.ofPatient = solids_.front().source().isSided();
        drawGiven(preview, recipe_.pack, mesh);
        result_.files.push_back(file);
    }

    const ConvertRecipe& recipe_;
    ConvertResult& result_;
    const Callbacks& callbacks_;
    std::vector<GivenSolid> solids_;
};

}  // namespace

ConvertResult runConvert(const ConvertRecipe& recipe, const Callbacks& callbacks) {
    if (recipe.outputs.empty() && recipe.preview.file.empty())
        throw ParameterError(
            "there is nothing to write; name a file in `outputs` or `preview.file`");
    checkSettings(recipe, RunKind::convert, {}, inputFiles(recipe));
    ConvertResult result;
    std::vector<std::string> warnings;
    const Callbacks heard = keepingWarnings(withinMemory(callbacks, recipe.memoryLimit), warnings);
    withThreads(recipe.threads, [&] {
        auto pack = packUnlessSolid(recipe, heard);
        if (!pack)
            SolidConversion(recipe, result, heard).write();
        else if (isPlane(*pack))
            convertPack(recipe, asCircles(*pack), result, heard);
        else
            convertPack(recipe, std::move(*pack), result, heard);
    });
    result.warnings = std::move(warnings);
    return result;
}

}  // namespace vdbpack
