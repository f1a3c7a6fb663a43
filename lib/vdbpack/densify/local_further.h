// Private to densify: sizes of spheres where the requested sizes differ by place.
#pragma once

#include "vdbpack/core/rng.h"
#include "vdbpack/densify/densify.h"
#include "vdbpack/densify/further_spheres.h"
#include "vdbpack/pack/local_sizes.h"

#include <cstdint>
#include <map>
#include <vector>

namespace vdbpack {

template <int Dim>
struct LocalPack {
    std::vector<Sphere<Dim>> spheres;
    std::vector<std::int32_t> classes;
    std::vector<double> relative;  ///< radii where the factor is 1, mm
};

/// Spheres of requests that are nearly the same form a class, by which they exchange positions and
/// receive further spheres: of the same group, with factors that differ by at most a tenth.
template <int Dim>
class LocalFurther {
public:
    /// @param spheres, options  as those of FurtherSizes, with local sizes. Options and domain must
    /// outlive this.
    LocalFurther(const Domain<Dim>& domain, const std::vector<Sphere<Dim>>& spheres,
                 const DensifyOptions& options);

    /// The class of a request, and its factor.
    static std::int32_t classOf(const LocalSize& size);
    static LocalSize sizeOf(std::int32_t number);

    /// Of each sphere.
    const std::vector<std::int32_t>& classes() const { return classes_; }
    /// Radii of all spheres divided by their factors, mm.
    const std::vector<double>& relative() const { return relative_; }
    /// The same of those that move.
    const std::vector<double>& radii() const { return radii_; }

    /// Adds spheres of a total volume (2D: area) of `missing` mm^Dim, each of the size that is
    /// requested at its center.
    /// @param inset  where their centers and the shells around them are to be.
    void insert(double missing, const Domain<Dim>& inset, std::uint64_t stage,
                LocalPack<Dim>& pack) const;
    /// Gives spheres the radii that are requested of them where they are.
    void fit(LocalPack<Dim>& pack) const;
    /// The root mean square by which radii differ from those requested, as a share.
    double misfit(const LocalPack<Dim>& pack) const;

private:
    FurtherSpheres draw(double volume, RandomStream& random) const;
    template <class Visit>
    void forEachAtHome(const LocalPack<Dim>& pack, const Visit& visit) const;

    const Domain<Dim>& domain_;
    const DensifyOptions& options_;
    struct Group {
        DensifyOptions options;
        std::vector<Sphere<Dim>> spheres;          ///< radii where the factor is 1
        std::map<std::int32_t, double> volumes{};  ///< of each class, mm^Dim
    };
    std::vector<Group> groups_;
    std::vector<FurtherSizes<Dim>> sizes_;  ///< of each group
    std::vector<std::int32_t> classes_;
    std::vector<double> relative_, radii_;
    double volume_ = 0;  ///< of all moving spheres
};

}  // namespace vdbpack
