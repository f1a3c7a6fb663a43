#include "vdbpack/densify/ascent.h"

#include <algorithm>
#include <array>
#include <limits>

namespace vdbpack {

namespace {

/// Increments of the solid fraction on the way to the densest pack; the last one ends it, at this
/// pace where sizes differ.
constexpr std::array<double, 3> kStages{0.02, 0.01, 0.005};
constexpr RelaxationPace kPaceOfMost{0.9985, 0.25};
/// The way to the densest pack of a periodic cell: in one stage from the front, by as much as can
/// be of the first; then in stages. Each of these is tried twice, with further spheres of its own:
/// which of them jams is chance.
constexpr std::array<double, 4> kGainsAtOnce{0.049, 0.047, 0.045, 0.0425};
constexpr std::array<double, 2> kStagesOfCell{0.005, 0.0025};
constexpr int kTries = 2;
constexpr RelaxationPace kPaceOfCell{0.998, 0.25};
/// Equal spheres stay at random at this pace where they have no walls, along which they
/// crystallize.
constexpr RelaxationPace kPaceOfEqualInCell{0.996, 0.1};
/// Of equal spheres, with or without walls: in several stages they are agitated for longer and
/// crystallize.
constexpr std::array<double, 11> kGainsOfEqual{0.0425, 0.041, 0.0395, 0.038, 0.0365, 0.035,
                                               0.032,  0.029, 0.025,  0.018, 0.01};
/// Below this, equal spheres are loose enough for another such gain.
constexpr double kLoose = 0.63;

}  // namespace

void Ascent::reach(double wanted) {
    if (attemptGain(wanted) || stages_.isInterrupted()) return;
    stages_.stage = 0;
    if (setting_.isInCell) climbInCell(wanted);
    if (!isEnded(wanted)) climb(wanted);
}

void Ascent::reachMost() {
    constexpr double most = std::numeric_limits<double>::infinity();
    if (setting_.isInCell)
        climbInCell(most);
    else if (paces_.areEqualSpheres())
        climbAtRandom(most);
    else
        climb(most);
}

bool Ascent::isEnded(double most) const {
    return stages_.isInterrupted() || stages_.reached() >= most - kFractionRounding;
}

/// To the densest pack of a periodic cell, or up to `most`.
void Ascent::climbInCell(double most) {
    if (paces_.areEqualSpheres()) return climbAtRandom(most);
    double failed = 1;  // the least fraction that has
    for (const double gain : kGainsAtOnce) {
        const double next = std::min(setting_.before + gain, most);
        if (!(next < failed)) continue;
        failed = next;
        if (stages_.attempt(next, {kPaceOfCell}) || stages_.isInterrupted()) break;
        stages_.stage = 0;
    }
    for (const double increment : kStagesOfCell)
        for (int tries = 0; tries < kTries;) {
            if (isEnded(most)) return;
            tries += !stages_.attempt(std::min(stages_.reached() + increment, most), {kPaceOfCell});
        }
}

/// As dense as paces allow that leave equal spheres at random, or up to `most`.
void Ascent::climbAtRandom(double most) {
    while (climbOnceAtRandom(most) && !stages_.isInterrupted()) {
    }
}

/// @return whether the pack is loose enough for another such gain.
bool Ascent::climbOnceAtRandom(double most) {
    const double from = stages_.reached();
    double failed = 1;  // the least fraction that has
    for (const double gain : kGainsOfEqual) {
        const std::uint64_t stage = stages_.stage;
        const double next = std::min(from + gain, most);
        if (!(next < failed)) continue;
        failed = next;
        if (stages_.attempt(next, setting_.hasWalls
                                      ? paces_.randomForGain(next - setting_.before)
                                      : std::vector<RelaxationPace>{kPaceOfEqualInCell}))
            return gain == kGainsOfEqual.front() && next < kLoose && next < most;
        if (stages_.isInterrupted()) return false;
        stages_.stage = stage;
    }
    return false;
}

/// Climbs in stages until the smallest one fails, or `most` is reached.
void Ascent::climb(double most) {
    for (const double increment : kStages)
        while (!stages_.isInterrupted()) {
            const double next = std::min(stages_.reached() + increment, most);
            const bool isLast = increment == kStages.back() && paces_.differInSize();
            if (next > setting_.limit ||
                !(isLast ? stages_.attempt(next, {kPaceOfMost}) : attemptGain(next)))
                break;
            if (isEnded(most)) return;
        }
}

bool Ascent::attemptGain(double fraction) {
    return stages_.attempt(fraction, paces_.forGain(fraction - setting_.before));
}

}  // namespace vdbpack
