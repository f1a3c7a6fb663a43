#include "vdbpack/measure/attached.h"

#include "vdbpack/core/disjoint_sets.h"
#include "vdbpack/measure/contacts.h"

#include <algorithm>

namespace vdbpack {

template <int Dim>
std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<Dim>>& spheres,
                                          const std::vector<std::int32_t>& region,
                                          double tolerance) {
    const auto count = static_cast<std::uint32_t>(spheres.size());
    DisjointSets sets(count);
    for (const Contact& c : listContacts(spheres, tolerance)) sets.join(c.i, c.j);
    std::vector<std::uint8_t> rooted(count);  // by the root of the component
    if (!region.empty()) {
        for (std::uint32_t i = 0; i < count; ++i)
            if (region[i] == 0) rooted[sets.find(i)] = 1;
    } else if (count > 0) {
        std::vector<std::uint32_t> size(count);
        for (std::uint32_t i = 0; i < count; ++i) ++size[sets.find(i)];
        rooted[static_cast<std::size_t>(std::max_element(size.begin(), size.end()) -
                                        size.begin())] = 1;
    }
    std::vector<std::uint8_t> attached(count);
    for (std::uint32_t i = 0; i < count; ++i) attached[i] = rooted[sets.find(i)];
    return attached;
}

template std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<2>>&,
                                                   const std::vector<std::int32_t>&, double);
template std::vector<std::uint8_t> attachedSpheres(const std::vector<Sphere<3>>&,
                                                   const std::vector<std::int32_t>&, double);

}  // namespace vdbpack
