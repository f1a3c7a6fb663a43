#include "vdbpack/voids/void_recipe.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/voids/scalar_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

constexpr std::array<std::pair<const char*, VoidMethod>, 8> kMethods{
    {{"grid", VoidMethod::grid},
     {"overlay", VoidMethod::overlay},
     {"concentric", VoidMethod::concentric},
     {"threshold", VoidMethod::threshold},
     {"mixed", VoidMethod::mixed},
     {"ellipses", VoidMethod::ellipses},
     {"boolean", VoidMethod::boolean},
     {"foam", VoidMethod::foam}}};

bool isOneOf(VoidMethod method, const std::vector<VoidMethod>& methods) {
    return std::find(methods.begin(), methods.end(), method) != methods.end();
}

void requireShare(const char* name, const std::optional<double>& value, const char* range,
                  bool zero, bool one) {
    if (!value) return;
    if (!(zero ? *value >= 0 : *value > 0) || !(one ? *value <= 1 : *value < 1))
        throw ParameterError(fmt::format("`{}` {}: must lie in {}", name, *value, range));
}

void requireLength(const char* name, double value) {
    if (!(value > 0) || !std::isfinite(value))
        throw ParameterError(fmt::format("`{}` {}: must be a positive length in mm", name, value));
}

/// A parameter, whether it is given, and the methods that use it.
struct Use {
    const char* name;
    bool given;
    std::vector<VoidMethod> methods;
};

std::vector<Use> usesOf(const VoidRecipe& r) {
    using M = VoidMethod;
    const std::vector<M> all{M::grid,     M::overlay, M::concentric, M::threshold, M::mixed,
                             M::ellipses, M::boolean, M::foam,       M::list};
    const std::vector<M> stamped{M::grid,    M::overlay, M::mixed, M::ellipses,
                                 M::boolean, M::foam,    M::list};
    const std::vector<M> shaped{M::overlay, M::ellipses, M::boolean, M::foam};
    return {{"voids.radius",
             !r.radius.empty(),
             {M::overlay, M::mixed, M::ellipses, M::boolean, M::foam}},
            {"voids.blend", r.blend.has_value(), stamped},
            {"voids.strut", r.strut.has_value(), stamped},
            {"voids.strutShare", r.strutShare.has_value(), stamped},
            {"voids.jitter", r.jitter.has_value(), {M::foam}},
            {"voids.aspect", !r.aspect.empty(), shaped},
            {"voids.count", r.count.has_value(), {M::overlay, M::boolean}},
            {"voids.probability", r.probability.has_value(), {M::grid, M::mixed, M::ellipses}},
            {"deleteFraction", r.deleteFraction.has_value(), {M::concentric, M::threshold}},
            {"matrix", !r.matrix.empty(), {M::grid}},
            {"cell", !r.cell.empty(), {M::grid}},
            {"orientation.angles", !r.orientation.angles.empty(), shaped},
            {"orientation.axis", !r.orientation.axis.empty(), shaped},
            {"orientation.field", !r.orientation.field.empty(), shaped},
            {"voids.voxelSize", r.voxelSize > 0, stamped},
            {"like", !r.like.empty(), {M::foam}},
            {"trabecular", !r.trabecular.empty(), {M::foam}},
            {"targetBvtv",
             r.targetBvtv.has_value(),
             {M::grid, M::overlay, M::concentric, M::threshold, M::mixed, M::ellipses, M::boolean,
              M::foam}},
            {"bvtvField", !r.bvtvField.empty(), {M::boolean, M::foam}},
            {"bvtvRange", !r.bvtvRange.empty(), {M::boolean, M::foam}},
            {"targetTbth", r.targetTbth.has_value(), {M::boolean, M::foam}},
            {"targetTbsp", r.targetTbsp.has_value(), {M::foam}},
            {"targetDa", r.targetDa.has_value(), {M::foam}},
            {"targetConnd", r.targetConnd.has_value(), {M::foam}},
            {"keepConnected", r.keepConnected, all},
            {"cull",
             r.cull == Cull::touch,
             {M::grid, M::overlay, M::ellipses, M::boolean, M::foam, M::list}}};
}

/// Refuses parameters that the method does not use.
void requireUse(const VoidRecipe& r, VoidMethod method) {
    for (const Use& use : usesOf(r)) {
        if (!use.given || isOneOf(method, use.methods)) continue;
        if (method == VoidMethod::none)
            throw ParameterError(fmt::format(
                "`{}` is given, but no voids are requested; choose how they are made with "
                "`voids` (foam, boolean, grid, overlay, ...)",
                use.name));
        std::string others;
        for (const auto& [name, m] : kMethods)
            if (isOneOf(m, use.methods)) others += (others.empty() ? "" : ", ") + std::string(name);
        throw ParameterError(fmt::format("`{}` is not used by `voids` {}; it is used by {}",
                                         use.name, r.method, others));
    }
}

