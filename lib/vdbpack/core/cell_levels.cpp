#include "vdbpack/core/cell_levels.h"

#include "vdbpack/core/count.h"
#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"

#include <fmt/format.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <atomic>
#include <cmath>
#include <map>
#include <numeric>

namespace vdbpack {

namespace {

constexpr std::int64_t kMostCellsAnAxis = std::int64_t{1} << 21;  // three axes fit 63 bits

/// The class of a radius: the smallest k with radius <= reference * 2^k.
int sizeClass(double radius, double reference) {
    int er = 0, ef = 0;
    const double mr = std::frexp(radius, &er), mf = std::frexp(reference, &ef);
    return er - ef + (mr > mf ? 1 : 0);
}

/// The largest radius of the bulk, so that the usual pack (size ratio up to 2) is one class and
/// a few spheres far too large do not move the classes of all others.
template <int Dim>
double referenceRadius(const std::vector<Sphere<Dim>>& spheres) {
    std::vector<double> sample;
    const std::size_t step = std::max<std::size_t>(1, spheres.size() / 1024);
    for (std::size_t i = 0; i < spheres.size(); i += step) sample.push_back(spheres[i].radius);
    const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
    std::nth_element(sample.begin(), middle, sample.end());
    const double median = *middle;
    double reference = median;
    for (const auto& s : spheres)
        if (s.radius <= 2 * median) reference = std::max(reference, s.radius);
    return reference;
}

}  // namespace

template <int Dim>
void requireUsable(const std::vector<Sphere<Dim>>& spheres) {
    indexable(spheres.size(), Measure<Dim>::kSpheres, "split the pack");
    const auto usable = [](const Sphere<Dim>& s) {
        bool ok = s.radius >= 1 / kLargestLength && s.radius <= kLargestLength;
        for (int i = 0; i < Dim; ++i) ok = ok && std::abs(s.center[i]) <= kLargestLength;
        return ok;
    };
    std::atomic<std::size_t> first{spheres.size()};
    parallelFor(IndexRange(0, spheres.size(), 4096), [&](const IndexRange& block) {
        for (std::size_t i = block.begin(); i < block.end(); ++i) {
            if (usable(spheres[i])) continue;
            std::size_t seen = first;
            while (i < seen && !first.compare_exchange_weak(seen, i)) {
            }
            return;
        }
    });
    if (first == spheres.size()) return;
    const Sphere<Dim>& s = spheres[first];
    std::string at;
    for (int i = 0; i < Dim; ++i) at += fmt::format("{}{}", i ? ", " : "", s.center[i]);
    throw InputError(
        fmt::format("pack: {} number {} (counted from 0) at ({}) has radius {}: not a finite "
                    "position and a positive radius (1e-30 to 1e30 mm); remove or correct it",
                    Measure<Dim>::kSphere, first.load(), at, s.radius));
}

template <int Dim>
std::int64_t CellLevels<Dim>::Axis::cell(double x) const {
    const double c = lattice(x);
    if (occupied.empty())
        return static_cast<std::int64_t>(std::clamp(c, 0.0, static_cast<double>(count - 1)));
    const auto at = std::lower_bound(occupied.begin(), occupied.end(), c) - occupied.begin();
    return compact[static_cast<std::size_t>(at)];
}

template <int Dim>
std::pair<std::int64_t, std::int64_t> CellLevels<Dim>::Axis::cells(double a, double b) const {
    if (occupied.empty()) {
        const double last = static_cast<double>(count - 1);
        const double ca = lattice(a), cb = lattice(b);
        if (cb < 0 || ca > last) return {1, 0};
        return {static_cast<std::int64_t>(std::max(ca, 0.0)),
                static_cast<std::int64_t>(std::min(cb, last))};
    }
    const auto first = std::lower_bound(occupied.begin(), occupied.end(), lattice(a));
    const auto last = std::upper_bound(first, occupied.end(), lattice(b));
    if (first == last) return {1, 0};
    return {compact[static_cast<std::size_t>(first - occupied.begin())],
            compact[static_cast<std::size_t>(last - occupied.begin()) - 1]};
}

/// Lays the axes over the members, with gaps closed up if cells would be more than `most`.
/// @return the number of cells.
template <int Dim>
double CellLevels<Dim>::layAxes(Level& level, const std::vector<Sphere<Dim>>& spheres,
                                const Members& members, double most) const {
    const std::size_t n = members.size();
    using Extent = std::pair<Box<Dim>, double>;
    const auto [bounds, largest] = tbb::parallel_reduce(
        IndexRange(0, n, 4096), Extent{},
        [&](const IndexRange& block, Extent extent) {
            for (std::size_t k = block.begin(); k < block.end(); ++k) {
                const Sphere<Dim>& s = spheres[members[k]];
                extent.first.add(s.center);
                extent.second = std::max(extent.second, s.radius);
            }
            return extent;
        },
        [](Extent a, const Extent& b) {
            if (b.first.empty()) return a;
            a.first.add(b.first.lo);
            a.first.add(b.first.hi);
            a.second = std::max(a.second, b.second);
            return a;
        });
    level.largestRadius = largest;
    // The widening keeps rounding from putting a pair in reach two cells apart.
    const double edge = (2 + slack_) * level.largestRadius * (1 + 1e-9);
    double cells = 1;
    for (int i = 0; i < Dim; ++i) {
        Axis& axis = level.axes[static_cast<std::size_t>(i)];
        axis.lo = bounds.lo[i];
        axis.perCell = 1 / edge;
        const double count = axis.lattice(bounds.hi[i]) + 1;
        cells *= count;
        axis.count = static_cast<std::int64_t>(std::min(count, 1e15));
    }
    if (cells > most) {
        cells = 1;
        for (int i = 0; i < Dim; ++i) {
            Axis& axis = level.axes[static_cast<std::size_t>(i)];
            axis.occupied.resize(n);
            for (std::size_t k = 0; k < n; ++k)
                axis.occupied[k] = axis.lattice(spheres[members[k]].center[i]);
            tbb::parallel_sort(axis.occupied.begin(), axis.occupied.end());
            axis.occupied.erase(std::unique(axis.occupied.begin(), axis.occupied.end()),
                                axis.occupied.end());
            axis.compact.resize(axis.occupied.size());
            std::int64_t at = 0;
            for (std::size_t k = 0; k < axis.occupied.size(); ++k) {
                // Far out, where the lattice itself is rounded, two apart may be neighbors.
                const double step = axis.occupied[k] - axis.occupied[k ? k - 1 : 0];
                const double adjacent = axis.occupied[k] > 1e6 ? 2 + 1e-15 * axis.occupied[k] : 1.0;
                if (k > 0) at += step <= adjacent ? 1 : 2;
                axis.compact[k] = std::min(at, kMostCellsAnAxis - 1);
            }
            axis.count = axis.compact.back() + 1;
            cells *= static_cast<double>(axis.count);
        }
    }
    return cells;
}

template <int Dim>
std::uint64_t CellLevels<Dim>::cellOf(const Level& level, const Vec<Dim>& center) {
    std::uint64_t cell = 0;
    for (int i = Dim - 1; i >= 0; --i)
        cell = cell * static_cast<std::uint64_t>(level.axis(i).count) +
               static_cast<std::uint64_t>(level.axis(i).cell(center[i]));
    return cell;
}

template <int Dim>
void CellLevels<Dim>::fillLevel(Level& level, const std::vector<Sphere<Dim>>& spheres,
                                const Members& members) {
    const double most = std::min(4.0 * static_cast<double>(members.size()) + 64, 4e9);
    const double cells = layAxes(level, spheres, members, most);
    if (cells <= most)
        sortByCell(level, spheres, members, static_cast<std::size_t>(cells));
    else
        sortByKey(level, spheres, members);
}

/// Counting sort into as many slots as there are cells.
template <int Dim>
void CellLevels<Dim>::sortByCell(Level& level, const std::vector<Sphere<Dim>>& spheres,
                                 const Members& members, std::size_t cells) {
    const std::size_t n = members.size();
    // The order inside a cell depends on the threads; no result does. Positions are found before
    // the spheres are written: atomic counts beside random writes would wait for each other.
    std::vector<std::uint32_t> at(n);
    {
        std::vector<std::atomic<std::uint32_t>> next(cells);
        forAll(n, [&](std::size_t k) {
            at[k] = static_cast<std::uint32_t>(cellOf(level, spheres[members[k]].center));
            next[at[k]].fetch_add(1, std::memory_order_relaxed);
        });
        firstPositions(next, level.start, "spheres", "take fewer spheres");
        forAll(n,
               [&](std::size_t k) { at[k] = next[at[k]].fetch_add(1, std::memory_order_relaxed); });
    }
    level.spheres.resize(n);
    level.index.resize(n);
    forAll(n, [&](std::size_t k) {
        level.spheres[at[k]] = spheres[members[k]];
        level.index[at[k]] = members[k];
    });
}

/// Sorts into slots of the occupied cells alone.
template <int Dim>
void CellLevels<Dim>::sortByKey(Level& level, const std::vector<Sphere<Dim>>& spheres,
                                const Members& members) {
    const std::size_t n = members.size();
    std::vector<std::uint64_t> key(n);
    forAll(n, [&](std::size_t k) { key[k] = cellOf(level, spheres[members[k]].center); });
    level.spheres.resize(n);
    level.index.resize(n);
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    tbb::parallel_sort(order.begin(), order.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; });
    for (std::size_t k = 0; k < n; ++k) {
        level.spheres[k] = spheres[members[order[k]]];
        level.index[k] = members[order[k]];
        if (k == 0 || key[order[k]] != level.keys.back()) {
            level.keys.push_back(key[order[k]]);
            level.start.push_back(static_cast<std::uint32_t>(k));
        }
    }
    level.start.push_back(static_cast<std::uint32_t>(n));
}

