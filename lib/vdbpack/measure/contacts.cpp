#include "vdbpack/measure/contacts.h"

#include "vdbpack/core/cell_levels.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/domain/sampling.h"
#include "vdbpack/measure/contact_directions.h"
#include "vdbpack/measure/stiffness.h"

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbpack {

namespace {

/// Connected components, joined from many threads at once.
/// Source: Anderson, Woll (1991), "Wait-free parallel algorithms for the union-find problem".
class Components {
public:
    explicit Components(std::size_t n) : parent_(n) {
        for (std::size_t i = 0; i < n; ++i)
            parent_[i].store(static_cast<std::uint32_t>(i), std::memory_order_relaxed);
    }
    std::uint32_t find(std::uint32_t i) {
        for (;;) {
            std::uint32_t up = parent_[i].load(std::memory_order_relaxed);
            if (up == i) return i;
            const std::uint32_t next = parent_[up].load(std::memory_order_relaxed);
            // Roots only ever move to smaller numbers: skipping one is always right.
            if (next != up) parent_[i].compare_exchange_weak(up, next, std::memory_order_relaxed);
            i = next;
        }
    }
    void join(std::uint32_t i, std::uint32_t j) {
        for (;;) {
            i = find(i);
            j = find(j);
            if (i == j) return;
            if (i < j) std::swap(i, j);
            std::uint32_t root = i;
            if (parent_[i].compare_exchange_strong(root, j, std::memory_order_relaxed)) return;
        }
    }

private:
    std::vector<std::atomic<std::uint32_t>> parent_;
};

/// Radii below the wall from which on contacts tell of the stiffness, and how many do at least: of
/// as many in random directions, the modulus ratio is about 1.3 by chance.
constexpr double kDeepRadii = 3;
constexpr std::uint64_t kFewestDeep = 1000;

/// The symmetric matrix of such sums.
template <int Size, class Sums>
Matrix<Size> matrixOf(const Sums& sums) {
    Matrix<Size> m;
    std::size_t k = 0;
    for (std::size_t p = 0; p < Size; ++p)
        for (std::size_t q = p; q < Size; ++q)
            m[p].c[q] = m[q].c[p] = static_cast<double>(static_cast<std::int64_t>(sums[k++]));
    return m;
}

template <int Dim>
void addAnisotropy(const ContactSums& sums, ContactNetwork& network) {
    const Matrix<Dim> fabric = matrixOf<Dim>(sums.fabric);
    double trace = 0;
    for (std::size_t p = 0; p < Dim; ++p) trace += fabric[p].c[p];
    for (std::size_t p = 0; trace > 0 && p < Dim; ++p)
        for (int q = 0; q < Dim; ++q) network.fabric[p][q] = fabric[p][q] * (1 / trace);
    network.deepContacts = sums.deepContacts;
    if (sums.deepContacts < kFewestDeep) return;
    const auto modulus = modulusRatio<Dim>(matrixOf<Dim*(Dim + 1) / 2>(sums.stiffness));
    if (!modulus) return;
    network.modulusRatio = modulus->ratio;
    network.stiffest = modulus->direction;
}

/// Whether a pair counts in the sums of the first `own` spheres. @param source  as of `leastGap`
template <int Dim>
bool isOwnPair(std::uint32_t i, const Sphere<Dim>& a, std::uint32_t j, const Sphere<Dim>& b,
               std::size_t own, const std::vector<std::uint32_t>* source) {
    if (std::max(i, j) < own) return true;
    if (source) return std::min(i, j) < own && std::min(i, j) <= (*source)[std::max(i, j)];
    return (isBefore(a, b) ? i : j) < own;
}

/// @param source  of each sphere as in `SpheresWithImages`; null: there are no images.
template <int Dim>
std::optional<double> leastGap(const std::vector<Sphere<Dim>>& spheres, std::size_t standing,
                               const std::vector<std::uint32_t>* source) {
    if (spheres.size() < 2 || spheres.size() <= standing) return std::nullopt;
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();
    double smallest = kInfinity;
    for (const auto& s : spheres) smallest = std::min(smallest, s.radius);
    // Pairs are sought up to a gap in proportion to their radii: wide enough once no pair of the
    // smallest spheres could be closer than what was found.
    for (double slack = 0.01;;) {
        PerThread<double> found([] { return kInfinity; });
        const CellLevels<Dim> cells(spheres, slack);
        cells.forEachPair(
            [&] {
                return
                    [&, mine = &found.local()](std::uint32_t i, const Sphere<Dim>& a,
                                               std::uint32_t j, const Sphere<Dim>& b, double d2) {
                        if (source) i = (*source)[i], j = (*source)[j];
                        if (i < standing && j < standing) return;
                        *mine = std::min(*mine, std::sqrt(d2) - a.radius - b.radius);
                    };
            },
            [] { return false; });
        double gap = kInfinity;
        for (const double each : found) gap = std::min(gap, each);
        if (gap <= slack * smallest) return gap;
        slack = gap < kInfinity ? gap / smallest * (1 + 1e-9) : 8 * slack;
    }
}

}  // namespace

void requireContactTolerance(double tolerance) {
    if (!(tolerance >= 0 && tolerance <= 1))
        throw ParameterError(
            fmt::format("`contactTolerance` {}: must be a share of a radius, 0 to 1", tolerance));
}

template <int Dim>
PartContacts contactsOfPart(const std::vector<Sphere<Dim>>& spheres, std::size_t own,
                            double tolerance, const std::vector<float>& depth,
                            const std::vector<std::uint32_t>* source) {
    requireContactTolerance(tolerance);
    requireUsable(spheres);
    if (!depth.empty() && depth.size() != own)
        throw ParameterError(fmt::format("contacts: {} depths for {} {}; give one each or none",
                                         depth.size(), own, Measure<Dim>::kSpheres));
    PartContacts result;
    // The largest part of the memory is taken before the rest, and given back before the results.
    std::optional<CellLevels<Dim>> cells(std::in_place, spheres, tolerance);
    std::vector<std::atomic<std::int32_t>> partners(spheres.size());
    struct Found {
        ContactSums sums;
        Directions<Dim> directions;
    };
    PerThread<Found> found;
    const auto isDeep = [&](std::uint32_t i) {
        return i < own &&
               (depth.empty() || static_cast<double>(depth[i]) > kDeepRadii * spheres[i].radius);
    };
    Components components(spheres.size());
    cells->forEachPair(
        [&] {
            return [&, mine = &found.local()](std::uint32_t i, const Sphere<Dim>& a,
                                              std::uint32_t j, const Sphere<Dim>& b, double d2) {
                partners[i].fetch_add(1, std::memory_order_relaxed);
                partners[j].fetch_add(1, std::memory_order_relaxed);
                if (!source)
                    components.join(i, j);
                else if (std::min(i, j) < own)
                    components.join((*source)[i], (*source)[j]);
                const bool once = isOwnPair(i, a, j, b, own, source);
                ContactSums& sums = mine->sums;
                if (once)
                    sums.smallestGap =
                        std::min(sums.smallestGap, std::sqrt(d2) - a.radius - b.radius);
                const int deep = int{isDeep(i)} + int{isDeep(j)};
                if (!(d2 > 0) || !(once || deep > 0)) return;
                sums.deepContacts += static_cast<std::uint64_t>(deep);
                mine->directions.add(b.center - a.center, d2, once, deep, sums);
            };
        },
        [] { return false; });
    cells.reset();
    for (Found& each : found) {
        each.directions.addTo(each.sums);
        result.sums.add(each.sums);
    }
    result.partners.resize(own);
    result.component.resize(spheres.size());
    forAll(spheres.size(), [&](std::size_t i) {
        if (i < own) result.partners[i] = partners[i].load(std::memory_order_relaxed);
        result.component[i] = components.find(static_cast<std::uint32_t>(i));
    });
    return result;
}

template <int Dim>
SpheresWithImages<Dim> withPartners(const std::vector<Sphere<Dim>>& spheres, double tolerance,
                                    const PeriodicCell<Dim>& cell) {
    requireContactTolerance(tolerance);
    requireUsable(spheres);
    double largest = 0;
    for (const Sphere<Dim>& s : spheres) largest = std::max(largest, s.radius);
    requireLongCell(cell, largest, kGivenCellDiameters);
    return withImages(spheres, cell, (1 + tolerance) * largest * (1 + 1e-9));
}

template <int Dim>
std::array<std::uint64_t, 3> partnersOfPart(const std::vector<Sphere<Dim>>& spheres,
                                            std::size_t own,
                                            const std::array<double, 3>& tolerances) {
    PerThread<std::array<std::uint64_t, 3>> found;
    const CellLevels<Dim> cells(spheres, tolerances.back());
    cells.forEachPair(
        [&] {
            return [&, mine = &found.local()](std::uint32_t i, const Sphere<Dim>& a,
                                              std::uint32_t j, const Sphere<Dim>& b, double d2) {
                for (std::size_t k = 0; k < tolerances.size(); ++k) {
                    const double reach =
                        a.radius + b.radius + tolerances[k] * std::min(a.radius, b.radius);
                    if (d2 < reach * reach) (*mine)[k] += std::uint64_t{i < own} + (j < own);
                }
            };
        },
        [] { return false; });
    std::array<std::uint64_t, 3> partners{};
    for (const auto& each : found)
        for (std::size_t k = 0; k < partners.size(); ++k) partners[k] += each[k];
    return partners;
}

template <int Dim>
void ContactSums::add(const std::vector<Sphere<Dim>>& added, double tolerance,
                      const std::vector<float>& depth, std::vector<std::int32_t>& counts) {
    PerThread<ContactSums> tallies;
    parallelFor(IndexRange(0, added.size(), 4096), [&](const IndexRange& block) {
        ContactSums& tally = tallies.local();
        tally.spheres += block.size();
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            std::int32_t& count = counts[i];
            tally.partners += static_cast<std::uint64_t>(count);
            const double r = added[i].radius;
            if (!depth.empty() && std::abs(static_cast<double>(depth[i]) - r) <= tolerance * r) {
                ++count;
                ++tally.wallContacts;
            }
            tally.few += count < Dim + 1;
            const auto k = static_cast<std::size_t>(count);
            if (k >= tally.histogram.size()) tally.histogram.resize(k + 1);
            ++tally.histogram[k];
        }
    });
    for (const ContactSums& tally : tallies) add(tally);
}

