#include "vdbpack/run/recipe.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/mesh_domain.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/run_parts.h"
#include "vdbpack/voids/local_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// Beyond this the field for the smallest radius would outgrow any pack of the largest.
constexpr double kLargestSizeRatio = 200;

}  // namespace

std::vector<std::string> voidInputs(const VoidRecipe& recipe) {
    std::vector<std::string> inputs{recipe.shellField};
    if (const auto* listed = recipe.as<ListedVoids>()) inputs.push_back(listed->file);
    if (const auto* grid = recipe.as<GridVoids>()) inputs.push_back(grid->matrix);
    if (const VoidShapeRecipe* shape = shapeOf(recipe))
        inputs.insert(inputs.end(), {shape->orientation.field, shape->radius.spec(),  // table:FILE
                                     shape->aspect.spec()});
    if (const BvtvField* field = bvtvFieldOf(recipe)) inputs.push_back(field->file);
    if (const auto* foam = recipe.as<FoamVoids>())
        inputs.insert(inputs.end(), {foam->like.file, foam->like.domain});
    return inputs;
}

namespace {

/// Refuses what has no meaning where the solid is filled.
void checkSolidFill(const PackRecipe& recipe) {
    const VoidRecipe& voids = recipe.voids;
    if (voids.empty())
        throw ParameterError(
            "`fill` solid: there are no voids to leave a solid; set `voids`, such as boolean");
    if (voids.as<Thinning>() || voids.as<FrontHoles>())
        throw ParameterError(fmt::format(
            "`fill` solid: `voids` {} are chosen among the spheres of a pack; use voids that are "
            "made before it, such as boolean",
            nameOf(voids)));
    if (voids.cull == Cull::touch)
        throw ParameterError(
            "`fill` solid: no sphere meets a void, so that none is removed; leave `cull` out");
    if (recipe.domain.slice)
        throw ParameterError(
            "`fill` solid: voids have level sets in space alone; leave `slice` out");
}

/// Refuses radii of a shell without a shell, and files of factors that cannot be read.
void checkLocalSizes(const PackRecipe& recipe) {
    if (!recipe.shellRadius.empty()) {
        if (!recipe.voids.hasShell())
            throw ParameterError(
                "`shellRadius` " + recipe.shellRadius.spec() +
                ": there is no shell; set its thickness by `shell`, such as 3, or `shellField`");
        if (recipe.voids.fill == Fill::solid)
            throw ParameterError(
                "`fill` solid and `shellRadius` cannot be combined; leave one out");
    }
    if ((!recipe.shellRadius.empty() || !recipe.sizeField.empty()) && recipe.voids.as<FrontHoles>())
        throw ParameterError(
            "`voids` " + nameOf(recipe.voids) +
            " cannot be combined with sizes by place; use voids that are cut afterwards, such as "
            "boolean");
    checkFactorField(recipe.sizeField);
}

/// Refuses what spheres at random points cannot be made with.
void checkRandomStart(const PackRecipe& recipe) {
    if (!recipe.randomStart) return;
    if (!(recipe.densify.fraction > 0))
        throw ParameterError(
            "`start` random: needs the solid fraction at which to end; add `densify`, such as 0.63 "
            "or max");
    const char* const other = !recipe.existing.empty()      ? "existing"
                              : !recipe.sizeField.empty()   ? "sizeField"
                              : !recipe.shellRadius.empty() ? "shellRadius"
                                                            : nullptr;
    if (other)
        throw ParameterError(
            fmt::format("`start` random and `{}` cannot be combined; leave one out", other));
}

/// Refuses settings of one domain that exclude one another.
void checkPacking(const PackRecipe& recipe) {
    const bool denser = recipe.densify.fraction > 0;
    if (denser && recipe.settle)
        throw ParameterError(
            "`settle` and `densify` cannot be combined: spheres made denser are "
            "moved as well; leave out `settle`");
    const char* const moved = denser ? "densify" : recipe.settle ? "settle" : nullptr;
    if (moved && recipe.packing.maxCount > 0)
        throw ParameterError(
            fmt::format("`maxCount` and `{}` cannot be combined; leave one out", moved));
    if (moved && recipe.voids.as<FrontHoles>())
        throw ParameterError(
            fmt::format("`{}` would move the holes among the spheres of `voids` {}; use voids that "
                        "are cut afterwards, such as boolean",
                        moved, nameOf(recipe.voids)));
    checkRandomStart(recipe);
    if (recipe.domain.shellFrom == ShellFrom::outer && recipe.voids.as<FrontHoles>())
        throw ParameterError("`shellFrom` outer: `voids` " + nameOf(recipe.voids) +
                             " keep the thickness of the shell from all walls; use voids that are "
                             "cut afterwards, such as boolean");
    if (recipe.voids.fill == Fill::solid) checkSolidFill(recipe);
    if (recipe.targetCount > 0 && recipe.targetCount != std::floor(recipe.targetCount))
        throw ParameterError(
            fmt::format("`targetCount` {}: must be a whole number of spheres", recipe.targetCount));
    checkLocalSizes(recipe);
    checkVoids(recipe.voids, true, true);
    requireVoidFields(recipe.voids);
}

void addInputs(const PackRecipe& recipe, std::vector<std::string>& inputs) {
    for (auto& file : voidInputs(recipe.voids)) inputs.push_back(std::move(file));
    for (auto& file : domainInputs(recipe.domain)) inputs.push_back(std::move(file));
    if (!recipe.givenExisting) inputs.push_back(recipe.existing);
    inputs.push_back(recipe.radius.spec());  // table:FILE
    inputs.push_back(recipe.shellRadius.spec());
    inputs.push_back(recipe.sizeField);
}

}  // namespace

