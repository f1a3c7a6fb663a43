// The part of a domain that a shell encloses.
#pragma once

#include "vdbpack/domain/domain.h"

#include <memory>

namespace vdbpack {

/// Volume (2D: area) of the points of a domain that lie deeper than `shell` below the wall of its
/// envelope, mm^Dim. As exact as `volumeDeeperThan`; where the thickness varies, counted in 128
/// cells (2D: 1024) along the longest side, to about 1e-3 of the result.
/// A cavity, and what a clip takes off, may lie partly in the shell.
template <int Dim>
double coreVolume(const Domain<Dim>& domain, const ShellThickness& shell);

/// Those points as a domain, for packing; null: all of `domain`. `domain` must outlive the result.
/// Volume and area are for estimates only.
template <int Dim>
std::shared_ptr<const Domain<Dim>> coreDomain(const Domain<Dim>& domain, double shell);

}  // namespace vdbpack
