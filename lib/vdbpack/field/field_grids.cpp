#include "vdbpack/field/field_grids.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/read_vdb.h"
#include "vdbpack/field/vdb_archive.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

namespace vdbpack {

namespace {

using openvdb::Coord;

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
    bool probe(const Coord& voxel, Value& value) const {
        if (single_) return single_->tree().probeValue(voxel, value);
        typename Double::ValueType unrounded;
        const bool isActive = double_->tree().probeValue(voxel, unrounded);
        value = Value(unrounded);
        return isActive;
    }
    /// Adds to `voxels` all active voxels whose `counts(value, voxel)` is true, and to `chosen` the
    /// first and the last of them in each leaf, which represent the others from afar.
    template <class Counts>
    void survey(openvdb::CoordBBox& voxels, std::vector<Coord>& chosen,
                const Counts& counts) const {
        Coord leaf = Coord::max();
        const auto visitAll = [&](const auto& grid) {
            for (auto value = grid.cbeginValueOn(); value; ++value) {
                const openvdb::CoordBBox box = value.getBoundingBox();
                const Coord at = box.min();
                if (!counts(Value(*value), at)) continue;
                voxels.expand(box);
                if (value.isTileValue()) {
                    for (int corner = 0; corner < 8; ++corner)
                        chosen.emplace_back(corner & 1 ? box.max().x() : at.x(),
                                            corner & 2 ? box.max().y() : at.y(),
                                            corner & 4 ? box.max().z() : at.z());
                    continue;
                }
                constexpr int kLeafSide = 8;
                const Coord origin = at & ~(kLeafSide - 1);
                if (origin != leaf) chosen.insert(chosen.end(), 2, at);
                leaf = origin;
                chosen.back() = at;
            }
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

using NumberGrid = EitherGrid<openvdb::FloatGrid, openvdb::DoubleGrid>;
using VectorGrid = EitherGrid<openvdb::Vec3SGrid, openvdb::Vec3DGrid>;

Vec<3> toVec(const openvdb::Vec3d& v) {
    return {{v[0], v[1], v[2]}};
}

/// @throws InputError if the place of a voxel (mm) is too far from the origin to be meant.
void requireNear(const std::string& file, const Coord& voxel, const Vec<3>& x) {
    if (isFinite(x) && std::max({std::fabs(x[0]), std::fabs(x[1]), std::fabs(x[2])}) <= 1e9) return;
    throw InputError(fmt::format(
        "{}: voxel ({}, {}, {}) lies more than 1e9 mm from the origin; correct the transform", file,
        voxel.x(), voxel.y(), voxel.z()));
}

/// Calls `visit(voxel, weight)` for those of the eight voxels around `x` (mm) that have a trilinear
/// weight. @param scale  mm in one unit of the file.
template <class Visit>
void forEachAround(const openvdb::math::Transform& transform, double scale, const Vec<3>& x,
                   const Visit& visit) {
    const openvdb::Vec3d p = transform.worldToIndex(openvdb::Vec3d(x[0], x[1], x[2]) / scale);
    // Far away voxels have no number.
    if (!(p.length() < 1e9)) return;
    const Coord low = Coord::floor(p);
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        Coord voxel = low;
        for (int d = 0; d < 3; ++d) {
            const int up = corner >> d & 1;
            const double t = p[d] - low[d];
            weight *= up ? t : 1 - t;
            voxel[d] += up;
        }
        if (weight > 0) visit(voxel, weight);
    }
}

/// The box around voxels, a voxel wider on each side, mm. @param scale  mm in one unit of the file.
Box<3> boxAround(const openvdb::CoordBBox& voxels, const openvdb::math::Transform& transform,
                 double scale) {
    openvdb::BBoxd box(voxels.min().asVec3d(), voxels.max().asVec3d());
    box.expand(1.0);
    const auto world = transform.indexToWorld(box);
    return {toVec(world.min()) * scale, toVec(world.max()) * scale};
}

NumberGrid readFirst(const std::string& path) {
    VdbArchive file(path);
    if (const auto grid = file.find(NumberGrid::isOne)) return NumberGrid(grid);
    const std::string all = file.list();
    throw InputError(
        fmt::format("{}: no grid of floats among its grids: {}; write one grid of numbers", path,
                    all.empty() ? "none" : all));
}

}  // namespace

struct ScalarGrid::Impl {
    std::optional<NumberGrid> grid;
    double scale = 1;
    Box<3> bounds;
    std::vector<std::pair<Vec<3>, double>> samples;