void ContactSums::add(const ContactSums& other) {
    spheres += other.spheres;
    partners += other.partners;
    wallContacts += other.wallContacts;
    few += other.few;
    for (std::size_t k = 0; k < fabric.size(); ++k) fabric[k] += other.fabric[k];
    for (std::size_t k = 0; k < stiffness.size(); ++k) stiffness[k] += other.stiffness[k];
    deepContacts += other.deepContacts;
    histogram.resize(std::max(histogram.size(), other.histogram.size()));
    for (std::size_t k = 0; k < other.histogram.size(); ++k) histogram[k] += other.histogram[k];
    smallestGap = std::min(smallestGap, other.smallestGap);
}

ContactNetwork networkOf(const ContactSums& sums, int dim) {
    ContactNetwork result;
    result.smallestGap = sums.smallestGap;
    if (dim == 2)
        addAnisotropy<2>(sums, result);
    else
        addAnisotropy<3>(sums, result);
    result.few = dim + 1;
    result.histogram = sums.histogram;
    result.wallContacts = sums.wallContacts;
    result.pairs = sums.partners / 2;
    if (sums.spheres == 0) return result;
    const auto total = static_cast<double>(sums.spheres);
    result.mean = static_cast<double>(sums.partners + sums.wallContacts) / total;
    result.meanOfSpheres = static_cast<double>(sums.partners) / total;
    result.fewShare = static_cast<double>(sums.few) / total;
    return result;
}

