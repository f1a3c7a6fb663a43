#include "vdbpack/run/run_parts.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/output_target.h"
#include "vdbpack/formats/sphere_density.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/run/report_file.h"
#include "vdbpack/verify/overlap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace vdbpack {

namespace {

/// Spheres of a pack for which nothing else is requested.
constexpr double kUsualCount = 100'000;

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
    TriangleMesh& surface(std::size_t part) { return surfaces_[part]; }
    const ImageGrid& grid() const { return image_.grid; }
    bool isSpaced() const { return image_.isSpaced; }
    std::size_t layerOf(std::size_t part) const { return parts_[part].labels.front().layer; }

private:
    Image image_;
    std::optional<std::vector<LabelCount>> labels_;
    std::string path_;
    std::vector<LabelPart> parts_;
    std::set<std::pair<std::size_t, std::int64_t>> used_;
    std::vector<TriangleMesh> surfaces_;
};

}  // namespace

Parts partsOf(const PackRecipe& recipe, const Callbacks& callbacks) {
    using Key = decltype(imageKey(recipe.domain));
    std::map<Key, LabelledImage> images;
    const auto imageOf = [&](const DomainRecipe& domain) -> LabelledImage& {
        const Key key = imageKey(domain);
        const auto known = images.find(key);
        if (known != images.end()) return known->second;
        return images.emplace(key, LabelledImage(domain, callbacks)).first->second;
    };
    std::vector<PackRecipe> recipes = recipe.parts;
    if (recipes.empty()) {
        const std::string& label = recipe.domain.label;
        if (!isLabelMap(recipe.domain) || (label != "all" && label.find(',') == std::string::npos))
            return {};
        recipes = labelRecipes(recipe, imageOf(recipe.domain).parse(label));
        if (recipes.size() == 1 && recipe.domain.label == "all") return {};
    }
    checkPartsRecipe(recipe);
    // Labels first, all of an image at once.
    struct Place {
        LabelledImage* image = nullptr;
        std::size_t part = 0;
    };
    std::vector<Place> places(recipes.size());
    for (std::size_t k = 0; k < recipes.size(); ++k) {
        checkPartsRecipe(recipes[k]);
        if (recipes[k].name.empty()) recipes[k].name = fmt::format("part {}", k);
        for (std::size_t l = 0; l < k; ++l)
            if (recipes[l].name == recipes[k].name)
                throw ParameterError("two parts are named '" + recipes[k].name +
                                     "'; give each a name of its own");
        // Files and pictures are of all.
        recipes[k].preview = {};
        recipes[k].outputs.clear();
        if (!isLabelMap(recipes[k].domain)) continue;
        LabelledImage& image = imageOf(recipes[k].domain);
        const std::string& label = recipes[k].domain.label;
        const auto parts = image.parse(label.empty() ? "all" : label);
        if (parts.size() != 1 && label.empty())
            throw ParameterError(
                fmt::format("{}: {} has {} labels; set `label` to that of the part",
                            recipes[k].name, recipes[k].domain.source, parts.size()));
        if (parts.size() != 1)
            throw ParameterError(
                fmt::format("{}: names {} labels of {}; a part is one, or several joined by +",
                            recipes[k].name, parts.size(), recipes[k].domain.source));
        places[k] = {&image, image.add({recipes[k].name, parts.front().labels}, callbacks)};
    }
    for (auto& [key, image] : images) image.makeSurfaces();
    Parts parts;
    for (std::size_t k = 0; k < recipes.size(); ++k) {
        callbacks.stopIfCancelled();
        const DomainRecipe domain = recipes[k].domain;
        LabelledImage* image = places[k].image;
        DomainSource source =
            image ? DomainSource(domain, std::move(image->surface(places[k].part)), callbacks)
                  : DomainSource(domain, callbacks);
        if (image) source.setImageGrid(image->grid(), image->isSpaced());
        if (source.dim() != 3)
            throw ParameterError(recipes[k].name + ": parts fill domains of space");
        parts.push_back(std::make_unique<Part>(Part{std::move(recipes[k]), std::move(source)}));
    }
    // A later part has the space; labels of one layer leave one another theirs.
    for (std::size_t k = 0; k < parts.size(); ++k)
        for (std::size_t l = k + 1; l < parts.size(); ++l) {
            const bool apart = places[k].image && places[k].image == places[l].image &&
                               places[k].image->layerOf(places[k].part) ==
                                   places[l].image->layerOf(places[l].part);
            const bool near =
                !intersection(parts[k]->source.domainBounds(), parts[l]->source.domainBounds())
                     .empty();
            if (!apart && near) parts[k]->source.cutBy(parts[l]->source);
        }
    return parts;
}

