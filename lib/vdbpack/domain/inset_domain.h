// A domain whose wall is moved inwards.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>

namespace vdbpack {

/// The part of `domain` that is at least `inset` >= 0 (mm) from its wall. Exact where the domain
/// is: distances inside shrink by `inset`. `domain` must outlive what is returned.
///
/// Volume and area are those of `domain` itself: good for estimates only.
template <int Dim>
std::unique_ptr<Domain<Dim>> insetDomain(const Domain<Dim>& domain, double inset);

extern template std::unique_ptr<Domain<2>> insetDomain(const Domain<2>&, double);
extern template std::unique_ptr<Domain<3>> insetDomain(const Domain<3>&, double);

}  // namespace vdbpack
