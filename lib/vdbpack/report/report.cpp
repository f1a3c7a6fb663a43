#include "vdbpack/report/report.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/mesh/repair/mesh_repair.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstddef>
#include <type_traits>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json orNull(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

/// Columns on a terminal of UTF-8 text.
std::size_t columns(const std::string& text) {
    std::size_t n = 0;
    for (const char c : text) n += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    return n;
}

/// Lines under labels, wrapped between words.
class Summary {
public:
    void line(const std::string& label, const std::string& text) {
        constexpr std::size_t kLabel = 11, kWidth = 80;
        std::string row = fmt::format("{:<{}}", label, kLabel);
        std::size_t used = kLabel;
        bool fresh = true;
        for (std::size_t at = 0; at < text.size();) {
            const std::size_t end = std::min(text.find(' ', at), text.size());
            const std::string word = text.substr(at, end - at);
            if (!fresh && used + 1 + columns(word) > kWidth) {
                text_ += row + "\n";
                row = std::string(kLabel, ' ');
                used = kLabel;
                fresh = true;
            }
            row += (fresh ? "" : " ") + word;
            used += columns(word) + (fresh ? 0 : 1);
            fresh = false;
            at = end + 1;
        }
        text_ += row + "\n";
    }
    const std::string& text() const { return text_; }

private:
    std::string text_;
};

Json contactsJson(const Report& r) {
    Json json = {{"mean", nullptr}, {"tolerance", r.contactTolerance}};
    if (!r.contacts) return json;
    const ContactNetwork& c = *r.contacts;
    json["mean"] = c.mean;
    json["meanOfSpheres"] = c.meanOfSpheres;
    json["wallsKnown"] = !r.domain.kind.empty();
    json["pairs"] = c.pairs;
    json["wall"] = c.wallContacts;
    json["histogram"] = c.histogram;
    json["few"] = {{"below", c.few}, {"share", c.fewShare}};
    json["components"] = c.components;
    json["largestComponent"] = c.largestComponent;
    const auto fabric = [&](auto dim) {
        constexpr int Dim = decltype(dim)::value;
        Matrix<Dim> m;
        Json rows = Json::array();
        for (std::size_t i = 0; i < Dim; ++i) {
            for (std::size_t j = 0; j < Dim; ++j) m[i].c[j] = c.fabric[i].c[j];
            rows.push_back(m[i].c);
        }
        const auto eigen = eigenSystem<Dim>(m);
        json["fabric"] = {
            {"tensor", rows}, {"eigenvalues", eigen.values.c}, {"direction", eigen.vectors[0].c}};
    };
    if (r.dim == 2)
        fabric(std::integral_constant<int, 2>());
    else
        fabric(std::integral_constant<int, 3>());
    return json;
}

void addDomain(Summary& out, const Report& r) {
    const bool plane = r.dim == 2;
    const char* volume = plane ? Measure<2>::kVolume : Measure<3>::kVolume;
    const char* unit = plane ? Measure<2>::kVolumeUnit : Measure<3>::kVolumeUnit;
    std::string text = r.domain.kind;
    if (r.domain.triangles > 0) text += fmt::format(", {} triangles", grouped(r.domain.triangles));
    text += fmt::format(", {} {:.6g} {}", volume, r.volume, unit);
    if (r.domain.meshVolume > 0) text += fmt::format(" (mesh: {:.6g})", r.domain.meshVolume);
    text += fmt::format(", wall {:.6g} {}", r.area, plane ? "mm" : "mm²");
    out.line("domain", text);
    if (r.domain.voxelSize > 0)
        out.line("", fmt::format("field of {} active voxels of {:.4g} mm",
                                 grouped(r.domain.activeVoxels), r.domain.voxelSize));
    if (r.domain.boundaryEdges > 0 || r.domain.nonManifoldEdges > 0)
        out.line("",
                 fmt::format("the mesh has {} boundary and {} non-manifold edges",
                             grouped(r.domain.boundaryEdges), grouped(r.domain.nonManifoldEdges)));
    if (r.domain.repair) {
        out.line("repair", describe(*r.domain.repair));
        if (r.domain.repair->doubtfulVolume > 0)
            out.line("", fmt::format("{:.4g} mm³ in doubt next to holes",
                                     r.domain.repair->doubtfulVolume));
    }
}

Json densifiedJson(const Report& r) {
    if (!r.densified) return {};
    const Report::Densified& d = *r.densified;
    Json contacts = Json::array();
    for (std::size_t k = 0; k < d.contactsBefore.size(); ++k)
        contacts.push_back({{"tolerance", Report::Densified::kContactTolerances[k]},
                            {"before", d.contactsBefore[k]},
                            {"after", d.contactsAfter ? Json((*d.contactsAfter)[k]) : Json()}});
    return {{"asked", d.asked ? Json(*d.asked) : Json("max")},
            {"before", d.before},
            {"after", d.after},
            {"inserted", d.inserted},
            {"steps", d.steps},
            {"stages", d.stages},
            {"contacts", contacts},
            {"solidLike", orNull(d.solidLike)}};
}

