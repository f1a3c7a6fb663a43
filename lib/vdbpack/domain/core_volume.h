// The part of a domain that a shell encloses.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>

namespace vdbpack {

/// Volume (2D: area) of the points of a domain that lie deeper than `shell` >= 0 (mm) below the
/// wall of its envelope, mm^Dim. As exact as `volumeDeeperThan`.
/// A cavity, and what a clip takes off, may lie partly in the shell.
template <int Dim>
double coreVolume(const Domain<Dim>& domain, double shell);

/// Those points as a domain, for packing; null: all of `domain`. `domain` must outlive the result.
/// Volume and area are for estimates only.
template <int Dim>
std::shared_ptr<const Domain<Dim>> coreDomain(const Domain<Dim>& domain, double shell);

}  // namespace vdbpack
