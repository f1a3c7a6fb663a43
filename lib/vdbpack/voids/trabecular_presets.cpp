#include "vdbpack/voids/trabecular_presets.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

namespace vdbpack {

namespace {

/// From long / short, as many programs state it.
constexpr double fromRatio(double ratio) {
    return 1 - 1 / (ratio * ratio);
}

std::string cell(const std::optional<double>& value, const char* format) {
    return value ? fmt::format(fmt::runtime(format), *value) : "-";
}

}  // namespace

const std::vector<TrabecularPreset>& trabecularPresets() {
    static const std::vector<TrabecularPreset> presets{
        {"vertebra", "vertebral cancellous bone, 9 specimens", 0.0675, 0.132, 1.020,
         fromRatio(1.48), 4.84, "PMC3352993, Table 1"},
        {"iliac-crest",
         "iliac crest, controls without disease",
         0.1539,
         {},
         0.781,
         {},
         {},
         "Rubin et al. 2010, doi:10.1016/j.bone.2009.09.020, unmatched controls"},
        {"iliac-crest-matched",
         "iliac crest, 25 controls",
         {},
         0.17,
         {},
         {},
         8.39,
         "Rubin et al. 2010, doi:10.1016/j.bone.2009.09.020, matched controls"},
        {"jaw-dense",
         "alveolar bone of the jaw, type D1",
         {},
         0.30,
         0.59,
         {},
         {},
         "Lee et al. 2017, doi:10.5051/jpis.2017.47.1.20"},
        {"jaw-sparse",
         "alveolar bone of the jaw, type D4",
         {},
         0.22,
         1.20,
         {},
         {},
         "Lee et al. 2017, doi:10.5051/jpis.2017.47.1.20"}};
    return presets;
}

const TrabecularPreset& trabecularPreset(const std::string& name) {
    std::string names;
    for (const TrabecularPreset& p : trabecularPresets()) {
        if (name == p.name) return p;
        names += (names.empty() ? "" : ", ") + std::string(p.name);
    }
    throw ParameterError(fmt::format("`trabecular` {}: must be one of {}", name, names));
}

std::string presetTable() {
    std::string text = fmt::format("{:<20} {:>6} {:>9} {:>9} {:>6} {:>13}\n", "NAME", "BV/TV",
                                   "Tb.Th, mm", "Tb.Sp, mm", "DA", "Conn.D, /mm³");
    for (const TrabecularPreset& p : trabecularPresets())
        text += fmt::format("{:<20} {:>6} {:>9} {:>9} {:>6} {:>12}\n    {}; {}\n", p.name,
                            cell(p.bvtv, "{:.4f}"), cell(p.tbth, "{:.3f}"), cell(p.tbsp, "{:.3f}"),
                            cell(p.da, "{:.3f}"), cell(p.connd, "{:.2f}"), p.bone, p.source);
    return text;
}

}  // namespace vdbpack
