// A domain whose wall is moved inward.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>

namespace vdbpack {

/// The part of `domain` that is at least `inset` >= 0 (mm) from its wall. Exact where the domain
/// is: distances inside shrink by `inset`. `domain` must outlive the result.
///
/// Volume and area are those of `domain` itself: for estimates only.
template <int Dim>
std::unique_ptr<Domain<Dim>> insetDomain(const Domain<Dim>& domain, double inset);

}  // namespace vdbpack