void addDensified(Summary& out, const Report& r, const char* spheres) {
    const Report::Densified& d = *r.densified;
    out.line("densified",
             fmt::format("from {:.4f} to {:.4f} of the domain, {} {} added, {} steps", d.before,
                         d.after, grouped(d.inserted), spheres, grouped(d.steps)));
    const auto& before = d.contactsBefore;
    if (!d.contactsAfter || !d.solidLike) return;
    const auto& after = *d.contactsAfter;
    out.line("",
             fmt::format("{} that one touches within 0.1, 1 and 5 % of the smaller radius: "
                         "{:.2f}, {:.2f}, {:.2f} (before: {:.2f}, {:.2f}, {:.2f})",
                         spheres, after[0], after[1], after[2], before[0], before[1], before[2]));
    constexpr double kNextTolerance = Report::Densified::kContactTolerances[1];
    if (r.contactTolerance < kNextTolerance)
        out.line("", fmt::format("contacts and bonds of densified {} want a wider tolerance: "
                                 "--contact-tol {:.2g}",
                                 spheres, kNextTolerance));
    out.line("", fmt::format("{:.2g} % lie as in a crystal (bond order)", 100 * *d.solidLike));
}

Json voidsJson(const Report& r) {
    const VoidReport v = r.voids.value_or(VoidReport());
    Json json = {{"count", v.count}, {"bvtv", orNull(v.bvtv)}, {"culled", v.culled}};
    if (!r.voids) return json;
    json["method"] = v.method.empty() ? Json() : Json(v.method);
    json["shell"] = v.shell;
    json["voxelSize"] = v.voxelSize > 0 ? Json(v.voxelSize) : Json();
    json["totalVolume"] = v.totalVolume;
    json["bvtvOf"] = v.ofSpheres ? "spheres" : "solid";
    json["amount"] = orNull(v.amount);
    json["reachedShare"] = orNull(v.reachedShare);
    json["radius"] = v.radius.empty() ? Json() : Json(v.radius);
    json["tbth"] = orNull(v.thickness);
    json["solidAttached"] = orNull(v.solidAttached);
    json["solidPieces"] = v.solidPieces;
    json["spheresAttached"] = orNull(v.spheresAttached);
    json["dropped"] = v.dropped;
    json["cortical"] = v.cortical;
    json["across"] = orNull(v.across);
    return json;
}

void addVoids(Summary& out, const Report& r, const char* spheres) {
    const VoidReport& v = *r.voids;
    const char* root = v.shell > 0 ? "the shell" : "the largest piece";
    if (!v.method.empty()) {
        std::string text = v.method;
        if (v.count > 0) text += fmt::format(": {}", grouped(v.count));
        if (v.bvtv)
            text +=
                fmt::format(", {} {:.4f}",
                            v.ofSpheres ? "share of the spheres' volume left" : "BV/TV", *v.bvtv);
        if (v.amount && v.method == "boolean")
            text += fmt::format(", {:.5g} centers a {}", *v.amount, r.dim == 2 ? "mm²" : "mm³");
        else if (v.amount)
            text += fmt::format(", {} {:.5g}",
                                v.method == "overlay" ? "number"
                                : v.ofSpheres         ? "D ="
                                                      : "probability",
                                *v.amount);
        if (v.reachedShare) text += fmt::format(" (share of holes {:.4g})", *v.reachedShare);
        if (v.culled > 0) text += fmt::format(", {} {} culled", grouped(v.culled), spheres);
        out.line("voids", text);
        if (v.thickness)
            out.line("", fmt::format("Tb.Th {:.4g} mm with void radii {}", *v.thickness, v.radius));
        if (v.voxelSize > 0)
            out.line("", fmt::format("level set in voxels of {:.4g} mm", v.voxelSize));
        if (v.solidAttached)
            out.line("", fmt::format("{:.4g} % of the solid hangs together with {}; {} {}",
                                     100 * *v.solidAttached, root, grouped(v.solidPieces),
                                     v.solidPieces == 1 ? "piece" : "pieces"));
        if (v.spheresAttached)
            out.line("", fmt::format(
                             "contacts join {:.4g} % of the {} with {}{}", 100 * *v.spheresAttached,
                             spheres, v.shell > 0 ? root : "the largest set",
                             v.dropped > 0 ? fmt::format("; {} others dropped", grouped(v.dropped))
                                           : std::string()));
    }
    if (v.shell > 0 && r.count > 0)
        out.line("shell",
                 fmt::format("{:g} mm, {} {} cortical{}", v.shell, grouped(v.cortical), spheres,
                             v.across ? fmt::format("; it is {:.3g} {} thick", *v.across, spheres)
                                      : std::string()));
}

