#include "vdbpack/run/input_pack.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/level_set.h"
#include "vdbpack/formats/grey_values.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/with_images.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/formats/mesh_io.h"
#include "vdbpack/run/stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// Warns of ids that several spheres have: contacts name spheres by them.
void warnOfSharedIds(const Pack<3>& pack, const std::string& file, const Callbacks& callbacks) {
    std::vector<std::int64_t> ids = pack.id;
    if (!std::is_sorted(ids.begin(), ids.end())) std::sort(ids.begin(), ids.end());
    const auto shared = std::adjacent_find(ids.begin(), ids.end());
    if (shared == ids.end()) return;
    const std::int64_t first = *shared;
    const auto different = std::unique(ids.begin(), ids.end()) - ids.begin();
    callbacks.warn(
        fmt::format("{}: {} spheres have {} different ids; several share {}. Contacts name spheres "
                    "by their ids: "
                    "renumber the spheres, or leave the ids out",
                    file, pack.id.size(), different, first));
}

}  // namespace

std::optional<Pack<3>> readInputPackUnlessSolid(const InputPack& recipe,
                                                const Callbacks& callbacks) {
    const std::string extension = recipe.given ? "" : extensionOf(recipe.pack);
    if (extension == ".stl" || extension == ".obj" || extension == ".off" || extension == ".gts")
        return std::nullopt;
    try {
        return readInputPack(recipe, callbacks);
    } catch (const InputError& noPack) {
        if (extension == ".ply") return std::nullopt;  // without radii: a mesh
        if (extension == ".vtk" || extension == ".vtp") try {
                readMesh(recipe.pack);
                return std::nullopt;
            } catch (const InputError&) {
                throw noPack;
            }
        // Without points it may be a level set; if it is neither, the first message is the better.
        if (extension != ".vdb" || !holdsLevelSet(recipe.pack)) throw;
        return std::nullopt;
    }
}

Pack<3> readInputPack(const InputPack& recipe, const Callbacks& callbacks) {
    callbacks.stopIfCancelled();
    std::error_code none;
    if (!recipe.given && std::filesystem::is_directory(filePart(recipe.pack), none))
        throw IoError(recipe.pack + ": is a folder; name a pack in it");
    PackReadOptions read;
    read.unit = recipe.packUnit;
    read.columns = recipe.packColumns;
    read.radius = recipe.packRadius;
    read.gridName = recipe.packGrid;
    read.memoryLimit = recipe.memoryLimit;
    read.callbacks = callbacks;
    Pack<3> pack = recipe.given ? *recipe.given : readPack(recipe.pack, read);
    if (pack.spheres.empty()) throw InputError(recipe.pack + ": holds no spheres");
    warnOfUnusedWeights(recipe.weightBy, {&recipe.radius}, callbacks);
    const auto columns = columnsOfNumbers(pack);
    checkGrey(recipe.grey, recipe.density, &columns);
    warnOfSharedIds(pack, recipe.pack, callbacks);
    Box<3> box{pack.spheres[0].center, pack.spheres[0].center};
    for (const auto& s : pack.spheres)
        for (int d = 0; d < 3; ++d) {
            box.lo[d] = std::min(box.lo[d], s.center[d] - s.radius);
            box.hi[d] = std::max(box.hi[d], s.center[d] + s.radius);
        }
    if (std::any_of(pack.columns.begin(), pack.columns.end(),
                    [](const Column& c) { return c.name == kImageColumn; }))
        callbacks.warn(fmt::format(
            "{}: holds images of spheres of a periodic cell (column {}), which count as further "
            "spheres here; give the file without images",
            recipe.pack, kImageColumn));
    const double extent = length(box.size());
    if (extent < 2 || extent > 5000)
        callbacks.warn(fmt::format(
            "{}: the pack is {:.3g} mm across, which is unlikely for a bone. Set `packUnit` to "
            "m, cm, mm or um if its lengths are not in mm",
            recipe.pack, extent));
    return pack;
}

