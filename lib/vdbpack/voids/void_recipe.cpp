#include "vdbpack/voids/void_recipe.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

constexpr std::array<std::pair<const char*, VoidMethod>, 7> kMethods{
    {{"grid", VoidMethod::grid},
     {"overlay", VoidMethod::overlay},
     {"concentric", VoidMethod::concentric},
     {"threshold", VoidMethod::threshold},
     {"mixed", VoidMethod::mixed},
     {"ellipses", VoidMethod::ellipses},
     {"boolean", VoidMethod::boolean}}};

bool isOneOf(VoidMethod method, std::initializer_list<VoidMethod> methods) {
    for (const VoidMethod m : methods)
        if (m == method) return true;
    return false;
}

void requireShare(const char* option, const std::optional<double>& value, const char* range,
                  bool zero, bool one) {
    if (!value) return;
    if (!(zero ? *value >= 0 : *value > 0) || !(one ? *value <= 1 : *value < 1))
        throw ParameterError(fmt::format("{} {}: must lie in {}", option, *value, range));
}

void requireLength(const char* option, double value) {
    if (!(value > 0) || !std::isfinite(value))
        throw ParameterError(fmt::format("{} {}: must be a positive length in mm", option, value));
}

/// Options that only some methods use.
void requireUse(const VoidRecipe& r, VoidMethod method) {
    using M = VoidMethod;
    struct Use {
        const char* option;
        bool given;
        std::initializer_list<M> methods;
    };
    const Use uses[] = {
        {"--void-radius", !r.radius.empty(), {M::overlay, M::mixed, M::ellipses, M::boolean}},
        {"--void-aspect", !r.aspect.empty(), {M::overlay, M::ellipses, M::boolean}},
        {"--void-count", r.count.has_value(), {M::overlay, M::boolean}},
        {"--void-probability", r.probability.has_value(), {M::grid, M::mixed, M::ellipses}},
        {"--delete-fraction", r.deleteFraction.has_value(), {M::concentric, M::threshold}},
        {"--void-matrix", !r.matrix.empty(), {M::grid}},
        {"--void-cell", !r.cell.empty(), {M::grid}},
        {"--void-angles", !r.orientation.angles.empty(), {M::overlay, M::ellipses, M::boolean}},
        {"--void-axis", !r.orientation.axis.empty(), {M::overlay, M::ellipses, M::boolean}},
        {"--void-field", !r.orientation.field.empty(), {M::overlay, M::ellipses, M::boolean}},
        {"--void-voxel",
         r.voxelSize > 0,
         {M::grid, M::overlay, M::mixed, M::ellipses, M::boolean, M::list}},
        {"--target-bvtv",
         r.targetBvtv.has_value(),
         {M::grid, M::overlay, M::concentric, M::threshold, M::mixed, M::ellipses, M::boolean}},
        {"--target-tbth", r.targetTbth.has_value(), {M::boolean}},
        {"--cull touch",
         r.cull == Cull::touch,
         {M::grid, M::overlay, M::ellipses, M::boolean, M::list}}};
    for (const Use& use : uses) {
        if (!use.given || isOneOf(method, use.methods)) continue;
        std::string others;
        for (const auto& [name, m] : kMethods)
            if (isOneOf(m, use.methods)) others += (others.empty() ? "" : ", ") + std::string(name);
        throw ParameterError(fmt::format("{} is of no use to --voids {}; it belongs to {}",
                                         use.option, r.method, others));
    }
}

}  // namespace

VoidMethod methodOf(const VoidRecipe& recipe) {
    if (recipe.method.empty()) return VoidMethod::none;
    for (const auto& [name, method] : kMethods)
        if (recipe.method == name) return method;
    if (recipe.method.rfind("list:", 0) == 0 && recipe.method.size() > 5) return VoidMethod::list;
    std::string names;
    for (const auto& [name, method] : kMethods) names += std::string(name) + ", ";
    throw ParameterError(fmt::format("--voids {}: is none of {}list:FILE", recipe.method, names));
}

