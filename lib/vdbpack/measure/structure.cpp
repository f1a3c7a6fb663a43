#include "vdbpack/measure/structure.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <vector>

namespace vdbpack {

using Json = nlohmann::ordered_json;

void addTo(nlohmann::ordered_json& report, const Structure& s) {
    std::vector<double> depths;
    for (std::size_t b = 0; s.profile && b < s.profile->fraction.size(); ++b)
        depths.push_back((static_cast<double>(b) + 0.5) * s.profile->width);
    report["profile"] = s.profile ? Json({{"width", s.profile->width},
                                          {"depth", depths},
                                          {"volume", s.profile->volume},
                                          {"fraction", s.profile->fraction},
                                          {"error", s.profile->error}})
                                  : Json();
    report["localFraction"] = s.local ? Json({{"edge", s.local->edge},
                                              {"cells", s.local->cells},
                                              {"mean", s.local->mean},
                                              {"sd", s.local->sd}})
                                      : Json();
    report["pairCorrelation"] = s.pairCorrelation
                                    ? Json({{"width", s.pairCorrelation->width},
                                            {"meanDiameter", s.meanDiameter},
                                            {"references", s.pairCorrelation->references},
                                            {"density", s.pairCorrelation->density},
                                            {"g", s.pairCorrelation->g},
                                            {"error", s.pairCorrelation->error}})
                                    : Json();
    report["crystalline"] = s.crystalline ? Json(*s.crystalline) : Json();
    Json regions = Json::array();
    for (const auto& r : s.regions)
        regions.push_back({{"name", r.name},
                           {"volume", r.volume},
                           {"solidFraction", r.solidFraction},
                           {"count", r.count},
                           {"meanRadius", r.count > 0 ? Json(r.meanRadius) : Json()}});
    report["regions"] = s.regions.empty() ? Json() : Json({{"shell", s.shell}, {"parts", regions}});
}

std::string summary(const Structure& s) {
    std::string text;
    const auto line = [&](const char* label, const std::string& words) {
        text += fmt::format("{:<11}{}\n", label, words);
    };
    if (s.profile && !s.profile->fraction.empty()) {
        // Closer ones near the wall; the JSON has all.
        const auto& f = s.profile->fraction;
        std::string depths, values;
        for (const std::size_t b : {0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32})
            if (b < f.size()) {
                depths +=
                    fmt::format(" {:>7.3g}", (static_cast<double>(b) + 0.5) * s.profile->width);
                values += fmt::format(" {:>7.3f}", f[b]);
            }
        line("depth, mm", depths);
        line("solid", values);
        std::vector<double> errors = s.profile->error;
        std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2),
                         errors.end());
        line("", fmt::format("standard error mostly below {:.1g}", errors[errors.size() / 2]));
    }
    if (s.local)
        line("local", fmt::format("{:.4f} ± {:.4f} in {} cells of {:.4g} mm", s.local->mean,
                                  s.local->sd, s.local->cells, s.local->edge));
    if (s.pairCorrelation) {
        const auto& g = s.pairCorrelation->g;
        const auto peak = std::max_element(g.begin(), g.end()) - g.begin();
        line("g(r)", fmt::format("peak {:.3g} at {:.3g} mean diameters, about {} centers",
                                 g[static_cast<std::size_t>(peak)],
                                 (static_cast<double>(peak) + 0.5) * s.pairCorrelation->width /
                                     s.meanDiameter,
                                 s.pairCorrelation->references));
    }
    if (s.crystalline)
        line("order", fmt::format("{:.{}g} % of the {} in crystalline order (by bond order)",
                                  100 * *s.crystalline, *s.crystalline < 0.995 ? 2 : 3,
                                  s.dim == 2 ? Measure<2>::kSpheres : Measure<3>::kSpheres));
    for (const auto& r : s.regions)
        line(r.name.c_str(),
             fmt::format("{:.4f} solid in {:.6g} {}; {} {}{}", r.solidFraction, r.volume,
                         s.dim == 2 ? Measure<2>::kVolumeUnit : Measure<3>::kVolumeUnit, r.count,
                         s.dim == 2 ? "circles" : "spheres",
                         r.count > 0 ? fmt::format(", mean radius {:.4g} mm", r.meanRadius) : ""));
    return text;
}

}  // namespace vdbpack
