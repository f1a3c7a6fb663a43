// What a report says of voids.
#pragma once

#include "vdbpack/measure/morphometry/morphometry.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbpack {

/// A number of a structure that was asked for.
struct TargetReport {
    std::string name;  ///< of the parameter, such as targetTbth
    double asked = 0, reached = 0;
    /// Standard deviation over specimens of other seeds; absent: not measured
    std::optional<double> scatter;

    /// Such as Tb.Th.
    std::string symbol() const;
    /// With a space before it, or empty.
    std::string unit() const;
};

/// The voids and the shell in a report.
struct VoidReport {
    std::string method;                ///< as requested; empty: only a shell
    std::uint64_t count = 0;           ///< ellipsoids (2D: ellipses)
    double shell = 0;                  ///< mm, the largest thickness
    std::optional<double> leastShell;  ///< where it varies: the smallest, mm
    double voxelSize = 0;              ///< of the level set, mm; 0: none
    double totalVolume = 0;            ///< of the domain deeper than the shell, mm^dim
    std::optional<double> bvtv;        ///< BV/TV there, of the solid
    std::optional<double> filled;      ///< share of that volume that the spheres there fill
    bool ofSpheres = false;  ///< `bvtv` is the remaining share of the spheres' volume instead
    /// Found by a target or given: voids per mm^dim (boolean), their number (overlay), probability
    /// (grid, mixed, ellipses) or D (concentric, threshold).
    std::optional<double> amount;
    std::optional<double> reachedShare;  ///< holes among the spheres deeper than the shell
    std::string radius;                  ///< SPEC of b that gave the target thickness, mm
    std::optional<double> thickness;     ///< Tb.Th if a target was set, mm
    std::vector<TargetReport> targets;   ///< of a structure, as found in a specimen
    /// Kolmogorov-Smirnov distances of local thickness and spacing from a sample.
    std::optional<double> thicknessDistance, separationDistance;
    std::optional<SolidMeasures> solid;  ///< what the voids leave there, where it was measured
    double specimen = 0;                 ///< shortest side of that specimen, mm; 0: none
    /// Of the foam that was found for them: names between backquotes, each before its value.
    std::string parameters;
    std::optional<double> solidAttached;  ///< share connected to the shell
    std::uint64_t solidPieces = 0;
    std::uint64_t culled = 0;               ///< spheres that the voids removed
    std::optional<double> spheresAttached;  ///< share connected to it by contacts
    std::uint64_t dropped = 0;              ///< spheres removed since they are not connected
    std::uint64_t cortical = 0;             ///< spheres with centers in the shell
    std::optional<double> across;           ///< thickness of the shell in their mean diameters
    std::vector<std::string> chosen;        ///< defaults that were chosen, one sentence each
};

}  // namespace vdbpack
