#include "vdbpack/report/report.h"

#include <cstddef>

namespace vdbpack {

std::string grouped(std::uint64_t n) {
    std::string text = std::to_string(n);
    for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
    return text;
}

bool keepsGap(const Report& r) {
    return !(r.gapAsked > 0) || !r.smallestGap ||
           *r.smallestGap >= r.gapAsked - kVerifyTolerance * r.radius.min;
}

}  // namespace vdbpack
