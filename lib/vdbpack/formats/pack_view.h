// Private: a pack of either dimension as the writers see it, in the unit that is written.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/core/pack.h"
#include "vdbpack/core/units.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vdbpack {

/// Name of the unit in the metadata of .vdb and .vtp, and how comments of .ply and YADE begin.
inline constexpr const char* kUnitKey = "unit_of_length";
inline constexpr const char* kUnitComment = "unit of length: ";
inline constexpr const char* kGeneratorKey = "generator";

/// The best double for `mm` in `unit`: divided by a whole number rather than multiplied by its
/// inexact inverse.
inline double fromMillimeters(double mm, Unit unit) {
    return unit == Unit::micrometer ? mm * 1000.0 : mm / millimetersPer(unit);
}
inline double toMillimeters(double value, Unit unit) {
    return unit == Unit::micrometer ? value / 1000.0 : value * millimetersPer(unit);
}

/// Reads a pack without copying it; must not outlive the pack.
class PackView {
public:
    template <int Dim>
    PackView(const Pack<Dim>& pack, Unit unit)
        : size_(pack.spheres.size()),
          unit_(unit),
          height_(fromMillimeters(pack.sliceHeight, unit)),
          id_(&pack.id),
          region_(&pack.region),
          order_(&pack.order),
          depth_(&pack.depth),
          contacts_(&pack.contacts),
          columns_(&pack.columns) {
        if constexpr (Dim == 2)
            circles_ = pack.spheres.data();
        else
            spheres_ = pack.spheres.data();
    }

    std::size_t size() const { return size_; }
    Unit unit() const { return unit_; }
    /// 2 for circles.
    int dim() const { return circles_ != nullptr ? 2 : 3; }

    std::array<double, 3> position(std::size_t i) const {
        if (circles_ != nullptr)
            return {fromMillimeters(circles_[i].center[0], unit_),
                    fromMillimeters(circles_[i].center[1], unit_), height_};
        const Vec<3>& c = spheres_[i].center;
        return {fromMillimeters(c[0], unit_), fromMillimeters(c[1], unit_),
                fromMillimeters(c[2], unit_)};
    }
    double radius(std::size_t i) const {
        return fromMillimeters(circles_ != nullptr ? circles_[i].radius : spheres_[i].radius,
                               unit_);
    }
    /// Around whole spheres, in the unit that is written; of one length where there are none.
    Box<3> bounds() const {
        Box<3> box;
        for (std::size_t i = 0; i < size_; ++i) {
            const auto p = position(i);
            const double r = radius(i);
            box.add({{p[0] - r, p[1] - r, p[2] - r}});
            box.add({{p[0] + r, p[1] + r, p[2] + r}});
        }
        return size_ > 0 ? box : Box<3>{{{0, 0, 0}}, {{1, 1, 1}}};
    }
    std::int64_t id(std::size_t i) const {
        return id_->empty() ? static_cast<std::int64_t>(i) : (*id_)[i];
    }
    double depth(std::size_t i) const {
        return fromMillimeters(static_cast<double>((*depth_)[i]), unit_);
    }

    /// Each empty or with one value a sphere.
    const std::vector<std::int32_t>& region() const { return *region_; }
    const std::vector<std::int64_t>& order() const { return *order_; }
    const std::vector<std::int32_t>& contacts() const { return *contacts_; }
    bool hasDepth() const { return !depth_->empty(); }
    const std::vector<Column>& columns() const { return *columns_; }

private:
    std::size_t size_ = 0;
    Unit unit_ = Unit::millimeter;
    double height_ = 0;
    const Sphere<2>* circles_ = nullptr;
    const Sphere<3>* spheres_ = nullptr;
    const std::vector<std::int64_t>* id_;
    const std::vector<std::int32_t>* region_;
    const std::vector<std::int64_t>* order_;
    const std::vector<float>* depth_;
    const std::vector<std::int32_t>* contacts_;
    const std::vector<Column>* columns_;
};

}  // namespace vdbpack
