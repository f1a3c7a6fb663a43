#include "vdbpack/core/error.h"
#include "vdbpack/domain/label_domains.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/mesh/mesh_shells.h"
#include "vdbpack/mesh/welding.h"
#include "vdbpack/report/page_frame.h"
#include "vdbpack/run/run_parts.h"

#include <fmt/format.h>

#include <string>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::size_t kMostParts = 100;  ///< of a mesh

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
    refuse(isPage(recipe.reportFile), "a report page (a .json is written)");
    for (const PackRecipe& part : recipe.parts) {
        const GreyRecipe &own = part.grey, &all = recipe.grey;
        const bool others = (!own.samples.empty() && own.samples != all.samples) ||
                            (!own.calibration.empty() && own.calibration != all.calibration);
        if (others)
            throw ParameterError(part.name +
                                 ": `samples` and `calibration` are those of all parts; give them "
                                 "outside of the parts");
        if (!own.modulus.empty() && all.calibration.empty())
            throw ParameterError(part.name +
                                 ": `modulus` is a column beside densities from grey values; set "
                                 "`calibration`");
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

struct NamedMesh {
    std::string name;
    TriangleMesh mesh;
};

/// The triangles by the names that they have in their file, in its order.
std::vector<NamedMesh> groupsOf(const TriangleMesh& mesh, const MeshGroups& names) {
    std::vector<NamedMesh> parts;
    std::size_t next = 0, at = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        while (next < names.size() && names[next].second <= t) ++next;
        const std::string& name = next > 0 ? names[next - 1].first : names.front().first;
        if (at >= parts.size() || parts[at].name != name)
            for (at = 0; at < parts.size() && parts[at].name != name;) ++at;
        if (at == parts.size()) parts.push_back({name, {}});
        parts[at].mesh.triangles.push_back(mesh.triangles[t]);
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

/// The parts that names in the file of a mesh, or its components, are, one recipe each.
std::vector<PackRecipe> meshRecipes(const PackRecipe& recipe) {
    const DomainRecipe& domain = recipe.domain;
    if (isImage(domain))
        throw ParameterError(
            "`partsBy` is for meshes; parts of an image are its labels (`label` all)");
    MeshReadOptions read;
    read.unit = domain.unit;
    read.scale = domain.scale;
    MeshGroups names;
    const TriangleMesh mesh = readMesh(domain.source, read, nullptr, &names);
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
    std::vector<PackRecipe> recipes(parts.size(), recipe);
    for (std::size_t k = 0; k < parts.size(); ++k) {
        parts[k].mesh.vertices = mesh.vertices;  // `welded` drops those that are not used
        recipes[k].name = parts[k].name;
        recipes[k].domain.partsBy = PartsBy::none;
        recipes[k].domain.unit = Unit::millimeter;
        recipes[k].domain.scale = 1;
        recipes[k].domain.mesh =
            std::make_shared<const TriangleMesh>(welded(std::move(parts[k].mesh)));
    }
    return recipes;
}

/// The recipes of the parts: as given, one a label, or one a piece of a mesh; none if there is one
/// domain.
std::vector<PackRecipe> recipesOf(const PackRecipe& recipe, LabelledImages& images) {
    if (!recipe.parts.empty()) return recipe.parts;
    if (recipe.domain.partsBy != PartsBy::none) return meshRecipes(recipe);
    const std::string& label = recipe.domain.label;
    if (!isLabelMap(recipe.domain) || (label != "all" && label.find(',') == std::string::npos))
        return {};
    auto recipes = labelRecipes(recipe, images.of(recipe.domain).parse(label));
    if (recipes.size() == 1 && label == "all") recipes.clear();
    return recipes;
}

/// Refuses what a part cannot be, names it, and leaves files and pictures to all parts together.
void settle(std::vector<PackRecipe>& recipes, std::size_t k) {
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
}

LabelPlace placeOf(const PackRecipe& recipe, LabelledImages& images, const Callbacks& callbacks) {
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
    return {&image, image.add({recipe.name, parts.front().labels}, callbacks)};
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

Parts partsOf(const PackRecipe& recipe, const Callbacks& callbacks) {
    LabelledImages images(callbacks);
    std::vector<PackRecipe> recipes = recipesOf(recipe, images);
    if (recipes.empty()) return {};
    checkPartsRecipe(recipe);
    // Labels first, all of an image at once.
    std::vector<LabelPlace> places;
    for (std::size_t k = 0; k < recipes.size(); ++k) {
        settle(recipes, k);
        places.push_back(placeOf(recipes[k], images, callbacks));
    }
    images.makeSurfaces();
    Parts parts;
    for (std::size_t k = 0; k < recipes.size(); ++k) {
        callbacks.stopIfCancelled();
        const DomainRecipe& domain = recipes[k].domain;
        const LabelPlace& place = places[k];
        auto source = std::make_shared<DomainSource>(
            place.image ? place.image->source(domain, place.part, callbacks)
                        : DomainSource(domain, callbacks));
        if (source->dim() != 3)
            throw ParameterError(recipes[k].name + ": parts fill domains of space");
        parts.push_back({std::move(recipes[k]), std::move(source)});
    }
    cutByLater(places, parts);
    return parts;
}

}  // namespace vdbpack
