#include "vdbpack/voids/void_recipe.h"

#include "vdbpack/core/error.h"
#include "vdbpack/voids/scalar_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace vdbpack {

namespace {

using Value = std::optional<double>;

void require(const char* name, const Value& value, bool good, const std::string& what) {
    if (value && !good) throw ParameterError(fmt::format("`{}` {}: must {}", name, *value, what));
}

/// From 0 to 1, with or without these.
void requireShare(const char* name, const Value& v, bool zero, bool one) {
    require(
        name, v, v && (zero ? *v >= 0 : *v > 0) && (one ? *v <= 1 : *v < 1),
        fmt::format(
            "lie in {}0, 1{}{}", zero ? '[' : '(', one ? ']' : ')',
            v && *v > 1 && *v <= 100 ? fmt::format("; write {:g} for {:g} %", *v / 100, *v) : ""));
}

void requireLength(const char* name, const Value& v) {
    require(name, v, v && *v > 0 && std::isfinite(*v), "be a positive length in mm");
}

void requireNotNegative(const char* name, const Value& v) {
    require(name, v, v && *v >= 0 && std::isfinite(*v), "be a length in mm, 0 or more");
}

/// Refuses a second parameter that determines the amount of voids.
void requireOneAmount(const char* name, bool given, const char* other, bool otherGiven) {
    if (given && otherGiven)
        throw ParameterError(fmt::format(
            "`{}` and `{}` both determine the amount of voids; give one of them", name, other));
}
void requireOneAmount(const char* name, bool given, const Value& targetBvtv) {
    requireOneAmount(name, given, "targetBvtv", targetBvtv.has_value());
}

void checkField(const BvtvField& field) {
    const std::string range =
        field.range ? fmt::format("`bvtvRange` {},{}: ", field.range->first, field.range->second)
                    : "";
    if (field.empty() && field.range)
        throw ParameterError(range + "gives the meaning of grey values; set `bvtvField`");
    if (field.range && field.range->first == field.range->second)
        throw ParameterError(range + "the values of marrow and bone must differ");
    if (!field.empty() && !field.range && !namesScalarField(field.file))
        throw ParameterError(
            "`bvtvField` " + field.file +
            ": set `bvtvRange` to the grey values of marrow and of bone, such as 0,1200");
}

/// BV/TV of plates, and of rods that are as thin as those of a cubic lattice, as shares of what
/// Tb.Th and Tb.Sp give: bounds with room to spare. Foams of BV/TV 0.47 have 1.4 of the first.
constexpr double kMostOfPlates = 1.6, kLeastOfRods = 0.6;

/// Refuses a thickness, spacing and BV/TV that no structure has together.
void requireConsistent(const FoamVoids& foam) {
    const FoamTargets& t = foam.targets;
    if (!(foam.targetBvtv && t.tbth && t.tbsp)) return;
    const double share = *t.tbth / (*t.tbth + *t.tbsp);
    const double most = kMostOfPlates * share, least = kLeastOfRods * share * share;
    if (*foam.targetBvtv <= most && *foam.targetBvtv >= least) return;
    throw ParameterError(fmt::format(
        "`targetBvtv` {:g} contradicts `targetTbth` {:g} and `targetTbsp` {:g}: rods of that "
        "thickness and spacing have at least {:.2g}, plates at most {:.2g}; change one of them",
        *foam.targetBvtv, *t.tbth, *t.tbsp, least, std::min(most, 1.0)));
}

/// The rules of each method.
struct MethodCheck {
    std::string name;
    bool hasSpheres, hasFront;

    void operator()(std::monostate) const {}
    void operator()(const ListedVoids&) const {}
    void operator()(const GridVoids& m) const {
        requireShare("voids.probability", m.probability, true, true);
        requireOneAmount("voids.probability", m.probability.has_value(), m.targetBvtv);
        requireOneAmount("matrix", !m.matrix.empty(), m.targetBvtv);
        if (m.matrix.empty() && m.cell.empty())
            throw ParameterError("`voids` grid needs `voids.matrix` or `cell`");
    }
    void operator()(const OverlayVoids& m) const { checkAmount(m); }
    void operator()(const BooleanVoids& m) const {
        requireOneAmount("voids.count", m.count.has_value(), "bvtvField", !m.bvtvField.empty());
        checkField(m.bvtvField);
        requireLength("targetTbth", m.targetTbth);
        if (m.targetTbth && !m.targetBvtv)
            throw ParameterError(
                "`targetTbth` fixes the thickness at a given BV/TV; give `targetBvtv` as well");
        checkAmount(m);
    }
    void operator()(const FoamVoids& m) const {
        const FoamTargets& t = m.targets;
        requireShare("voids.jitter", m.jitter, true, true);
        checkField(m.bvtvField);
        requireLength("targetTbth", t.tbth);
        requireLength("targetTbsp", t.tbsp);
        require("targetConnd", t.connd, t.connd && *t.connd > 0 && std::isfinite(*t.connd),
                "be above 0, in 1/mm³");
        require("targetDa", t.da, t.da && *t.da >= 0 && *t.da < 1,
                "lie in [0, 1): 1 - (short / long)² of the mean intercept lengths. From a ratio R "
                "= long / short of other programs it is 1 - 1 / R²");
        requireConsistent(m);
        if (m.shape.radius.empty() && !hasSpheres && !t.scale() && m.like.file.empty())
            throw ParameterError(
                "the size of a foam is not given; add `targetTbth`, `targetTbsp`, `targetConnd`, "
                "or `voids.radius`, the shorter half-axis of its voids in mm");
    }
    void operator()(const Thinning& m) const {
        if (!hasSpheres)
            fail("removes spheres, and this run has none; choose grid, overlay or boolean here");
        requireShare("deleteFraction", m.fraction, false, true);
        requireOneAmount("deleteFraction", m.fraction.has_value(), m.targetBvtv);
        if (!m.fraction && !m.targetBvtv) fail("needs `deleteFraction` or `targetBvtv`");
    }
    void operator()(const FrontHoles& m) const {
        if (!hasFront)
            fail(
                "makes its voids during packing, and this run packs nothing; choose overlay or "
                "boolean here");
        requireShare("voids.probability", m.probability, true, false);
        requireOneAmount("voids.probability", m.probability.has_value(), m.targetBvtv);
    }

private:
    [[noreturn]] void fail(const char* why) const {
        throw ParameterError(fmt::format("`voids` {} {}", name, why));
    }
    template <class Method>
    void checkAmount(const Method& m) const {
        require("voids.count", m.count, m.count && *m.count >= 1 && *m.count < 4e9,
                "be a number of voids from 1 to 4e9");
        requireOneAmount("voids.count", m.count.has_value(), m.targetBvtv);
        if (m.shape.radius.empty() && !hasSpheres)
            fail("needs `voids.radius`, the shorter half-axis in mm");
    }
};

/// A member that some methods have: `get` of the method, or `none`.
template <class Result, class Method, class Get>
Result ifAny(Method& method, Result none, const Get& get) {
    return std::visit(
        [&](auto& m) -> Result {
            if constexpr (std::is_invocable_v<Get, decltype(m)>)
                return get(m);
            else
                return none;
        },
        method);
}

}  // namespace