    Vec<3> placeOf(const Coord& voxel) const {
        return toVec(grid->base().transform().indexToWorld(voxel)) * scale;
    }
    void read(const std::string& file, const std::function<std::string(double)>& fault);
};

void ScalarGrid::Impl::read(const std::string& file,
                            const std::function<std::string(double)>& fault) {
    grid = readFirst(file);
    openvdb::CoordBBox voxels;
    std::vector<Coord> chosen;
    grid->survey(voxels, chosen, [&](float value, const Coord& at) {
        const std::string wrong = fault(static_cast<double>(value));
        if (wrong.empty()) return true;
        const Vec<3> x = placeOf(at);
        throw InputError(fmt::format(
            "{}: grid '{}', voxel ({}, {}, {}) at ({:.6g}, {:.6g}, {:.6g}) mm: {}", file,
            grid->base().getName(), at.x(), at.y(), at.z(), x[0], x[1], x[2], wrong));
    });
    if (chosen.empty()) throw InputError(file + ": no voxel is active; write the field again");
    samples.reserve(chosen.size());
    for (const Coord& voxel : chosen) {
        float value = 0;
        grid->probe(voxel, value);
        samples.emplace_back(placeOf(voxel), static_cast<double>(value));
        requireNear(file, voxel, samples.back().first);
    }
    bounds = boxAround(voxels, grid->base().transform(), scale);
}

ScalarGrid::ScalarGrid(const std::string& file, double scale,
                       const std::function<std::string(double)>& fault)
    : impl_(std::make_unique<Impl>()) {
    impl_->scale = scale;
    readVdb(file, [&] { impl_->read(file, fault); });
}

ScalarGrid::~ScalarGrid() = default;

const Box<3>& ScalarGrid::bounds() const {
    return impl_->bounds;
}

double ScalarGrid::step() const {
    const openvdb::Vec3d edges = impl_->grid->base().voxelSize();
    return std::min({edges.x(), edges.y(), edges.z()}) * impl_->scale;
}

const std::vector<std::pair<Vec<3>, double>>& ScalarGrid::samples() const {
    return impl_->samples;
}

std::optional<double> ScalarGrid::at(const Vec<3>& x) const {
    double sum = 0, all = 0;
    forEachAround(impl_->grid->base().transform(), impl_->scale, x,
                  [&](const Coord& voxel, double weight) {
                      float value = 0;
                      if (!impl_->grid->probe(voxel, value)) return;
                      sum += weight * static_cast<double>(value);
                      all += weight;
                  });
    if (!(all > 0)) return {};
    return sum / all;
}

namespace {

bool isFiniteValue(float v) {
    return std::isfinite(v);
}
bool isFiniteValue(const openvdb::Vec3s& v) {
    return v.isFinite();
}

/// The grids of one field; all with the transform of the first.
struct FieldGrids {
    std::vector<VectorGrid> vectors;  ///< directions; or diagonal, off-diagonal
    std::vector<NumberGrid> scalars;  ///< in the order of `Tensor`

    const openvdb::math::Transform& transform() const {
        return scalars.empty() ? vectors[0].base().transform() : scalars[0].base().transform();
    }
    /// Zero where the voxel is inactive.
    Tensor at(const Coord& voxel) const {
        Tensor t{};
        for (std::size_t i = 0; i < scalars.size(); ++i) {
            float value = 0;
            if (scalars[i].probe(voxel, value)) t[i] = static_cast<double>(value);
        }
        for (std::size_t i = 0; i < vectors.size(); ++i) {
            openvdb::Vec3s value;
            if (!vectors[i].probe(voxel, value)) continue;
            for (int d = 0; d < 3; ++d)
                t[3 * i + static_cast<std::size_t>(d)] = static_cast<double>(value[d]);
        }
        return vectors.size() == 1 ? dyad({{t[0], t[1], t[2]}}) : t;
    }
};

/// Adds the voxels of a grid that are not zero (see `EitherGrid::survey`).
/// @throws InputError if a value is not finite.
template <class Grid>
void survey(const std::string& file, const Grid& grid, openvdb::CoordBBox& voxels,
            std::vector<Coord>& chosen) {
    grid.survey(voxels, chosen, [&](const auto& value, const Coord& at) {
        if (!isFiniteValue(value))
            throw InputError(fmt::format(
                "{}: the value of grid '{}' at voxel ({}, {}, {}) is not finite; write it again",
                file, grid.base().getName(), at.x(), at.y(), at.z()));
        return value != openvdb::zeroVal<typename Grid::Value>();
    });
}

/// The component that the end of a grid's name stands for, of six; the rest is cut off it.
int cutComponent(std::string& name) {
    constexpr std::array<std::array<const char*, 2>, 6> kNames{
        {{"xx", "11"}, {"yy", "22"}, {"zz", "33"}, {"xy", "12"}, {"yz", "23"}, {"xz", "13"}}};
    if (name.size() < 2) return -1;
    const std::string end = lowered(name.substr(name.size() - 2));
    for (std::size_t i = 0; i < kNames.size(); ++i)
        if (end == kNames[i][0] || end == kNames[i][1]) {
            name.resize(name.size() - 2);
            return static_cast<int>(i);
        }
    return -1;
}

bool cutEnd(std::string& name, std::string_view end) {
    if (!endsWith(name, end)) return false;
    name.resize(name.size() - end.size());
    return true;
}

/// Names of the grids of each field in the file, by what their names have in common.
struct FieldNames {
    std::vector<std::string> directions;
    std::map<std::string, std::array<std::string, 2>> pairs;
    std::map<std::string, std::array<std::string, 6>> sixes;

