// Sizes that are requested by place: a factor on all radii, and a distribution for the shell.
#pragma once

#include "vdbpack/domain/domain.h"
#include "vdbpack/domain/shell_test.h"
#include "vdbpack/pack/pack_options.h"
#include "vdbpack/pack/size_distribution.h"
#include "vdbpack/pack/size_field.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace vdbpack {

/// What is requested at a point.
struct LocalSize {
    double factor = 1;
    std::uint32_t group = 0;  ///< 1: the sizes of the shell
};

/// Queries local sizes from one thread.
template <int Dim>
class LocalSizeSampler {
public:
    /// @param domain, sizes  must outlive this; the shell is that of the domain.
    LocalSizeSampler(const Domain<Dim>& domain, const LocalSizes& sizes);

    LocalSize at(const Vec<Dim>& x);

    /// Bounds of what is requested in a part of space.
    struct Range {
        double least = 1, most = 1;  ///< factors
        bool inner = true;           ///< whether group 0 may be there
        bool shell = false;          ///< whether group 1 may be there
    };
    Range within(const Box<Dim>& box);
    Range around(const Vec<Dim>& x, double distance);
    /// Whether the same is requested everywhere up to a distance along each axis. Quick, and not
    /// true where it is uncertain.
    bool isConstant(const Vec<Dim>& x, double distance);

private:
    void addGroups(const Vec<Dim>& x, double distance, Range& range);

    /// The image of a point in a periodic cell.
    Vec<Dim> inCell(const Vec<Dim>& x) const { return wraps_ ? cell_.wrapped(x) : x; }

    const LocalSizes& sizes_;
    PeriodicCell<Dim> cell_;
    bool wraps_;
    std::optional<ShellTest<Dim>> shell_;
};

template <int Dim>
LocalSize LocalSizeSampler<Dim>::at(const Vec<Dim>& x) {
    const Vec<Dim> here = inCell(x);
    LocalSize size;
    if (sizes_.factor) size.factor = sizes_.factor->at(here);
    if (shell_) size.group = shell_->isDeeper(here) ? 0 : 1;
    return size;
}

/// Spheres that would fill a domain alike if each had this volume (2D: area) on average: the
/// harmonic mean over the domain of the mean sphere's volume.
template <int Dim>
class LocalBalls {
public:
    /// Samples the domain; for uniform sizes there is nothing to sample.
    LocalBalls(const Domain<Dim>& domain, const SizeDistribution& sizes, const LocalSizes& local);

    /// With radii times `scale`, and a layer of `layer` mm around each sphere, mm^Dim.
    double mean(double scale = 1, double layer = 0) const;
    /// Spheres of a group in a volume (2D: area) of the domain that spheres filled wholly, per
    /// mm^Dim.
    double groupShare(std::uint32_t group) const;

private:
    struct Share {
        SizeDistribution sizes;
        double factor, weight;
        std::uint32_t group = 0;
    };
    std::vector<Share> shares_;
};

/// The local factor and group of each sphere's center, in parallel.
template <int Dim>
std::vector<LocalSize> localSizesOf(const std::vector<Sphere<Dim>>& spheres,
                                    const Domain<Dim>& domain, const LocalSizes& sizes);

/// Mean volume (2D: area) of spheres with radii times `scale` and a layer around each, mm^Dim.
template <int Dim>
double ballWithShell(const SizeDistribution& sizes, double scale, double shell);

}  // namespace vdbpack
