// Voids that the front packs among the spheres.
#include "vdbpack/core/error.h"
#include "vdbpack/voids/cull.h"
#include "vdbpack/voids/solve_target.h"
#include "vdbpack/voids/stamped_solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vdbpack {

namespace {

/// How near to a target BV/TV voids are made that are packed.
constexpr double kPackedTolerance = 0.002;
/// Holes with less beside them would be no pack.
constexpr double kMostProbability = 0.9;

/// Packs with one probability of holes after the other.
template <int Dim>
class HolePacker {
public:
    HolePacker(const VoidSetting<Dim>& setting, const PackOptions& options,
               const std::vector<Sphere<Dim>>& existing, MadeVoids<Dim>& made)
        : s_(setting),
          options_(options),
          existing_(existing),
          made_(made),
          shape_(voidShapeOf(setting, &made.report.chosen)),
          voxel_(voidVoxelFor(setting.recipe,
                              shape_.radius.min() * std::min(1.0, shape_.aspect.min()))) {}

    PackResult<Dim> run(const FrontHoles& holes) {
        const auto pack = [this](double probability) { return bvtvAt(probability); };
        if (const auto target = holes.targetBvtv) {
            // As if holes took their share of what is filled.
            const double left = -std::log(*target), ball = options_.sizes.meanBall(Dim);
            const double guess = left * ball / (left * ball + shape_.meanMeasure());
            solveForBvtv(s_.recipe, 0, std::clamp(guess, 1e-4, 0.3), kMostProbability,
                         kPackedTolerance,
                         "; give larger or longer voids, or set `voids` boolean, whose voids "
                         "overlap",
                         pack);
            if (!result_.interrupted) warnIfOff(s_, made_.report);
        } else {
            if (!holes.probability)
                made_.report.chosen.push_back(
                    fmt::format("a hole with probability {}", kDefaultProbability));
            pack(holes.probability.value_or(kDefaultProbability));
        }
        warnOfFew();
        return std::move(result_);
    }

private:
    double bvtvAt(double probability) {
        const double shell = s_.recipe.shell;
        PackOptions mixed = options_;
        mixed.species.push_back({shape_.radius, probability, shell});
        result_ = packSpheres(s_.domain, mixed, s_.callbacks, existing_);
        std::vector<Sphere<Dim>> places;
        std::vector<std::uint8_t> keep(result_.pack.spheres.size(), 1);
        for (std::size_t i = 0; i < keep.size(); ++i)
            if (result_.species[i] != 0) {
                keep[i] = 0;
                places.push_back(result_.pack.spheres[i]);
            }
        holes_ = places.size();
        made_.report.amount = probability;
        const auto deep = deeperThan(result_.pack.spheres, s_.domain, shell);
        const auto core = static_cast<double>(
            std::max<std::ptrdiff_t>(1, std::count(deep.begin(), deep.end(), 1)));
        made_.report.reachedShare = static_cast<double>(holes_) / core;
        wanted_ = probability * core;
        keepOnly(result_.pack, keep);
        // Placed in this order, without gaps.
        for (std::size_t i = 0; i < result_.pack.order.size(); ++i)
            result_.pack.order[i] = static_cast<std::int64_t>(i);
        made_.list = voidsAtSpheres(places, false, shape_, s_.seed);
        if (!result_.interrupted) {
            try {
                return bvtvOf(s_, voxel_, made_);
            } catch (const Interrupted&) {
                result_.interrupted = true;
            }
        }
        // An interrupted pack is kept unchanged, without voids and further trials.
        made_.stamped.reset();
        made_.solid = {};
        made_.report.bvtv.reset();
        return targetBvtvOf(s_.recipe).value_or(0);
    }

    void warnOfFew() const {
        if (holes_ == 0)
            s_.callbacks.warn(
                "no hole found room: give smaller ones, a larger `voids.probability` or a "
                "thinner shell");
        else if (const auto found = static_cast<double>(holes_);
                 found < 0.8 * wanted_ && found < wanted_ - 3 * std::sqrt(wanted_))  // no chance
            s_.callbacks.warn(fmt::format(
                "{:.3g} of the spheres were to be holes, {:.3g} are: no more found room",
                *made_.report.amount, *made_.report.reachedShare));
    }

    const VoidSetting<Dim>& s_;
    const PackOptions& options_;
    const std::vector<Sphere<Dim>>& existing_;
    MadeVoids<Dim>& made_;
    VoidShape<Dim> shape_;
    double voxel_;
    PackResult<Dim> result_;
    std::size_t holes_ = 0;
    double wanted_ = 0;  ///< holes
};

}  // namespace

template <int Dim>
PackResult<Dim> packWithHoles(const VoidSetting<Dim>& s, const PackOptions& options,
                              const std::vector<Sphere<Dim>>& existing, MadeVoids<Dim>& made) {
    made.report.method = nameOf(s.recipe);
    made.report.shell = s.recipe.shell;
    return HolePacker<Dim>(s, options, existing, made)
        .run(*std::get_if<FrontHoles>(&s.recipe.method));
}

#define VDBPACK_INSTANTIATE(Dim)                                                        \
    template PackResult<Dim> packWithHoles(const VoidSetting<Dim>&, const PackOptions&, \
                                           const std::vector<Sphere<Dim>>&, MadeVoids<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