void requireSameAxes(const std::string& file, const PackOrigin& origin,
                     const DomainSource& source) {
    const std::string axes = axesOf(source);
    if (origin.axes.empty() || axes.empty() || origin.axes == axes) return;
    throw InputError(
        fmt::format("{}: its spheres are in axes {}, and {} is read in {}; set "
                    "`space` {}",
                    file, origin.axes, source.recipe().source, axes, lowered(origin.axes)));
}

void warnOfTolerance(const std::string& file, const PackOrigin& origin, const BondOptions& options,
                     const Callbacks& callbacks) {
    const double own = origin.contactTolerance, between = origin.interfaceTolerance;
    const double now = std::max(options.interfaceTolerance, options.tolerance);
    if (constexpr double kMuchMore = 1.2; between > own && now > kMuchMore * between)
        callbacks.warn(fmt::format(
            "{}: its parts were joined with `interfaceTolerance` {:g}; up to {:g} there are more "
            "bonds, across wider gaps, and stiffer interfaces",
            file, between, now));
    if (const double shear = origin.shearRatio; shear > 0 && shear != options.law.shearRatio)
        callbacks.warn(
            fmt::format("{}: was packed for bonds with k_t / k_n {:g}, and they have {:g} now; set "
                        "`bond-shear` "
                        "{:g}",
                        file, shear, options.law.shearRatio, shear));
    if (options.tolerance >= own && now >= between) return;
    callbacks.warn(fmt::format(
        "{}: its contacts were counted with `contactTolerance` {:g}{}, and there are fewer pairs "
        "up "
        "to {:g}; set the same for the same pairs",
        file, own,
        between > std::max(own, now) ? fmt::format(" and `interfaceTolerance` {:g}", between) : "",
        options.tolerance));
}

bool warnOfOutside(const std::vector<double>& depths, const PackAttributes& pack,
                   const std::string& domain, const Callbacks& callbacks) {
    const Materials materials(pack);
    std::set<std::int32_t> parts;
    std::uint64_t outside = 0;
    for (std::size_t i = 0; i < depths.size(); ++i)
        if (depths[i] > 0) ++outside, parts.insert(materials.partOf(i));
    const auto& names = partNames(pack);
    std::vector<std::string> theirs;
    if (parts.size() < names.size())
        for (const std::int32_t part : parts)
            theirs.push_back(names[static_cast<std::size_t>(part)]);
    return warnOfOutside(outside, depths.size(), domain, callbacks,
                         fmt::to_string(fmt::join(theirs, ", ")));
}

bool warnOfOutside(std::uint64_t outside, std::size_t count, const std::string& domain,
                   const Callbacks& callbacks, const std::string& parts) {
    constexpr double kMostOutside = 0.01;
    if (static_cast<double>(outside) <= kMostOutside * static_cast<double>(count)) return false;
    callbacks.warn(
        parts.empty()
            ? fmt::format("{} of {} spheres have their center outside of {}, which is the domain "
                          "of another body, or of one of several parts; check `domain`, `label`, "
                          "`mask`, `space` and units",
                          outside, count, domain)
            : fmt::format("{} of {} spheres, all of {}, have their center outside of {}, as the "
                          "spheres of an implant may; else check `domain`, `label` and `mask`",
                          outside, count, parts, domain));
    return true;
}

void warnOfPlane(const std::string& file, const Pack<3>& pack, const Callbacks& callbacks) {
    if (isPlane(pack))
        callbacks.warn(file +
                       ": all its spheres lie at one height. If they are circles of a plane, give "
                       "a rect or disc, or the `slice` z=V of the domain");
}