/// Refuses a method that the run cannot perform.
void requireInput(const VoidRecipe& r, VoidMethod method, bool hasSpheres, bool hasFront) {
    if (needsFront(method) && !hasFront)
        throw ParameterError(
            fmt::format("`voids` {} makes its voids during packing, and this run packs nothing; "
                        "choose overlay or boolean here",
                        r.method));
    if (isThinning(method) && !hasSpheres)
        throw ParameterError(
            fmt::format("`voids` {} removes spheres, and this run has none; choose grid, "
                        "overlay or boolean here",
                        r.method));
}

/// Refuses values out of range.
void requireRanges(const VoidRecipe& r, VoidMethod method) {
    requireShare("voids.probability", r.probability, needsFront(method) ? "[0, 1)" : "[0, 1]", true,
                 !needsFront(method));
    requireShare("deleteFraction", r.deleteFraction, "(0, 1]", false, true);
    requireShare("targetBvtv", r.targetBvtv, "(0, 1)", false, false);
    if (r.targetTbth) requireLength("targetTbth", *r.targetTbth);
    if (r.targetTbsp) requireLength("targetTbsp", *r.targetTbsp);
    if (r.targetConnd && !(*r.targetConnd > 0 && std::isfinite(*r.targetConnd)))
        throw ParameterError(
            fmt::format("`targetConnd` {}: must be above 0, in 1/mm³", *r.targetConnd));
    if (r.targetDa && !(*r.targetDa >= 0 && *r.targetDa < 1))
        throw ParameterError(fmt::format(
            "`targetDa` {}: must lie in [0, 1): 1 - (short / long)² of the mean intercept lengths. "
            "From a ratio R = long / short of other programs it is 1 - 1 / R²",
            *r.targetDa));
    if (r.voxelSize != 0) requireLength("voids.voxelSize", r.voxelSize);
    requireShare("voids.jitter", r.jitter, "[0, 1]", true, true);
    requireShare("voids.strutShare", r.strutShare, "[0, 1]", true, true);
    if (r.strut && !(*r.strut >= 0 && std::isfinite(*r.strut)))
        throw ParameterError(
            fmt::format("`voids.strut` {}: must be a thickness in mm, 0 or more", *r.strut));
    if (r.blend && !(*r.blend >= 0 && std::isfinite(*r.blend)))
        throw ParameterError(
            fmt::format("`voids.blend` {}: must be a length in mm, 0 or more", *r.blend));
    if (r.count && !(*r.count >= 1 && *r.count < 4e9))
        throw ParameterError(
            fmt::format("`voids.count` {}: must be a number of voids from 1 to 4e9", *r.count));
}

/// BV/TV of plates, and of rods that are as thin as those of a cubic lattice, as shares of what
/// Tb.Th and Tb.Sp say: bounds with room to spare. Foams of BV/TV 0.47 have 1.4 of the first.
constexpr double kMostOfPlates = 1.6, kLeastOfRods = 0.6;

/// Refuses a thickness, spacing and BV/TV that no structure has together.
void requireConsistent(const VoidRecipe& r) {
    if (!(r.targetBvtv && r.targetTbth && r.targetTbsp)) return;
    const double share = *r.targetTbth / (*r.targetTbth + *r.targetTbsp);
    const double most = kMostOfPlates * share, least = kLeastOfRods * share * share;
    if (*r.targetBvtv <= most && *r.targetBvtv >= least) return;
    throw ParameterError(fmt::format(
        "`targetBvtv` {:g} contradicts `targetTbth` {:g} and `targetTbsp` {:g}: rods of that "
        "thickness and spacing have at least {:.2g}, plates at most {:.2g}; change one of them",
        *r.targetBvtv, *r.targetTbth, *r.targetTbsp, least, std::min(most, 1.0)));
}

