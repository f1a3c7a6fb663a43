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

const char* verdict(bool ok) {
    return ok ? "ok" : "FAILED";
}

}  // namespace

template <int Dim>
nlohmann::ordered_json worstJson(const OverlapCheck& check, const Pack<Dim>& pack) {
    auto all = nlohmann::ordered_json::array();
    for (const auto& w : check.worst)
        all.push_back(
            {{"overlap", w.overlap}, {"spheres", {sphereJson(pack, w.i), sphereJson(pack, w.j)}}});
    return all;
}

template <int Dim>
nlohmann::ordered_json worstJson(const ProtrusionCheck& check, const Pack<Dim>& pack) {
    auto all = nlohmann::ordered_json::array();
    for (const auto& w : check.worst) {
        auto sphere = sphereJson(pack, w.i);
        sphere["protrusion"] = w.protrusion;
        all.push_back(std::move(sphere));
    }
    return all;
}

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
    const OverlapCheck& overlap = result.overlap;
    json["overlap"] = {{"max", overlap.max},
                       {"pairs", overlap.pairs},
                       {"complete", overlap.complete},
                       {"worst", worstJson(overlap, pack)}};
    if (const auto& protrusion = result.protrusion)
        json["protrusion"] = {{"max", protrusion->max},
                              {"spheres", protrusion->spheres},
                              {"centersOutside", protrusion->centersOutside},
                              {"closed", protrusion->closed},
                              {"worst", worstJson(*protrusion, pack)}};
    else
        json["protrusion"] = {{"max", nullptr}, {"spheres", nullptr}};
    return json;
}

/// Says how many a list of the worst leaves out.
std::string moreThan(std::size_t listed, std::uint64_t all) {
    return all > listed ? fmt::format("  and {} more\n", all - listed) : std::string();
}

template <int Dim>
std::string describe(const OverlapCheck& check, const Pack<Dim>& pack) {
    std::string text = fmt::format("{:<12}{}: {}{} pairs, largest {:.3g} of the smaller radius\n",
                                   "overlap", verdict(check.pairs == 0),
                                   check.complete ? "" : "more than ", check.pairs, check.max);
    for (const auto& w : check.worst)
        text += fmt::format("  {:.3g}: {}\n    and {}\n", w.overlap, labelOf(pack, w.i),
                            labelOf(pack, w.j));
    return text + moreThan(check.worst.size(), check.pairs);
}

template <int Dim>
std::string describe(const ProtrusionCheck& check, const Pack<Dim>& pack) {
    std::string text =
        fmt::format("{:<12}{}: {} {}, largest {:.3g} of the radius, {} with centers outside\n",
                    "protrusion", verdict(check.spheres == 0), check.spheres,
                    Measure<Dim>::kSpheres, check.max, check.centersOutside);
    if (!check.closed)
        text +=
            "  the wall is not closed: inside or outside is decided by the majority of six lines\n";
    if (2 * check.centersOutside > pack.spheres.size())
        text +=
            "  most centers lie outside: check `unit` and `packUnit`, and the axes (`space`) of "
            "the domain\n";
    for (const auto& w : check.worst)
        text += fmt::format("  {:.3g}: {}{}\n", w.protrusion, labelOf(pack, w.i),
                            w.protrusion > 1 ? ", center outside" : "");
    return text + moreThan(check.worst.size(), check.spheres);
}

template <int Dim>
std::string describe(const VerifyResult& result, const Pack<Dim>& pack) {
    std::string text = fmt::format("{:<12}{} {}, radius {:.6g} to {:.6g} mm, mean {:.6g}\n", "pack",
                                   result.count, Measure<Dim>::kSpheres, result.radius.min,
                                   result.radius.max, result.radius.mean);
    text += describe(result.overlap, pack);
    text += result.protrusion
                ? describe(*result.protrusion, pack)
                : fmt::format("{:<12}not checked: no domain was given\n", "protrusion");
    if (result.ks)
        text += fmt::format("{:<12}{}: Kolmogorov-Smirnov distance {:.4g}\n", "sizes",
                            verdict(*result.ks <= result.ksLimit), *result.ks);
    text += fmt::format("{:<12}{}\n", "hash", hashText(result.hash));
    return text;
}

#define VDBPACK_INSTANTIATE(Dim)                                                         \
    template std::string describe(const OverlapCheck&, const Pack<Dim>&);                \
    template std::string describe(const ProtrusionCheck&, const Pack<Dim>&);             \
    template nlohmann::ordered_json worstJson(const OverlapCheck&, const Pack<Dim>&);    \
    template nlohmann::ordered_json worstJson(const ProtrusionCheck&, const Pack<Dim>&); \
    template nlohmann::ordered_json toJson(const VerifyResult&, const Pack<Dim>&);       \
    template std::string describe(const VerifyResult&, const Pack<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