void addChecks(Summary& out, const Report& r, const char* spheres) {
    // To measure is not to judge.
    const char* failed = r.task == "measure" ? "" : "CHECK FAILED: ";
    if (r.overlap) {
        const auto& o = *r.overlap;
        out.line("overlap",
                 o.pairs == r.givenOverlaps
                     ? o.pairs > 0
                           ? fmt::format("none but the {} pairs that were given", grouped(o.pairs))
                           : fmt::format("none (largest {:.2g} of a radius)", o.max)
                     : fmt::format("{}{}{} pairs, largest {:.3g} of the smaller radius", failed,
                                   o.complete ? "" : "more than ", grouped(o.pairs), o.max));
    }
    if (r.gapAsked > 0 && r.smallestGap)
        out.line("gap", fmt::format("{}{:.6g} mm asked for, smallest {:.6g} mm",
                                    keepsGap(r) ? "" : failed, r.gapAsked, *r.smallestGap));
    if (r.protrusion) {
        const auto& p = *r.protrusion;
        out.line("protrusion", p.spheres == r.givenProtrusions
                                   ? p.spheres > 0
                                         ? fmt::format("none but the {} {} that were given",
                                                       grouped(p.spheres), spheres)
                                         : fmt::format("none (largest {:.2g} of a radius)", p.max)
                                   : fmt::format("{}{} {}, largest {:.3g} of the radius, {} with "
                                                 "centers outside",
                                                 failed, grouped(p.spheres), spheres, p.max,
                                                 grouped(p.centersOutside)));
    }
}

}  // namespace

std::string grouped(std::uint64_t n) {
    std::string text = std::to_string(n);
    for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
    return text;
}

bool keepsGap(const Report& r) {
    return !(r.gapAsked > 0) || !r.smallestGap ||
           *r.smallestGap >= r.gapAsked - kVerifyTolerance * r.radius.min;
}

nlohmann::ordered_json toJson(const Report& r) {
    Json json;
    json["version"] = r.version;
    json["command"] = r.command;
    json["unit"] = "mm";
    json["seed"] = r.seed;
    json["threads"] = r.threads;
    json["hash"] = hashText(r.hash);
    json["interrupted"] = r.interrupted;
    json["domain"] = {{"kind", r.domain.kind},
                      {"triangles", r.domain.triangles},
                      {"volume", r.volume},
                      {"meshVolume", r.domain.meshVolume > 0 ? Json(r.domain.meshVolume) : Json()},
                      {"area", r.area},
                      {"voxelSize", r.domain.voxelSize > 0 ? Json(r.domain.voxelSize) : Json()},
                      {"activeVoxels", r.domain.activeVoxels},
                      {"boundaryEdges", r.domain.boundaryEdges},
                      {"nonManifoldEdges", r.domain.nonManifoldEdges}};
    if (r.domain.repair) json["domain"]["repair"] = toJson(*r.domain.repair);
    const bool any = r.count > 0;
    json["spheres"] = {{"count", r.count},
                       {"existing", r.existing},
                       {"requested", r.requested.empty() ? Json() : Json(r.requested)},
                       {"radius",
                        {{"min", any ? Json(r.radius.min) : Json()},
                         {"mean", any ? Json(r.radius.mean) : Json()},
                         {"max", any ? Json(r.radius.max) : Json()},
                         {"sd", any ? Json(r.radius.sd) : Json()}}},
                       {"ks", orNull(r.ks)},
                       {"ksByVolume", orNull(r.ksByVolume)},
                       {"wall", r.wallSizes ? Json({{"depth", r.wallSizes->depth},
                                                    {"count", r.wallSizes->count},
                                                    {"ks", r.wallSizes->ks},
                                                    {"ksByVolume", r.wallSizes->ksByVolume}})
                                            : Json()}};
    json["solidFraction"] = {{"total", orNull(r.solidFractionTotal)},
                             {"interior", orNull(r.solidFractionInterior)}};
    json["contacts"] = contactsJson(r);
    json["overlap"] = {{"max", r.overlap ? Json(r.overlap->max) : Json()},
                       {"pairs", r.overlap ? Json(r.overlap->pairs) : Json()}};
    json["gap"] = {{"asked", r.gapAsked}, {"min", orNull(r.smallestGap)}};
    json["protrusion"] = {
        {"max", r.protrusion ? Json(r.protrusion->max) : Json()},
        {"spheres", r.protrusion ? Json(r.protrusion->spheres) : Json()},
        {"centersOutside", r.protrusion ? Json(r.protrusion->centersOutside) : Json()}};
    json["densified"] = densifiedJson(r);
    json["voids"] = voidsJson(r);
    json["seconds"] = {{"mesh", r.seconds.mesh},   {"domain", r.seconds.domain},
                       {"pack", r.seconds.pack},   {"densify", r.seconds.densify},
                       {"voids", r.seconds.voids}, {"measure", r.seconds.measure},
                       {"write", r.seconds.write}, {"total", r.seconds.total}};
    json["peakMemoryBytes"] = r.peakMemoryBytes;
    return json;
}

