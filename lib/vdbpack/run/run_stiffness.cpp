// The run that computes the stiffness of a bonded pack: `vdb_pack stiffness`.
#include "vdbpack/core/error.h"
#include "vdbpack/formats/bonded_pack.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/interfaces.h"
#include "vdbpack/run/stiffness_grips.h"
#include "vdbpack/run/stiffness_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// Sides of the range of k_t / k_n that is searched, and how close a Poisson's ratio has to be.
constexpr double kLeastShear = 0.05, kMostShear = 4, kPoissonError = 5e-4;
constexpr int kMostTries = 12;
/// Share of the box around the spheres that they fill if it is their domain, at least.
constexpr double kFillsBox = 0.48;
/// Tolerance from which on bonds cross gaps.
constexpr double kWideGaps = 0.05;

struct Body : BondedBody {
    std::vector<std::uint8_t> outside;  ///< 1 for spheres with centers outside of the domain

    /// Without bonds between two such spheres: where the boundary holds both, they would add to
    /// the energy, but not to the volume.
    std::vector<Bond> within(std::vector<Bond> all) const {
        if (outside.empty()) return all;
        all.erase(std::remove_if(all.begin(), all.end(),
                                 [&](const Bond& b) { return outside[b.i] && outside[b.j]; }),
                  all.end());
        return all;
    }
};

/// What the spheres fill, in which cell, and which of them are at its wall.
void setBoundary(const StiffnessRecipe& recipe, Pack<3>& pack, Body& body, StiffnessResult& result,
                 const Callbacks& callbacks) {
    const RadiusStatistics radius = radiusStatistics(pack.spheres);
    const double reach = recipe.boundary.value_or(0.1 * radius.mean);
    const std::vector<Vec<3>> centers = centersOf(pack);
    const DomainRecipe named = domainOf(recipe, pack);
    const auto source = domainAround(named, 3, callbacks);
    std::vector<double> depths;
    double wall = 0;
    if (source) {
        requireSameAxes(recipe.pack, pack.origin, *source);
        const auto built =
            buildAround(source, 3, radius, centers.size(), radius.max + reach, recipe, callbacks);
        body.volume = built.space->volume();
        wall = built.space->wallArea();
        const PeriodicCell<3> cell = built.space->cell();
        if (!recipe.domain.source.empty()) warnOfOtherCell(recipe.pack, pack.cell, cell, callbacks);
        if (cell.any()) pack.cell = cell;
        result.body = describe(named);
        depths = built.space->signedDistances(centers);
        if (std::none_of(depths.begin(), depths.end(), [](double depth) { return depth <= 0; }))
            throw InputError(fmt::format(
                "{}: all spheres have their center outside of {}; check `domain`, `label`, `mask`, "
                "`space` and units",
                recipe.pack, result.body));
        const bool elsewhere = warnOfOutside(depths, pack, result.body, callbacks);
        if (named.clips.empty())  // else the bounds are wider than the clipped domain
            warnOfOtherEnds(pack, built.space->bounds(), result.body,
                            startsWith(named.source, "box:"), !elsewhere, callbacks);
    } else {
        const Box<3> box = boxAround(pack);
        body.volume = box.volume();
        const Vec<3> size = box.size();
        wall = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
        result.body = "the box around the spheres; give `domain` for that of a body";
        double filled = 0;
        for (const auto& s : pack.spheres) filled += Measure<3>::ball(s.radius);
        if (filled < kFillsBox * body.volume)
            callbacks.warn(
                fmt::format("the spheres fill {:.2g} of the box around them, whose volume and "
                            "cross-section are not theirs; set the `domain` of the pack",
                            filled / body.volume));
        for (const auto& x : centers) {
            double depth = box.lo[0] - x[0];
            for (int d = 0; d < 3; ++d)
                depth = std::max({depth, box.lo[d] - x[d], x[d] - box.hi[d]});
            depths.push_back(depth);
        }
    }
    const bool repeats = pack.cell.isAlong(0) && pack.cell.isAlong(1) && pack.cell.isAlong(2);
    body.boundary.assign(repeats ? 0 : centers.size(), 0);
    for (std::size_t i = 0; i < body.boundary.size(); ++i) {
        body.boundary[i] = -depths[i] - pack.spheres[i].radius <= reach;
        result.boundary += body.boundary[i];
    }
    if (source) body.outside.assign(centers.size(), 0);
    for (std::size_t i = 0; i < body.outside.size(); ++i) body.outside[i] = depths[i] > 0;
    if (!repeats && !recipe.press)
        warnOfFewHeld(pack, body.boundary, wall, source.has_value(), callbacks);
}