template <int Dim>
void requireOneBody(const Pack<Dim>& pack, const Domain<Dim>& domain, const std::string& file,
                    const char* setting) {
    const Column* const parts = columnOfNumbers(pack, kPartColumn);
    if (!parts) return;
    constexpr double kMany = 0.05, kDeep = 0.01;  // share of a part's spheres, of the radius
    std::map<double, std::pair<std::size_t, std::size_t>> protruding;  // of how many, by part
    const auto sampler = domain.sampler();
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const Sphere<Dim>& s = pack.spheres[i];
        auto& [some, all] = protruding[parts->numbers[i]];
        some += sampler->signedDistance(s.center) > -(1 - kDeep) * s.radius;
        ++all;
    }
    const std::vector<std::string>& names = partNames(pack);
    for (const auto& [part, count] : protruding)
        if (static_cast<double>(count.first) > kMany * static_cast<double>(count.second)) {
            const auto number = static_cast<std::size_t>(part);
            throw InputError(fmt::format(
                "{}: {} of {} spheres of its part {} protrude from the domain, so this is not the "
                "domain of all parts. Set `{}` in the run that packs the parts",
                file, count.first, count.second,
                number < names.size() ? names[number] : fmt::format("{:g}", part), setting));
        }
}

template void requireOneBody(const Pack<2>&, const Domain<2>&, const std::string&, const char*);
template void requireOneBody(const Pack<3>&, const Domain<3>&, const std::string&, const char*);

void requireDomain(const InputPack& recipe, bool ofFile) {
    const DomainRecipe& d = recipe.domain;
    if (!d.source.empty()) return;
    const char* set = !ofFile && d.unit != Unit::millimeter ? "`unit`"
                      : !ofFile && d.scale != 1             ? "`scale`"
                      : d.slice                             ? "`slice`"
                      : !d.clips.empty()                    ? "`clips`"
                      : d.periodic != std::array<bool, 3>{} ? "`periodic`"
                      : d.pose.any()                        ? "`translate` (or another move)"
                      : !ofFile && d.repair                 ? "`repair`"
                                                            : nullptr;
    if (set)
        throw ParameterError(fmt::format(
            "{} applies to the domain, and there is none; set `domain` (the unit of the "
            "file itself is "
            "`packUnit`)",
            set));
}

DomainRecipe domainOf(const InputPack& recipe, const Pack<3>& pack) {
    DomainRecipe domain = recipe.domain;
    if (!domain.source.empty() || !pack.cell.any()) return domain;
    const Box<3>& box = pack.cell.box;
    // A cell of space that is higher than the spheres holds no circles; files round.
    const bool plane =
        isPlane(pack) && box.hi[2] - box.lo[2] <= 2.000001 * radiusStatistics(pack.spheres).max;
    std::string corners[2];
    for (int d = 0; d < (plane ? 2 : 3); ++d) {
        corners[0] += fmt::format("{}{}", d > 0 ? "," : "", box.lo[d]);
        corners[1] += fmt::format(",{}", box.hi[d]);
        domain.periodic[static_cast<std::size_t>(d)] = pack.cell.isAlong(d);
    }
    domain.source = (plane ? "rect:" : "box:") + corners[0] + corners[1];
    return domain;
}

std::optional<DomainSource> domainAround(const DomainRecipe& recipe, int dim,
                                         const Callbacks& callbacks) {
    if (recipe.source.empty()) return std::nullopt;
    std::optional<DomainSource> source(std::in_place, recipe, callbacks);
    if (source->dim() != dim)
        throw ParameterError(
            fmt::format("{}: is a domain of {} dimensions, the pack one of {}; give one that it "
                        "lies in",
                        recipe.source, source->dim(), dim));
    return source;
}

DomainSource::Built buildAround(const std::optional<DomainSource>& source, int dim,
                                const RadiusStatistics& radius, std::size_t count, double reach,
                                const RunSettings& settings, const Callbacks& callbacks) {
    const double detail = fieldDetail(radius.min, radius.mean);
    Extent extent;
    extent.dim = dim;
    if (source) extent = extentOf(*source, detail, reach);
    extent.count = static_cast<double>(count);
    requireResources(extent, settings);
    return source ? source->build(detail, reach, callbacks) : DomainSource::Built{};
}

std::vector<std::string> inputFiles(const InputPack& recipe) {
    auto files = domainInputs(recipe.domain);
    if (!recipe.given) files.push_back(recipe.pack);
    files.push_back(recipe.radius.spec());  // table:FILE
    return files;
}

}  // namespace vdbpack