std::string summary(const Report& r) {
    const char* spheres = r.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres;
    const char* sphere = r.dim == 2 ? Measure<2>::kSphere : Measure<3>::kSphere;
    Summary out;
    if (!r.domain.kind.empty()) addDomain(out, r);
    for (std::size_t i = 0; i < r.chosen.size(); ++i)
        out.line(i == 0 ? "by default" : "", r.chosen[i]);
    std::string count = grouped(r.count);
    if (!r.requested.empty()) count += ", asked for " + r.requested;
    if (r.ks && r.ksByVolume)
        count += fmt::format(" (Kolmogorov-Smirnov distance {:.2g}, by {} {:.2g})", *r.ks,
                             r.dim == 2 ? Measure<2>::kVolume : Measure<3>::kVolume, *r.ksByVolume);
    if (r.voids && r.voids->culled > 0 && r.ks) count += "; both before the cut";
    if (r.interrupted) count += "; INTERRUPTED, this is what was complete";
    if (r.existing > 0) count += fmt::format("; {} of them stood already", grouped(r.existing));
    if (r.task != "voids") out.line(spheres, count);
    if (r.count > 0)
        out.line("", fmt::format("radius {:.5g} to {:.5g} mm, mean {:.5g}, deviation {:.4g}",
                                 r.radius.min, r.radius.max, r.radius.mean, r.radius.sd));
    if (r.solidFractionTotal) {
        std::string text = fmt::format("{:.4f} of the domain", *r.solidFractionTotal);
        if (r.solidFractionInterior)
            text +=
                fmt::format(", {:.4f} deeper than three largest radii", *r.solidFractionInterior);
        out.line("solid", text);
    }
    if (r.contacts)
        out.line("contacts",
                 fmt::format("{:.3g} a {}{} (gap within {:g} of the smaller radius), {:.3g} % have "
                             "fewer than {}; the largest connected set holds {:.4g} %",
                             r.contacts->mean, sphere,
                             r.domain.kind.empty()
                                 ? std::string(", walls unknown")
                                 : fmt::format(", {:.3g} without walls", r.contacts->meanOfSpheres),
                             r.contactTolerance, 100 * r.contacts->fewShare, r.contacts->few,
                             100 * r.contacts->largestComponent));
    if (r.densified) addDensified(out, r, spheres);
    if (r.voids) addVoids(out, r, spheres);
    addChecks(out, r, spheres);
    std::string seconds;
    const std::pair<const char*, double> stages[] = {
        {"mesh", r.seconds.mesh},   {"domain", r.seconds.domain},
        {"pack", r.seconds.pack},   {"densify", r.seconds.densify},
        {"voids", r.seconds.voids}, {"measure", r.seconds.measure},
        {"write", r.seconds.write}};
    for (const auto& [name, value] : stages)
        if (value > 0) seconds += fmt::format("{} {:.2f}, ", name, value);
    out.line("seconds", seconds + fmt::format("total {:.2f} on {} thread{}", r.seconds.total,
                                              r.threads, r.threads == 1 ? "" : "s"));
    if (r.seconds.pack > 0 && r.count > 0)
        out.line("", fmt::format("{} {} placed a second",
                                 grouped(static_cast<std::uint64_t>(static_cast<double>(r.count) /
                                                                    r.seconds.pack)),
                                 spheres));
    if (r.peakMemoryBytes > 0)
        out.line("memory", fmt::format("{:.0f} MiB at most",
                                       static_cast<double>(r.peakMemoryBytes) / (1 << 20)));
    if (r.task == "voids")
        out.line("seed", std::to_string(r.seed));
    else if (r.task == "pack" || r.task == "carve")
        out.line("seed", fmt::format("{}, hash {}", r.seed, hashText(r.hash)));
    else
        out.line("hash", hashText(r.hash));
    for (std::size_t i = 0; i < r.files.size(); ++i) out.line(i == 0 ? "written" : "", r.files[i]);
    return out.text();
}

}  // namespace vdbpack
