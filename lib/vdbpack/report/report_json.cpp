#include "vdbpack/core/symmetric.h"
#include "vdbpack/repair/mesh_repair.h"
#include "vdbpack/report/found_value.h"
#include "vdbpack/report/report.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <type_traits>
#include <vector>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json orNull(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

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
    json["modulus"] = nullptr;
    if (c.modulusRatio > 0)
        json["modulus"] = {
            {"ratio", c.modulusRatio},
            {"direction", std::vector<double>(c.stiffest.c.begin(), c.stiffest.c.begin() + r.dim)},
            {"deepContacts", c.deepContacts}};
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

Json massOffsetJson(const Report& r) {
    if (!r.massOffset) return {};
    Json axes = Json::array();
    for (std::size_t d = 0; d < static_cast<std::size_t>(r.dim); ++d)
        axes.push_back(orNull(r.massOffset->axes[d]));
    return {{"axes", axes}, {"length", r.massOffset->length}, {"share", r.massOffset->share}};
}

Json densitiesJson(const PartReport& part) {
    Json densities;  // null: none by region
    for (const auto& [region, density] : part.densities)
        densities[std::to_string(region)] = density;
    return densities;
}

Json protrusionJson(const std::optional<ProtrusionCheck>& p) {
    return {{"max", p ? Json(p->max) : Json()},
            {"spheres", p ? Json(p->spheres) : Json()},
            {"centersOutside", p ? Json(p->centersOutside) : Json()}};
}

Json deviceJson(const DeviceUse& d) {
    return {{"name", d.name}, {"driver", d.driver}, {"steps", d.steps}, {"seconds", d.seconds}};
}

Json densifiedJson(const Report& r) {
    if (!r.densified) return {};
    const Report::Densified& d = *r.densified;
    Json contacts = Json::array();
    for (std::size_t k = 0; k < d.contactsBefore.size(); ++k)
        contacts.push_back({{"tolerance", Report::Densified::kContactTolerances[k]},
                            {"before", d.contactsBefore[k]},
                            {"after", d.contactsAfter ? Json((*d.contactsAfter)[k]) : Json()}});
    return {{"asked", d.requested ? Json(*d.requested) : Json("max")},
            {"start", d.random ? "random" : "pack"},
            {"before", d.before},
            {"after", d.after},
            {"inserted", d.inserted},
            {"steps", d.steps},
            {"stages", d.stages},
            {"contacts", contacts},
            {"solidLike", orNull(d.solidLike)}};
}

Json voidsJson(const Report& r) {
    const VoidReport v = r.voids.value_or(VoidReport());
    Json json = {{"count", v.count}, {"bvtv", orNull(v.bvtv)}, {"culled", v.culled}};
    if (!r.voids) return json;
    json["method"] = v.method.empty() ? Json() : Json(v.method);
    json["shell"] = v.shell;
    if (v.leastShell) json["leastShell"] = *v.leastShell;
    json["voxelSize"] = v.voxelSize > 0 ? Json(v.voxelSize) : Json();
    json["totalVolume"] = v.totalVolume;
    json["sphereFraction"] = orNull(v.filled);
    json["bvtvOf"] = v.ofSpheres ? "spheres" : "solid";
    json["amount"] = orNull(v.amount);
    json["reachedShare"] = orNull(v.reachedShare);
    json["radius"] = v.radius.empty() ? Json() : Json(v.radius);
    json["tbth"] = orNull(v.thickness);
    if (!v.targets.empty()) {
        json["targets"] = Json::object();
        for (const TargetReport& t : v.targets)
            json["targets"][t.name] = {
                {"asked", t.asked}, {"reached", t.reached}, {"scatter", orNull(t.scatter)}};
        json["thicknessDistance"] = orNull(v.thicknessDistance);
        json["separationDistance"] = orNull(v.separationDistance);
        json["specimen"] = v.specimen;
        json["parameters"] = v.parameters;
    }
    if (v.solid) json["solid"] = toJson(*v.solid);
    json["solidAttached"] = orNull(v.solidAttached);
    json["solidPieces"] = v.solidPieces;
    json["spheresAttached"] = orNull(v.spheresAttached);
    json["dropped"] = v.dropped;
    json["cortical"] = v.cortical;
    json["across"] = orNull(v.across);
    return json;
}

Json domainJson(const Report& r) {
    Json json = {{"kind", r.domain.kind},
                 {"triangles", r.domain.triangles},
                 {"volume", r.volume},
                 {"meshVolume", r.domain.meshVolume > 0 ? Json(r.domain.meshVolume) : Json()},
                 {"area", r.area},
                 {"voxelSize", r.domain.voxelSize > 0 ? Json(r.domain.voxelSize) : Json()},
                 {"activeVoxels", r.domain.activeVoxels},
                 {"boundaryEdges", r.domain.boundaryEdges},
                 {"nonManifoldEdges", r.domain.nonManifoldEdges}};
    if (r.domain.repair) json["repair"] = toJson(*r.domain.repair);
    return json;
}