std::string listFile(const VoidRecipe& recipe) {
    return methodOf(recipe) == VoidMethod::list ? recipe.method.substr(5) : std::string();
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
            fmt::format("--shell {}: must be a thickness in mm, 0 or more", r.shell));
    if (method == VoidMethod::none) {
        const std::pair<const char*, bool> given[] = {
            {"--keep-connected", r.keepConnected},
            {"--cull", r.cull != Cull::center},
            {"--target-bvtv", r.targetBvtv.has_value()},
            {"--target-tbth", r.targetTbth.has_value()},
            {"--void-voxel", r.voxelSize > 0},
            {"--void-radius", !r.radius.empty()},
            {"--void-aspect", !r.aspect.empty()},
            {"--void-count", r.count.has_value()},
            {"--void-probability", r.probability.has_value()},
            {"--delete-fraction", r.deleteFraction.has_value()},
            {"--void-matrix", !r.matrix.empty()},
            {"--void-cell", !r.cell.empty()},
            {"--void-angles", !r.orientation.angles.empty()},
            {"--void-axis", !r.orientation.axis.empty()},
            {"--void-field", !r.orientation.field.empty()}};
        for (const auto& [option, isGiven] : given)
            if (isGiven)
                throw ParameterError(fmt::format(
                    "{}: an option about voids is given, and no voids are asked for; say how they "
                    "are made with --voids (grid, overlay, boolean, ...)",
                    option));
        return;
    }
    if (needsFront(method) && !hasFront)
        throw ParameterError(fmt::format(
            "--voids {} makes its holes while spheres are packed: use it with vdb_pack pack, or "
            "take overlay or boolean here",
            r.method));
    if (isThinning(method) && !hasSpheres)
        throw ParameterError(fmt::format(
            "--voids {} takes spheres out of a pack: use it with vdb_pack pack or carve, or take "
            "grid, overlay or boolean here",
            r.method));
    requireUse(r, method);
    requireShare("--void-probability", r.probability, needsFront(method) ? "[0, 1)" : "[0, 1]",
                 true, !needsFront(method));
    requireShare("--delete-fraction", r.deleteFraction, "(0, 1]", false, true);
    requireShare("--target-bvtv", r.targetBvtv, "(0, 1)", false, false);
    if (r.targetTbth) {
        requireLength("--target-tbth", *r.targetTbth);
        if (!r.targetBvtv)
            throw ParameterError(
                "--target-tbth fixes the thickness at a given BV/TV; give "
                "--target-bvtv as well");
    }
    if (r.voxelSize != 0) requireLength("--void-voxel", r.voxelSize);
    if (r.count && !(*r.count >= 1 && *r.count < 4e9))
        throw ParameterError(
            fmt::format("--void-count {}: must be a number of voids from 1 to 4e9", *r.count));
    const auto twice = [&](bool given, const char* option) {
        if (given && r.targetBvtv)
            throw ParameterError(fmt::format(
                "{} and --target-bvtv both say how much is cut; give one of them", option));
    };
    twice(r.count.has_value(), "--void-count");
    twice(r.probability.has_value(), "--void-probability");
    twice(r.deleteFraction.has_value(), "--delete-fraction");
    twice(!r.matrix.empty(), "--void-matrix");
    if (isThinning(method) && !r.deleteFraction && !r.targetBvtv)
        throw ParameterError(fmt::format(
            "--voids {} needs --delete-fraction D or --target-bvtv F to know how much goes",
            r.method));
    if (method == VoidMethod::grid && r.matrix.empty() && r.cell.empty())
        throw ParameterError("--voids grid needs --void-matrix FILE or --void-cell SIZE");
    const bool sized = method == VoidMethod::overlay || method == VoidMethod::boolean;
    if (sized && r.radius.empty() && !hasSpheres)
        throw ParameterError(fmt::format(
            "--voids {} needs --void-radius SPEC, the shorter half-axis in mm", r.method));
}

}  // namespace vdbpack
