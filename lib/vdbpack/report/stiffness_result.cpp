// What `vdb_pack stiffness` prints.
#include "vdbpack/report/run_result.h"
#include "vdbpack/report/words.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <string>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

Json tensorOf(const StiffnessResult& r) {
    Json json, rows = Json::array();
    for (const Vec<6>& row : r.apparent.stiffness) rows.push_back(row.c);
    json["stiffness"] = rows;
    if (r.elasticity) {
        const Elasticity& e = *r.elasticity;
        json["E"] = e.modulus.c;
        json["G"] = e.shear.c;
        json["nu"] = e.poisson.c;
        json["largest"] = {{"E", e.largest}, {"direction", e.stiffest.c}};
        json["smallest"] = {{"E", e.smallest}};
        json["isotropic"] = {{"E", e.isotropicModulus}, {"nu", e.isotropicPoisson}};
    }
    json["solver"] = {{"iterations", r.apparent.iterations}, {"residual", r.apparent.residual}};
    return json;
}

Json toJson(const StiffnessResult::Pressed& p) {
    return {{"axis", std::string(1, "xyz"[p.axis])},
            {"modulus", p.modulus},
            {"stiffness", p.stiffness},
            {"gauge", p.gauge},
            {"grip", p.grip},
            {"area", p.area},
            {"held", p.held},
            {"covers", p.covers}};
}

/// @param line  adds a line with a label.
template <class Line>
void addTensor(const StiffnessResult& r, const Line& line) {
    line("stiffness", "MPa; rows and columns xx yy zz yz xz xy, engineering shear strains");
    for (const Vec<6>& row : r.apparent.stiffness)
        line("", fmt::format("{:9.4g} {:9.4g} {:9.4g} {:9.4g} {:9.4g} {:9.4g}", row.c[0], row.c[1],
                             row.c[2], row.c[3], row.c[4], row.c[5]));
    if (const auto& e = r.elasticity) {
        line("E", fmt::format("{:.5g} {:.5g} {:.5g} MPa along x, y, z", e->modulus[0],
                              e->modulus[1], e->modulus[2]));
        line("", fmt::format("{:.5g} MPa at most, along ({:.2f}, {:.2f}, {:.2f}); {:.4g} times the "
                             "least",
                             e->largest, e->stiffest[0], e->stiffest[1], e->stiffest[2],
                             e->largest / e->smallest));
        line("G", fmt::format("{:.5g} {:.5g} {:.5g} MPa of yz, xz, xy", e->shear[0], e->shear[1],
                              e->shear[2]));
        line("nu", fmt::format("{:.4f} {:.4f} {:.4f} of xy, xz, yz", e->poisson[0], e->poisson[1],
                               e->poisson[2]));
        line("isotropic", fmt::format("E {:.5g} MPa, nu {:.4f} (Voigt, Reuss, Hill)",
                                      e->isotropicModulus, e->isotropicPoisson));
    } else {
        line("E", "none: some strain meets no resistance");
    }
    line("solver", fmt::format("{} iterations at most, residual {:.1g}", r.apparent.iterations,
                               r.apparent.residual));
}

}  // namespace

Json toJson(const StiffnessResult& r) {
    Json json = {{"spheres", r.spheres},
                 {"bonds",
                  {{"count", r.bonds},
                   {"modulus", r.ownModuli ? Json("of each sphere") : Json(r.law.modulus)},
                   {"modulusFactor", r.modulusFactor},
                   {"keptModuli", r.keptParts},
                   {"radiusFactor", r.law.radiusFactor},
                   {"shearRatio", r.law.shearRatio},
                   {"hinged", r.law.isHinged}}},
                 {"boundary", r.boundary},
                 {"volume", r.volume},
                 {"volumeOf", r.body}};
    if (r.pressed)
        json["pressed"] = toJson(*r.pressed);
    else
        json.update(tensorOf(r));
    json["seconds"] = {{"mesh", r.seconds.mesh},
                       {"domain", r.seconds.domain},
                       {"measure", r.seconds.measure},
                       {"write", r.seconds.write},
                       {"total", r.seconds.total}};
    json["files"] = r.files;
    json["warnings"] = r.warnings;
    return json;
}

std::string summary(const StiffnessResult& r) {
    std::string text;
    const auto line = [&text](const char* label, const std::string& what) {
        text += fmt::format("{:<11}{}\n", label, what);
    };
    line("bonds", fmt::format("{} between {} spheres; {} spheres move with the boundary",
                              grouped(r.bonds), grouped(r.spheres), grouped(r.boundary)));
    line("", fmt::format("modulus {}, radius {:g} of the smaller sphere, k_t / k_n {:.4g}{}",
                         r.ownModuli ? "of each sphere" : fmt::format("{:.6g} MPa", r.law.modulus),
                         r.law.radiusFactor, r.law.shearRatio, r.law.isHinged ? ", hinged" : ""));
    if (r.modulusFactor != 1 && r.ownModuli)
        line("", fmt::format("moduli of all spheres times {:.6g}{}, at this k_t / k_n in all runs",
                             r.modulusFactor,
                             r.keptParts.empty() ? ""
                                                 : fmt::format(", but not those of {}",
                                                               fmt::join(r.keptParts, ", "))));
    line("volume", fmt::format("{:.6g} mm³ of {}", r.volume, r.body));
    if (r.pressed) {
        const StiffnessResult::Pressed& p = *r.pressed;
        line(
            "pressed",
            fmt::format("along {} between grips of {:.4g} mm, which hold {} and {} "
                        "spheres, {:.0f} and {:.0f} % of the cross-section; {:.4g} mm between them",
                        "xyz"[p.axis], p.grip, grouped(p.held[0]), grouped(p.held[1]),
                        100 * p.covers[0], 100 * p.covers[1], p.gauge));
        line("modulus", fmt::format("{:.5g} MPa apparent, by the mean cross-section of {:.5g} mm²; "
                                    "{:.5g} N/mm",
                                    p.modulus, p.area, p.stiffness));
    } else {
        addTensor(r, line);
    }
    line("seconds",
         fmt::format("read {:.2f}, domain {:.2f}, solve {:.2f}, total {:.2f}", r.seconds.mesh,
                     r.seconds.domain, r.seconds.measure, r.seconds.total));
    for (const auto& file : r.files) line("written", file);
    return text;
}

}  // namespace vdbpack