template <int Dim>
ContactCheck countContacts(const std::vector<Sphere<Dim>>& spheres, double tolerance,
                           const std::vector<float>& depth, const PeriodicCell<Dim>& cell) {
    PartContacts all;
    if (cell.any()) {
        const auto repeated = withPartners(spheres, tolerance, cell);
        all = contactsOfPart(repeated.spheres, repeated.own, tolerance, depth, &repeated.source);
        all.component.resize(repeated.own);
    } else {
        all = contactsOfPart(spheres, spheres.size(), tolerance, depth);
    }
    all.sums.add(spheres, tolerance, depth, all.partners);
    ContactCheck result;
    static_cast<ContactNetwork&>(result) = networkOf(all.sums, Dim);
    result.counts = std::move(all.partners);
    if (spheres.empty()) return result;
    std::vector<std::atomic<std::uint32_t>> members(spheres.size());
    parallelFor(IndexRange(0, spheres.size(), 4096), [&](const IndexRange& block) {
        std::uint32_t component = 0, inARow = 0;
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            const std::uint32_t root = all.component[i];
            if (root != component) {
                members[component].fetch_add(inARow, std::memory_order_relaxed);
                component = root;
                inARow = 0;
            }
            ++inARow;
        }
        members[component].fetch_add(inARow, std::memory_order_relaxed);
    });
    std::uint32_t largest = 0;
    for (const auto& size : members) {
        const std::uint32_t n = size.load(std::memory_order_relaxed);
        result.components += n > 0;
        largest = std::max(largest, n);
    }
    result.largestComponent = largest / static_cast<double>(spheres.size());
    return result;
}

