#include "vdbpack/field/tensor_grid.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/either_grid.h"
#include "vdbpack/field/read_vdb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

using openvdb::Coord;

bool isFiniteValue(float v) {
    return std::isfinite(v);
}
bool isFiniteValue(const openvdb::Vec3s& v) {
    return v.isFinite();
}

using VectorGrid = EitherGrid<openvdb::Vec3SGrid, openvdb::Vec3DGrid>;
using ScalarGrid = EitherGrid<openvdb::FloatGrid, openvdb::DoubleGrid>;

/// The grids of one field; all with the transform of the first.
struct FieldGrids {
    std::vector<VectorGrid> vectors;  ///< directions; or diagonal, off-diagonal
    std::vector<ScalarGrid> scalars;  ///< in the order of `Tensor`

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

/// Adds to `voxels` all that are not zero, and to `chosen` the first and the last of them in each
/// leaf, which represent the others from afar.
/// @throws InputError if a value is not finite.
template <class Grid>
void survey(const std::string& file, const Grid& grid, openvdb::CoordBBox& voxels,
            std::vector<Coord>& chosen) {
    const auto zero = openvdb::zeroVal<typename Grid::Value>();
    constexpr int kLeaf = 8;
    Coord leaf = Coord::max();
    grid.forEachOn([&](const auto& value, const openvdb::CoordBBox& box, bool isTile) {
        const Coord at = box.min();
        if (!isFiniteValue(value))
            throw InputError(fmt::format(
                "{}: the value of grid '{}' at voxel ({}, {}, {}) is not finite; write it again",
                file, grid.base().getName(), at.x(), at.y(), at.z()));
        if (value == zero) return;
        voxels.expand(box);
        if (isTile) {
            for (int corner = 0; corner < 8; ++corner)
                chosen.emplace_back(corner & 1 ? box.max().x() : box.min().x(),
                                    corner & 2 ? box.max().y() : box.min().y(),
                                    corner & 4 ? box.max().z() : box.min().z());
            return;
        }
        const Coord origin = at & ~(kLeaf - 1);
        if (origin != leaf) chosen.insert(chosen.end(), 2, at);
        leaf = origin;
        chosen.back() = at;
    });
}

/// The component that the end of a grid's name stands for, of six; the rest is cut off it.
int cutComponent(std::string& name) {
    constexpr std::array<std::array<const char*, 2>, 6> kNames{
        {{"xx", "11"}, {"yy", "22"}, {"zz", "33"}, {"xy", "12"}, {"yz", "23"}, {"xz", "13"}}};
    if (name.size() < 2) return -1;
    std::string end = name.substr(name.size() - 2);
    for (char& c : end)
        if (c >= 'X' && c <= 'Z') c = static_cast<char>(c - 'X' + 'x');
    for (std::size_t i = 0; i < kNames.size(); ++i)
        if (end == kNames[i][0] || end == kNames[i][1]) {
            name.resize(name.size() - 2);
            return static_cast<int>(i);
        }
    return -1;
}

bool cutEnd(std::string& name, std::string_view end) {
    if (name.size() < end.size() || name.compare(name.size() - end.size(), end.size(), end) != 0)
        return false;
    name.resize(name.size() - end.size());
    return true;
}

/// Names of the grids of each field in the file, by what their names have in common.
struct FieldNames {
    std::vector<std::string> directions;
    std::map<std::string, std::array<std::string, 2>> pairs;
    std::map<std::string, std::array<std::string, 6>> sixes;
    std::string all;  ///< for messages

    template <std::size_t N>
    static void dropIncomplete(std::map<std::string, std::array<std::string, N>>& fields) {
        for (auto field = fields.begin(); field != fields.end();) {
            const auto& names = field->second;
            const bool whole = std::find(names.begin(), names.end(), "") == names.end();
            field = whole ? std::next(field) : fields.erase(field);
        }
    }
};

FieldNames fieldNames(openvdb::io::File& file) {
    FieldNames fields;
    const auto headers = file.readAllGridMetadata();
    for (const auto& header : *headers) {
        const std::string name = header->getName();
        fields.all +=
            fmt::format("{}'{}' ({})", fields.all.empty() ? "" : ", ", name, header->valueType());
        std::string stem = name;
        if (ScalarGrid::isOne(*header)) {
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
    openvdb::io::File file(path);
    file.open(/*delayLoad=*/false);
    const FieldNames names = fieldNames(file);
    const std::size_t count = names.directions.size() + names.pairs.size() + names.sixes.size();
    if (count != 1)
        throw InputError(fmt::format(
            "{}: {} among its grids: {}; leave one grid of vectors (directions), two named "
            "NAME_diagonal and NAME_offdiagonal, or six of scalars whose names end in xx, yy, zz, "
            "xy, yz and xz (a tensor)",
            path,
            count == 0 ? "no field of directions" : fmt::format("{} fields of directions", count),
            names.all.empty() ? "none" : names.all));
    FieldGrids grids;
    const auto readVectors = [&](const std::string& name) {
        grids.vectors.push_back(VectorGrid(file.readGrid(name)));
    };
    for (const auto& name : names.directions) readVectors(name);
    for (const auto& pair : names.pairs)
        for (const auto& name : pair.second) readVectors(name);
    for (const auto& six : names.sixes)
        for (const auto& name : six.second)
            grids.scalars.push_back(ScalarGrid(file.readGrid(name)));
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
    const openvdb::Vec3d p =
        impl_->grids.transform().worldToIndex(openvdb::Vec3d(x[0], x[1], x[2]) / impl_->scale);
    // Far away voxels have no number.
    if (!(p.length() < 1e9)) return {};
    const Coord low = Coord::floor(p);
    Tensor sum{};
    double size = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        Coord voxel = low;
        for (int d = 0; d < 3; ++d) {
            const int up = corner >> d & 1;
            const double t = p[d] - low[d];
            weight *= up ? t : 1 - t;
            voxel[d] += up;
        }
        if (!(weight > 0)) continue;
        const Tensor t = impl_->grids.at(voxel);
        addScaled(sum, weight, t);
        size += weight * magnitude(t);
    }
    if (!(magnitude(sum) > 1e-12 * size)) return {};
    return sum;
}

}  // namespace vdbpack
