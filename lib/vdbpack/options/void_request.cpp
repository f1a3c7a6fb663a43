#include "vdbpack/options/void_request.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/suggest.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/option_rows.h"
#include "vdbpack/voids/trabecular_presets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// An option that some methods alone use.
struct Use {
    const char* name;
    bool given;
    const char* methods;  ///< "list" for list:FILE
};

std::vector<Use> usesOf(const VoidRequest& r) {
    const char* const stamped = "grid overlay mixed ellipses boolean foam list";
    const char* const shaped = "overlay ellipses boolean foam";
    return {{"voids.radius", !r.radius.empty(), "overlay mixed ellipses boolean foam"},
            {"voids.blend", r.blend.has_value(), stamped},
            {"voids.strut", r.strut.has_value(), stamped},
            {"voids.strutShare", r.strutShare.has_value(), stamped},
            {"voids.jitter", r.jitter.has_value(), "foam"},
            {"voids.aspect", !r.aspect.empty(), shaped},
            {"voids.count", r.count.has_value(), "overlay boolean"},
            {"voids.probability", r.probability.has_value(), "grid mixed ellipses"},
            {"deleteFraction", r.deleteFraction.has_value(), "concentric threshold"},
            {"matrix", !r.matrix.empty(), "grid"},
            {"cell", !r.cell.empty(), "grid"},
            {"orientation.angles", r.orientation.angles.has_value(), shaped},
            {"orientation.axis", r.orientation.axis.has_value(), shaped},
            {"orientation.field", !r.orientation.field.empty(), shaped},
            {"voids.voxelSize", r.voxelSize > 0, stamped},
            {"like", !r.like.empty(), "foam"},
            {"trabecular", !r.trabecular.empty(), "foam"},
            {"targetBvtv", r.targetBvtv.has_value(),
             "grid overlay concentric threshold mixed ellipses boolean foam"},
            {"bvtvField", !r.bvtvField.empty(), "boolean foam"},
            {"bvtvRange", !r.bvtvRange.empty(), "boolean foam"},
            {"targetTbth", r.targetTbth.has_value(), "boolean foam"},
            {"targetTbsp", r.targetTbsp.has_value(), "foam"},
            {"targetDa", r.targetDa.has_value(), "foam"},
            {"targetConnd", r.targetConnd.has_value(), "foam"},
            {"keepConnected", r.keepConnected,
             "grid overlay concentric threshold mixed ellipses boolean foam list"},
            {"measureSolid", r.measureSolid, "grid overlay boolean foam list"},
            {"cull", r.cull == Cull::touch, "grid overlay ellipses boolean foam list"}};
}

/// Refuses options that the method does not use.
void requireUse(const VoidRequest& r) {
    const std::string method = startsWith(r.method, "list:") ? "list" : r.method;
    for (const Use& use : usesOf(r)) {
        const auto methods = splitAt(use.methods, ' ');
        if (!use.given || std::find(methods.begin(), methods.end(), method) != methods.end())
            continue;
        if (method.empty())
            throw ParameterError(fmt::format(
                "`{}` is given, but no voids are requested; choose how they are made with "
                "`voids` (foam, boolean, grid, overlay, ...)",
                use.name));
        throw ParameterError(fmt::format("`{}` is not used by `voids` {}; it is used by {}",
                                         use.name, r.method, fmt::join(methods, ", ")));
    }
}

/// The request with the numbers of its preset as targets where it has none, and with the method
/// that targets need if it names none.
VoidRequest completed(VoidRequest r) {
    if (r.like.empty() && (r.likeThreshold || !r.likeDomain.empty()))
        throw ParameterError(fmt::format("`{}` is given without a sample; set `like`",
                                         r.likeThreshold ? "likeThreshold" : "likeDomain"));
    if (!r.trabecular.empty()) {
        const TrabecularPreset& p = trabecularPreset(r.trabecular);
        for (const auto& [target, value] :
             {std::pair{&r.targetBvtv, &p.bvtv}, std::pair{&r.targetTbth, &p.tbth},
              std::pair{&r.targetTbsp, &p.tbsp}, std::pair{&r.targetDa, &p.da},
              std::pair{&r.targetConnd, &p.connd}})
            if (!*target) *target = *value;
    }
    const bool shaped = r.targetTbsp || r.targetDa || r.targetConnd || r.targetTbth;
    if (r.method.empty() && (shaped || !r.like.empty())) r.method = "foam";
    return r;
}