/// Solves once. @return the Poisson's ratio of the isotropic average
double solve(const Pack<3>& pack, const BondOptions& options, Body body, StiffnessResult& result,
             const Callbacks& callbacks) {
    const auto all = bondsIn(pack, options), bonds = body.within(all);
    body.pack = &pack;
    body.bonds = &bonds;
    if (result.bonds == 0) {
        warnOfLoose(pack, bonds, body.boundary, callbacks);
        warnOfLooseParts(pack, all, callbacks);
        warnOfCellFit(pack, bonds, callbacks);
    }
    result.bonds = bonds.size();
    result.law = options.law;
    result.apparent = apparentStiffness(body, callbacks);
    result.elasticity = elasticityOf(result.apparent.stiffness);
    return result.elasticity ? result.elasticity->isotropicPoisson : 0;
}

/// Which spheres keep their moduli while others are multiplied: spheres of parts with one modulus,
/// such as implants, beside parts whose moduli follow grey values. Empty: none does.
std::vector<std::uint8_t> keptModuli(const Pack<3>& pack, StiffnessResult& result) {
    const Column* column = columnOfNumbers(pack, kModulusColumn);
    const Materials materials(pack);
    if (!column || !materials.hasParts()) return {};
    const std::vector<double>& moduli = column->numbers;
    std::map<std::int32_t, std::pair<double, double>> ranges;
    for (std::size_t i = 0; i < moduli.size(); ++i) {
        const auto known = ranges.try_emplace(materials.partOf(i), moduli[i], moduli[i]).first;
        auto& [least, most] = known->second;
        least = std::min(least, moduli[i]);
        most = std::max(most, moduli[i]);
    }
    const auto isOne = [](const auto& range) { return range.second.first == range.second.second; };
    const auto ones = std::count_if(ranges.begin(), ranges.end(), isOne);
    if (ones == 0 || static_cast<std::size_t>(ones) == ranges.size()) return {};
    std::vector<std::uint8_t> kept(moduli.size());
    for (std::size_t i = 0; i < kept.size(); ++i)
        kept[i] = isOne(*ranges.find(materials.partOf(i)));
    const auto names = partNames(pack);
    for (const auto& range : ranges)
        if (const auto at = static_cast<std::size_t>(range.first); isOne(range))
            result.keptParts.push_back(at < names.size() ? names[at] : fmt::format("part {}", at));
    return kept;
}

/// Multiplies the moduli of bonds until the pack has the wanted modulus: at once, or, where parts
/// keep theirs, by secants of the logarithms.
/// @param found  its modulus. @param again  finds it with the moduli of now.
/// @return the factor by which the stiffness found last has to be multiplied
template <class Again>
double reachModulus(const StiffnessRecipe& recipe, double found, Pack<3>& pack,
                    BondOptions& options, StiffnessResult& result, const Again& again) {
    constexpr double kClose = 1e-4, kLeastPower = 0.02, kMostBy = 1e4;
    const auto kept = keptModuli(pack, result);
    const auto multiply = [&](double by) {
        result.modulusFactor *= by;
        result.law.modulus = options.law.modulus *= by;
        for (Column& column : pack.columns)
            if (column.name == kModulusColumn)
                for (std::size_t i = 0; i < column.numbers.size(); ++i)
                    if (kept.empty() || !kept[i]) column.numbers[i] *= by;
    };
    double by = recipe.wantedModulus / found;
    multiply(by);
    if (kept.empty()) return by;
    for (int k = 0; k < kMostTries; ++k) {
        const double now = again();
        if (std::fabs(now / recipe.wantedModulus - 1) < kClose) return 1;
        const double power = std::log(now / found) / std::log(by);
        if (!(power > kLeastPower)) break;
        found = now;
        by = std::clamp(std::pow(recipe.wantedModulus / now, 1 / power), 1 / kMostBy, kMostBy);
        multiply(by);
    }
    throw ParameterError(fmt::format(
        "`bond-modulus-for`: {} keep{} a modulus of {} own, beside which the pack does not reach "
        "{:g} MPa; choose another, nearer to the {:.4g} MPa of the pack as it is",
        fmt::join(result.keptParts, ", "), result.keptParts.size() == 1 ? "s" : "",
        result.keptParts.size() == 1 ? "its" : "their", recipe.wantedModulus, found));
}