namespace {

/// Gives the parts that share the sizes of the whole run the radii that one of them was given.
class SharedRadii {
public:
    SharedRadii(const PackRecipe& recipe, const Parts& parts) : shared_(parts.size()) {
        const double target = recipe.targetCount > 0  ? recipe.targetCount
                              : recipe.radius.empty() ? kUsualCount
                                                      : 0;
        if (!(target > 0)) return;
        double volume = 0, largest = 0;
        for (std::size_t k = 0; k < parts.size(); ++k) {
            const PackRecipe& part = parts[k]->recipe;
            shared_[k] = part.radius.spec() == recipe.radius.spec() &&
                         part.weightBy == recipe.weightBy && part.targetCount == recipe.targetCount;
            if (!shared_[k]) continue;
            const double own = parts[k]->source.volume();
            volume += own;
            if (own <= largest) continue;
            largest = own;
            first_ = k;
        }
        if (!(largest > 0)) return;
        PackRecipe& first = parts[first_]->recipe;
        first.targetCount = std::max(1.0, std::round(target * largest / volume));
    }
    /// The order in which parts are packed.
    std::vector<std::size_t> order() const {
        std::vector<std::size_t> all(shared_.size());
        for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
        if (!all.empty())
            std::rotate(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(first_),
                        all.begin() + static_cast<std::ptrdiff_t>(first_) + 1);
        return all;
    }
    /// Called before each part is packed, in that order.
    void prepare(PackRecipe& part, std::size_t k) const {
        if (!shared_[k] || k == first_ || found_.empty()) return;
        part.radius = found_;
        part.targetCount = 0;
    }
    void take(const SizeDistribution& sizes, std::size_t k) {
        if (shared_[k] && k == first_) found_ = sizes;
    }

private:
    std::vector<std::uint8_t> shared_;
    std::size_t first_ = 0;
    SizeRequest found_;
};

/// Adds a pack of a part to those before it, and its number to the first column. Depths are taken
/// over, contacts are not.
void append(Pack<3>& all, Pack<3> part, std::int32_t number) {
    const std::size_t before = all.spheres.size(), count = part.spheres.size();
    const auto add = [&](auto& values, auto& more) {
        if (more.empty() && values.empty()) return;
        values.resize(before);
        more.resize(count);
        values.insert(values.end(), more.begin(), more.end());
    };
    add(all.region, part.region);
    add(all.depth, part.depth);
    for (std::int64_t& order : part.order) order += static_cast<std::int64_t>(before);
    add(all.order, part.order);
    all.columns.front().numbers.insert(all.columns.front().numbers.end(), count, number);
    all.spheres.insert(all.spheres.end(), part.spheres.begin(), part.spheres.end());
}

/// Puts the figures of all parts together in one report.
class JoinedReport {
public:
    explicit JoinedReport(Report& all) : all_(all) {
        all_.domain = {};
        all_.domain.kind = "parts";
        all_.protrusion = ProtrusionCheck{};
    }
    void add(const PackedPart& part, const PackRecipe& recipe, std::size_t firstSphere) {
        const Run<3>& run = *part.run;
        const Report& r = run.report;
        PartReport one;
        one.name = recipe.name;
        one.source = describe(recipe.domain);
        one.requested = r.requested;
        one.count = r.count;
        one.volume = r.volume;
        one.area = r.area;
        one.solidFraction = r.solidFractionTotal.value_or(0);
        one.interior = r.solidFractionInterior;
        if (r.voids) one.bvtv = r.voids->bvtv;
        if (r.protrusion) one.protrusion = r.protrusion->max;
        one.density = particleDensity(recipe.density, r.solidFractionTotal).all;
        all_.parts.push_back(one);

        all_.count += r.count;
        all_.hash += r.hash;
        all_.volume += r.volume;
        all_.area += r.area;
        all_.domain.triangles += r.domain.triangles;
        all_.domain.meshVolume += r.domain.meshVolume;
        all_.domain.activeVoxels += r.domain.activeVoxels;
        all_.domain.boundaryEdges += r.domain.boundaryEdges;
        all_.domain.nonManifoldEdges += r.domain.nonManifoldEdges;
        all_.domain.voxelSize = std::max(all_.domain.voxelSize, r.domain.voxelSize);
        covered_ += one.solidFraction * r.volume;
        if (const double deep = 3 * r.radius.max;
            one.interior && deep <= run.filled().fieldDepth()) {
            const double volume = run.filled().volumeDeeperThan(deep);
            deepCovered_ += *one.interior * volume;
            deepVolume_ += volume;
        }
        if (r.protrusion) {
            ProtrusionCheck own = *r.protrusion;
            for (ProtrudingSphere& sphere : own.worst) sphere.i += firstSphere;
            all_.protrusion = joined(*all_.protrusion, own);
        }
        all_.interrupted = all_.interrupted || r.interrupted;
        all_.requestedGap = std::max(all_.requestedGap, r.requestedGap);
        for (const std::string& text : r.chosen) all_.chosen.push_back(recipe.name + ": " + text);
        // The first ones were there before.
        for (std::size_t w = begun_; w < r.warnings.size(); ++w)
            all_.warnings.push_back(recipe.name + ": " + r.warnings[w]);
        const auto& s = r.seconds;
        all_.seconds.domain += s.domain;
        all_.seconds.pack += s.pack;
        all_.seconds.densify += s.densify;
        all_.seconds.voids += s.voids;
    }
    void setBegun(std::size_t warnings) { begun_ = warnings; }
    void finish() {
        if (all_.volume > 0) all_.solidFractionTotal = covered_ / all_.volume;
        if (deepVolume_ > 0) all_.solidFractionInterior = deepCovered_ / deepVolume_;
        const auto& first = all_.parts.front().requested;
        const bool same = std::all_of(all_.parts.begin(), all_.parts.end(),
                                      [&](const PartReport& p) { return p.requested == first; });
        all_.requested = same ? first : "by part";
    }

private:
    Report& all_;
    std::size_t begun_ = 0;
    double covered_ = 0, deepCovered_ = 0, deepVolume_ = 0;
};

/// Whether any of some outputs lists pairs in contact.
bool listsContacts(const std::vector<OutputTarget>& outputs) {
    return std::any_of(outputs.begin(), outputs.end(),
                       [](const OutputTarget& output) { return output.listsPairs(); });
}

/// Grids of a part under the part's name.
void addLevelSets(const Run<3>& part, const std::string& name, Run<3>& all) {
    auto grids = part.voids.levelSets();
    if (grids.empty() && part.built.mesh) {
        all.partLevelSets.push_back(renamed(*part.built.mesh->grid(), name));
        return;
    }
    for (const auto& grid : grids)
        all.partLevelSets.push_back(renamed(*grid, name + " " + levelSetName(*grid)));
}

}  // namespace