Json spheresJson(const Report& r) {
    const auto known = [&](double value) { return r.count > 0 ? Json(value) : Json(); };
    Json json = {{"count", r.count},
                 {"existing", r.existing},
                 {"requested", r.requested.empty() ? Json() : Json(r.requested)},
                 {"radius",
                  {{"min", known(r.radius.min)},
                   {"mean", known(r.radius.mean)},
                   {"max", known(r.radius.max)},
                   {"sd", known(r.radius.sd)}}},
                 {"ks", orNull(r.ks)},
                 {"ksByVolume", orNull(r.ksByVolume)},
                 {"wall", r.wallSizes ? Json({{"depth", r.wallSizes->depth},
                                              {"count", r.wallSizes->count},
                                              {"ks", r.wallSizes->ks},
                                              {"ksByVolume", r.wallSizes->ksByVolume}})
                                      : Json()}};
    for (const auto& group : r.localSizes)
        json["local"].push_back({{"name", group.name},
                                 {"requested", group.requested},
                                 {"count", group.count},
                                 {"factors", {group.factorLeast, group.factorMost}},
                                 {"ks", group.ks},
                                 {"ksByVolume", group.ksByVolume}});
    return json;
}

Json materialsJson(const Report& r) {
    const auto range = [](const std::optional<std::array<double, 3>>& of) {
        return of ? Json{{"min", (*of)[0]}, {"median", (*of)[1]}, {"max", (*of)[2]}} : Json();
    };
    Json all = Json::array();
    for (const MaterialReport& m : r.materials)
        all.push_back({{"part", m.part.empty() ? Json() : Json(m.part)},
                       {"density", range(m.density)},
                       {"modulus", range(m.modulus)}});
    return all;
}

}  // namespace

nlohmann::ordered_json toJson(const Report& r) {
    Json json;
    json["version"] = r.version;
    json["command"] = r.command;
    json["unit"] = "mm";
    json["axes"] = r.axes.empty() ? Json() : Json(r.axes);
    json["seed"] = r.seed;
    for (const auto& [option, value] : r.varied) json["varied"][option] = value;
    json["threads"] = r.threads;
    json["ranks"] = r.ranks;
    if (r.device.steps > 0) json["device"] = deviceJson(r.device);
    json["hash"] = r.task == "voids" ? Json() : Json(hashText(r.hash));
    json["interrupted"] = r.interrupted;
    json["found"] = toJson(r.found);
    json["domain"] = domainJson(r);
    json["spheres"] = spheresJson(r);
    json["solidFraction"] = {{"total", orNull(r.solidFractionTotal)},
                             {"interior", orNull(r.solidFractionInterior)}};
    json["massOffset"] = massOffsetJson(r);
    json["contacts"] = contactsJson(r);
    json["overlap"] = {{"max", r.overlap ? Json(r.overlap->max) : Json()},
                       {"pairs", r.overlap ? Json(r.overlap->pairs) : Json()}};
    json["gap"] = {{"asked", r.requestedGap}, {"min", orNull(r.smallestGap)}};
    json["protrusion"] = protrusionJson(r.protrusion);
    json["densified"] = densifiedJson(r);
    json["voids"] = voidsJson(r);
    if (!r.parts.empty()) {
        json["parts"] = Json::array();
        for (const PartReport& p : r.parts)
            json["parts"].push_back(
                {{"name", p.name},
                 {"count", p.count},
                 {"volume", p.volume},
                 {"area", p.area},
                 {"solidFraction", p.solidFraction},
                 {"interior", orNull(p.interior)},
                 {"bvtv", orNull(p.bvtv)},
                 {"protrusion", p.protrusion},
                 {"density", p.density > 0 ? Json(p.density) : Json()},
                 {"densities", densitiesJson(p)},
                 {"requested", p.requested.empty() ? Json() : Json(p.requested)},
                 {"ks", orNull(p.ks)},
                 {"source", p.source}});
        json["contacts"]["betweenParts"] = r.contactsBetweenParts;
        for (const InterfaceReport& i : r.interfaces)
            json["interfaces"].push_back({{"parts", i.parts},
                                          {"bonds", i.pairs},
                                          {"area", i.area},
                                          {"bondsPerArea", i.perArea()},
                                          {"bulkBondsPerArea", i.bulk}});
    }
    if (!r.materials.empty()) json["materials"] = materialsJson(r);
    for (const auto& [name, value] : r.seconds.stages()) json["seconds"][name] = value;
    json["seconds"]["total"] = r.seconds.total;
    json["peakMemoryBytes"] = r.peakMemoryBytes;
    json["warnings"] = r.warnings;
    return json;
}

}  // namespace vdbpack
