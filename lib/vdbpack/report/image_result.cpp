#include "vdbpack/report/image_result.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

const char* nameOf(ImageSpace space) {
    return space == ImageSpace::lps ? "LPS" : "RAS";
}

}  // namespace

nlohmann::json toJson(const ImageResult& r) {
    nlohmann::json json{{"source", r.source},
                        {"format", r.format},
                        {"type", r.type},
                        {"size", r.grid.size},
                        {"layers", r.layers},
                        {"spacing", r.grid.spacing().c},
                        {"space", nameOf(r.space)},
                        {"orientation", r.grid.orientation()},
                        {"origin", r.grid.origin.c},
                        {"range", {r.lowest, r.highest}},
                        {"labels", nullptr},
                        {"warnings", r.warnings}};
    for (const Vec<3>& step : r.grid.step) json["directions"].push_back(normalized(step).c);
    if (!r.labels) return json;
    const double voxel = std::fabs(r.grid.signedVoxelVolume());
    json["labels"] = nlohmann::json::array();
    json["contacts"] = nlohmann::json::array();
    for (std::size_t i = 0; i < r.labels->size(); ++i) {
        const LabelCount& label = (*r.labels)[i];
        json["labels"].push_back({{"value", label.value},
                                  {"name", label.name},
                                  {"layer", label.layer},
                                  {"voxels", label.voxels},
                                  {"volume", voxel * static_cast<double>(label.voxels)},
                                  {"components", r.relations.components[i]}});
    }
    for (const LabelContact& contact : r.relations.contacts)
        json["contacts"].push_back(
            {{"labels", {(*r.labels)[contact.first].value, (*r.labels)[contact.second].value}},
             {"layer", (*r.labels)[contact.first].layer},
             {"faces", contact.faces}});
    return json;
}

std::string summary(const ImageResult& r) {
    const auto row = [](const char* name, const std::string& value) {
        return fmt::format("{:<12}{}\n", name, value);
    };
    const Vec<3> s = r.grid.spacing(), o = r.grid.origin;
    std::string text =
        row("image", fmt::format("{}, {}{}", r.format, r.type,
                                 r.layers > 1 ? fmt::format(", {} layers", r.layers) : ""));
    text +=
        row("size", fmt::format("{} x {} x {} voxels of {:.6g} x {:.6g} x {:.6g} mm",
                                r.grid.size[0], r.grid.size[1], r.grid.size[2], s[0], s[1], s[2]));
    text += row("axes", fmt::format("{}: the directions of the patient in which indices grow",
                                    r.grid.orientation()));
    for (const Vec<3>& step : r.grid.step) {
        const Vec<3> d = normalized(step);
        text += row(
            "", fmt::format("{:>10.6f} {:>10.6f} {:>10.6f}", d[0] + 0.0, d[1] + 0.0, d[2] + 0.0));
    }
    text += row("first voxel", fmt::format("({:.6g}, {:.6g}, {:.6g}) mm in {}", o[0], o[1], o[2],
                                           nameOf(r.space)));
    text += row("values", fmt::format("{:g} to {:g}", r.lowest, r.highest));
    if (!r.labels)
        return text + row("labels", "none: a grey image, of which `threshold` V takes a part");
    const double voxel = std::fabs(r.grid.signedVoxelVolume());
    text += fmt::format("\n{:>8} {:>10} {:>13} {:>10}  {}\n", "label", "voxels", "volume, mm³",
                        "components", "name");
    constexpr std::size_t kMost = 40;
    const auto addRest = [&](std::size_t count, const char* what) {
        if (count > kMost)
            text += fmt::format("{:>8} and {} more {}, all in `json`\n", "", count - kMost, what);
    };
    for (std::size_t i = 0; i < std::min(kMost, r.labels->size()); ++i) {
        const LabelCount& label = (*r.labels)[i];
        text += fmt::format("{:>8} {:>10} {:>12.5g} {:>11}  {}\n", label.value, label.voxels,
                            voxel * static_cast<double>(label.voxels), r.relations.components[i],
                            label.name);
    }
    addRest(r.labels->size(), "labels");
    if (r.relations.contacts.empty()) return text;
    text += fmt::format("\n{:>8} {:>8} {:>10}\n", "touches", "", "faces");
    for (std::size_t i = 0; i < std::min(kMost, r.relations.contacts.size()); ++i) {
        const LabelContact& contact = r.relations.contacts[i];
        text += fmt::format("{:>8} {:>8} {:>10}\n", (*r.labels)[contact.first].value,
                            (*r.labels)[contact.second].value, contact.faces);
    }
    addRest(r.relations.contacts.size(), "pairs");
    return text;
}

}  // namespace vdbpack