namespace {

/// Refuses a color by a column that the spheres will not have.
void checkPreviewColumn(const PackRecipe& recipe, const std::vector<std::string>& columns) {
    const std::string& name = recipe.preview.column;
    if (recipe.preview.color != PreviewColor::column) return;
    std::vector<std::string> words = columns;
    for (const std::string& text : recipe.grey.samples)
        words.push_back(text.substr(0, text.find('=')));
    if (!recipe.grey.calibration.empty()) words.insert(words.end(), {kDensityColumn, kClassColumn});
    if (!recipe.grey.modulus.empty()) words.push_back(kModulusColumn);
    if (std::find(words.begin(), words.end(), name) != words.end()) return;
    words.insert(words.end(), {"radius", "region", "depth", "order", "part"});
    throw ParameterError(
        "`preview.color` " + name +
        ": is no column of the spheres; color by radius, region, depth, order, part or a column "
        "of `samples`" +
        similarWord(name, words));
}

}  // namespace

void checkRecipe(const PackRecipe& recipe) {
    std::vector<std::string> inputs{recipe.partsFile};
    checkPacking(recipe);
    addInputs(recipe, inputs);
    for (const PackRecipe& part : recipe.parts) {
        inPart(recipe, part, [&] {
            checkPacking(part);
            checkDensity(part.density);
            if (!part.grey.modulus.empty()) needsDensity(part.grey.modulus);
        });
        addInputs(part, inputs);
    }
    checkSettings(recipe, RunKind::pack, recipe.voids, inputs);
    const std::string& label = recipe.domain.label;
    const bool severalLabels = label == "all" || label.find(',') != std::string::npos;
    if (recipe.parts.empty() && recipe.domain.partsBy == PartsBy::none && !severalLabels)
        refuseInterfaces(recipe);
    if (!recipe.existing.empty()) return;
    // A pack has no columns but its part and the samples.
    const std::vector<std::string> columns{kPartColumn};
    checkGrey(recipe.grey, recipe.density, &columns);
    checkPreviewColumn(recipe, columns);
}

namespace {

/// Refuses sizes of one pack that differ too much.
void requireRatio(const SizeDistribution& fine, const SizeDistribution& coarse) {
    if (!(coarse.max() > kLargestSizeRatio * fine.min())) return;
    const bool same = fine.spec() == coarse.spec();
    throw ParameterError(fmt::format(
        "radius distribution{} '{}'{} {} a ratio of {:.3g}; the limit is {:g}: raise the "
        "smallest radius",
        same ? "" : "s", fine.spec(), same ? "" : " and '" + coarse.spec() + "'",
        same ? "spans" : "span", coarse.max() / fine.min(), kLargestSizeRatio));
}

}  // namespace

double RequestedSizes::least() const {
    const double all = shellSizes ? std::min(sizes.min(), shellSizes->min()) : sizes.min();
    return factor ? all * factor->least() : all;
}

double RequestedSizes::largest() const {
    const double all = shellSizes ? std::max(sizes.max(), shellSizes->max()) : sizes.max();
    return factor ? all * factor->most() : all;
}

double RequestedSizes::detail() const {
    double smallest = sizes.min(), mean = sizes.mean();
    if (shellSizes) {
        smallest = std::min(smallest, shellSizes->min());
        mean = std::min(mean, shellSizes->mean());
    }
    const double middle = factor ? std::sqrt(factor->least() * factor->most()) : 1;
    return fieldDetail(smallest, mean) * middle;
}

