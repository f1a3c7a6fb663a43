// The run that checks any pack: `vdb_pack verify`.
#include "vdbpack/core/ball_share.h"
#include "vdbpack/core/error.h"
#include "vdbpack/formats/materials.h"
#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/vacancies.h"
#include "vdbpack/run/input_pack.h"
#include "vdbpack/run/interfaces.h"
#include "vdbpack/run/run_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

std::vector<std::string> namesOf(const Parts& parts) {
    std::vector<std::string> names;
    for (const Part& part : parts) names.push_back(part.recipe.name);
    return names;
}

/// Refuses domains in another order than the parts of a pack. @throws InputError
void checkOrder(const std::string& file, const Pack<3>& pack, const Parts& parts) {
    const std::vector<std::string>&names = partNames(pack), given = namesOf(parts);
    if (names != given &&
        std::is_permutation(names.begin(), names.end(), given.begin(), given.end()))
        throw InputError(fmt::format(
            "{}: its parts were packed in another order, on which their walls depend; list them as "
            "{}",
            file, fmt::join(names, ", ")));
}

/// Spheres of each part by their number in a pack. @throws InputError if some have none
std::vector<std::vector<std::size_t>> membersOf(const std::string& file, const Pack<3>& pack,
                                                const Parts& parts) {
    checkOrder(file, pack, parts);
    const Materials materials(pack);
    if (!materials.hasParts())
        throw InputError(file +
                         ": has no column `part` that says which of several parts each "
                         "sphere fills; verify the parts one by one, with their own files");
    std::vector<std::vector<std::size_t>> members(parts.size());
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const auto part = static_cast<std::size_t>(materials.partOf(i));
        if (part >= parts.size())
            throw InputError(fmt::format(
                "{}: sphere {} is of part {}, and there are {} parts, "
                "counted from 0; give the domains it was packed in",
                file, pack.id.empty() ? std::int64_t(i) : pack.id[i], part, parts.size()));
        members[part].push_back(i);
    }
    return members;
}

/// Holds each sphere against the wall of its own part.
void verifyParts(const Parts& parts, const std::string& file, Pack<3>& pack, Report& report) {
    const auto members = membersOf(file, pack, parts);
    report.domain.kind = "parts";
    ProtrusionCheck all;
    double covered = 0;
    pack.depth.resize(pack.spheres.size());
    for (std::size_t k = 0; k < parts.size(); ++k) {
        std::vector<Sphere<3>> spheres;
        for (const std::size_t i : members[k]) spheres.push_back(pack.spheres[i]);
        const DomainSource& source = *parts[k].source;
        const RadiusStatistics radius = radiusStatistics(spheres);
        const auto domain = source.build(fieldDetail(radius.min, radius.mean), radius.max).space;
        std::vector<double> distances;
        ProtrusionCheck own = source.protrusion(spheres, &distances);
        const auto depths = source.depths(spheres, *domain, distances);
        for (std::size_t i = 0; i < depths.size(); ++i) pack.depth[members[k][i]] = depths[i];
        PartReport one;
        one.name = parts[k].recipe.name;
        one.source = describe(parts[k].recipe.domain);
        one.count = spheres.size();
        // What clips and other parts leave of a domain is known by its field alone.
        one.volume = source.isWhole() ? source.volume() : domain->volume();
        one.area = source.isWhole() ? source.plan(1, 1).area : domain->wallArea();
        one.solidFraction = ballShare(spheres, one.volume);
        one.protrusion = own.max;
        covered += one.solidFraction * one.volume;
        report.volume += one.volume;
        report.area += one.area;
        report.parts.push_back(std::move(one));
        for (ProtrudingSphere& sphere : own.worst) sphere.i = members[k][sphere.i];
        all = joined(std::move(all), own);
    }
    report.protrusion = std::move(all);
    if (!pack.spheres.empty())
        report.contacts = countContacts(pack.spheres, report.contactTolerance, pack.depth);
    report.contactsBetweenParts = contactsBetweenParts(pack, report.contactTolerance);
    if (report.volume > 0) report.solidFractionTotal = covered / report.volume;
}

