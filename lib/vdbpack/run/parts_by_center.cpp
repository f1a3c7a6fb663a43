// One pack over several labels of an image, whose spheres belong to the label at their center.
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/sphere.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/mesh/mesh_sides.h"
#include "vdbpack/run/interfaces.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// The part that a point lies in, or that is about the nearest to it.
std::size_t partAt(const std::vector<MeshSides>& parts, const Vec<3>& x, double radius) {
    constexpr double kFirst = 0.01, kGrowth = 1.5;
    constexpr int kRounds = 16;  // the last one six radii away
    const auto find = [&](const Vec<3>& at) {
        std::size_t k = 0;
        while (k < parts.size() && !parts[k].inside(at)) ++k;
        return k;
    };
    std::size_t part = find(x);
    // Parts have surfaces of their own, which are not smoothed together.
    double away = kFirst * radius;
    for (int round = 0; part == parts.size() && round < kRounds; ++round, away *= kGrowth)
        for (int d = 0; d < 6 && part == parts.size(); ++d) {
            Vec<3> at = x;
            at[d / 2] += d % 2 == 0 ? away : -away;
            part = find(at);
        }
    return part == parts.size() ? 0 : part;
}

}  // namespace

Parts partsByCenter(PackRecipe& recipe, const Callbacks& callbacks) {
    if (recipe.domain.partsBy != PartsBy::center) return {};
    PackRecipe apart = recipe;
    apart.domain.partsBy = PartsBy::none;
    if (apart.domain.label.empty()) apart.domain.label = "all";
    // What they would warn of, the domain warns of.
    Callbacks quiet = callbacks;
    quiet.warning = nullptr;
    Parts parts = partsOf(apart, quiet);
    if (parts.empty())
        throw ParameterError(recipe.domain.source +
                             ": `partsBy` center is for several labels of an image; give `label` "
                             "A,B or all");
    recipe.domain.partsBy = PartsBy::none;
    std::string& label = recipe.domain.label = apart.domain.label;
    std::replace(label.begin(), label.end(), ',', '+');
    if (label != "all") return parts;
    label.clear();
    for (const Part& part : parts) label += (label.empty() ? "" : "+") + part.recipe.domain.label;
    return parts;
}

void takeCenters(const Parts& parts, Run<3>& run) {
    const std::vector<Sphere<3>>& spheres = run.pack.spheres;
    std::vector<MeshSides> sides;
    for (const Part& part : parts)
        sides.emplace_back(part.source->mesh(), part.source->isWatertight());
    std::vector<double> of(spheres.size());
    parallelFor(std::size_t(0), spheres.size(), [&](std::size_t i) {
        of[i] = static_cast<double>(partAt(sides, spheres[i].center, spheres[i].radius));
    });
    std::vector<PartReport> reports(parts.size());
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        PartReport& part = reports[static_cast<std::size_t>(of[i])];
        ++part.count;
        part.solidFraction += Measure<3>::ball(spheres[i].radius);
    }
    std::vector<std::string> names;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        PartReport& part = reports[k];
        const auto left = parts[k].source->left();
        part.name = parts[k].recipe.name;
        part.source = run.source->recipe().source;
        part.requested = run.report.requested;
        part.volume = left.volume;
        part.area = left.area;
        part.solidFraction /= left.volume;
        names.push_back(part.name);
    }
    run.report.parts = std::move(reports);
    run.pack.columns.insert(run.pack.columns.begin(), {kPartColumn, std::move(of), {}});
    setPartNames(run.pack, std::move(names));
    run.report.contactsBetweenParts = contactsBetweenParts(run.pack, run.settings.contactTolerance);
    measureInterfaces(parts, run);
}

}  // namespace vdbpack
