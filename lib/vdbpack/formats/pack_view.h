// Private: a pack of either dimension as the writers see it, in the unit that is written.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/periodic_cell.h"
#include "vdbpack/core/units.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace vdbpack {  /// The type of the values of a vector, by the type of a reference to it.
template <class Vector>
using ValueOf = typename std::decay_t<Vector>::value_type;

/// Refers to a pack; must not outlive it.
class PackView {
public:
    template <int Dim>
    PackView(const Pack<Dim>& pack, Unit unit)
        : size_(pack.spheres.size()),
          unit_(unit),
          dim_(Dim),
          height_(fromMillimeters(pack.sliceHeight, unit)),
          attributes_(&pack) {
        if constexpr (Dim == 2)
            circles_ = pack.spheres.data();
        else
            spheres_ = pack.spheres.data();
        for (int d = 0; d < Dim; ++d) {
            cell_.wraps[static_cast<std::size_t>(d)] = pack.cell.isAlong(d);
            if (!pack.cell.any()) continue;
            cell_.box.lo[d] = fromMillimeters(pack.cell.box.lo[d], unit);
            cell_.box.hi[d] = fromMillimeters(pack.cell.box.hi[d], unit);
        }
        if (Dim == 2 && pack.cell.any()) cell_.box.lo[2] = cell_.box.hi[2] = height_;
    }

    std::size_t size() const { return size_; }
    Unit unit() const { return unit_; }
    /// 2 for circles.
    int dim() const { return dim_; }

    /// In space: circles lie at the height of their slice.
    Vec<3> center(std::size_t i) const {
        if (dim_ == 2)
            return {{fromMillimeters(circles_[i].center[0], unit_),
                     fromMillimeters(circles_[i].center[1], unit_), height_}};
        const Vec<3>& c = spheres_[i].center;
        return {{fromMillimeters(c[0], unit_), fromMillimeters(c[1], unit_),
                 fromMillimeters(c[2], unit_)}};
    }
    std::array<double, 3> position(std::size_t i) const { return center(i).c; }
    double radius(std::size_t i) const {
        return fromMillimeters(dim_ == 2 ? circles_[i].radius : spheres_[i].radius, unit_);
    }
    /// In which the spheres repeat, in the unit that is written.
    const PeriodicCell<3>& cell() const { return cell_; }
    /// Around whole spheres, in the unit that is written; a unit cube if there are none. Along axes
    /// that wrap, the cell.
    Box<3> bounds() const {
        Box<3> box = boundsOfSpheres();
        if (size_ == 0) box = {{{0, 0, 0}}, {{1, 1, 1}}};
        for (int d = 0; d < 3; ++d)
            if (cell_.isAlong(d)) box.lo[d] = cell_.box.lo[d], box.hi[d] = cell_.box.hi[d];
        return box;
    }
    /// Empty if there are no spheres.
    Box<3> boundsOfCenters() const {
        Box<3> box;
        for (std::size_t i = 0; i < size_; ++i) box.add(center(i));
        return box;
    }
    Box<3> boundsOfSpheres() const {
        Box<3> box;
        for (std::size_t i = 0; i < size_; ++i) {
            const Vec<3> reach = Box<3>::filled(radius(i));
            box.add(center(i) - reach);
            box.add(center(i) + reach);
        }
        return box;
    }

    std::int64_t id(std::size_t i) const {
        return attributes_->id.empty() ? static_cast<std::int64_t>(i) : attributes_->id[i];
    }
    /// Empty or with one value a sphere.
    const std::vector<std::int32_t>& region() const { return attributes_->region; }
    const std::vector<Column>& columns() const { return attributes_->columns; }

    const PackAttributes& attributes() const { return *attributes_; }
    /// Calls `use` with the pack itself, whose lengths are mm.
    template <class Use>
    auto withPack(const Use& use) const {
        return dim_ == 2 ? use(static_cast<const Pack<2>&>(*attributes_))
                         : use(static_cast<const Pack<3>&>(*attributes_));
    }

    /// For each attribute that has values, except the id: calls `numbers(name, values)` or
    /// `texts(name, values)`. The vectors are in the units of the pack; `value` converts their
    /// numbers.
    template <class Numbers, class Texts>
    void forEachAttribute(const Numbers& numbers, const Texts& texts) const {
        forEachAttributeButId(*attributes_, [&](std::string_view name, const auto& values) {
            if (values.empty()) return;
            if constexpr (std::is_same_v<decltype(values), const std::vector<std::string>&>)
                texts(name, values);
            else
                numbers(name, values);
        });
    }
    /// Number `i` of an attribute, lengths in the unit that is written: an int64 or a double.
    template <class T>
    auto value(const std::vector<T>& numbers, std::size_t i) const {
        if constexpr (std::is_integral_v<T>)
            return std::int64_t{numbers[i]};
        else if constexpr (std::is_same_v<T, float>)
            return fromMillimeters(static_cast<double>(numbers[i]), unit_);
        else
            return numbers[i];
    }

private:
    std::size_t size_ = 0;
    Unit unit_ = Unit::millimeter;
    int dim_ = 3;
    double height_ = 0;
    PeriodicCell<3> cell_;
    const Sphere<2>* circles_ = nullptr;
    const Sphere<3>* spheres_ = nullptr;
    const PackAttributes* attributes_;
};

}  // namespace vdbpack
