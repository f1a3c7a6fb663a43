#include "vdbpack/formats/outputs.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/bonded_pack.h"
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/material_file.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/pack_parts.h"
#include "vdbpack/formats/pack_target.h"
#include "vdbpack/formats/run_surface.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/formats/with_images.h"
#include "vdbpack/formats/write_blender.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/voids/void_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// The .vdb among some outputs that level sets are to be found in; empty: none.
std::string volumeAmong(const std::vector<OutputTarget>& outputs) {
    for (const OutputTarget& output : outputs)
        if (output.kind == OutputKind::pack && output.isSolid()) return output.file;
    return {};
}

void checkVoidsToList(const std::string& output, const VoidRecipe& recipe) {
    if (recipe.empty())
        throw ParameterError(output + ": lists voids, but no voids are requested; add `voids`");
    if (recipe.as<Thinning>())
        throw ParameterError(fmt::format(
            "{}: `voids` {} removes spheres and has no voids to list; leave the output out", output,
            nameOf(recipe)));
}

/// Whether two names are those of one file, which need not exist: by another path, by symbolic
/// links, or by hard links.
bool isSame(const std::string& a, const std::string& b) {
    namespace fs = std::filesystem;
    std::error_code failed;
    if (a == b || fs::equivalent(a, b, failed)) return true;
    const auto place = [&](const std::string& name) {
        const fs::path target = followLinks(name);
        const fs::path folder =
            fs::canonical(target.has_parent_path() ? target.parent_path() : fs::path("."), failed);
        return failed ? target : folder / target.filename();
    };
    return place(a) == place(b);
}

/// A pack, in formats that hold it with what voids leave, or else with the wall of a mesh.
template <int Dim>
void writePackAndSurface(const std::string& output, const RunOutputs<Dim>& have) {
    PackWriteOptions options = have.options;
    TriangleMesh contour;
    if (Dim == 3 && holdsSurface(output)) {
        options.surface = have.wall;
        options.surfaceName = kSurface;
        for (const auto& set : options.levelSets) {
            if (!set || levelSetName(*set) != kSolid) continue;
            constexpr double kAdaptivity = 0.05;  // a third of the triangles, which look the same
            contour = levelSetMesh(*set, output, kAdaptivity);
            options.surface = &contour;
            options.surfaceName = kSolid;
        }
    }
    writePack(*have.pack, output, options);
}

template <int Dim>
void writeContour(const OutputTarget& target, const RunOutputs<Dim>& have) {
    const auto& levelSets = have.options.levelSets;
    const bool cut = std::any_of(levelSets.begin(), levelSets.end(), [](const auto& set) {
        return set && levelSetName(*set) == kSolid;
    });
    const bool wall = have.wall && (target.grid == kSurface || (target.grid.empty() && !cut));
    TriangleMesh contour;
    if (!wall) contour = contourOf(target, have);
    // Spheres that touch the wall lie within the wall of the file; the contour of a shape lies
    // within its walls anyway.
    writeStl(wall                ? roundedOutward(*have.wall, have.options.unit)
             : levelSets.empty() ? contour
                                 : roundedOutward(std::move(contour), have.options.unit),
             target.file, have.options.unit, have.options.generator);
}

bool isOfLammps(PackFormat format) {
    return format == PackFormat::lammpsData || format == PackFormat::lammpsBonds;
}

/// Ids of a .ply and of atoms have 32 bits; where one does not fit, the file has none.
template <int Dim>
void warnOfIds(const OutputTarget& target, const Pack<Dim>& pack, const Callbacks& callbacks) {
    if (target.kind != OutputKind::pack) return;
    const bool atoms = isOfLammps(targetToWrite(target.text, Dim).format);
    if (!atoms && target.extension() != ".ply") return;
    const auto wide = std::find_if(pack.id.begin(), pack.id.end(), [](std::int64_t id) {
        return id < std::numeric_limits<std::int32_t>::min() ||
               id > std::numeric_limits<std::int32_t>::max();
    });
    if (wide != pack.id.end())
        callbacks.warn(fmt::format(
            "{}: ids are left out{}, as {} does not fit into the 32 bits that {} for one; "
            ".csv, .vtp and .vdb keep them",
            target.file, atoms ? " and atoms counted from 1" : "", *wide,
            atoms ? "LAMMPS has" : ".ply has"));
}

