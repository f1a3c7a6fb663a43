#include "vdbpack/report/axes_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace vdbpack {

nlohmann::json toJson(const PrincipalAxes<3>& axes) {
    nlohmann::json json{{"center", axes.center.c}, {"lengths", axes.lengths.c}};
    for (const Vec<3>& axis : axes.axes) json["axes"].push_back(axis.c);
    return json;
}

std::vector<std::string> linesOf(const PrincipalAxes<3>& axes) {
    const auto text = [](const Vec<3>& v, const char* form) {
        return fmt::format(fmt::runtime(form), v[0] + 0.0, v[1] + 0.0, v[2] + 0.0);
    };
    std::vector<std::string> lines{"center " + text(axes.center, "({:.6g}, {:.6g}, {:.6g}) mm")};
    for (std::size_t d = 0; d < 3; ++d)
        lines.push_back(text(axes.axes[d], "({:.5f}, {:.5f}, {:.5f})") +
                        fmt::format(", {:.5g} mm long", axes.lengths.c[d]));
    return lines;
}

}  // namespace vdbpack
