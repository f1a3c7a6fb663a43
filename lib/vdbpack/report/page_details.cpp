#include "vdbpack/report/page_details.h"

#include "vdbpack/domain/intersection_domain.h"
#include "vdbpack/report/measured_pack.h"

#include <vector>

namespace vdbpack {

template <int Dim>
RadiusHistogram radiiOf(const Pack<Dim>& pack, std::size_t existing, const SizeDistribution* sizes,
                        Ranks* ranks) {
    std::vector<double> radii;
    for (std::size_t i = existing; i < pack.spheres.size(); ++i)
        radii.push_back(pack.spheres[i].radius);
    if (!sizes) return radiusHistogram(radii);
    return radiusHistogram(
        radii, [&](double r) { return sizes->cdfBelow(r); }, {sizes->min(), sizes->max()}, 40,
        ranks);
}

template <int Dim>
PageDetails pageDetails(const Pack<Dim>& pack, std::size_t fixed, const DomainSource& source,
                        const DomainSource* around, const Domain<Dim>& domain,
                        const SizeDistribution& sizes, const Report& report,
                        const Callbacks& callbacks, const SphereRows& rows) {
    PageDetails details;
    // Radii by place have no distribution of their own.
    details.radii = radiiOf(pack, fixed, report.localSizes.empty() ? &sizes : nullptr, rows.ranks);
    // Its layers are those of one thickness.
    const double shell = report.voids && !report.voids->leastShell ? report.voids->shell : 0;
    const double depth = structureDepth(report.radius, shell);
    if (report.count == 0 || domain.fieldDepth() >= depth) {
        details.structure = measureStructure(pack, &domain, report, shell, callbacks, rows);
        return details;
    }
    const double detail = fieldDetail(report.radius.min, report.radius.mean);
    auto space = ofDim<Dim>(source.build(detail, depth / 3, callbacks));
    if constexpr (Dim == 3)
        if (around) space = partDomain(space, around->build(detail, depth / 3, callbacks).space);
    details.structure = measureStructure(pack, space.get(), report, shell, callbacks, rows);
    return details;
}

template PageDetails pageDetails<2>(const Pack<2>&, std::size_t, const DomainSource&,
                                    const DomainSource*, const Domain<2>&, const SizeDistribution&,
                                    const Report&, const Callbacks&, const SphereRows&);
template PageDetails pageDetails<3>(const Pack<3>&, std::size_t, const DomainSource&,
                                    const DomainSource*, const Domain<3>&, const SizeDistribution&,
                                    const Report&, const Callbacks&, const SphereRows&);

template RadiusHistogram radiiOf(const Pack<2>&, std::size_t, const SizeDistribution*, Ranks*);
template RadiusHistogram radiiOf(const Pack<3>&, std::size_t, const SizeDistribution*, Ranks*);

}  // namespace vdbpack