double RequestedSizes::meanBall(int dim, double shell) const {
    double ball = sizes.meanBall(dim);
    if (shellSizes) ball = 1 / ((1 - shell) / ball + shell / shellSizes->meanBall(dim));
    if (!factor) return ball;
    // Where all factors from the smallest to the largest are equally frequent.
    const double a = factor->least(), b = factor->most();
    return ball * (dim == 3 ? 2 * a * a * b * b / (a + b) : a * b);
}

RequestedSizes requestedSizes(const PackRecipe& recipe, int dim) {
    const bool given = !recipe.radius.empty();
    RequestedSizes r{
        given ? recipe.radius.in(dim, recipe.weightBy) : SizeDistribution::uniform(1, 2),
        recipe.targetCount,
        {},
        recipe.shellRadius.find(dim, recipe.weightBy),
        readFactors(recipe.sizeField, recipe.domain)};
    requireRatio(r.sizes, r.sizes);
    if (r.shellSizes) {
        requireRatio(*r.shellSizes, r.sizes);
        requireRatio(r.sizes, *r.shellSizes);
        requireRatio(*r.shellSizes, *r.shellSizes);
    }
    if (given) return r;
    if (!(r.targetCount > 0)) {
        r.targetCount = kDefaultCount;
        r.chosen.push_back(fmt::format("about {:.0f} spheres", kDefaultCount));
    }
    return r;
}

template <int Dim>
LocalSizes localSizes(const PackRecipe& recipe, const RequestedSizes& requested,
                      const Domain<Dim>& domain, double sliceHeight, const ShellThickness& shell) {
    LocalSizes sizes;
    sizes.shell = shell;
    sizes.shellSizes = requested.shellSizes;
    if (requested.factor)
        sizes.factor =
            factorsOver(requested.factor, recipe.sizeField, domain.bounds(), sliceHeight);
    return sizes;
}

PackOptions packOptions(const PackRecipe& recipe, const SizeDistribution& sizes) {
    PackOptions options = recipe.packing;
    options.sizes = sizes;
    options.seed = recipe.seed;
    options.threads = recipe.threads;
    options.ranks = recipe.ranks;
    return options;
}

template <int Dim>
Pack<Dim> readExisting(const PackRecipe& recipe, double sliceHeight, const Callbacks& callbacks) {
    if (recipe.existing.empty()) return {};
    PackReadOptions read;
    read.unit = recipe.packUnit;
    read.columns = recipe.packColumns;
    read.radius = recipe.packRadius;
    read.memoryLimit = recipe.memoryLimit;
    read.callbacks = callbacks;
    Pack<3> pack = recipe.givenExisting ? *recipe.givenExisting : readPack(recipe.existing, read);
    requireRoomToNumber(pack, recipe.existing);
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Sphere<3>& s = pack.spheres[i];
        const bool finite = std::all_of(s.center.c.begin(), s.center.c.end(),
                                        [](double c) { return std::isfinite(c); });
        if (!finite || !(s.radius > 0 && std::isfinite(s.radius)))
            throw InputError(fmt::format(
                "{}: sphere {} has center ({}, {}, {}) and radius {}; positions must be finite and "
                "radii positive",
                recipe.existing, i, s.center[0], s.center[1], s.center[2], s.radius));
    }
    if constexpr (Dim == 3) {
        warnOfPlane(recipe.existing, pack, callbacks);
        return pack;
    } else {
        Pack<2> circles;
        try {
            circles = asCircles(pack);
        } catch (const InputError& e) {
            throw InputError(recipe.existing + ": " + e.what());
        }
        if (!circles.spheres.empty() &&
            std::fabs(circles.sliceHeight - sliceHeight) > 1e-6 * (1 + std::fabs(sliceHeight)))
            throw InputError(fmt::format("{}: its circles lie at z = {}, the domain at z = {}",
                                         recipe.existing, circles.sliceHeight, sliceHeight));
        return circles;
    }
}

template LocalSizes localSizes(const PackRecipe&, const RequestedSizes&, const Domain<2>&, double,
                               const ShellThickness&);
template LocalSizes localSizes(const PackRecipe&, const RequestedSizes&, const Domain<3>&, double,
                               const ShellThickness&);
template Pack<2> readExisting(const PackRecipe&, double, const Callbacks&);
template Pack<3> readExisting(const PackRecipe&, double, const Callbacks&);

}  // namespace vdbpack
