// Morphometry as JSON and as text.
#include "vdbpack/measure/morphometry/morphometry.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <utility>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json orNull(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json json(const std::optional<LengthStatistics>& s) {
    if (!s) return nullptr;
    Json out{{"mean", s->mean}, {"sd", s->sd}, {"max", s->max}};
    for (const int percent : {5, 25, 50, 75, 95})
        out[fmt::format("p{}", percent)] =
            s->quantiles.empty() ? Json() : Json(s->quantile(percent));
    return out;
}

std::string text(const std::optional<LengthStatistics>& s) {
    if (!s) return "none";
    return fmt::format("mean {:.4g} mm, deviation {:.3g}, largest {:.4g}", s->mean, s->sd, s->max);
}

std::string text(const Vec<3>& v) {
    return fmt::format("({:.3f}, {:.3f}, {:.3f})", v[0], v[1], v[2]);
}

Json json(const std::optional<Anisotropy>& a) {
    if (!a) return nullptr;
    Json lengths = Json::array(), axes = Json::array();
    for (const auto& length : a->meanInterceptLengths) lengths.push_back(orNull(length));
    for (const auto& axis : a->axes) axes.push_back(axis.c);
    return {{"degree", a->degree},
            {"ratio", orNull(a->ratio)},
            {"eigenvalues", a->eigenvalues},
            {"MIL", lengths},
            {"axes", axes}};
}

void add(Json& out, const SolidMeasures& m) {
    out["TV"] = m.totalVolume;
    out["BV"] = m.solidVolume;
    out["BV/TV"] = m.solidFraction;
    out["BS"] = m.solidSurface;
    out["Tb.Th"] = json(m.thickness);
    out["Tb.Sp"] = json(m.separation);
    out["Tb.N"] = orNull(m.number);
    out["SMI"] = orNull(m.structureModelIndex);
    out["euler"] = {{"whole", m.eulerNumber}, {"delta", m.deltaEuler}};
    out["connectivity"] = m.connectivity;
    out["Conn.D"] = m.connectivityDensity;
    out["DA"] = json(m.anisotropy);
    out["DAvoxels"] = m.voxelAnisotropy ? Json({{"degree", m.voxelAnisotropy->degree},
                                                {"ratio", orNull(m.voxelAnisotropy->ratio)},
                                                {"axis", m.voxelAnisotropy->axes[0].c}})
                                        : Json();
}

/// Lines of a label and its value.
class Lines {
public:
    void add(const std::string& label, const std::string& value) {
        text_ += fmt::format("{:<11}{}\n", indent_ + label, value);
    }
    void indent(const std::string& by) { indent_ = by; }
    std::string take() { return std::move(text_); }

private:
    std::string text_, indent_;
};

std::string bvtv(const SolidMeasures& m) {
    return fmt::format("{:.4f}: {:.6g} of {:.6g} mm³", m.solidFraction, m.solidVolume,
                       m.totalVolume);
}

void addAnisotropy(Lines& out, const SolidMeasures& m) {
    if (!m.anisotropy) return out.add("DA", "none");
    const Anisotropy& a = *m.anisotropy;
    out.add("DA", fmt::format("{:.4f} as 1 - (short / long)², {} as long / short", a.degree,
                              a.ratio ? fmt::format("{:.4g}", *a.ratio) : "infinite"));
    if (m.voxelAnisotropy)
        out.add("", fmt::format("{:.4f} by lines from voxel to voxel, as in BoneJ",
                                m.voxelAnisotropy->degree));
    std::string lengths;
    for (const auto& length : a.meanInterceptLengths)
        lengths +=
            (lengths.empty() ? "" : ", ") + (length ? fmt::format("{:.4g}", *length) : "infinite");
    out.add("MIL", lengths + " mm");
    out.add("", "the longest along " + text(a.axes[0]));
}

void addLengths(Lines& out, const std::string& label, const std::optional<LengthStatistics>& s) {
    out.add(label, text(s));
    if (s && !s->quantiles.empty())
        out.add("", fmt::format("quartiles {:.4g}, {:.4g}, {:.4g}", s->quantile(25),
                                s->quantile(50), s->quantile(75)));
}

/// All but BV/TV.
void addMeasures(Lines& out, const SolidMeasures& m) {
    out.add("BS", fmt::format("{:.6g} mm²", m.solidSurface));
    addLengths(out, "Tb.Th", m.thickness);
    addLengths(out, "Tb.Sp", m.separation);
    out.add("Tb.N",
            m.number ? fmt::format("{:.4g} /mm (BV/TV divided by Tb.Th)", *m.number) : "none");
    out.add("SMI", m.structureModelIndex
                       ? fmt::format("{:.4g} (0 plates, 3 rods, 4 balls, below 0 concave)",
                                     *m.structureModelIndex)
                       : "none");
    out.add("Conn.D", fmt::format("{:.5g} /mm³ (Euler number {:.8g}, {})", m.connectivityDensity,
                                  m.eulerNumber,
                                  m.deltaEuler == m.eulerNumber
                                      ? "nothing is cut"
                                      : fmt::format("{:.8g} corrected for cuts", m.deltaEuler)));
    addAnisotropy(out, m);
}

void addBorder(Lines& out, const Morphometry& m) {
    const BorderShares& b = m.border;
    out.add("border", m.walled ? "the wall: the solid and the pore space end there"
                      : m.deltaEuler == m.eulerNumber
                          ? "limits no ball of Tb.Th and Tb.Sp"
                          : "cuts a larger sample, and limits no ball of Tb.Th and Tb.Sp");
    out.add("", fmt::format("{:.3g} % of it is solid, beyond {:.3g} % of which the solid continues",
                            100 * b.solid, 100 * b.continued));
    if (b.poresNearWall)
        out.add("", fmt::format("{:.3g} % of the pore space is nearer to it than to the solid",
                                100 * *b.poresNearWall));
}

}  // namespace

nlohmann::ordered_json toJson(const SolidMeasures& part) {
    Json out;
    add(out, part);
    return out;
}

nlohmann::ordered_json toJson(const Morphometry& m) {
    Json out;
    out["of"] = m.ofVoxels ? "voxels" : "surface";
    out["voxelSize"] = m.voxelSize;
    out["voxels"] = m.voxels;
    add(out, m);
    out["border"] = {{"kind", m.walled ? "wall" : "cut"},
                     {"solid", m.border.solid},
                     {"continued", m.border.continued},
                     {"poresNearWall", orNull(m.border.poresNearWall)}};
    out["largestComponent"] = orNull(m.largestComponent);
    out["regions"] = Json::array();
    for (const RegionMorphometry& r : m.regions) {
        Json region{{"label", r.label}};
        add(region, r);
        out["regions"].push_back(region);
    }
    return out;
}

std::string summary(const Morphometry& m) {
    Lines out;
    out.add("BV/TV", bvtv(m) + fmt::format(", voxels of {:.4g} mm", m.voxelSize));
    out.add("", m.ofVoxels ? "of the voxels of the image" : "of the surface, in these voxels");
    addMeasures(out, m);
    if (m.largestComponent)
        out.add("connected", fmt::format("{:.4g} % of the solid is its largest component",
                                         100 * *m.largestComponent));
    addBorder(out, m);
    for (const RegionMorphometry& r : m.regions) {
        out.add(fmt::format("region {}", r.label), "BV/TV " + bvtv(r));
        out.indent("  ");
        addMeasures(out, r);
        out.indent("");
    }
    return out.take();
}

}  // namespace vdbpack