RunResult packParts(const PackRecipe& recipe, const Parts& parts, const Report& begun, Clock& clock,
                    const Callbacks& callbacks) {
    std::vector<const DomainSource*> sources;
    for (const auto& part : parts) sources.push_back(&part->source);
    Report first = begun;
    beginOn(sources, recipe, recipe.voids, first, callbacks);
    if (recipe.preview.cut) {
        Box<3> box;
        for (const DomainSource* source : sources) {
            box.add(source->domainBounds().lo);
            box.add(source->domainBounds().hi);
        }
        checkPreviewCut(*recipe.preview.cut, box);
    }
    SharedRadii radii(recipe, parts);
    std::vector<PackedPart> packed(parts.size());
    bool interrupted = false;
    double measuring = 0;
    for (const std::size_t k : radii.order()) {
        Part& part = *parts[k];
        if (interrupted) break;
        radii.prepare(part.recipe, k);
        Callbacks own = callbacks;
        own.warning = [&](const std::string& text) {
            callbacks.warn(part.recipe.name + ": " + text);
        };
        try {
            packed[k] = packPart(part.recipe, part.source, begun, clock, own);
        } catch (const Interrupted&) {
            if (k == radii.order().front()) throw;  // none is complete
            interrupted = true;
            break;
        }
        measuring += clock.lap();
        radii.take(packed[k].options->sizes, k);
        interrupted = packed[k].run->report.interrupted;
    }
    Run<3> all(recipe, parts.front()->source, first, clock, callbacks);
    all.keepsPack = true;
    Report& report = all.report;
    JoinedReport joined(report);
    joined.setBegun(begun.warnings.size());
    all.pack.columns.push_back({kPartColumn, {}, {}});
    bool anyPosition = false;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        if (!packed[k].run) continue;
        Run<3>& run = *packed[k].run;
        joined.add(packed[k], parts[k]->recipe, all.pack.spheres.size());
        const double own = parts[k]->source.volume(), left = run.report.volume;
        if (parts[k]->source.isCut() && left < 0.99 * own)
            report.chosen.push_back(fmt::format("{}: {:.3g} % of its volume left to later parts",
                                                parts[k]->recipe.name, 100 * (1 - left / own)));
        append(all.pack, std::move(run.pack), static_cast<std::int32_t>(k));
        if (run.positionStep > 0)
            all.positionStep = all.positionStep > 0 ? std::min(all.positionStep, run.positionStep)
                                                    : run.positionStep;
        else
            anyPosition = true;
        addLevelSets(run, parts[k]->recipe.name, all);
        if (const auto& mesh = parts[k]->source.mesh()) append(all.partWalls, *mesh);
        all.partRuns.push_back(&run);
    }
    if (anyPosition) all.positionStep = 0;
    joined.finish();
    report.interrupted = interrupted;
    // Whatever is filled is the first part's for what needs one domain, such as a picture's frame.
    const std::size_t shown = radii.order().front();
    all.built = packed[shown].run->built;
    all.built.mesh = nullptr;

    report.seconds.measure = measuring;
    report.dim = 3;
    report.seed = recipe.seed;
    report.radius = radiusStatistics(all.pack.spheres);
    report.overlap = checkOverlap(all.pack.spheres);
    report.contactTolerance = recipe.contactTolerance;
    if (report.count > 0 && !interrupted) {
        ContactCheck contacts =
            countContacts(all.pack.spheres, recipe.contactTolerance, all.pack.depth);
        all.pack.contacts = std::move(contacts.counts);
        report.contacts = contacts;
        const auto& part = all.pack.columns.front().numbers;
        for (const Contact& c : listContacts(all.pack.spheres, recipe.contactTolerance))
            report.contactsBetweenParts += part[c.i] != part[c.j];
        report.smallestGap = smallestGap(all.pack.spheres);
    }
    if (report.contactsBetweenParts == 0 && !interrupted && listsContacts(recipe.outputs))
        all.callbacks.warn(fmt::format(
            "no contact joins two parts within `contactTolerance` {}; spheres of both sides touch "
            "the interface, but seldom at the same point: 0.1 finds some, 0.5 most neighbors",
            recipe.contactTolerance));
    const Materials materials(all.pack);
    for (std::size_t k = 0; k < parts.size(); ++k) {
        if (!packed[k].run) continue;
        const auto number = static_cast<std::int32_t>(k);
        const PackRecipe& part = parts[k]->recipe;
        if (!part.grey.modulus.empty() && part.grey.modulus != recipe.grey.modulus)
            all.partModulus[number] = part.grey.modulus;
        else if (!part.density.empty() && !recipe.grey.modulus.empty())
            all.callbacks.warn(fmt::format(
                "{}: its modulus follows from `modulus` {} and its density; set `modulus` in the "
                "part to the modulus of its material, MPa",
                part.name, recipe.grey.modulus));
        const SphereDensity density =
            particleDensity(parts[k]->recipe.density, packed[k].run->report.solidFractionTotal);
        for (const std::int32_t region : {0, 1}) {
            const auto found = density.ofRegions.find(region);
            const double value = found != density.ofRegions.end() ? found->second : density.all;
            if (value > 0) all.partDensity[materials.withoutClass(number, region)] = value;
        }
    }
    RunResult result = finishStage(all);
    writeReport(result, {}, recipe);
    return result;
}

}  // namespace vdbpack
