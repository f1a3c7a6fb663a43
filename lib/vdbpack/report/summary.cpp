#include "vdbpack/core/symmetric.h"
#include "vdbpack/io/text.h"
#include "vdbpack/repair/mesh_repair.h"
#include "vdbpack/report/found_value.h"
#include "vdbpack/report/report.h"
#include "vdbpack/report/words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <sstream>
#include <string>
#include <utility>

namespace vdbpack {

namespace {

/// Lines under labels, wrapped between words.
class Summary {
public:
    void line(const std::string& label, const std::string& text) {
        constexpr std::size_t kLabel = 11, kWidth = 80;
        const std::string row = fmt::format("{:<{}}", label, kLabel);
        text_ += row + wrapped(text, kWidth, kLabel, row.size()) + "\n";
    }
    const std::string& text() const { return text_; }

private:
    std::string text_;
};

void addDomain(Summary& out, const Report& r, const DimensionWords& words) {
    const DomainFacts& d = r.domain;
    std::string text = d.kind;
    if (d.triangles > 0) text += fmt::format(", {} triangles", grouped(d.triangles));
    text += fmt::format(", {} {:.6g} {}", words.volume, r.volume, words.volumeUnit);
    if (d.meshVolume > 0) text += fmt::format(" (whole mesh: {:.6g} mm³)", d.meshVolume);
    text += fmt::format(", wall {:.6g} {}", r.area, words.wallUnit);
    out.line("domain", text);
    if (d.voxelSize > 0)
        out.line("", fmt::format("field of {} active voxels of {:.4g} mm", grouped(d.activeVoxels),
                                 d.voxelSize));
    if (d.boundaryEdges > 0 || d.nonManifoldEdges > 0)
        out.line("", fmt::format("the mesh has {} boundary and {} non-manifold edges",
                                 grouped(d.boundaryEdges), grouped(d.nonManifoldEdges)));
    if (!d.repair) return;
    const char* name = "repair";
    for (const auto& line : repairLines(*d.repair)) out.line(std::exchange(name, ""), line);
}

void addSpheres(Summary& out, const Report& r, const DimensionWords& words) {
    std::string text = grouped(r.count);
    if (!r.requested.empty()) text += ", requested " + r.requested;
    if (r.ks && r.ksByVolume)
        text += fmt::format(" (Kolmogorov-Smirnov distance {:.2g}, by {} {:.2g})", *r.ks,
                            words.volume, *r.ksByVolume);
    if (r.voids && r.voids->culled > 0 && r.ks) text += "; distances before voids were cut";
    if (r.interrupted) text += "; INTERRUPTED, these are the completed ones";
    if (r.existing > 0) text += fmt::format("; {} of them existed before", grouped(r.existing));
    if (r.task != "voids") out.line(words.spheres, text);
    if (r.count > 0)
        out.line("", fmt::format("radius {:.5g} to {:.5g} mm, mean {:.5g}, deviation {:.4g}",
                                 r.radius.min, r.radius.max, r.radius.mean, r.radius.sd));
    for (const Report::LocalGroup& group : r.localSizes) {
        std::string by;
        if (group.factorMost > group.factorLeast)
            by = fmt::format(" times {:.3g} to {:.3g}", group.factorLeast, group.factorMost);
        out.line(&group == &r.localSizes.front() ? "by place" : "",
                 fmt::format("{}: {}, requested {}{} (distance {:.2g}, by {} {:.2g})", group.name,
                             grouped(group.count), group.requested, by, group.ks, words.volume,
                             group.ksByVolume));
    }
    if (!r.solidFractionTotal) return;
    std::string solid =
        fmt::format("{:.4f} of the {}", *r.solidFractionTotal,
                    r.domain.kind == "solid" ? "solid that the voids leave" : "domain");
    if (r.solidFractionInterior)
        solid += fmt::format(", {:.4f} deeper than three largest radii", *r.solidFractionInterior);
    out.line("solid", solid);
    if (r.massOffset)
        out.line("",
                 fmt::format("center of mass {:.3g} mm ({:.2g} % of the length) off the domain's",
                             r.massOffset->length, 100 * r.massOffset->share));
}

/// The direction along which more contacts point than elsewhere, if any.
template <int Dim>
void addFabric(Summary& out, const ContactNetwork& c) {
    constexpr double kDirected = 0.03;
    Matrix<Dim> fabric;
    for (std::size_t i = 0; i < Dim; ++i)
        for (std::size_t j = 0; j < Dim; ++j) fabric[i].c[j] = c.fabric[i].c[j];
    const auto eigen = eigenSystem<Dim>(fabric);
    if (!(eigen.values[0] > 1.0 / Dim + kDirected)) return;
    out.line("",
             fmt::format("more contacts along ({:.2g}): {:.3f} of the fabric tensor (isotropic: "
                         "{:.3f})",
                         fmt::join(eigen.vectors[0].c, ", "), eigen.values[0], 1.0 / Dim));
}

void addContacts(Summary& out, const Report& r, const DimensionWords& words) {
    const ContactNetwork& c = *r.contacts;
    out.line(
        "contacts",
        fmt::format("coordination number {:.3g}, {} (gap up to {:g} of the smaller radius); "
                    "{:.3g} % of the {} have fewer than {} contacts; {} {:.4g} %",
                    c.mean,
                    r.domain.kind.empty() ? std::string("walls unknown")
                                          : fmt::format("{:.3g} without walls", c.meanOfSpheres),
                    r.contactTolerance, 100 * c.fewShare, words.spheres, c.few,
                    c.components > 1
                        ? fmt::format("largest of {} connected components", grouped(c.components))
                        : std::string("largest connected component"),
                    100 * c.largestComponent));
    if (r.dim == 2)
        addFabric<2>(out, c);
    else
        addFabric<3>(out, c);
    if (c.modulusRatio > 0)
        out.line("",
                 fmt::format("estimated modulus along ({:.2g}) {:.2f} times the smallest",
                             fmt::join(c.stiffest.c.begin(), c.stiffest.c.begin() + r.dim, ", "),
                             c.modulusRatio));
}

void addMaterials(Summary& out, const Report& r) {
    constexpr std::size_t kShown = 6;
    const auto number = [](double x) {
        return x < 1e4 ? fmt::format("{:.4g}", x) : grouped(static_cast<std::uint64_t>(x + 0.5));
    };
    for (std::size_t k = 0; k < std::min(kShown, r.materials.size()); ++k) {
        const MaterialReport& m = r.materials[k];
        std::vector<std::string> texts;
        const auto add = [&](const char* name, const auto& of, const char* unit) {
            if (!of) return;
            const auto& [least, middle, most] = *of;
            texts.push_back(least == most
                                ? fmt::format("{} {} {}", name, number(least), unit)
                                : fmt::format("{} {} to {} {}, median {}", name, number(least),
                                              number(most), unit, number(middle)));
        };
        add("density", m.density, "kg/m³");
        add("Young's modulus", m.modulus, "MPa");
        out.line(k == 0 ? "material" : "",
                 (m.part.empty() ? "" : m.part + ": ") + fmt::format("{}", fmt::join(texts, "; ")));
    }
    if (r.materials.size() > kShown)
        out.line("", fmt::format("and {} more parts, which a report as .json lists",
                                 r.materials.size() - kShown));
}

void addParts(Summary& out, const Report& r) {
    if (r.parts.empty()) return;
    for (const PartReport& p : r.parts) {
        std::string text = fmt::format("{}: {} spheres, {:.4f} of {:.6g} mm³", p.name,
                                       grouped(p.count), p.solidFraction, p.volume);
        if (p.bvtv) text += fmt::format(", BV/TV {:.4f}", *p.bvtv);
        if (p.ks) text += fmt::format(", KS {:.2g}", *p.ks);
        if (p.density > 0) text += fmt::format(", {:g} kg/m³", p.density);
        for (const auto& [region, density] : p.densities)
            text += fmt::format(", region {} {:g} kg/m³", region, density);
        if (!p.requested.empty() && r.requested != p.requested) text += ", " + p.requested;
        out.line(&p == &r.parts.front() ? "parts" : "", text);
    }
    out.line("", fmt::format("{} contact{} between parts (gap up to {:g})",
                             grouped(r.contactsBetweenParts),
                             r.contactsBetweenParts == 1 ? "" : "s", r.contactTolerance));
    constexpr std::size_t kShown = 6;
    for (std::size_t k = 0; k < std::min(kShown, r.interfaces.size()); ++k) {
        const InterfaceReport& i = r.interfaces[k];
        out.line(k == 0 ? "interfaces" : "",
                 fmt::format("{} and {}: {} bond{} on {:.4g} mm², {:.2g} per mm² (planes through "
                             "them: {:.2g} and {:.2g})",
                             i.parts[0], i.parts[1], grouped(i.pairs), i.pairs == 1 ? "" : "s",
                             i.area, i.perArea(), i.bulk[0], i.bulk[1]));
    }
    if (r.interfaces.size() > kShown)
        out.line("", fmt::format("and {} more, which a report as .json lists",
                                 r.interfaces.size() - kShown));
}

void addDensified(Summary& out, const Report& r, const DimensionWords& words) {
    const Report::Densified& d = *r.densified;
    if (d.random)
        out.line("densified", fmt::format("from random points to {:.4f} of the domain, {} steps",
                                          d.after, grouped(d.steps)));
    else
        out.line("densified",
                 fmt::format("from {:.4f} to {:.4f} of the domain, {} {} added, {} steps", d.before,
                             d.after, grouped(d.inserted), words.spheres, grouped(d.steps)));
    const auto& before = d.contactsBefore;
    if (!d.contactsAfter || !d.solidLike) return;
    const auto& after = *d.contactsAfter;
    out.line("",
             fmt::format("coordination numbers without walls, for gaps up to 0.1, 1 and 5 % of the "
                         "smaller radius: {:.2f}, {:.2f}, {:.2f}{}",
                         after[0], after[1], after[2],
                         d.random ? std::string()
                                  : fmt::format(" (before: {:.2f}, {:.2f}, {:.2f})", before[0],
                                                before[1], before[2])));
    constexpr double kNextTolerance = Report::Densified::kContactTolerances[1];
    if (r.contactTolerance < kNextTolerance && after[0] < 0.5 * after[1])
        out.line("", fmt::format("contacts and bonds of densified {} need a wider tolerance: "
                                 "`contactTolerance` {:.2g}",
                                 words.spheres, kNextTolerance));
    out.line("", fmt::format("{:.{}g} % in crystalline order (by bond order)", 100 * *d.solidLike,
                             *d.solidLike < 0.995 ? 2 : 3));
}

std::string voidsText(const Report& r, const DimensionWords& words) {
    const VoidReport& v = *r.voids;
    std::string text = v.method;
    if (v.count > 0) text += fmt::format(": {}", grouped(v.count));
    if (v.bvtv)
        text += fmt::format(", {} {:.4f}",
                            v.ofSpheres ? "share of the spheres' volume left" : "BV/TV", *v.bvtv);
    if (v.filled)
        text += fmt::format(" ({} fill {:.4f} of the same volume)", words.spheres, *v.filled);
    if (v.amount && v.method == "boolean")
        text += fmt::format(", {:.5g} centers per {}", *v.amount, words.volumeUnit);
    else if (v.amount)
        text += fmt::format(", {} {:.5g}",
                            v.method == "overlay" ? "number"
                            : v.method == "foam"  ? "dilated by the factor"
                            : v.ofSpheres         ? "D ="
                                                  : "probability",
                            *v.amount);
    if (v.reachedShare) text += fmt::format(" (share of holes {:.4g})", *v.reachedShare);
    if (v.culled > 0) text += fmt::format(", {} {} culled", grouped(v.culled), words.spheres);
    return text;
}

/// What a structure was asked to have, and has.
void addTargets(Summary& out, const VoidReport& v) {
    if (v.targets.empty()) return;
    for (const TargetReport& t : v.targets)
        out.line(fmt::format("{:<11}{:<7}", "", t.symbol()),
                 fmt::format("{:.4g} of {:g} asked{}", t.reached, t.asked,
                             t.scatter ? fmt::format(", standard deviation {:.2g}", *t.scatter)
                                       : std::string()));
    if (v.thicknessDistance && v.separationDistance)
        out.line("",
                 fmt::format("distributions: {:.2f} (local thickness) and {:.2f} (spacing) from "
                             "the sample's",
                             *v.thicknessDistance, *v.separationDistance));
    out.line("", fmt::format("measured in a specimen of {:.4g} mm; to repeat it without a search:",
                             v.specimen));
    std::string line;
    std::istringstream words(v.parameters);
    for (std::string option, value; words >> option >> value;) {
        if (line.size() + option.size() + value.size() > 64) {
            out.line("", line);
            line.clear();
        }
        line += (line.empty() ? "" : " ") + option + " " + value;
    }
    if (!line.empty()) out.line("", line);
}

std::string text(const std::optional<LengthStatistics>& length) {
    return length ? fmt::format("{:.4g} mm", length->mean) : "none";
}

void addVoids(Summary& out, const Report& r, const DimensionWords& words) {
    const VoidReport& v = *r.voids;
    const char* root = v.shell > 0 ? "connected to the shell" : "in the largest component";
    if (!v.method.empty()) {
        out.line("voids", voidsText(r, words));
        if (v.thickness)
            out.line("", fmt::format("Tb.Th {:.4g} mm with void radii {}", *v.thickness, v.radius));
        addTargets(out, v);
        if (v.solid)
            out.line("", fmt::format("measured: Tb.Th {}, Tb.Sp {}, DA {}, Conn.D {:.4g} /mm³",
                                     text(v.solid->thickness), text(v.solid->separation),
                                     v.solid->anisotropy
                                         ? fmt::format("{:.3f}", v.solid->anisotropy->degree)
                                         : "none",
                                     v.solid->connectivityDensity));
        if (v.voxelSize > 0)
            out.line("", fmt::format("level set in voxels of {:.4g} mm", v.voxelSize));
        if (v.solidAttached)
            out.line("", fmt::format("{:.4g} % of the solid is {}; {} connected component{}",
                                     100 * *v.solidAttached, root, grouped(v.solidPieces),
                                     v.solidPieces == 1 ? "" : "s"));
        if (v.spheresAttached)
            out.line("", fmt::format("{:.4g} % of the {} are {} by contacts{}",
                                     100 * *v.spheresAttached, words.spheres, root,
                                     v.dropped > 0
                                         ? fmt::format("; {} others removed", grouped(v.dropped))
                                         : std::string()));
    }
    if (v.shell > 0 && r.count > 0)
        out.line("shell",
                 fmt::format("{}{:g} mm, {} {} cortical{}",
                             v.leastShell ? fmt::format("{:g} to ", *v.leastShell) : std::string(),
                             v.shell, grouped(v.cortical), words.spheres,
                             v.across ? fmt::format("; {:.3g} {} across", *v.across, words.spheres)
                                      : std::string()));
}

/// "none", apart from what the input pack had; or nothing if this run found more than that.
std::string noneNew(std::uint64_t found, std::uint64_t given, const std::string& things,
                    const std::string& fault, double largest, const char* radius) {
    if (found != given) return "";
    if (found == 0) return fmt::format("none (largest {:.2g} of {})", largest, radius);
    return fmt::format("none new; {} {} of the input pack {}", grouped(found), things, fault);
}

void addChecks(Summary& out, const Report& r, const DimensionWords& words) {
    // `measure` reports; it does not judge.
    const char* failed = r.task == "measure" ? "" : "CHECK FAILED: ";
    if (r.overlap) {
        const auto& o = *r.overlap;
        const std::string none =
            noneNew(o.pairs, r.inputOverlaps, "pairs", "overlap", o.max, "a radius");
        out.line("overlap",
                 !none.empty()
                     ? none
                     : fmt::format("{}{}{} pairs, largest {:.3g} of the smaller radius", failed,
                                   o.complete ? "" : "more than ", grouped(o.pairs), o.max));
    }
    if (r.requestedGap > 0 && r.smallestGap)
        out.line("gap",
                 fmt::format("{}smallest {:.6g} mm, requested {:.6g} mm",
                             failedChecks(r).gap ? failed : "", *r.smallestGap, r.requestedGap));
    if (r.protrusion) {
        const auto& p = *r.protrusion;
        const std::string none =
            noneNew(p.spheres, r.inputProtrusions, words.spheres, "protrude", p.max, "a radius");
        out.line("protrusion", !none.empty()
                                   ? none
                                   : fmt::format("{}{} {}, largest {:.3g} of the radius, {} with "
                                                 "centers outside",
                                                 failed, grouped(p.spheres), words.spheres, p.max,
                                                 grouped(p.centersOutside)));
    }
}

void addRun(Summary& out, const Report& r, const DimensionWords& words) {
    std::string seconds;
    for (const auto& [name, value] : r.seconds.stages())
        if (value > 0) seconds += fmt::format("{} {:.2f}, ", name, value);
    const std::string processes = r.ranks > 1 ? fmt::format("{} processes of ", r.ranks) : "";
    out.line("seconds", seconds + fmt::format("total {:.2f} on {}{} thread{}", r.seconds.total,
                                              processes, r.threads, r.threads == 1 ? "" : "s"));
    if (r.device.steps > 0)
        out.line("device",
                 fmt::format("{}, driver {}: {} steps, {:.2f} seconds of kernels", r.device.name,
                             r.device.driver, grouped(r.device.steps), r.device.seconds));
    if (r.seconds.pack > 0 && r.count > 0 && !(r.densified && r.densified->random))
        out.line("", fmt::format(
                         "{} {} placed per second",
                         grouped(static_cast<std::uint64_t>(static_cast<double>(r.count) /
                                                            (r.seconds.pack + r.seconds.settle))),
                         words.spheres));
    if (r.peakMemoryBytes > 0)
        out.line("memory", fmt::format("{:.0f} MiB at most{}",
                                       static_cast<double>(r.peakMemoryBytes) / (1 << 20),
                                       r.ranks > 1 ? " in a process" : ""));
    if (r.task == "voids")
        out.line("seed", std::to_string(r.seed));
    else if (r.task == "pack" || r.task == "carve")
        out.line("seed", fmt::format("{}, hash {}", r.seed, hashText(r.hash)));
    else
        out.line("hash", hashText(r.hash));
    const auto rounds = [](const std::string& file) { return extensionOf(file) == ".vdb"; };
    if (r.filesUnit != Unit::millimeter && std::any_of(r.files.begin(), r.files.end(), rounds))
        out.line("", fmt::format("a .vdb in {} rounds lengths: the pack in it has another hash",
                                 unitName(r.filesUnit)));
}

/// Lines of which the first has a label.
void addLines(Summary& out, const char* label, const std::vector<std::string>& lines) {
    for (std::size_t i = 0; i < lines.size(); ++i) out.line(i == 0 ? label : "", lines[i]);
}

}  // namespace

std::string summary(const Report& r) {
    const DimensionWords words(r.dim);
    Summary out;
    if (!r.domain.kind.empty()) addDomain(out, r, words);
    for (const FoundValue& found : r.found) out.line("found", textOf(found));
    addLines(out, "by default", r.chosen);
    addSpheres(out, r, words);
    if (r.contacts) addContacts(out, r, words);
    if (r.densified) addDensified(out, r, words);
    if (r.voids) addVoids(out, r, words);
    addParts(out, r);
    addMaterials(out, r);
    addChecks(out, r, words);
    if (r.task == "verify")
        out.line("verdict", failedChecks(r).any() ? "FAILED"
                            : r.protrusion        ? "passed: overlap and protrusion"
                                                  : "passed: overlap; without a domain, protrusion "
                                                    "is not checked");
    addRun(out, r, words);
    addLines(out, "written", r.files);
    return out.text();
}

}  // namespace vdbpack