    template <std::size_t N>
    static void dropIncomplete(std::map<std::string, std::array<std::string, N>>& fields) {
        for (auto field = fields.begin(); field != fields.end();) {
            const auto& names = field->second;
            const bool whole = std::find(names.begin(), names.end(), "") == names.end();
            field = whole ? std::next(field) : fields.erase(field);
        }
    }
};

FieldNames fieldNames(const VdbArchive& file) {
    FieldNames fields;
    for (const auto& header : file.heads()) {
        const std::string name = header->getName();
        std::string stem = name;
        if (NumberGrid::isOne(*header)) {
            const int component = cutComponent(stem);
            if (component >= 0) fields.sixes[stem][static_cast<std::size_t>(component)] = name;
        } else if (VectorGrid::isOne(*header)) {
            if (cutEnd(stem, "offdiagonal"))
                fields.pairs[stem][1] = name;
            else if (cutEnd(stem, "diagonal"))
                fields.pairs[stem][0] = name;
            else
                fields.directions.push_back(name);
        }
    }
    FieldNames::dropIncomplete(fields.pairs);
    FieldNames::dropIncomplete(fields.sixes);
    return fields;
}

template <class Grids>
void requireOneTransform(const std::string& file, const Grids& grids) {
    for (const auto& grid : grids)
        if (grid.base().transform() != grids[0].base().transform())
            throw InputError(fmt::format(
                "{}: grids '{}' and '{}' have different transforms; resample them to one", file,
                grids[0].base().getName(), grid.base().getName()));
}

FieldGrids readGrids(const std::string& path) {
    VdbArchive file(path);
    const FieldNames names = fieldNames(file);
    const std::size_t count = names.directions.size() + names.pairs.size() + names.sixes.size();
    const std::string all = file.list();
    if (count != 1)
        throw InputError(fmt::format(
            "{}: {} among its grids: {}; leave one grid of vectors (directions), two named "
            "NAME_diagonal and NAME_offdiagonal, or six of scalars whose names end in xx, yy, zz, "
            "xy, yz and xz (a tensor)",
            path,
            count == 0 ? "no field of directions" : fmt::format("{} fields of directions", count),
            all.empty() ? "none" : all));
    FieldGrids grids;
    const auto read = [&file](const std::string& name) {
        return file.find([&](const openvdb::GridBase& head) { return file.isNamed(head, name); });
    };
    const auto readVectors = [&](const std::string& name) {
        grids.vectors.push_back(VectorGrid(read(name)));
    };
    for (const auto& name : names.directions) readVectors(name);
    for (const auto& pair : names.pairs)
        for (const auto& name : pair.second) readVectors(name);
    for (const auto& six : names.sixes)
        for (const auto& name : six.second) grids.scalars.push_back(NumberGrid(read(name)));
    requireOneTransform(path, grids.vectors);
    requireOneTransform(path, grids.scalars);
    return grids;
}

}  // namespace

struct TensorGrid::Impl {
    FieldGrids grids;
    double scale = 1;
    Box<3> bounds;
    std::vector<TensorSample> samples;

    void read(const std::string& file);
};

void TensorGrid::Impl::read(const std::string& file) {
    grids = readGrids(file);
    openvdb::CoordBBox voxels;
    std::vector<Coord> chosen;
    for (const auto& grid : grids.vectors) survey(file, grid, voxels, chosen);
    for (const auto& grid : grids.scalars) survey(file, grid, voxels, chosen);
    if (chosen.empty())
        throw InputError(file + ": no active voxel has a direction; write the field again");
    samples.reserve(chosen.size());
    for (const Coord& voxel : chosen) {
        samples.push_back({toVec(grids.transform().indexToWorld(voxel)) * scale, grids.at(voxel)});
        requireNear(file, voxel, samples.back().x);
    }
    bounds = boxAround(voxels, grids.transform(), scale);
}

TensorGrid::TensorGrid(const std::string& file, double scale) : impl_(std::make_unique<Impl>()) {
    impl_->scale = scale;
    readVdb(file, [&] { impl_->read(file); });
}

TensorGrid::~TensorGrid() = default;

const Box<3>& TensorGrid::bounds() const {
    return impl_->bounds;
}

const std::vector<TensorSample>& TensorGrid::samples() const {
    return impl_->samples;
}

std::optional<Tensor> TensorGrid::at(const Vec<3>& x) const {
    Tensor sum{};
    double size = 0;
    forEachAround(impl_->grids.transform(), impl_->scale, x,
                  [&](const Coord& voxel, double weight) {
                      const Tensor t = impl_->grids.at(voxel);
                      addScaled(sum, weight, t);
                      size += weight * magnitude(t);
                  });
    if (!(magnitude(sum) > 1e-12 * size)) return {};
    return sum;
}

}  // namespace vdbpack
