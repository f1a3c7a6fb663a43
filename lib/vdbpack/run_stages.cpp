#include "vdbpack/run_stages.h"

#include "vdbpack/measure/contacts.h"
#include "vdbpack/measure/density.h"

#include <utility>
#include <vector>

namespace vdbpack {

namespace {

template <int Dim>
double ksOf(const std::vector<Sphere<Dim>>& spheres, std::size_t from,
            const SizeDistribution& sizes) {
    std::vector<double> radii(spheres.size() - from);
    for (std::size_t i = 0; i < radii.size(); ++i) radii[i] = spheres[from + i].radius;
    return ksDistance(
        std::move(radii), [&](double r) { return sizes.cdf(r); },
        [&](double r) { return sizes.cdfBelow(r); });
}

}  // namespace

template <int Dim>
void measurePack(Pack<Dim>& pack, const DomainSource* source, const Domain<Dim>* domain,
                 const SizeDistribution* sizes, double contactTolerance, Report& report) {
    report.dim = Dim;
    report.count = pack.spheres.size();
    report.hash = packHash(pack);
    report.radius = radiusStatistics(pack.spheres);
    report.overlap = checkOverlap(pack.spheres);
    report.smallestGap = smallestGap(pack.spheres, report.existing);
    report.contactTolerance = contactTolerance;
    if (sizes) {
        report.requested = sizes->spec();
        report.ks = ksOf(pack.spheres, report.existing, *sizes);
    }
    if (domain) {
        report.domain = domain->facts();
        report.volume = domain->measure();
        report.area = domain->wallMeasure();
        report.protrusion = source->protrusion(pack.spheres);
        report.solidFractionTotal = solidFraction(pack.spheres, *domain);
        const double interior = 3 * report.radius.max;
        if (interior <= domain->fieldDepth())
            report.solidFractionInterior = interiorFraction(pack.spheres, *domain, interior);
        pack.depth = source->depths(pack.spheres, *domain);
    }
    auto contacts = countContacts(pack.spheres, contactTolerance, pack.depth);
    report.contactsMean = contacts.mean;
    pack.contacts = std::move(contacts.counts);
}

template void measurePack<2>(Pack<2>&, const DomainSource*, const Domain<2>*,
                             const SizeDistribution*, double, Report&);
template void measurePack<3>(Pack<3>&, const DomainSource*, const Domain<3>*,
                             const SizeDistribution*, double, Report&);

}  // namespace vdbpack