/// Refuses two parameters that both determine the amount of voids, or none.
void requireOneAmount(const VoidRecipe& r, VoidMethod method, bool hasSpheres) {
    if (r.bvtvField.empty() && !r.bvtvRange.empty())
        throw ParameterError("`bvtvRange` " + r.bvtvRange +
                             ": says what grey values mean; set `bvtvField`");
    if (!r.bvtvField.empty() && r.bvtvRange.empty() && !namesScalarField(r.bvtvField))
        throw ParameterError(
            "`bvtvField` " + r.bvtvField +
            ": set `bvtvRange` to the grey values of marrow and of bone, such as 0,1200");
    if (!r.bvtvRange.empty()) parseBvtvRange(r.bvtvRange);
    if (!r.bvtvField.empty() && r.count)
        throw ParameterError(
            "`voids.count` and `bvtvField` both determine the amount of voids; give one of them");
    if (r.targetTbth && !r.targetBvtv && method != VoidMethod::foam)
        throw ParameterError(
            "`targetTbth` fixes the thickness at a given BV/TV; give `targetBvtv` as well");
    const std::pair<bool, const char*> amounts[] = {
        {r.count.has_value(), "voids.count"},
        {r.probability.has_value(), "voids.probability"},
        {r.deleteFraction.has_value(), "deleteFraction"},
        {!r.matrix.empty(), "matrix"}};
    for (const auto& [given, name] : amounts)
        if (given && r.targetBvtv)
            throw ParameterError(fmt::format(
                "`{}` and `targetBvtv` both determine the amount of voids; give one of them",
                name));
    if (isThinning(method) && !r.deleteFraction && !r.targetBvtv)
        throw ParameterError(
            fmt::format("`voids` {} needs `deleteFraction` or `targetBvtv`", r.method));
    if (method == VoidMethod::grid && r.matrix.empty() && r.cell.empty())
        throw ParameterError("`voids` grid needs `matrix` or `cell`");
    const bool sized =
        isOneOf(method, {VoidMethod::overlay, VoidMethod::boolean, VoidMethod::foam});
    const bool scaled = method == VoidMethod::foam &&
                        (r.targetTbth || r.targetTbsp || r.targetConnd || !r.like.empty());
    if (sized && r.radius.empty() && !hasSpheres && !scaled)
        throw ParameterError(
            method == VoidMethod::foam
                ? "the size of a foam is not given; add `targetTbth`, `targetTbsp`, `targetConnd`, "
                  "or `voids.radius`, the shorter half-axis of its voids in mm"
                : fmt::format("`voids` {} needs `voids.radius`, the shorter half-axis in mm",
                              r.method));
}

}  // namespace

std::pair<double, double> parseBvtvRange(const std::string& text) {
    const auto numbers = parseNumberList(text);
    if (!numbers || numbers->size() != 2 || (*numbers)[0] == (*numbers)[1])
        throw ParameterError("`bvtvRange` '" + text +
                             "': write MARROW,BONE, the grey values at BV/TV 0 and 1, such as "
                             "0,1200");
    return {(*numbers)[0], (*numbers)[1]};
}

VoidMethod methodOf(const VoidRecipe& recipe) {
    if (recipe.method.empty()) return VoidMethod::none;
    for (const auto& [name, method] : kMethods)
        if (recipe.method == name) return method;
    if (recipe.method.rfind("list:", 0) == 0 && recipe.method.size() > 5) return VoidMethod::list;
    std::string names;
    for (const auto& [name, method] : kMethods) names += std::string(name) + ", ";
    throw ParameterError(
        fmt::format("`voids` {}: must be one of {}list:FILE", recipe.method, names));
}

std::string listFile(const VoidRecipe& recipe) {
    return methodOf(recipe) == VoidMethod::list ? recipe.method.substr(5) : std::string();
}

bool hasStructureTargets(const VoidRecipe& r) {
    return methodOf(r) == VoidMethod::foam &&
           (r.targetTbth || r.targetTbsp || r.targetDa || r.targetConnd);
}

bool scalesVoids(const VoidRecipe& r) {
    return r.targetTbth || (hasStructureTargets(r) && (r.targetTbsp || r.targetConnd));
}

bool isThinning(VoidMethod method) {
    return method == VoidMethod::concentric || method == VoidMethod::threshold;
}

bool needsFront(VoidMethod method) {
    return method == VoidMethod::mixed || method == VoidMethod::ellipses;
}

void checkVoids(const VoidRecipe& r, bool hasSpheres, bool hasFront) {
    const VoidMethod method = methodOf(r);
    if (!(r.shell >= 0) || !std::isfinite(r.shell))
        throw ParameterError(
            fmt::format("`voids.shell` {}: must be a thickness in mm, 0 or more", r.shell));
    if (!r.shellField.empty() && r.shell > 0)
        throw ParameterError(
            "`voids.shell` and `shellField` both set the thickness of the shell; "
            "give one of them");
    if (!r.shellField.empty() && (method == VoidMethod::overlay || needsFront(method)))
        throw ParameterError("`shellField`: `voids` " + r.method +
                             " need a shell of one thickness; use `shell`, or voids that are cut "
                             "afterwards, such as boolean");
    if (method != VoidMethod::none) requireInput(r, method, hasSpheres, hasFront);
    requireUse(r, method);
    if (method == VoidMethod::none) return;
    requireRanges(r, method);
    requireConsistent(r);
    requireOneAmount(r, method, hasSpheres);
}

}  // namespace vdbpack
