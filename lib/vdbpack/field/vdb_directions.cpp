// Fields of directions in .vdb files.
#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/field/vdb_check.h"
#include "vdbpack/field/vdb_grid.h"
#include "vdbpack/voids/tensor_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <map>
#include <new>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3SGrid;

constexpr double kFarthest = 1e9;  ///< from the origin, mm

bool isFiniteValue(float v) {
    return std::isfinite(v);
}
bool isFiniteValue(const openvdb::Vec3s& v) {
    return v.isFinite();
}

Vec<3> toVec(const openvdb::Vec3d& v) {
    return {{v[0], v[1], v[2]}};
}

/// The grids of one field; all with the transform of the first.
struct FieldGrids {
    std::vector<Vec3SGrid::Ptr> vectors;  ///< directions; or diagonal, off-diagonal
    std::vector<FloatGrid::Ptr> scalars;  ///< in the order of `Tensor`

    const openvdb::math::Transform& transform() const {
        return scalars.empty() ? vectors[0]->transform() : scalars[0]->transform();
    }
    /// Zero where the voxel tells nothing.
    Tensor at(const Coord& voxel) const {
        Tensor t{};
        for (std::size_t i = 0; i < scalars.size(); ++i) {
            float value = 0;
            if (scalars[i]->tree().probeValue(voxel, value)) t[i] = static_cast<double>(value);
        }
        for (std::size_t i = 0; i < vectors.size(); ++i) {
            openvdb::Vec3s value;
            if (!vectors[i]->tree().probeValue(voxel, value)) continue;
            for (int d = 0; d < 3; ++d)
                t[3 * i + static_cast<std::size_t>(d)] = static_cast<double>(value[d]);
        }
        return vectors.size() == 1 ? dyad({{t[0], t[1], t[2]}}) : t;
    }
};

class VdbField : public DirectionField {
public:
    VdbField(FieldGrids grids, const openvdb::CoordBBox& voxels, PointTensors beyond, double scale)
        : grids_(std::move(grids)), beyond_(std::move(beyond)), scale_(scale) {
        openvdb::BBoxd box(voxels.min().asVec3d(), voxels.max().asVec3d());
        box.expand(1.0);
        const auto world = grids_.transform().indexToWorld(box);
        bounds_ = {toVec(world.min()) * scale_, toVec(world.max()) * scale_};
    }

    Box<3> bounds() const override { return bounds_; }

    Vec<3> at(const Vec<3>& x) const override {
        const openvdb::Vec3d p =
            grids_.transform().worldToIndex(openvdb::Vec3d(x[0], x[1], x[2]) / scale_);
        // Far away voxels have no number.
        if (!(p.length() < 1e9)) return beyond_.mainAxisAt(x);
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
            const Tensor t = grids_.at(voxel);
            addScaled(sum, weight, t);
            size += weight * magnitude(t);
        }
        return magnitude(sum) > 1e-12 * size ? mainAxis(sum) : beyond_.mainAxisAt(x);
    }

private:
    FieldGrids grids_;
    PointTensors beyond_;
    double scale_;
    Box<3> bounds_;
};

/// Adds to `voxels` all that are not zero, and to `chosen` the first and the last of them in each
/// leaf, which stand for the others from afar.
/// @throws InputError if a value is not finite.
template <class GridType>
void survey(const std::string& file, const GridType& grid, openvdb::CoordBBox& voxels,
            std::vector<Coord>& chosen) {
    const auto zero = openvdb::zeroVal<typename GridType::ValueType>();
    Coord leaf = Coord::max();
    for (auto value = grid.cbeginValueOn(); value; ++value) {
        const Coord at = value.getCoord();
        if (!isFiniteValue(*value))
            throw InputError(fmt::format(
                "{}: grid '{}' holds a value that is not finite at voxel ({}, {}, {}); write it "
                "again",
                file, grid.getName(), at.x(), at.y(), at.z()));
        if (*value == zero) continue;
        const auto box = value.getBoundingBox();
        voxels.expand(box);
        if (value.isTileValue()) {
            for (int corner = 0; corner < 8; ++corner)
                chosen.emplace_back(corner & 1 ? box.max().x() : box.min().x(),
                                    corner & 2 ? box.max().y() : box.min().y(),
                                    corner & 4 ? box.max().z() : box.min().z());
            continue;
        }
        const Coord origin = at & ~(GridType::TreeType::LeafNodeType::DIM - 1);
        if (origin != leaf) chosen.insert(chosen.end(), 2, at);
        leaf = origin;
        chosen.back() = at;
    }
}