/// Files for YADE and LAMMPS have materials alone besides spheres, a .vtkhdf numbers alone, and a
/// .ply nothing.
template <int Dim>
void warnOfColumns(const OutputTarget& target, const Pack<Dim>& pack, const Callbacks& callbacks) {
    if (target.kind != OutputKind::pack) return;
    using Names = std::vector<std::string>;
    static const Names materials{"region",     kPartColumn,    kDensityColumn,
                                 kClassColumn, kModulusColumn, "density",
                                 "type",       "matId",        "existing"};
    static const Names clumps{kYadeClump, "existing"}, none;
    const PackFormat format = targetToWrite(target.text, Dim).format;
    const bool ofPrograms = format == PackFormat::yade || isOfLammps(format);
    const bool numbers = format == PackFormat::vtkhdf, ply = target.extension() == ".ply";
    if (!ofPrograms && !numbers && !ply && format != PackFormat::spherePack) return;
    const Names& kept = ofPrograms ? materials : ply ? none : clumps;
    Names lost;
    const auto add = [&](const std::string& name) {
        if (std::find(kept.begin(), kept.end(), name) == kept.end()) lost.push_back(name);
    };
    const auto& regions = pack.region;
    if (!numbers && std::any_of(regions.begin(), regions.end(),
                                [&](std::int32_t region) { return region != regions[0]; }))
        add("region");
    for (const Column& column : pack.columns)
        if (!numbers || !column.texts.empty()) add(column.name);
    if (!lost.empty())
        callbacks.warn(fmt::format(
            "{}: holds spheres{}, without the columns {}; .csv, .vtp and .vdb keep them",
            target.file,
            ofPrograms ? " and their materials"
            : numbers  ? " and numbers"
                       : "",
            quotedExcerpt(fmt::format("{}", fmt::join(lost, ", ")))));
}

template <int Dim>
void warnOfTypes(const OutputTarget& target, const Pack<Dim>& pack, const Callbacks& callbacks) {
    const Column* const yade = columnOfNumbers(pack, "matId");
    const Column* const types = yade ? yade : columnOfNumbers(pack, "type");
    if (!types || (target.kind != OutputKind::materials && target.text.rfind("yade:", 0) != 0))
        return;
    const auto& all = types->numbers;
    if (std::any_of(all.begin(), all.end(), [&](double v) { return v != all[0]; }))
        callbacks.warn(target.text + ": the numbers in the column " + types->name +
                       " are left out, as they name no materials; set `columns` density_class=" +
                       types->name + " for a material of each");
}

/// YADE repeats along all axes or none.
template <int Dim>
void warnOfCell(const OutputTarget& target, const Pack<Dim>& pack, const Callbacks& callbacks) {
    if (target.text.rfind("yade:", 0) == 0 && pack.cell.any() && !pack.cell.all())
        callbacks.warn(target.text +
                       ": names no cell, since YADE repeats along all axes or none; spheres reach "
                       "across the faces that repeat. LAMMPS (.data) repeats along some");
}

}  // namespace

double shapeVoxelSize(const Box<3>& bounds) {
    constexpr double kVoxelsAcross = 256, kVoxelsThrough = 16;
    const Vec<3> size = bounds.size();
    const auto [thin, longest] = std::minmax_element(size.c.begin(), size.c.end());
    return std::min(*longest / kVoxelsAcross, *thin / kVoxelsThrough);
}