std::string nameOf(const VoidRecipe& recipe) {
    if (const auto* listed = recipe.as<ListedVoids>()) return "list:" + listed->file;
    if (const auto* thinning = recipe.as<Thinning>())
        return thinning->by == Thinning::By::concentric ? "concentric" : "threshold";
    if (const auto* holes = recipe.as<FrontHoles>())
        return holes->as == FrontHoles::As::spheres ? "mixed" : "ellipses";
    // In the order of the variant.
    constexpr const char* kNames[] = {"", "grid", "overlay", "boolean", "foam"};
    return kNames[recipe.method.index()];
}

const VoidShapeRecipe* shapeOf(const VoidRecipe& recipe) {
    return ifAny<const VoidShapeRecipe*>(
        recipe.method, nullptr, [](const auto& m) -> decltype(&m.shape) { return &m.shape; });
}

VoidShapeRecipe* shapeOf(VoidRecipe& recipe) {
    return const_cast<VoidShapeRecipe*>(shapeOf(static_cast<const VoidRecipe&>(recipe)));
}

const BvtvField* bvtvFieldOf(const VoidRecipe& recipe) {
    return ifAny<const BvtvField*>(recipe.method, nullptr,
                                   [](const auto& m) -> decltype(&m.bvtvField) {
                                       return m.bvtvField.empty() ? nullptr : &m.bvtvField;
                                   });
}

std::optional<double> targetBvtvOf(const VoidRecipe& recipe) {
    return ifAny<Value>(recipe.method, {},
                        [](const auto& m) -> decltype(m.targetBvtv) { return m.targetBvtv; });
}

std::optional<double> targetTbthOf(const VoidRecipe& recipe) {
    if (const auto* boolean = recipe.as<BooleanVoids>()) return boolean->targetTbth;
    if (const auto* foam = recipe.as<FoamVoids>()) return foam->targets.tbth;
    return std::nullopt;
}

void setTargetBvtv(VoidRecipe& recipe, double bvtv) {
    ifAny<bool>(recipe.method, false, [bvtv](auto& m) -> decltype(m.targetBvtv.has_value()) {
        m.targetBvtv = bvtv;
        return true;
    });
}

bool hasStructureTargets(const VoidRecipe& recipe) {
    const auto* foam = recipe.as<FoamVoids>();
    return foam && foam->targets.any();
}

bool scalesVoids(const VoidRecipe& recipe) {
    const auto* foam = recipe.as<FoamVoids>();
    return targetTbthOf(recipe) || (foam && foam->targets.scale());
}

void checkVoids(const VoidRecipe& r, bool hasSpheres, bool hasFront) {
    requireNotNegative("voids.shell", r.shell);
    if (!r.shellField.empty() && r.shell > 0)
        throw ParameterError(
            "`voids.shell` and `shellField` both set the thickness of the shell; give one of them");
    if (!r.shellField.empty() && (r.as<OverlayVoids>() || r.as<FrontHoles>()))
        throw ParameterError("`shellField`: `voids` " + nameOf(r) +
                             " need a shell of one thickness; use `shell`, or voids that are cut "
                             "afterwards, such as boolean");
    requireShare("targetBvtv", targetBvtvOf(r), false, false);
    if (r.voxelSize != 0) requireLength("voids.voxelSize", r.voxelSize);
    requireShare("voids.strutShare", r.strutShare, true, true);
    requireNotNegative("voids.strut", r.strut);
    requireNotNegative("voids.blend", r.blend);
    std::visit(MethodCheck{nameOf(r), hasSpheres, hasFront}, r.method);
}

}  // namespace vdbpack
