#include "vdbpack/run/parts.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/report/page_frame.h"

#include <fmt/format.h>

#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

bool isLabelMap(const DomainRecipe& domain) {
    return isImage(domain) && !domain.threshold;
}

/// What recipes that read the same image in the same way have in common.
auto imageKey(const DomainRecipe& domain) {
    return std::make_tuple(domain.source, domain.image, domain.voxelSpacing.value_or(Vec<3>{}).c,
                           domain.unit, domain.scale, domain.space);
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

/// An image that parts are labels of, and their surfaces.
class LabelledImage {
public:
    LabelledImage(const DomainRecipe& domain, const Callbacks& callbacks)
        : image_(readDomainImage(domain, callbacks)),
          labels_(labelsOf(image_)),
          path_(domain.source) {
        if (!labels_)
            throw ParameterError(path_ +
                                 ": is no label map, but has many different values; set "
                                 "`threshold` to the lowest value of bone");
    }
    std::vector<LabelPart> parse(const std::string& text) const {
        return parseLabels(text, *labels_, path_);
    }
    /// Adds a part and returns its number. @throws ParameterError if a label is in two parts
    std::size_t add(const LabelPart& part, const Callbacks& callbacks) {
        for (const LabelCount& label : part.labels)
            if (!used_.insert({label.layer, label.value}).second)
                throw ParameterError(
                    fmt::format("{}: label {} is in two parts", path_, label.value));
        warnOfBorder(part, image_.grid, path_, callbacks);
        parts_.push_back(part);
        return parts_.size() - 1;
    }
    /// The surfaces of all parts, those of a layer together.
    void makeSurfaces() {
        surfaces_.resize(parts_.size());
        std::map<std::size_t, std::vector<std::size_t>> layers;
        for (std::size_t p = 0; p < parts_.size(); ++p)
            layers[parts_[p].labels.front().layer].push_back(p);
        for (const auto& [layer, members] : layers) {
            std::vector<LabelPart> some;
            for (const std::size_t p : members) some.push_back(parts_[p]);
            auto meshes = labelSurfaces(image_, *labels_, some);
            for (std::size_t k = 0; k < members.size(); ++k)
                surfaces_[members[k]] = std::move(meshes[k]);
        }
        image_.bytes.reset();
    }
    /// The domain of a part, once.
    DomainSource source(const DomainRecipe& domain, std::size_t part, const Callbacks& callbacks) {
        DomainSource made(domain, std::move(surfaces_[part]), callbacks);
        made.setImageGrid(image_.grid, image_.isSpaced);
        return made;
    }
    std::size_t layerOf(std::size_t part) const { return parts_[part].labels.front().layer; }

private:
    Image image_;
    std::optional<std::vector<LabelCount>> labels_;
    std::string path_;
    std::vector<LabelPart> parts_;
    std::set<std::pair<std::size_t, std::int64_t>> used_;
    std::vector<TriangleMesh> surfaces_;
};

/// The images of some domains, each read once.
class LabelledImages {
public:
    explicit LabelledImages(const Callbacks& callbacks) : callbacks_(callbacks) {}

    LabelledImage& of(const DomainRecipe& domain) {
        const auto known = images_.find(imageKey(domain));
        if (known != images_.end()) return known->second;
        return images_.emplace(imageKey(domain), LabelledImage(domain, callbacks_)).first->second;
    }
    void makeSurfaces() {
        for (auto& [key, image] : images_) image.makeSurfaces();
    }

private:
    const Callbacks& callbacks_;
    std::map<decltype(imageKey(DomainRecipe())), LabelledImage> images_;
};

/// The recipes of the parts: as given, or one a label; none if there is one domain.
std::vector<PackRecipe> recipesOf(const PackRecipe& recipe, LabelledImages& images) {
    if (!recipe.parts.empty()) return recipe.parts;
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
    if (recipe.name.empty()) recipe.name = fmt::format("part {}", k);
    for (std::size_t l = 0; l < k; ++l)
        if (recipes[l].name == recipe.name)
            throw ParameterError("two parts are named '" + recipe.name +
                                 "'; give each a name of its own");
    recipe.preview = {};
    recipe.outputs.clear();
}

/// Where the surface of a part is among the labels of an image.
struct LabelPlace {
    LabelledImage* image = nullptr;  ///< null: the part is no label
    std::size_t part = 0;

    bool sharesLayerWith(const LabelPlace& other) const {
        return image && image == other.image && image->layerOf(part) == image->layerOf(other.part);
    }
};

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