/// A grid of floats, from doubles where there are such.
template <class Single, class Double>
typename Single::Ptr readAs(openvdb::io::File& file, const std::string& name) {
    const auto grid = file.readGrid(name);
    if (!grid->isType<Double>()) return openvdb::gridPtrCast<Single>(grid);
    // OpenVDB converts numbers by itself, but not vectors. The same topology is walked alike.
    const auto from = openvdb::gridPtrCast<Double>(grid);
    const auto to = Single::create(std::make_shared<typename Single::TreeType>(
        from->tree(), openvdb::zeroVal<typename Single::ValueType>(), openvdb::TopologyCopy()));
    to->setName(name);
    to->setTransform(from->transformPtr());
    auto target = to->beginValueOn();
    for (auto source = from->cbeginValueOn(); source; ++source, ++target)
        target.setValue(typename Single::ValueType(*source));
    return to;
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
        if (header->isType<FloatGrid>() || header->isType<openvdb::DoubleGrid>()) {
            const int component = cutComponent(stem);
            if (component >= 0) fields.sixes[stem][static_cast<std::size_t>(component)] = name;
        } else if (header->isType<Vec3SGrid>() || header->isType<openvdb::Vec3DGrid>()) {
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
        if (grid->transform() != grids[0]->transform())
            throw InputError(fmt::format(
                "{}: grids '{}' and '{}' have different transforms; resample them to one", file,
                grids[0]->getName(), grid->getName()));
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
        grids.vectors.push_back(readAs<Vec3SGrid, openvdb::Vec3DGrid>(file, name));
    };
    for (const auto& name : names.directions) readVectors(name);
    for (const auto& pair : names.pairs)
        for (const auto& name : pair.second) readVectors(name);
    for (const auto& six : names.sixes)
        for (const auto& name : six.second)
            grids.scalars.push_back(readAs<FloatGrid, openvdb::DoubleGrid>(file, name));
    requireOneTransform(path, grids.vectors);
    requireOneTransform(path, grids.scalars);
    return grids;
}

std::shared_ptr<const DirectionField> makeField(const std::string& file, double scale) {
    FieldGrids grids = readGrids(file);
    openvdb::CoordBBox voxels;
    std::vector<Coord> chosen;
    for (const auto& grid : grids.vectors) survey(file, *grid, voxels, chosen);
    for (const auto& grid : grids.scalars) survey(file, *grid, voxels, chosen);
    if (chosen.empty())
        throw InputError(file + ": no active voxel tells a direction; write the field again");
    std::vector<PointTensors::Sample> samples;
    samples.reserve(chosen.size());
    for (const Coord& voxel : chosen) {
        samples.push_back({toVec(grids.transform().indexToWorld(voxel)) * scale, grids.at(voxel)});
        const Vec<3>& x = samples.back().x;
        if (!(std::fabs(x[0]) <= kFarthest && std::fabs(x[1]) <= kFarthest &&
              std::fabs(x[2]) <= kFarthest))
            throw InputError(
                fmt::format("{}: voxel ({}, {}, {}) lies more than 1e9 mm from the origin; correct "
                            "the transform",
                            file, voxel.x(), voxel.y(), voxel.z()));
    }
    return std::make_shared<VdbField>(std::move(grids), voxels, PointTensors(std::move(samples)),
                                      scale);
}

}  // namespace

std::shared_ptr<const DirectionField> readVdbDirections(const std::string& file, double scale) {
    checkVdbFile(file);
    try {
        return makeField(file, scale);
    } catch (const openvdb::IoError& e) {
        throw IoError(fmt::format("{}: {}; give a complete .vdb file", file, e.what()));
    } catch (const openvdb::Exception& e) {
        throw InputError(fmt::format("{}: {}; write the file again", file, e.what()));
    } catch (const Error&) {
        throw;
    } catch (const std::exception& e) {
        if (isShortage(e))
            throw ResourceError(fmt::format("{}: not enough memory to read it", file));
        throw IoError(
            fmt::format("{}: cannot be read: {}; give a complete .vdb file", file, e.what()));
    }
}

}  // namespace vdbpack