VoidShapeRecipe shapeOf(const VoidRequest& r) {
    VoidShapeRecipe shape;
    shape.radius = sizesOf("void-radius", r.radius);
    shape.aspect = sizesOf("void-aspect", r.aspect);
    shape.orientation = r.orientation;
    return shape;
}

BvtvField bvtvFieldOf(const VoidRequest& r) {
    BvtvField field;
    field.file = r.bvtvField;
    if (r.bvtvRange.empty()) return field;
    const auto numbers = parseNumberList(r.bvtvRange);
    if (!numbers || numbers->size() != 2)
        throw ParameterError("`bvtvRange` '" + r.bvtvRange +
                             "': write MARROW,BONE, the grey values at BV/TV 0 and 1, such as "
                             "0,1200");
    field.range = {(*numbers)[0], (*numbers)[1]};
    return field;
}

GridVoids gridOf(const VoidRequest& r) {
    GridVoids grid{r.matrix, {}, r.probability, r.targetBvtv};
    if (r.cell.empty()) return grid;
    grid.cell = parseNumberList(r.cell).value_or(std::vector<double>{});
    if (grid.cell.empty())
        throw ParameterError("`cell` " + r.cell +
                             ": write the side of a box in mm, or one side a direction: X,Y,Z");
    return grid;
}

FoamVoids foamOf(const VoidRequest& r) {
    FoamVoids foam;
    foam.shape = shapeOf(r);
    foam.jitter = r.jitter;
    foam.targetBvtv = r.targetBvtv;
    foam.bvtvField = bvtvFieldOf(r);
    foam.targets.tbth = r.targetTbth;
    foam.targets.tbsp = r.targetTbsp;
    foam.targets.da = r.targetDa;
    foam.targets.connd = r.targetConnd;
    foam.targets.ofBone = !r.trabecular.empty();
    foam.like = {r.like, r.likeDomain, r.likeThreshold};
    return foam;
}

VoidMethod methodOf(const VoidRequest& r) {
    if (r.method.empty()) return {};
    if (r.method == "grid") return gridOf(r);
    if (r.method == "overlay") return OverlayVoids{shapeOf(r), r.count, r.targetBvtv};
    if (r.method == "boolean")
        return BooleanVoids{shapeOf(r), r.count, r.targetBvtv, bvtvFieldOf(r), r.targetTbth};
    if (r.method == "foam") return foamOf(r);
    if (startsWith(r.method, "list:") && r.method.size() > 5)
        return ListedVoids{r.method.substr(5)};
    if (r.method == "concentric" || r.method == "threshold")
        return Thinning{
            r.method == "threshold" ? Thinning::By::threshold : Thinning::By::concentric,
            r.deleteFraction, r.targetBvtv};
    if (r.method == "mixed" || r.method == "ellipses")
        return FrontHoles{
            r.method == "mixed" ? FrontHoles::As::spheres : FrontHoles::As::ellipsoids, shapeOf(r),
            r.probability, r.targetBvtv};
    throw ParameterError(
        fmt::format("`voids` {}: must be one of grid, overlay, concentric, threshold, mixed, "
                    "ellipses, boolean, foam, list:FILE{}",
                    r.method,
                    similarWord(r.method, {"grid", "overlay", "concentric", "threshold", "mixed",
                                           "ellipses", "boolean", "foam"})));
}

}  // namespace

VoidRecipe voidsOf(const VoidRequest& given) {
    const VoidRequest r = completed(given);
    VoidRecipe recipe;
    recipe.method = methodOf(r);
    requireUse(r);
    recipe.shell = r.shell;
    recipe.shellField = r.shellField;
    recipe.fill = r.fill;
    recipe.cull = r.cull;
    recipe.keepConnected = r.keepConnected;
    recipe.measureSolid = r.measureSolid;
    recipe.voxelSize = r.voxelSize;
    recipe.blend = r.blend;
    recipe.strut = r.strut;
    recipe.strutShare = r.strutShare;
    return recipe;
}

}  // namespace vdbpack
