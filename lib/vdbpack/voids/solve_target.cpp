#include "vdbpack/voids/solve_target.h"

#include "vdbpack/core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbpack {

namespace {

constexpr int kMaxRounds = 20;
/// Between the amounts tried where few voids make BV/TV leap, in amounts.
constexpr double kApart = 0.03;

[[noreturn]] void outOfReach(const VoidRecipe& r, const char* bound, double bvtv,
                             const std::string& remedy) {
    throw ParameterError(
        fmt::format("`targetBvtv` {}: not reachable with `voids` {}, {} is {:.4f}{}",
                    *targetBvtvOf(r), nameOf(r), bound, bvtv, remedy));
}

}  // namespace

double solveForBvtv(const VoidRecipe& r, double lo, double guess, double hi, double tolerance,
                    const std::string& remedy, const std::function<double(double)>& bvtvAt,
                    double steepness) {
    const double target = *targetBvtvOf(r);
    double low = lo, high = hi, atLow = std::numeric_limits<double>::quiet_NaN(), atHigh = atLow;
    double best = guess, off = std::numeric_limits<double>::infinity(), last = guess;
    double x = guess;
    int apart = 0;
    for (int round = 0; round < kMaxRounds; ++round) {
        const double f = bvtvAt(x);
        last = x;
        if (std::fabs(f - target) < off) {
            off = std::fabs(f - target);
            best = x;
        }
        if (off <= tolerance) break;
        if (f > target) {
            if (x >= hi) outOfReach(r, "lowest", f, remedy);
            low = x;
            atLow = f;
        } else {
            if (x <= lo) outOfReach(r, "highest", f, "; give a lower one");
            high = x;
            atHigh = f;
        }
        double next = std::numeric_limits<double>::quiet_NaN();
        if (atLow > 0 && atHigh > 0)
            next = low + (high - low) * std::log(atLow / target) / std::log(atLow / atHigh);
        else if (f > 0 && steepness > 0)
            next = x + std::log(f / target) / steepness;
        else if (f > 0 && f < 1)
            next = x * std::log(target) / std::log(f);
        // Keeps away from the ends of the bracket, which false position could approach forever.
        const double margin = 0.02 * (high - low);
        if (round > 5 && std::isfinite(next)) next = round % 2 == 0 ? 0.5 * (low + high) : next;
        if (!(next > low)) next = atLow == atLow ? low + margin : lo;
        if (!(next < high)) next = atHigh == atHigh ? high - margin : hi;
        // A bracket that ought to hold less than the tolerance: BV/TV leaps, void by void.
        const double steep = steepness > 0 ? steepness : -std::log(target) / best;
        if (target * steep * (high - low) < tolerance) {
            ++apart;
            next = best * (1 + (apart % 2 == 0 ? kApart : -kApart) * apart);
            next = std::clamp(next, (lo + best) / 2, (hi + best) / 2);
        }
        x = next;
    }
    if (last != best) bvtvAt(best);
    return best;
}

}  // namespace vdbpack