void checkFiles(const std::vector<OutputTarget>& outputs, const std::string& reportFile,
                const std::vector<std::string>& inputs, const std::vector<std::string>& further) {
    namespace fs = std::filesystem;
    std::vector<std::string> files;
    for (const OutputTarget& target : outputs) {
        if (target.kind == OutputKind::pack) checkPackFormat(target.text);
        if (target.kind == OutputKind::blender) {
            // Whether there are level sets is not known yet.
            const auto all = blenderFiles(target.file, true, volumeAmong(outputs));
            files.insert(files.end(), all.begin(), all.end());
        } else {
            files.push_back(target.file);
            if (target.extension() == ".pvtp") files.push_back(pieceName(target.file, 0, ".vtp"));
        }
    }
    if (!reportFile.empty()) {
        const std::string extension = extensionOf(reportFile);
        if (extension != ".json" && extension != ".html")
            throw ParameterError("`reportFile` " + reportFile +
                                 ": reports are JSON or a page for the browser; name it .json or "
                                 ".html");
        files.push_back(reportFile);
    }
    std::copy_if(further.begin(), further.end(), std::back_inserter(files),
                 [](const std::string& file) { return !file.empty(); });
    for (std::size_t i = 0; i < files.size(); ++i) {
        requireFileName(files[i]);
        const fs::path parent = fs::path(files[i]).parent_path();
        std::error_code ignored;
        if (!parent.empty() && !fs::is_directory(parent, ignored))
            throw IoError(fmt::format("{}: folder '{}' does not exist; create it first", files[i],
                                      parent.string()));
        for (const std::string& input : inputs)
            if (!input.empty() && (isSame(files[i], filePart(input)) ||
                                   isSame(files[i], input.substr(input.find(':') + 1))))
                throw ParameterError(files[i] + ": is the input itself; name another output");
        for (std::size_t j = 0; j < i; ++j)
            if (isSame(files[i], files[j]))
                throw ParameterError(files[i] + ": is named twice as output" +
                                     (files[i] == files[j] ? "" : ", once as " + files[j]));
    }
    // Refuses before the work what could not be written after it.
    for (const std::string& file : files) const OutputFile unwritten(file);
}

void checkInterruptedFiles(const std::vector<OutputTarget>& outputs,
                           const std::vector<std::string>& inputs) {
    for (const OutputTarget& output : outputs) {
        const std::string file = filePart(interruptedName(output.text));
        for (const std::string& input : inputs)
            if (!input.empty() && isSame(file, filePart(input)))
                throw ParameterError(
                    fmt::format("{}: an interrupted run would be written to {}, which is an input; "
                                "name another output",
                                output.text, file));
        const OutputFile unwritten(file);
    }
}

void checkOutputKinds(const std::vector<OutputTarget>& outputs, RunKind run,
                      const VoidRecipe& voids, int dim) {
    for (const OutputTarget& target : outputs) {
        const std::string& output = target.text;
        if (run == RunKind::measure && target.kind != OutputKind::contacts && !target.isOfBonds())
            throw ParameterError(output +
                                 ": pairs of spheres alone are written; name it contacts:FILE.csv, "
                                 "or bonds:FILE.csv");
        if (target.isOfBonds() && dim == 2)
            throw ParameterError(output + ": bonds join spheres; leave it out");
        const bool solid = target.isSolid();
        const bool levelSet = solid && target.kind != OutputKind::pack;
        if (target.kind == OutputKind::labels && dim == 2)
            throw ParameterError(output + ": label maps are of spheres; leave it out");
        if (run == RunKind::voids && target.kind == OutputKind::labels && target.labels != "solid")
            throw ParameterError(output +
                                 ": voids have no spheres to label; name it labels-solid:FILE");
        if (run == RunKind::voids && target.kind != OutputKind::voidList &&
            target.kind != OutputKind::labels) {
            if (!solid)
                throw ParameterError(output +
                                     ": voids are level sets or a list; name it .vdb, .stl or "
                                     "list:FILE.csv");
            if (dim == 2)
                throw ParameterError(output +
                                     ": voids in 2D have no level set; write "
                                     "list:FILE.csv, or pack the domain and write .svg");
        }
        if (levelSet && dim == 2)
            throw ParameterError(output +
                                 ": needs a level set, which circles do not have; "
                                 "write .svg, or leave `slice` out");
        if (run == RunKind::convert) {
            if (target.kind == OutputKind::voidList)
                throw ParameterError(output +
                                     ": a pack contains no list of voids; leave it out: runs that "
                                     "make voids write it");
            if (target.grid == kVoids || target.grid == kSolid)
                throw ParameterError(fmt::format(
                    "{}: convert makes no voids; name the level set of a .vdb (`packGrid` "
                    "{}), and write {}",
                    output, target.grid, target.file));
        } else if (levelSet && (target.grid == kVoids || target.grid == kSolid)) {
            if (!voids.makesVoids())
                throw ParameterError(
                    fmt::format("{}: without voids there is no level set '{}'; add `voids` with a "
                                "method that makes voids, or write surface:{}",
                                output, target.grid, target.file));
        }
        if (target.kind == OutputKind::voidList) checkVoidsToList(output, voids);
        if (target.kind == OutputKind::pack) checkPackFormat(output, dim);
    }
}