/// Presses the body between two rigid grips, by one unit of strain of what lies between them.
void press(const StiffnessRecipe& recipe, Pack<3>& pack, BondOptions& options, Body body,
           StiffnessResult& result, const Callbacks& callbacks) {
    StiffnessResult::Pressed pressed = gripsOn(recipe, pack, body.volume, callbacks);
    body.boundary.assign(pack.spheres.size(), 0);
    std::vector<Vec<3>> moves(pack.spheres.size());
    for (std::size_t i = 0; i < moves.size(); ++i) {
        const double at = pack.spheres[i].center[pressed.axis];
        const bool lower = pressed.holds(0, at), upper = pressed.holds(1, at);
        body.boundary[i] = lower || upper;
        moves[i][pressed.axis] = lower ? 0.5 : upper ? -0.5 : 0;
        pressed.held[0] += lower;
        pressed.held[1] += upper;
    }
    std::size_t beyond = 0;
    for (std::size_t i = 0; i < body.outside.size(); ++i)
        beyond += body.outside[i] && body.boundary[i];
    if (constexpr double kBeyond = 0.05;
        static_cast<double>(beyond) >
        kBeyond * static_cast<double>(pressed.held[0] + pressed.held[1]))
        callbacks.warn(fmt::format(
            "`press` {}: {} of the {} spheres in the grips lie outside of {}: what is pressed is a "
            "part that protrudes; press along another axis, or shorten that part",
            "xyz"[pressed.axis], beyond, pressed.held[0] + pressed.held[1], result.body));
    if (pressed.held[0] == 0 || pressed.held[1] == 0)
        throw ParameterError(
            fmt::format("`grip` {:g}: holds the center of no sphere at one end; set a larger one, "
                        "such as {:.2g}",
                        pressed.grip, 4 * radiusStatistics(pack.spheres).mean));
    auto bonds = bondsIn(pack, options);
    body.pack = &pack;
    body.bonds = &bonds;
    warnOfLoose(pack, bonds, body.boundary, callbacks);
    warnOfLooseParts(pack, bonds, callbacks);
    const auto modulus = [&] {
        pressed.stiffness = 2 * energyOf(body, moves, callbacks);
        return pressed.modulus = pressed.stiffness * pressed.gauge / pressed.area;
    };
    modulus();
    result.bonds = bonds.size();
    result.law = options.law;
    result.boundary = pressed.held[0] + pressed.held[1];
    if (recipe.fits) {
        if (!(pressed.modulus > 0))
            throw ParameterError("`bond-modulus-for`: no bonds join the two grips of `press`");
        const double factor = reachModulus(recipe, pressed.modulus, pack, options, result, [&] {
            bonds = bondsIn(pack, options);
            return modulus();
        });
        pressed.stiffness *= factor, pressed.modulus *= factor;
    }
    result.pressed = pressed;
}

/// Finds the shear ratio for a Poisson's ratio, which falls as it rises from `kLeastShear`, by
/// regula falsi (Illinois): near the ratio of `options`, if `known`, or anywhere.
/// @return the Young's modulus with it
double findShear(const StiffnessRecipe& recipe, const Pack<3>& pack, BondOptions& options,
                 const Body& body, StiffnessResult& result, bool known,
                 const Callbacks& callbacks) {
    const auto offAt = [&](double shear) {
        options.law.shearRatio = shear;
        return solve(pack, options, body, result, callbacks) - recipe.wantedPoisson;
    };
    constexpr double kNear = 1.25;
    const double start = options.law.shearRatio;
    double low = known ? std::max(kLeastShear, start / kNear) : kLeastShear;
    double high = known ? std::min(kMostShear, start * kNear) : kMostShear;
    double offLow = offAt(low), offHigh = offAt(high);
    if (known && (offLow < 0 || offHigh > 0))
        return findShear(recipe, pack, options, body, result, false, callbacks);
    if (offLow < -kPoissonError || offHigh > kPoissonError)
        throw ParameterError(
            fmt::format("`bond-modulus-for`: bonds give this pack Poisson's ratios from {:.4f} "
                        "(k_t / k_n {:g}) to "
                        "{:.4f} ({:g}), but not {:g}; choose one between them",
                        recipe.wantedPoisson + offHigh, kMostShear, recipe.wantedPoisson + offLow,
                        kLeastShear, recipe.wantedPoisson));
    double off = offHigh;
    for (int k = 0; k < kMostTries && std::fabs(off) > kPoissonError; ++k) {
        // Between the two, or the one that is right already.
        const double between =
            offLow > 0 && offHigh < 0 ? (low * offHigh - high * offLow) / (offHigh - offLow) : low;
        off = offAt(between);
        (off > 0 ? low : high) = between;
        (off > 0 ? offHigh : offLow) *= 0.5;
        (off > 0 ? offLow : offHigh) = off;
    }
    if (!result.elasticity)
        throw ParameterError("`bond-modulus-for`: some strain of this pack meets no resistance");
    return result.elasticity->isotropicModulus;
}

