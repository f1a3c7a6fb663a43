// Private: grids of fields, of single or double precision. Costs 4 s to include; only sources may.
#pragma once

#include "vdbpack/core/box.h"
#include "vdbpack/field/vdb_grid.h"

#include <string>

namespace vdbpack {

/// A grid of single or double precision; all values are rounded to single precision. No grid of
/// these types is constructed here, which spares compiling their virtual functions.
template <class Single, class Double>
class EitherGrid {
public:
    using Value = typename Single::ValueType;

    static bool isOne(const openvdb::GridBase& grid) {
        return grid.isType<Single>() || grid.isType<Double>();
    }
    explicit EitherGrid(const openvdb::GridBase::Ptr& grid)
        : base_(grid),
          single_(openvdb::gridPtrCast<Single>(grid)),
          double_(openvdb::gridPtrCast<Double>(grid)) {}

    const openvdb::GridBase& base() const { return *base_; }
    /// @return whether the voxel is active.
    bool probe(const openvdb::Coord& voxel, Value& value) const {
        if (single_) return single_->tree().probeValue(voxel, value);
        typename Double::ValueType unrounded;
        const bool isActive = double_->tree().probeValue(voxel, unrounded);
        value = Value(unrounded);
        return isActive;
    }
    /// Calls `visit(value, its box, whether it is a tile)` for all active values.
    template <class Visit>
    void forEachOn(const Visit& visit) const {
        const auto visitAll = [&](const auto& grid) {
            for (auto value = grid.cbeginValueOn(); value; ++value)
                visit(Value(*value), value.getBoundingBox(), value.isTileValue());
        };
        if (single_)
            visitAll(*single_);
        else
            visitAll(*double_);
    }

private:
    openvdb::GridBase::Ptr base_;
    typename Single::Ptr single_;  ///< one of the two
    typename Double::Ptr double_;
};

inline Vec<3> toVec(const openvdb::Vec3d& v) {
    return {{v[0], v[1], v[2]}};
}

/// @throws InputError if the place of a voxel (mm) is too far from the origin to be meant.
void requireNear(const std::string& file, const openvdb::Coord& voxel, const Vec<3>& x);

/// The box around voxels, a voxel wider on each side, mm. @param scale  mm in one unit of the file.
Box<3> boxAround(const openvdb::CoordBBox& voxels, const openvdb::math::Transform& transform,
                 double scale);

}  // namespace vdbpack
