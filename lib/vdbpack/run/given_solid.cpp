#include "vdbpack/run/given_solid.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/domain_text.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/made_mesh.h"
#include "vdbpack/report/found_value.h"
#include "vdbpack/run/estimate.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/run_parts.h"
#include "vdbpack/run/solid_stage.h"

#include <utility>

namespace vdbpack {

namespace {

DomainRecipe recipeOf(const InputPack& recipe) {
    DomainRecipe solid = recipe.domain;
    if (!solid.source.empty())
        throw ParameterError("`domain` " + solid.source + ": goes with a pack, and " + recipe.pack +
                             " is a solid; leave it out");
    if (recipe.packUnit != Unit::millimeter && solid.unit != Unit::millimeter)
        throw ParameterError("`unit` and `packUnit`: both are the unit of " + recipe.pack +
                             "; give one of them");
    solid.source = recipe.pack;
    if (recipe.packUnit != Unit::millimeter) solid.unit = recipe.packUnit;
    if (!recipe.packGrid.empty()) solid.gridName = recipe.packGrid;
    return solid;
}

}  // namespace

std::optional<Pack<3>> packUnlessSolid(const InputPack& recipe, const Callbacks& callbacks) {
    const DomainRecipe& domain = recipe.domain;
    const bool isFog =
        domain.source.empty() && domain.threshold && extensionOf(recipe.pack) == ".vdb";
    if (!recipe.given &&
        (isFog || namesImage(recipe.pack) || parseShape(recipe.pack, domain.periodic)))
        return std::nullopt;
    return readInputPackUnlessSolid(recipe, callbacks);
}

GivenSolid::GivenSolid(std::string name, std::shared_ptr<const DomainSource> source,
                       const InputPack& settings, const Callbacks& callbacks)
    : name_(std::move(name)),
      source_(std::move(source)),
      settings_(settings),
      callbacks_(callbacks) {}

std::shared_ptr<const VdbGrid> GivenSolid::levelSet() const {
    if (source_->isWhole() && source_->levelSet()) return source_->levelSet();
    double voxel = settings_.domain.voxelSize;
    if (source_->isWhole() && source_->mesh())
        return fieldOfMesh(*source_->mesh(), source_->recipe(), 0, settings_, voxel, callbacks_)
            ->grid();
    // What clips leave may be much smaller than the whole.
    const bool isChosen = !(voxel > 0);
    if (isChosen) voxel = shapeVoxelSize(source_->domainBounds());
    for (;;) {
        const double detail = voxel / kVoxelPerDetail;
        requireResources(extentOf(*source_, detail, voxel, voxel), settings_);
        const auto built = source_->build(detail, voxel, callbacks_, voxel);
        const double finer = isChosen ? shapeVoxelSize(built.space->bounds()) : voxel;
        if (!(finer < 0.9 * voxel)) return surfaceLevelSet(*built.space, voxel);
        voxel = finer;
    }
}

const TriangleMesh& GivenSolid::surface() {
    if (source_->isWhole() && source_->mesh()) return *source_->mesh();
    if (!made_.triangles.empty()) return made_;
    const DomainRecipe& recipe = source_->recipe();
    const auto shape = parseShape(recipe.source, recipe.periodic);
    const bool isBox = source_->isWhole() && shape && shape->kind == NamedShape::Kind::box;
    made_ = isBox ? boxMesh(shape->box) : levelSetMesh(*levelSet(), recipe.source);
    return made_;
}

std::vector<GivenSolid> givenSolids(const InputPack& recipe, FoundValues& found,
                                    const Callbacks& callbacks) {
    PackRecipe parted;
    parted.domain = recipeOf(recipe);
    Parts parts = partsOf(parted, callbacks);
    if (parts.empty()) {
        PackRecipe whole = parted;
        whole.name = parted.domain.label;
        auto source = std::make_shared<DomainSource>(parted.domain, callbacks);
        parts.push_back({std::move(whole), std::move(source)});
    }
    DomainRecipe used = parted.domain;
    used.voxelSize = 0;  // of the level set
    warnOfUnused(used, *parts.front().source, callbacks);
    addThreshold(found, parts.front().source->recipe());
    std::vector<GivenSolid> solids;
    for (Part& part : parts) {
        if (part.source->dim() != 3)
            throw ParameterError(recipe.pack +
                                 ": is plane, and has no surface; give a 3D domain, without "
                                 "`slice`");
        solids.emplace_back(part.recipe.name, std::move(part.source), recipe, callbacks);
    }
    return solids;
}

TriangleMesh joinedSurface(std::vector<GivenSolid>& solids) {
    TriangleMesh all;
    for (GivenSolid& solid : solids) append(all, solid.surface());
    return all;
}

}  // namespace vdbpack
