#include "vdbpack/report/image_result.h"

#include "vdbpack/report/axes_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

const char* nameOf(ImageSpace space) {
    return space == ImageSpace::lps ? "LPS" : "RAS";
}

/// Bars of the logarithm, beside which a few voxels of bone are seen, too.
std::string histogramRows(const ValueHistogram& histogram) {
    if (histogram.counts.empty()) return {};
    constexpr double kLongest = 40;
    const auto most =
        static_cast<double>(*std::max_element(histogram.counts.begin(), histogram.counts.end()));
    std::string text = fmt::format("\n{:>12} {:>12} {:>8}  logarithm of the voxels\n",
                                   "values from", "voxels", "%");
    for (std::size_t k = 0; k < histogram.counts.size(); ++k) {
        const auto count = static_cast<double>(histogram.counts[k]);
        const double bar = kLongest * std::log1p(count) / std::log1p(most);
        text +=
            fmt::format("{:>12.6g} {:>12} {:>8.3f}  {}\n", histogram.edge(k), histogram.counts[k],
                        100 * count / static_cast<double>(histogram.total()),
                        std::string(static_cast<std::size_t>(std::lround(bar)), '#'));
    }
    return text;
}

std::string thresholdRows(const ImageResult& r) {
    if (r.taken.empty()) return {};
    std::string text = fmt::format("\n{:>12} {:>12} {:>12} {:>8} {:>13}\n", "`threshold`",
                                   "values from", "voxels", "%", "volume, mm³");
    for (const ImageResult::Taken& taken : r.taken) {
        const auto voxels = static_cast<double>(taken.solid.voxels);
        text += fmt::format("{:>12} {:>12.6g} {:>12} {:>8.3f} {:>12.5g}\n", taken.threshold.text(),
                            *taken.threshold.value, taken.solid.voxels,
                            100 * voxels / static_cast<double>(r.grid.voxels()),
                            std::fabs(r.grid.signedVoxelVolume()) * voxels);
    }
    if (!r.isRequested) return text;
    const VoxelSolid& solid = r.taken.front().solid;
    const char* name = "axes";
    text += "\n";
    if (solid.voxels > 0)
        for (const std::string& line : linesOf(solid.axes))
            text += fmt::format("{:<12}{}\n", std::exchange(name, ""), line);
    return text;
}

std::string labelRows(const ImageResult& r) {
    std::string text;
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
    text += fmt::format("\n{:>8} {:>32}  {:26}  {}\n", "label", "center, mm", "long axis",
                        "lengths, mm");
    for (std::size_t i = 0; i < std::min(kMost, r.labels->size()); ++i) {
        const PrincipalAxes<3>& a = r.solids[i].axes;
        text += fmt::format(
            "{:>8} {:>10.5g} {:>10.5g} {:>10.5g}  {:>8.4f} {:>8.4f} {:>8.4f}  {:.4g} x {:.4g} x "
            "{:.4g}\n",
            (*r.labels)[i].value, a.center[0], a.center[1], a.center[2], a.axes[0][0], a.axes[0][1],
            a.axes[0][2], a.lengths[0], a.lengths[1], a.lengths[2]);
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

}  // namespace

nlohmann::json toJson(const ImageResult& r) {
    nlohmann::json json{{"source", r.source},
                        {"format", r.format},
                        {"type", r.type},
                        {"size", r.grid.size},
                        {"layers", r.layers},
                        {"spacing", r.grid.spacing().c},
                        {"space", nameOf(r.space)},
                        {"orientation", nullptr},
                        {"origin", r.grid.origin.c},
                        {"range", {r.lowest, r.highest}},
                        {"labels", nullptr},
                        {"histogram", nullptr},
                        {"thresholds", nlohmann::json::array()},
                        {"warnings", r.warnings}};
    if (r.isSided) json["orientation"] = r.grid.orientation();
    for (const Vec<3>& step : r.grid.step) json["directions"].push_back(normalized(step).c);
    const double voxel = std::fabs(r.grid.signedVoxelVolume());
    if (!r.histogram.counts.empty())
        json["histogram"] = {{"first", r.histogram.first},
                             {"width", r.histogram.width},
                             {"counts", r.histogram.counts}};
    for (const ImageResult::Taken& taken : r.taken)
        json["thresholds"].push_back(
            {{"threshold", taken.threshold.text()},
             {"value", *taken.threshold.value},
             {"voxels", taken.solid.voxels},
             {"volume", voxel * static_cast<double>(taken.solid.voxels)},
             {"principalAxes",
              taken.solid.voxels > 0 ? toJson(taken.solid.axes) : nlohmann::json()}});
    if (!r.labels) return json;
    json["labels"] = nlohmann::json::array();
    json["contacts"] = nlohmann::json::array();
    for (std::size_t i = 0; i < r.labels->size(); ++i) {
        const LabelCount& label = (*r.labels)[i];
        json["labels"].push_back({{"value", label.value},
                                  {"name", label.name},
                                  {"layer", label.layer},
                                  {"voxels", label.voxels},
                                  {"volume", voxel * static_cast<double>(label.voxels)},
                                  {"components", r.relations.components[i]},
                                  {"principalAxes", toJson(r.solids[i].axes)}});
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
    text += row("axes", r.isSided
                            ? fmt::format("{}: the directions of the patient in which indices grow",
                                          r.grid.orientation())
                            : std::string("of no known sides of a patient; indices grow along"));
    for (const Vec<3>& step : r.grid.step) {
        const Vec<3> d = normalized(step);
        text += row(
            "", fmt::format("{:>10.6f} {:>10.6f} {:>10.6f}", d[0] + 0.0, d[1] + 0.0, d[2] + 0.0));
    }
    text += row("first voxel",
                fmt::format("({:.6g}, {:.6g}, {:.6g}) mm{}", o[0], o[1], o[2],
                            r.isSided ? std::string(" in ") + nameOf(r.space) : std::string()));
    text += row("values", fmt::format("{:g} to {:g}", r.lowest, r.highest));
    if (!r.labels) text += row("labels", "none: a grey image, of which `threshold` V takes a part");
    text += histogramRows(r.histogram) + thresholdRows(r);
    return r.labels ? text + labelRows(r) : text;
}

}  // namespace vdbpack
