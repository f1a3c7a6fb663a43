#include "vdbpack/run/void_plan.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/run/void_stage.h"
#include "vdbpack/voids/void_list.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace vdbpack {

namespace {

double meanOf(const std::string& spec, int dim, double otherwise) {
    return spec.empty() ? otherwise : SizeDistribution::parse(spec, dim).mean();
}

/// Voids of a list, of their mean volume (2D: area) and mean b.
template <int Dim>
PlannedVoids listed(const VoidRecipe& recipe) {
    PlannedVoids plan;
    plan.voxelSize = recipe.voxelSize;
    // A pipe can be read once only, when the voids are made.
    if (std::error_code failed; !std::filesystem::is_regular_file(listFile(recipe), failed))
        return plan;
    const auto list = readVoidList<Dim>(listFile(recipe));
    if (list.empty()) return plan;
    plan.count = static_cast<double>(list.size());
    double across = 0, volume = 0;
    for (const auto& v : list) {
        across += std::pow(v.b, Dim - 1);
        volume += v.a * std::pow(v.b, Dim - 1);
    }
    plan.radius = std::pow(across / plan.count, 1.0 / (Dim - 1));
    plan.length = volume / across;
    plan.voxelSize = voidVoxelFor(recipe, leastHalfAxis(list));
    return plan;
}

}  // namespace

PlannedVoids planVoids(const VoidRecipe& r, const VoidSurroundings& around) {
    const VoidMethod method = methodOf(r);
    PlannedVoids plan;
    if (method == VoidMethod::none || isThinning(method) || !(around.volume > 0)) return plan;
    const int dim = around.dim;
    if (method == VoidMethod::list) return dim == 3 ? listed<3>(r) : listed<2>(r);
    plan.radius = meanOf(r.radius, dim, 2 * around.largestRadius);
    if (r.targetTbth && r.radius.empty()) plan.radius = 1.2 * *r.targetTbth;
    const double aspect = method == VoidMethod::mixed ? 1 : meanOf(r.aspect, dim, 2);
    plan.length = plan.radius * aspect;
    plan.voxelSize = plannedVoxel(r, dim);
    if (!(plan.voxelSize > 0)) plan.voxelSize = 0.75 * plan.radius / 4;
    if (r.targetTbth) plan.voxelSize = std::min(plan.voxelSize, *r.targetTbth / 4);
    const double ball = dim == 3 ? Measure<3>::ball(plan.radius) : Measure<2>::ball(plan.radius);
    const double density = r.targetBvtv ? -std::log(*r.targetBvtv) / (ball * aspect)
                           : r.count    ? *r.count / around.volume
                                        : -std::log(0.3) / (ball * aspect);
    switch (method) {
        case VoidMethod::grid: {
            const double side = r.cell.empty() ? 0 : std::strtod(r.cell.c_str(), nullptr);
            if (!(side > 0)) return plan;  // as many as a matrix has: few
            plan.count = around.volume / std::pow(side, dim);
            plan.radius = plan.length = side / 2;
            if (!(r.voxelSize > 0)) plan.voxelSize = side / 2 / 4;
            break;
        }
        case VoidMethod::overlay:
            plan.count = 0.6 * around.volume / (ball * std::pow(std::max(1.0, aspect), dim));
            if (r.count) plan.count = std::min(plan.count, *r.count);
            break;
        case VoidMethod::mixed:
        case VoidMethod::ellipses:
            plan.count = r.targetBvtv ? density * around.volume
                                      : r.probability.value_or(0.02) * around.spheres;
            break;
        default:  // with those that reach in from outside
            plan.count = density * (around.volume + around.area * plan.length);
    }
    return plan;
}

}  // namespace vdbpack
