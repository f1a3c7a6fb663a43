#include "vdbpack/verify/verify.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <utility>

namespace vdbpack {

namespace {

template <int Dim>
std::int64_t nameOf(const Pack<Dim>& pack, std::size_t i) {
    return i < pack.id.size() ? pack.id[i] : static_cast<std::int64_t>(i);
}

template <int Dim>
std::string labelOf(const Pack<Dim>& pack, std::size_t i) {
    const Sphere<Dim>& s = pack.spheres[i];
    std::string text = fmt::format("{} at (", nameOf(pack, i));
    for (int k = 0; k < Dim; ++k) text += fmt::format("{}{:.6g}", k ? ", " : "", s.center[k]);
    return text + fmt::format("), radius {:.6g}", s.radius);
}

template <int Dim>
nlohmann::ordered_json sphereJson(const Pack<Dim>& pack, std::size_t i) {
    const Sphere<Dim>& s = pack.spheres[i];
    nlohmann::ordered_json json;
    json["id"] = nameOf(pack, i);
    json["position"] = s.center.c;
    json["radius"] = s.radius;
    return json;
}

}  // namespace

template <int Dim>
nlohmann::ordered_json toJson(const VerifyResult& result, const Pack<Dim>& pack) {
    nlohmann::ordered_json json;
    json["passed"] = result.passed();
    json["hash"] = hashText(result.hash);
    auto& spheres = json["spheres"];
    spheres["count"] = result.count;
    spheres["radius"] = {{"min", result.radius.min},
                         {"mean", result.radius.mean},
                         {"max", result.radius.max},
                         {"sd", result.radius.sd}};
    spheres["ks"] = result.ks ? nlohmann::ordered_json(*result.ks) : nullptr;
    auto& overlap = json["overlap"];
    overlap["max"] = result.overlap.max;
    overlap["pairs"] = result.overlap.pairs;
    overlap["complete"] = result.overlap.complete;
    overlap["worst"] = nlohmann::ordered_json::array();
    for (const auto& w : result.overlap.worst)
        overlap["worst"].push_back(
            {{"overlap", w.overlap}, {"spheres", {sphereJson(pack, w.i), sphereJson(pack, w.j)}}});
    auto& protrusion = json["protrusion"];
    protrusion = {{"max", nullptr}, {"spheres", nullptr}};
    if (result.protrusion) {
        protrusion["max"] = result.protrusion->max;
        protrusion["spheres"] = result.protrusion->spheres;
        protrusion["centersOutside"] = result.protrusion->centersOutside;
        protrusion["closed"] = result.protrusion->closed;
        protrusion["worst"] = nlohmann::ordered_json::array();
        for (const auto& w : result.protrusion->worst) {
            auto sphere = sphereJson(pack, w.i);
            sphere["protrusion"] = w.protrusion;
            protrusion["worst"].push_back(std::move(sphere));
        }
    }
    return json;
}

template <int Dim>
std::string describe(const VerifyResult& result, const Pack<Dim>& pack) {
    const auto verdict = [](bool ok) { return ok ? "ok" : "FAILED"; };
    std::string text = fmt::format("{:<12}{} {}, radius {:.6g} to {:.6g} mm, mean {:.6g}\n", "pack",
                                   result.count, Measure<Dim>::kSpheres, result.radius.min,
                                   result.radius.max, result.radius.mean);
    text +=
        fmt::format("{:<12}{}: {}{} pairs, largest {:.3g} of the smaller radius\n", "overlap",
                    verdict(result.overlap.pairs == 0), result.overlap.complete ? "" : "more than ",
                    result.overlap.pairs, result.overlap.max);
    for (const auto& w : result.overlap.worst)
        text += fmt::format("  {:.3g}: {}\n    and {}\n", w.overlap, labelOf(pack, w.i),
                            labelOf(pack, w.j));
    if (result.protrusion) {
        const auto& p = *result.protrusion;
        text +=
            fmt::format("{:<12}{}: {} {}, largest {:.3g} of the radius, {} with centers outside\n",
                        "protrusion", verdict(p.spheres == 0), p.spheres, Measure<Dim>::kSpheres,
                        p.max, p.centersOutside);
        if (!p.closed)
            text +=
                "  the wall is not closed: inside or outside is decided by the majority of six "
                "lines\n";
        for (const auto& w : p.worst)
            text += fmt::format("  {:.3g}: {}{}\n", w.protrusion, labelOf(pack, w.i),
                                w.protrusion > 1 ? ", center outside" : "");
    } else {
        text += fmt::format("{:<12}not checked: no domain was given\n", "protrusion");
    }
    if (result.ks)
        text += fmt::format("{:<12}{}: Kolmogorov-Smirnov distance {:.4g}\n", "sizes",
                            verdict(*result.ks <= result.ksLimit), *result.ks);
    text += fmt::format("{:<12}{}\n", "hash", hashText(result.hash));
    return text;
}

template nlohmann::ordered_json toJson<2>(const VerifyResult&, const Pack<2>&);
template nlohmann::ordered_json toJson<3>(const VerifyResult&, const Pack<3>&);
template std::string describe<2>(const VerifyResult&, const Pack<2>&);
template std::string describe<3>(const VerifyResult&, const Pack<3>&);

}  // namespace vdbpack