template <int Dim>
std::vector<Contact> listContacts(const std::vector<Sphere<Dim>>& given, double tolerance,
                                  const PeriodicCell<Dim>& cell) {
    requireContactTolerance(tolerance);
    requireUsable(given);
    SpheresWithImages<Dim> repeated;
    if (cell.any()) repeated = withPartners(given, tolerance, cell);
    const std::vector<Sphere<Dim>>& spheres = cell.any() ? repeated.spheres : given;
    PerThread<std::vector<Contact>> found;
    const CellLevels<Dim> cells(spheres, tolerance);
    cells.forEachPair(
        [&] {
            return [&, mine = &found.local()](std::uint32_t i, const Sphere<Dim>& a,
                                              std::uint32_t j, const Sphere<Dim>& b, double d2) {
                std::uint32_t first = std::min(i, j), second = std::max(i, j);
                if (second >= given.size()) {  // an image: the pair is found from both sides
                    if (first >= given.size() || first > repeated.source[second]) return;
                    second = repeated.source[second];
                }
                // The radii are added first, so that the gap is the same for (i, j) and (j, i).
                mine->push_back({first, second, std::sqrt(d2) - (a.radius + b.radius)});
            };
        },
        [] { return false; });
    std::size_t total = 0;
    for (const auto& part : found) total += part.size();
    std::vector<Contact> contacts;
    contacts.reserve(total);
    for (auto& part : found) {
        contacts.insert(contacts.end(), part.begin(), part.end());
        part = {};
    }
    tbb::parallel_sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
        return a.i != b.i ? a.i < b.i : a.j < b.j;
    });
    return contacts;
}

template <int Dim>
std::optional<double> smallestGap(const std::vector<Sphere<Dim>>& spheres, std::size_t standing,
                                  const PeriodicCell<Dim>& cell) {
    requireUsable(spheres);
    if (!cell.any() || spheres.size() <= standing) return leastGap(spheres, standing, nullptr);
    double reach = 0;
    for (const Sphere<Dim>& s : spheres) reach = std::max(reach, s.radius);
    // Images as far away as a gap that was found among nearer ones.
    for (reach *= 1.5;; reach *= 4) {
        const auto repeated = withImages(spheres, cell, reach);
        const auto gap = leastGap(repeated.spheres, standing, &repeated.source);
        if (gap && *gap < 0.3 * reach) return gap;
        if (reach > 2 * length(cell.box.size())) return gap;
    }
}

#define VDBPACK_INSTANTIATE(Dim)                                                                  \
    template std::vector<Contact> listContacts<Dim>(const std::vector<Sphere<Dim>>&, double,      \
                                                    const PeriodicCell<Dim>&);                    \
    template std::optional<double> smallestGap<Dim>(const std::vector<Sphere<Dim>>&, std::size_t, \
                                                    const PeriodicCell<Dim>&);                    \
    template PartContacts contactsOfPart(const std::vector<Sphere<Dim>>&, std::size_t, double,    \
                                         const std::vector<float>&,                               \
                                         const std::vector<std::uint32_t>*);                      \
    template SpheresWithImages<Dim> withPartners(const std::vector<Sphere<Dim>>&, double,         \
                                                 const PeriodicCell<Dim>&);                       \
    template std::array<std::uint64_t, 3> partnersOfPart(                                         \
        const std::vector<Sphere<Dim>>&, std::size_t, const std::array<double, 3>&);              \
    template void ContactSums::add(const std::vector<Sphere<Dim>>&, double,                       \
                                   const std::vector<float>&, std::vector<std::int32_t>&);        \
    template ContactCheck countContacts<Dim>(const std::vector<Sphere<Dim>>&, double,             \
                                             const std::vector<float>&, const PeriodicCell<Dim>&);
VDBPACK_INSTANTIATE(2)
VDBPACK_INSTANTIATE(3)
#undef VDBPACK_INSTANTIATE

}  // namespace vdbpack