template <int Dim>
CellLevels<Dim>::CellLevels(const std::vector<Sphere<Dim>>& spheres, double slack) : slack_(slack) {
    if (spheres.empty()) return;
    const double reference = referenceRadius(spheres);
    std::map<int, std::vector<std::uint32_t>, std::greater<>> classes;
    std::vector<std::uint32_t>* members = nullptr;
    double above = 0, upTo = 0;  // radii of the class of `members`
    for (std::size_t i = 0; i < spheres.size(); ++i) {
        const double radius = spheres[i].radius;
        if (!(radius > above && radius <= upTo)) {
            const int k = sizeClass(radius, reference);
            members = &classes[k];
            if (members->empty()) members->reserve(spheres.size() - i);
            upTo = std::ldexp(reference, k);
            above = upTo / 2;
        }
        members->push_back(static_cast<std::uint32_t>(i));
    }
    // A class joins the next larger one where it is the smaller in number: one search less.
    for (auto it = classes.begin(); it != classes.end(); ++it) {
        const auto finer = std::next(it);
        if (finer == classes.end() || finer->first != it->first - 1 ||
            finer->second.size() > it->second.size())
            continue;
        it->second.insert(it->second.end(), finer->second.begin(), finer->second.end());
        classes.erase(finer);
    }
    levels_.resize(classes.size());
    std::size_t k = 0;
    for (auto& [number, listed] : classes) {
        // All in one class, as usual: they need no list.
        if (listed.size() == spheres.size()) std::vector<std::uint32_t>().swap(listed);
        fillLevel(levels_[k++], spheres, Members(std::move(listed), spheres.size()));
    }
}

template class CellLevels<2>;
template class CellLevels<3>;
template void requireUsable<2>(const std::vector<Sphere<2>>&);
template void requireUsable<3>(const std::vector<Sphere<3>>&);

}  // namespace vdbpack