/// Finds shear ratio and moduli for a Young's modulus and a Poisson's ratio.
void fit(const StiffnessRecipe& recipe, Pack<3>& pack, BondOptions& options, const Body& body,
         StiffnessResult& result, const Callbacks& callbacks) {
    const auto modulus = [&](bool known) {
        return findShear(recipe, pack, options, body, result, known, callbacks);
    };
    const double factor =
        reachModulus(recipe, modulus(false), pack, options, result, [&] { return modulus(true); });
    for (Vec<6>& row : result.apparent.stiffness) row *= factor;
    result.elasticity = elasticityOf(result.apparent.stiffness);
}

/// Warns of bonds that are not those with which the pack was made.
void warnOfOtherBonds(const StiffnessRecipe& recipe, PackOrigin made, const BondOptions& options,
                      const Callbacks& callbacks) {
    if (recipe.fits && !recipe.press) made.shearRatio = 0;  // it is sought
    warnOfTolerance(recipe.pack, made, options, callbacks);
    const double own = made.contactTolerance;
    if (own > 0 && options.tolerance > std::max(kWideGaps, 5 * own))
        callbacks.warn(fmt::format(
            "`contactTolerance` {:g} bonds spheres across gaps of up to so many radii, and {} was "
            "packed with {:g}: more bonds, and a stiffer pack. Those between parts alone are set "
            "by `interfaceTolerance`",
            options.tolerance, recipe.pack, own));
}

}  // namespace

StiffnessResult runStiffness(const StiffnessRecipe& recipe, const Callbacks& callbacks) {
    checkSettings(recipe, RunKind::measure, {}, inputFiles(recipe));
    if (recipe.grip && !recipe.press)
        throw ParameterError(fmt::format(
            "`grip` {:g}: is the depth of a grip of `press`; name its axis by `press`, or leave it "
            "out",
            *recipe.grip));
    if (recipe.press && recipe.boundary)
        throw ParameterError("`press` holds spheres in grips; leave `boundary` out");
    if (recipe.fits && recipe.press.has_value() != std::isnan(recipe.wantedPoisson))
        throw ParameterError(
            recipe.press ? "`bond-modulus-for`: grips give no Poisson's ratio; write E alone, and "
                           "set `bond-shear` for the ratio of the bonds"
                         : "`bond-modulus-for`: write E,NU; E alone is for `press`");
    StiffnessResult result;
    std::vector<std::string> warnings;
    const Callbacks heard = keepingWarnings(withinMemory(callbacks, recipe.memoryLimit), warnings);
    withThreads(recipe.threads, [&] {
        Clock clock;
        requireDomain(recipe);
        Pack<3> pack = readInputPack(recipe, heard);
        if (isPlane(pack))
            throw ParameterError(recipe.pack +
                                 ": holds circles of a plane; bonds join spheres of space");
        result.spheres = pack.spheres.size();
        result.ownModuli = columnOfNumbers(pack, kModulusColumn) != nullptr;
        result.seconds.mesh = clock.lap();
        Body body;
        setBoundary(recipe, pack, body, result, heard);
        result.volume = body.volume;
        result.seconds.domain = clock.lap();
        BondOptions options = bondOptionsOf(recipe);
        warnOfOtherBonds(recipe, pack.origin, options, heard);
        warnOfUnusedBonds(pack, pack.origin, options, heard);
        if (recipe.press)
            press(recipe, pack, options, body, result, heard);
        else if (recipe.fits)
            fit(recipe, pack, options, body, result, heard);
        else
            solve(pack, options, body, result, heard);
        warnOfModuli(pack, options.law, heard);
        warnOfBondLaw(options.law, heard);
        if (recipe.fits && !recipe.press && recipe.bonds.law.shearRatio != BondLaw().shearRatio)
            heard.warn(
                fmt::format("`bond-shear` {:g} has no effect: `bond-modulus-for` E,NU finds it",
                            recipe.bonds.law.shearRatio));
        result.seconds.measure = clock.lap();
        RunOutputs<3> have;
        have.pack = &pack;
        have.options.bonds = options;
        have.options.unit = recipe.outUnit;
        result.files = writeOutputs(recipe.outputs, have, heard);
        result.seconds.write = clock.lap();
        result.seconds.total = clock.total();
    });
    result.warnings = std::move(warnings);
    return result;
}

}  // namespace vdbpack
