// Private to runs: the stages that a run and its forecast share.
#pragma once

#include "vdbpack/measure/structure.h"
#include "vdbpack/pack/packer.h"
#include "vdbpack/report/report.h"
#include "vdbpack/run/domain_source.h"
#include "vdbpack/run/recipe.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>

namespace vdbpack {

class Clock {
public:
    /// Seconds since the last call.
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const double s = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        return s;
    }
    double total() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point last_ = start_;
};

template <int Dim>
const std::shared_ptr<const Domain<Dim>>& ofDim(const DomainSource::Built& built) {
    if constexpr (Dim == 3)
        return built.space;
    else
        return built.plane;
}

/// Radius that the field is made for, mm: in wide distributions the smallest spheres follow the
/// triangles anyway, and a field as fine as them would cost more than the pack.
inline double fieldDetail(double smallest, double mean) {
    return std::max(smallest, 0.5 * mean);
}

/// The most memory that the process has held, bytes.
std::uint64_t peakMemory();
/// How many threads `threads` asks for; 0: all cores.
int effectiveThreads(int threads);
/// Whether the checks found nothing but what was given.
bool passed(const Report& report);

/// Scales the radii until about `target` spheres fill the domain: a guess from smaller packs, then
/// along the line through the two last packs, count against scale, between what was too few and
/// too many. `options.sizes` is left as packed.
template <int Dim>
PackResult<Dim> packToCount(const Domain<Dim>& domain, PackOptions& options, double target,
                            const Callbacks& callbacks, const std::vector<Sphere<Dim>>& existing);

/// What can be said of any pack, whoever made it; the first `report.existing` spheres stood
/// already. Once `report.interrupted` or cancelled, which sets it, only what verifies the pack:
/// overlap, protrusion and, where one was asked for, the gap; with count, hash, radii and solid
/// fraction. The pack then has no depths and no contacts.
template <int Dim>
void measurePack(Pack<Dim>& pack, const DomainSource* source, const Domain<Dim>* domain,
                 const SizeDistribution* sizes, double contactTolerance, Report& report,
                 const Callbacks& callbacks = {});

/// For which radii the field of a pack is made, mm, and about what its sizes are scaled by.
struct FieldRadii {
    double scale = 1, detail = 0, reach = 0;
};
FieldRadii fieldRadii(const PackRecipe& recipe, const RequestedSizes& requested,
                      const DomainSource& source);

/// Refuses a shell that is as thick as the domain before a field is made for it. @throws InputError
void requireShell(double shell, const DomainSource& source);

/// How deep the field must know distances for all that `measureStructure` tells of such radii, mm:
/// three mean diameters for the pair correlation, and a little beyond the shell.
double structureDepth(const RadiusStatistics& radius, double shell);

/// Holds the radii of a pack against what was asked for; a part of `measurePack`.
template <int Dim>
void measureSizes(const Pack<Dim>& pack, const SizeDistribution& sizes, Report& report);

/// How spheres fill a domain and lie about one another; `pack.depth` as `measurePack` leaves it.
/// @param domain  null: only what needs none.
/// @param shell   thickness of the layer along the wall that is told apart, mm; 0: none.
/// @throws Interrupted
template <int Dim>
Structure measureStructure(const Pack<Dim>& pack, const Domain<Dim>* domain, const Report& report,
                           double shell, const Callbacks& callbacks = {});

extern template PackResult<2> packToCount(const Domain<2>&, PackOptions&, double, const Callbacks&,
                                          const std::vector<Sphere<2>>&);
extern template PackResult<3> packToCount(const Domain<3>&, PackOptions&, double, const Callbacks&,
                                          const std::vector<Sphere<3>>&);
extern template Structure measureStructure<2>(const Pack<2>&, const Domain<2>*, const Report&,
                                              double, const Callbacks&);
extern template Structure measureStructure<3>(const Pack<3>&, const Domain<3>*, const Report&,
                                              double, const Callbacks&);
extern template void measureSizes(const Pack<2>&, const SizeDistribution&, Report&);
extern template void measureSizes(const Pack<3>&, const SizeDistribution&, Report&);
extern template void measurePack<2>(Pack<2>&, const DomainSource*, const Domain<2>*,
                                    const SizeDistribution*, double, Report&, const Callbacks&);
extern template void measurePack<3>(Pack<3>&, const DomainSource*, const Domain<3>*,
                                    const SizeDistribution*, double, Report&, const Callbacks&);

}  // namespace vdbpack
