#include "vdbpack/verify/sphere_cells.h"

#include "vdbpack/core/box.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/verify/counting.h"

#include <atomic>
#include <functional>
#include <map>

namespace vdbpack {

namespace {

constexpr double kClassRatio = 3;  ///< of the radii in a class

/// The largest radius of the bulk, so that a usual pack (size ratio up to 3) is one class and a few
/// spheres far larger do not move the classes of all others.
template <int Dim>
double bulkRadius(const std::vector<Sphere<Dim>>& spheres) {
    std::vector<double> sample;
    const std::size_t step = std::max<std::size_t>(1, spheres.size() / 1024);
    for (std::size_t i = 0; i < spheres.size(); i += step) sample.push_back(spheres[i].radius);
    const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
    std::nth_element(sample.begin(), middle, sample.end());
    double largest = *middle;
    for (const auto& s : spheres)
        if (s.radius <= 2 * *middle) largest = std::max(largest, s.radius);
    return largest;
}

}  // namespace

template <int Dim>
void SphereCells<Dim>::chooseSlots(const std::vector<Sphere<Dim>>& spheres,
                                   const std::vector<std::uint32_t>& members) {
    Box<Dim> bounds;
    for (const auto i : members) bounds.add(spheres[i].center);
    const CellNumbers first = cellsOf(bounds.lo), last = cellsOf(bounds.hi);
    std::array<double, 3> count{};
    for (std::size_t i = 0; i < 3; ++i)
        count[i] = static_cast<double>(last[i]) - static_cast<double>(first[i]) + 1;
    const double cells = count[0] * count[1] * count[2];
    const double n = static_cast<double>(members.size());
    constexpr double kMostSlots = 0x1p32;  // their numbers are kept in 32 bits
    hashed_ = cells > std::min(4 * n + 64, kMostSlots);
    const double wanted = std::min(hashed_ ? 2 * n : cells, kMostSlots);
    std::uint64_t slots = 1;
    while (static_cast<double>(slots) < wanted) slots *= 2;
    mask_ = slots - 1;
    // Odd numbers without a pattern, so that no lattice of rows falls onto few slots.
    strideY_ = hashed_ ? 0x9e3779b97f4a7c15ull : static_cast<std::uint64_t>(count[0]);
    strideZ_ = hashed_ ? 0xd1342543de82ef95ull : static_cast<std::uint64_t>(count[0] * count[1]);
}

template <int Dim>
SphereCells<Dim>::SphereCells(const std::vector<Sphere<Dim>>& spheres,
                              const std::vector<std::uint32_t>& members) {
    for (const auto i : members) largestRadius_ = std::max(largestRadius_, spheres[i].radius);
    perCell_ = 1 / (2 * largestRadius_);
    chooseSlots(spheres, members);
    const std::size_t n = members.size();
    // The order inside a slot depends on the threads; no result does. All places are found first,
    // since an atomic count beside each random write would let these wait for each other.
    std::vector<std::atomic<std::uint32_t>> next(mask_ + 1);
    std::vector<std::uint32_t> at(n);  // the slot of each member, then its place
    forAll(n, [&](std::size_t k) {
        at[k] = static_cast<std::uint32_t>(slotOf(cellsOf(spheres[members[k]].center)));
        next[at[k]].fetch_add(1, std::memory_order_relaxed);
    });
    start_ = startsOf(next);
    forAll(n, [&](std::size_t k) { at[k] = next[at[k]].fetch_add(1, std::memory_order_relaxed); });
    std::vector<std::atomic<std::uint32_t>>().swap(next);
    spheres_.resize(n);
    index_.resize(n);
    forAll(n, [&](std::size_t k) {
        spheres_[at[k]] = spheres[members[k]];
        index_[at[k]] = members[k];
    });
}

template <int Dim>
SphereClasses<Dim>::SphereClasses(const std::vector<Sphere<Dim>>& spheres) {
    if (spheres.empty()) return;
    const double bulk = bulkRadius(spheres);
    std::map<int, std::vector<std::uint32_t>, std::greater<>> classes;
    std::vector<std::uint32_t>* last = nullptr;
    double least = 0, most = 0;  // radii of the last sphere's class: above one, up to the other
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const double r = spheres[i].radius;
        if (!last || r <= least || r > most) {
            const int k = static_cast<int>(std::ceil(std::log(r / bulk) / std::log(kClassRatio)));
            most = bulk * std::pow(kClassRatio, k);
            least = most / kClassRatio;
            last = &classes[k];
            if (last->empty()) last->reserve(spheres.size() - i);
        }
        last->push_back(static_cast<std::uint32_t>(i));
    }
    for (auto& entry : classes) {
        classes_.emplace_back(spheres, entry.second);
        entry.second = {};
    }
}

template class SphereCells<2>;
template class SphereCells<3>;
template class SphereClasses<2>;
template class SphereClasses<3>;

}  // namespace vdbpack
