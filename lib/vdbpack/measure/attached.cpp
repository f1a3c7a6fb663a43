
#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/measure/contacts.h"

#include <algorithm>

namespace vdbpack {

namespace {

/// Smaller components of the shell, compared with the largest, are loose.
constexpr std::uint64_t kFewest = 1000;

}  // namespace

template <int Dim>
std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<Dim>>& spheres,
                                          const std::vector<std::int32_t>& region, double tolerance,
                                          const PeriodicCell<Dim>& cell) {
    const auto count = static_cast<std::uint32_t>(spheres.size());
    DisjointSets sets(count);
    for (const Contact& c : listContacts(spheres, tolerance, cell)) sets.join(c.i, c.j);
    std::vector<std::uint8_t> rooted(count);  // by the root of the component
    std::vector<std::uint32_t> size(count);
    for (std::uint32_t i = 0; i < count; ++i) ++size[sets.find(i)];
    const auto largest = std::max_element(size.begin(), size.end());
    if (!region.empty()) {
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t root = sets.find(i);
            if (region[i] == 0 && kFewest * size[root] >= *largest) rooted[root] = 1;
        }
    } else if (count > 0) {
        rooted[static_cast<std::size_t>(largest - size.begin())] = 1;
    }
    std::vector<std::uint8_t> attached(count);
    for (std::uint32_t i = 0; i < count; ++i) attached[i] = rooted[sets.find(i)];
    return attached;
}

template std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<2>>&,
                                                   const std::vector<std::int32_t>&, double,
                                                   const PeriodicCell<2>&);
template std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<3>>&,
                                                   const std::vector<std::int32_t>&, double,
                                                   const PeriodicCell<3>&);

}  // namespace vdbpack
