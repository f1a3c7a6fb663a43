#include "vdbpack/densify/ascent.h"

#include <algorithm>
#include <array>
#include <limits>

namespace vdbpack {

namespace {

/// Increments of the solid fraction on the way to the densest pack; the last one ends it, at this
/// pace where sizes differ.
constexpr std::array<double, 3> kStages{0.02, 0.01, 0.005};
constexpr RelaxationPace kPaceOfMost{0.9985, 0.6, 2, 0.004};
/// The way of spheres of different sizes: a quick relaxation by so much more than can be gained
/// ends with a strain, and this grows by kStrainBy for each unit of solid fraction. The densest
/// pack is about where it would have been kStrainOfMost: U[1,2] jams from 0.047 on in boxes of 60
/// mm and more, from 0.041 in a slab of 20 mm, U[1,4] from 0.040; a slab of 6 mm and a lognormal
/// distribution from 0.02 to 0.03 on, which costs one or two tries more.
constexpr RelaxationPace kProbe{0.99, 0.25, 3, 0.003, 5, true};
/// It is reached in two thirds of the steps at this pace, if at all in so many spans; in thin slabs
/// only at kPaceOfMost.
constexpr RelaxationPace kQuickPaceOfMost{0.9985, 0.6, 1, 0.004, 5};
constexpr double kGainOfProbe = 0.049, kStrainOfMost = 0.040, kStrainBy = 3.6;
/// What has jammed all the same is tried again without the fraction that its strain shows, and this
/// much less, a little more from try to try.
constexpr double kSurely = 1e-3;
/// A periodic cell is made denser in stages then. Each is tried twice, with further spheres of its
/// own: which of them jams is chance.
constexpr std::array<double, 2> kStagesOfCell{0.005, 0.0025};
constexpr int kTries = 2;
/// Equal spheres stay at random at this pace where they have no walls, along which they
/// crystallize.
constexpr RelaxationPace kPaceOfEqualInCell{0.996, 0.1};
/// Of equal spheres, with or without walls: in several stages they are agitated for longer and
/// crystallize.
constexpr std::array<double, 11> kGainsOfEqual{0.0425, 0.041, 0.0395, 0.038, 0.0365, 0.035,
                                               0.032,  0.029, 0.025,  0.018, 0.01};
/// Below this, equal spheres are loose enough for another such gain.
constexpr double kLoose = 0.63;

/// Spheres that cannot be pushed apart at this solid fraction are no pack.
constexpr double kLeastFraction = 0.05;

}  // namespace

void Ascent::reach(double wanted) {
    if (attemptGain(wanted) || stages_.isInterrupted()) return;
    stages_.stage = 0;
    if (setting_.isInCell) climbInCell(wanted);
    if (!isEnded(wanted)) climb(wanted);
    fallBack();
}

void Ascent::reachMost() {
    constexpr double most = std::numeric_limits<double>::infinity();
    if (setting_.isInCell)
        climbInCell(most);
    else if (paces_.areEqualSpheres())
        climbAtRandom(most);
    else
        climb(most);
    fallBack();
}

/// Where there is no pack to begin with, and none of the tries made one: any will do.
void Ascent::fallBack() {
    for (double goal = setting_.before;
         !(stages_.reached() > 0) && !stages_.isInterrupted() && goal > kLeastFraction; goal *= 0.9)
        stages_.attempt(goal, paces_.all());
}

bool Ascent::isEnded(double most) const {
    return stages_.isInterrupted() || stages_.reached() >= most - kFractionRounding;
}

/// To the densest pack of a periodic cell, or up to `most`.
void Ascent::climbInCell(double most) {
    if (paces_.areEqualSpheres()) return climbAtRandom(most);
    climbByStrain(most);
    for (const double increment : kStagesOfCell)
        for (int tries = 0; tries < kTries;) {
            if (isEnded(most)) return;
            tries += !stages_.attempt(std::min(stages_.reached() + increment, most), {kPaceOfMost});
        }
}

/// As dense as paces allow that leave equal spheres at random, or up to `most`.
void Ascent::climbAtRandom(double most) {
    while (climbOnceAtRandom(most) && !stages_.isInterrupted()) {
    }
}

/// @return whether the pack is loose enough for another such gain.
bool Ascent::climbOnceAtRandom(double most) {
    const double first = from();
    double failed = 1;  // the least fraction that has
    for (const double gain : kGainsOfEqual) {
        const std::uint64_t stage = stages_.stage;
        const double next = std::min(first + gain, most);
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

/// To the densest pack, or up to `most`, by what the strain of a jammed one says. @return whether
/// the pack is denser than before
bool Ascent::climbByStrain(double most) {
    const double begin = stages_.reached();
    const double limit = std::min(most, setting_.limit);
    double goal = 0;
    do {
        goal = std::min(from() + kGainOfProbe, limit);
    } while (stages_.attempt(goal, {kProbe}) && !isEnded(limit));
    if (isEnded(limit)) return true;
    goal = std::min(limit, goal + (kStrainOfMost - stages_.strain()) / kStrainBy);
    // The stages of a cell end higher after the slower pace.
    std::vector<RelaxationPace> paces{kPaceOfMost};
    if (!setting_.isInCell) paces.insert(paces.begin(), kQuickPaceOfMost);
    for (double less = kSurely; goal > stages_.reached(); less *= 1.3) {
        if (stages_.attempt(goal, paces) || stages_.isInterrupted()) break;
        goal -= stages_.strain() / kStrainBy + less;
    }
    return stages_.reached() > begin;
}

/// Climbs in stages until the smallest one fails, or `most` is reached.
void Ascent::climb(double most) {
    if (setting_.isInSpace && paces_.differInSize() && climbByStrain(most)) return;
    for (const double increment : kStages)
        while (!stages_.isInterrupted()) {
            const double next = std::min(from() + increment, most);
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