/// Refuses a pack that would span the domain in meters, and is read in mm.
template <int Dim>
void requireSameUnit(const std::string& file, const std::vector<Sphere<Dim>>& spheres,
                     const Box<Dim>& domain) {
    constexpr double kTimes = 1000, kLeast = 0.3, kMost = 1.05;  // of the domain's size
    Box<Dim> all;
    for (const Sphere<Dim>& s : spheres) all.add(s.center);
    const double own = length(all.size()), whole = length(domain.size());
    if (kTimes * own > kLeast * whole && kTimes * own < kMost * whole)
        throw InputError(fmt::format(
            "{}: the pack is {:.3g} mm across, and the domain {:.4g} mm; set `packUnit` m if its "
            "lengths are in meters",
            file, own, whole));
}

/// Warns where spheres of parts protrude from what are not the domains of these parts.
void warnOfOtherParts(const VerifyRecipe& recipe, const Pack<3>& pack, const Parts& parts,
                      const Callbacks& callbacks) {
    const std::vector<std::string>&names = partNames(pack), given = namesOf(parts);
    if (parts.empty()) {
        std::string label = recipe.domain.label;
        std::replace(label.begin(), label.end(), '+', ',');
        callbacks.warn(fmt::format(
            "{}: its spheres are in several parts, which have walls of their own; set {}, as the "
            "run did that packed them",
            recipe.pack,
            label.find(',') != label.npos ? "`label` " + label
                                          : "`partsFile` or all their labels"));
    } else if (!names.empty() && names != given) {
        callbacks.warn(fmt::format(
            "{}: its parts are {}, and were held against {}; give the domains of the same parts in "
            "the same order",
            recipe.pack, fmt::join(names, ", "), fmt::join(given, ", ")));
    }
}

}  // namespace

RunResult runVerify(const VerifyRecipe& recipe, const Callbacks& caller) {
    std::vector<std::string> warnings;
    const Callbacks callbacks = keepingWarnings(withinMemory(caller, recipe.memoryLimit), warnings);
    if (recipe.vacancySamples > 0 && recipe.domain.source.empty() && recipe.parts.empty())
        throw ParameterError("`vacancySamples` are points of a domain; set `domain`");
    Report report = begunReport(recipe, "verify", recipe.pack);
    report.requestedGap = recipe.gap;
    return withThreads(recipe.threads, [&] {
        Clock clock;
        Pack<3> given = readInputPack(recipe, callbacks);
        report.seconds.mesh = clock.lap();
        PackRecipe filled;
        filled.domain = recipe.domain;
        filled.parts = recipe.parts;
        for (PackRecipe& part : filled.parts) part.grey = {};  // materials are not checked
        partsByCenter(filled, callbacks);
        const Parts parts = partsOf(filled, callbacks);
        for (const Part& part : parts) requireSameAxes(recipe.pack, given.origin, *part.source);
        VerifyRecipe whole = recipe;
        whole.domain = parts.empty() ? filled.domain : DomainRecipe();
        if (!parts.empty() && recipe.vacancySamples > 0)
            throw ParameterError(
                "`vacancySamples`: are not searched in several parts; verify them one by one");
        std::optional<VacancySearch> vacancies;
        RunResult run = measureInputPack(
            whole, std::move(given), std::move(report),
            [](const RadiusStatistics& r) { return 3 * r.max; }, callbacks,
            [&](const auto& pack, const auto* domain, const Report& measured) {
                if (domain) requireSameUnit(recipe.pack, pack.spheres, domain->bounds());
                if (recipe.vacancySamples == 0) return;
                VacancySearch all;
                all.radius = 1.02 * measured.radius.mean;
                all.samples = recipe.vacancySamples;
                const auto found =
                    findVacancies(pack.spheres, *domain, all.radius, recipe.vacancySamples);
                all.largest = found.largest;
                all.count = found.points;
                vacancies = all;
            });
        run.vacancies = vacancies;
        auto* pack = std::get_if<Pack<3>>(&run.pack);
        if (!parts.empty()) {
            if (!pack) throw InputError(recipe.pack + ": holds circles, and parts hold spheres");
            verifyParts(parts, recipe.pack, *pack, run.report);
            run.passed = !failedChecks(run.report).any();
        }
        if (pack && columnOfNumbers(*pack, kPartColumn) && run.report.protrusion &&
            run.report.protrusion->spheres > 0)
            warnOfOtherParts(recipe, *pack, parts, callbacks);
        run.report.seconds.total = clock.total();
        run.report.warnings = std::move(warnings);
        return run;
    });
}

}  // namespace vdbpack
