#include "vdbpack/core/error.h"
#include "vdbpack/domain/label_domains.h"
#include "vdbpack/domain/mesh_parts.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/run/run_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

namespace vdbpack {

namespace {

bool isLabelMap(const DomainRecipe& domain) {
    return isImage(domain) && !domain.threshold;
}

/// Refuses what is done for one domain alone. @throws ParameterError
void checkPartsRecipe(const PackRecipe& recipe) {
    const auto refuse = [](bool wanted, const char* what) {
        if (wanted)
            throw ParameterError(fmt::format(
                "{}: is not done for several parts; leave it out, or pack them one by one", what));
    };
    refuse(!recipe.existing.empty(), "`existing`");
    refuse(recipe.packing.maxCount > 0, "`maxCount`");
    refuse(recipe.domain.slice.has_value(), "`slice`");
    refuse(recipe.ranks != nullptr, "mpirun");
    const bool cut = std::any_of(recipe.parts.begin(), recipe.parts.end(),
                                 [](const auto& part) { return part.voids.makesVoids(); });
    for (const OutputTarget& output : recipe.outputs)
        refuse(output.kind == OutputKind::fog ||
                   (output.kind == OutputKind::contour && output.grid != kSurface &&
                    (cut || recipe.voids.makesVoids() || !output.grid.empty())),
               output.text.c_str());
    refuse(recipe.voids.measureSolid, "`measureSolid`");
    const bool anyModulus =
        std::any_of(recipe.parts.begin(), recipe.parts.end(),
                    [](const PackRecipe& part) { return !part.grey.modulus.empty(); });
    for (const PackRecipe& part : recipe.parts) {
        const GreyRecipe &own = part.grey, &all = recipe.grey;
        const bool others = (!own.samples.empty() && own.samples != all.samples) ||
                            (!own.calibration.empty() && own.calibration != all.calibration);
        if (others)
            throw ParameterError(part.name +
                                 ": `samples` and `calibration` are those of all parts; give them "
                                 "outside of the parts");
        if (!own.modulus.empty() && needsDensity(own.modulus) && all.calibration.empty())
            throw ParameterError(
                part.name + ": `modulus` " + own.modulus +
                " follows from densities; set `calibration`, or one modulus alone");
        if (own.modulus.empty() && anyModulus)
            throw ParameterError(
                part.name +
                ": has no modulus, but other parts have; set its `modulus`, or one "
                "for all parts outside of them");
    }
}

/// The parts that labels of an image are, one recipe each.
std::vector<PackRecipe> labelRecipes(const PackRecipe& recipe,
                                     const std::vector<LabelPart>& parts) {
    std::vector<PackRecipe> recipes;
    for (const LabelPart& part : parts) {
        PackRecipe one = recipe;
        one.domain.label.clear();
        for (const LabelCount& label : part.labels)
            one.domain.label += fmt::format("{}{}@{}", one.domain.label.empty() ? "" : "+",
                                            label.value, label.layer);
        one.name = part.name;
        one.parts.clear();
        recipes.push_back(std::move(one));
    }
    return recipes;
}

/// One recipe for each part of a mesh.
std::vector<PackRecipe> meshRecipes(const PackRecipe& recipe, const Callbacks& callbacks) {
    std::vector<NamedMesh> parts = meshParts(recipe.domain, callbacks);
    std::vector<PackRecipe> recipes(parts.size(), recipe);
    for (std::size_t k = 0; k < parts.size(); ++k) {
        DomainRecipe& domain = recipes[k].domain;
        recipes[k].name = parts[k].name;
        domain.partsBy = PartsBy::none;
        domain.unit = Unit::millimeter;
        domain.scale = 1;
        domain.pose = {};
        domain.mesh = std::make_shared<const TriangleMesh>(std::move(parts[k].mesh));
    }
    return recipes;
}

/// The recipes of the parts: as given, one a label, or one a piece of a mesh; none if there is one
/// domain.
std::vector<PackRecipe> recipesOf(const PackRecipe& recipe, LabelledImages& images,
                                  const Callbacks& callbacks) {
    if (!recipe.parts.empty()) return recipe.parts;
    if (recipe.domain.partsBy != PartsBy::none) return meshRecipes(recipe, callbacks);
    const std::string& label = recipe.domain.label;
    if (!isLabelMap(recipe.domain) || (label != "all" && label.find(',') == std::string::npos))
        return {};
    auto recipes = labelRecipes(recipe, images.of(recipe.domain).parse(label));
    if (recipes.size() == 1 && label == "all") recipes.clear();
    return recipes;
}

/// Refuses what a part cannot be, names it, and leaves files and pictures to all parts together.
void settle(std::vector<PackRecipe>& recipes, std::size_t k, std::uint64_t seed) {
    PackRecipe& recipe = recipes[k];
    checkPartsRecipe(recipe);
    if (recipe.domain.partsBy != PartsBy::none)
        throw ParameterError(
            "`partsBy`: parts have no parts of their own; give it outside of them");
    if (recipe.name.empty()) recipe.name = fmt::format("part {}", k);
    for (std::size_t l = 0; l < k; ++l)
        if (recipes[l].name == recipe.name)
            throw ParameterError("two parts are named '" + recipe.name +
                                 "'; give each a name of its own");
    recipe.preview = {};
    recipe.outputs.clear();
    recipe.seed = seed;
}

LabelPlace placeOf(const PackRecipe& recipe, LabelledImages& images) {
    if (!isLabelMap(recipe.domain)) return {};
    LabelledImage& image = images.of(recipe.domain);
    const std::string& label = recipe.domain.label;
    const auto parts = image.parse(label.empty() ? "all" : label);
    if (parts.size() != 1 && label.empty())
        throw ParameterError(fmt::format("{}: {} has {} labels; set `label` to that of the part",
                                         recipe.name, recipe.domain.source, parts.size()));
    if (parts.size() != 1)
        throw ParameterError(
            fmt::format("{}: names {} labels of {}; a part is one, or several joined by +",
                        recipe.name, parts.size(), recipe.domain.source));
    return {&image, image.add({recipe.name, parts.front().labels})};
}

/// A later part has the space; labels of one layer leave one another theirs.
void cutByLater(const std::vector<LabelPlace>& places, Parts& parts) {
    for (std::size_t k = 0; k < parts.size(); ++k)
        for (std::size_t l = k + 1; l < parts.size(); ++l) {
            DomainSource &earlier = *parts[k].source, &later = *parts[l].source;
            if (places[k].sharesLayerWith(places[l])) continue;
            if (!intersection(earlier.domainBounds(), later.domainBounds()).empty())
                earlier.cutBy(later);
        }
}

}  // namespace

InputError withPart(const Part& part, const InputError& error) {
    constexpr double kNothing = 1e-3;
    const bool taken = part.source->left().volume < kNothing * part.source->left(false).volume;
    return InputError(part.recipe.name + ": " +
                      (taken ? "lies within parts that are listed after it, which have the space "
                               "that they share; list it after them"
                             : error.what()));
}

Parts partsOf(const PackRecipe& recipe, const Callbacks& callbacks) {
    LabelledImages images(callbacks);
    std::vector<PackRecipe> recipes = recipesOf(recipe, images, callbacks);
    if (recipes.empty()) return {};
    checkPartsRecipe(recipe);
    // Labels first, all of an image at once.
    std::vector<LabelPlace> places;
    for (std::size_t k = 0; k < recipes.size(); ++k) {
        settle(recipes, k, recipe.seed);
        places.push_back(inPart(recipe, recipes[k], [&] { return placeOf(recipes[k], images); }));
    }
    images.makeSurfaces();
    Parts parts;
    for (std::size_t k = 0; k < recipes.size(); ++k) {
        callbacks.stopIfCancelled();
        const DomainRecipe& domain = recipes[k].domain;
        const LabelPlace& place = places[k];
        auto source = inPart(recipe, recipes[k], [&] {
            return std::make_shared<DomainSource>(
                place.image ? place.image->source(domain, place.part, callbacks)
                            : DomainSource(domain, callbacks));
        });
        if (source->dim() != 3)
            throw ParameterError(recipes[k].name + ": parts fill domains of space");
        parts.push_back({std::move(recipes[k]), std::move(source)});
    }
    cutByLater(places, parts);
    for (const Part& part : parts) warnOfUnused(part.recipe.domain, *part.source, callbacks);
    return parts;
}

}  // namespace vdbpack
