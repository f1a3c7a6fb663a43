// Private to runs: the stages that a run and its forecast share.
#pragma once

#include "vdbpack/domain_source.h"
#include "vdbpack/measure/report.h"
#include "vdbpack/pack/size_distribution.h"

#include <chrono>
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

/// What can be said of any pack, whoever made it; the first `report.existing` spheres stood
/// already.
template <int Dim>
void measurePack(Pack<Dim>& pack, const DomainSource* source, const Domain<Dim>* domain,
                 const SizeDistribution* sizes, double contactTolerance, Report& report);

extern template void measurePack<2>(Pack<2>&, const DomainSource*, const Domain<2>*,
                                    const SizeDistribution*, double, Report&);
extern template void measurePack<3>(Pack<3>&, const DomainSource*, const Domain<3>*,
                                    const SizeDistribution*, double, Report&);

}  // namespace vdbpack
