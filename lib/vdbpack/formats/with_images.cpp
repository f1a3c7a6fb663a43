#include "vdbpack/formats/with_images.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace vdbpack {

template <int Dim>
Pack<Dim> withImages(const Pack<Dim>& pack) {
    SpheresWithImages<Dim> all = withImages(pack.spheres, pack.cell, 0);
    Pack<Dim> result = pack;
    result.cell = {};
    result.spheres = std::move(all.spheres);
    if (result.id.empty()) {
        result.id.resize(all.own);
        std::iota(result.id.begin(), result.id.end(), 0);
    }
    Column of{kImageColumn, {}, {}};
    for (const std::uint32_t source : all.source)
        of.numbers.push_back(static_cast<double>(result.id[source]));
    std::int64_t next = 0;
    for (const std::int64_t id : result.id) next = std::max(next, id + 1);
    for (std::size_t i = all.own; i < all.source.size(); ++i) result.id.push_back(next++);
    forEachAttributeButId(result, [&](std::string_view, auto& values) {
        if (values.empty()) return;
        for (std::size_t i = all.own; i < all.source.size(); ++i) {
            auto value = values[all.source[i]];
            values.push_back(std::move(value));
        }
    });
    result.columns.push_back(std::move(of));
    return result;
}

template Pack<2> withImages(const Pack<2>&);
template Pack<3> withImages(const Pack<3>&);

}  // namespace vdbpack
