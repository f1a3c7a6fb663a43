#include "vdbpack/report/report.h"

#include <cstddef>

namespace vdbpack {

std::string grouped(std::uint64_t n) {
    std::string text = std::to_string(n);
    for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
    return text;
}

FailedChecks failedChecks(const Report& r) {
    FailedChecks failed;
    failed.overlap = r.overlap && r.overlap->pairs != r.inputOverlaps;
    failed.protrusion = r.protrusion && r.protrusion->spheres != r.inputProtrusions;
    failed.gap = r.requestedGap > 0 && r.smallestGap &&
                 *r.smallestGap < r.requestedGap - kVerifyTolerance * r.radius.min;
    return failed;
}

}  // namespace vdbpack
