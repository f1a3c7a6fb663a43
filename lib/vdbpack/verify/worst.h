// Private to verify: the few worst findings of a check.
#pragma once

#include "vdbpack/verify/overlap.h"

#include <algorithm>
#include <vector>

namespace vdbpack {

/// Keeps the `kWorstNamed` worst findings, the worst first, in an order that does not depend on
/// that of arrival.
/// @param worse  a strict order of findings: whether the first is worse than the second.
template <typename Finding, typename Worse>
void keepWorst(std::vector<Finding>& worst, const Finding& found, const Worse& worse) {
    if (worst.size() == kWorstNamed && !worse(found, worst.back())) return;
    worst.insert(std::upper_bound(worst.begin(), worst.end(), found, worse), found);
    if (worst.size() > kWorstNamed) worst.pop_back();
}

}  // namespace vdbpack