namespace {

template <int Dim>
void writeTable(const OutputTarget& target, const Pack<Dim>& pack,
                const PackWriteOptions& options) {
    if (target.kind == OutputKind::materials) return writeMaterials(pack, target.file, options);
    if (target.kind == OutputKind::contacts)
        return writeContacts(pack, bondedPairs(pack, options.bonds), target.file, options.unit);
    if constexpr (Dim == 3) {
        const auto bonds = bondsIn(pack, options.bonds);
        if (target.kind == OutputKind::bonds)
            writeBonds(pack, bonds, target.file, options.unit);
        else
            writeBondCoefficients(bonds, options.bonds, target.file, options.unit);
    }
}

}  // namespace

template <int Dim>
std::vector<std::string> writeOutput(const OutputTarget& target, const RunOutputs<Dim>& have) {
    const std::string& output = target.text;
    const auto need = [&](bool there, const char* what) {
        if (!there)
            throw ParameterError(
                fmt::format("{}: this run has no {} to write; leave it out", output, what));
    };
    switch (target.kind) {
        case OutputKind::voidList:
            need(have.voidList != nullptr, "voids");
            writeVoidList(*have.voidList, target.file, have.options.unit, have.sliceHeight);
            break;
        case OutputKind::contacts:
        case OutputKind::bonds:
        case OutputKind::bondCoefficients:
        case OutputKind::materials:
            need(have.pack != nullptr, "pack");
            writeTable(target, *have.pack, have.options);
            break;
        case OutputKind::interfaces:
            need(have.interfaces != nullptr, "interfaces");
            writeInterfaces(*have.interfaces, target.file, have.options.unit);
            break;
        case OutputKind::labels:
            if constexpr (Dim == 3)
                writeLabels(target, have.pack, have.labels, have.options.generator);
            break;
        case OutputKind::contour:
            writeContour(target, have);
            break;
        case OutputKind::fog:
            writeFog(chosenLevelSet(output, target.grid, levelSetsOf(have)), target.file,
                     have.options);
            break;
        case OutputKind::levelSets: {
            PackWriteOptions sets = have.options;
            sets.levelSets = levelSetsOf(have);
            need(!sets.levelSets.empty(), "level set");
            writeLevelSets(target.file, sets);
            break;
        }
        case OutputKind::pack:
            if (have.pack) {
                writePackAndSurface(output, have);
                if (target.extension() == ".pvtp")
                    return {target.file, pieceName(target.file, 0, ".vtp")};
            } else {
                writeLevelSets(output, have.options);
            }
            break;
        case OutputKind::blender:
            need(have.pack != nullptr, "pack");
            if (have.options.images && have.pack->cell.any())
                return writeBlender(withImages(*have.pack), target.file, have.options, have.volume);
            return writeBlender(*have.pack, target.file, have.options, have.volume);
    }
    return {target.file};
}

template <int Dim>
std::vector<std::string> writeOutputs(const std::vector<OutputTarget>& outputs,
                                      const RunOutputs<Dim>& have, const Callbacks& callbacks) {
    std::vector<std::string> files;
    RunOutputs<Dim> all = have;
    all.volume = volumeAmong(outputs);
    if (have.options.images && !(have.pack && have.pack->cell.any()))
        throw ParameterError(
            "`images` are those of a periodic cell, and there is none; leave them out");
    if (have.pack) warnOfMissingDensities(*have.pack, have.options.materialDensity, callbacks);
    for (const OutputTarget& output : outputs) {
        callbacks.report("write", 0, 0);
        if (have.pack) {
            warnOfIds(output, *have.pack, callbacks);
            warnOfColumns(output, *have.pack, callbacks);
            warnOfTypes(output, *have.pack, callbacks);
            warnOfCell(output, *have.pack, callbacks);
        }
        const auto written = writeOutput(output, all);
        files.insert(files.end(), written.begin(), written.end());
    }
    return files;
}

template std::vector<std::string> writeOutput<2>(const OutputTarget&, const RunOutputs<2>&);
template std::vector<std::string> writeOutput<3>(const OutputTarget&, const RunOutputs<3>&);
template std::vector<std::string> writeOutputs<2>(const std::vector<OutputTarget>&,
                                                  const RunOutputs<2>&, const Callbacks&);
template std::vector<std::string> writeOutputs<3>(const std::vector<OutputTarget>&,
                                                  const RunOutputs<3>&, const Callbacks&);

}  // namespace vdbpack
