#include "vdbpack/field/scalar_grid.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/either_grid.h"
#include "vdbpack/field/read_vdb.h"

#include <fmt/format.h>

#include <algorithm>

namespace vdbpack {

namespace {

using openvdb::Coord;
using Scalars = EitherGrid<openvdb::FloatGrid, openvdb::DoubleGrid>;

Scalars readFirst(const std::string& path) {
    openvdb::io::File file(path);
    file.open(/*delayLoad=*/false);
    std::string all;
    const auto headers = file.readAllGridMetadata();
    for (const auto& header : *headers) {
        if (Scalars::isOne(*header)) return Scalars(file.readGrid(header->getName()));
        all += fmt::format("{}'{}' ({})", all.empty() ? "" : ", ", header->getName(),
                           header->valueType());
    }
    throw InputError(
        fmt::format("{}: no grid of floats among its grids: {}; write one grid of numbers", path,
                    all.empty() ? "none" : all));
}

}  // namespace

struct ScalarGrid::Impl {
    std::optional<Scalars> grid;
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
    constexpr int kLeaf = 8;
    Coord leaf = Coord::max();
    grid->forEachOn([&](float value, const openvdb::CoordBBox& box, bool isTile) {
        const Coord at = box.min();
        if (const std::string wrong = fault(static_cast<double>(value)); !wrong.empty()) {
            const Vec<3> x = placeOf(at);
            throw InputError(fmt::format(
                "{}: grid '{}', voxel ({}, {}, {}) at ({:.6g}, {:.6g}, {:.6g}) mm: {}", file,
                grid->base().getName(), at.x(), at.y(), at.z(), x[0], x[1], x[2], wrong));
        }
        voxels.expand(box);
        const auto add = [&](const Coord& voxel) {
            samples.emplace_back(placeOf(voxel), static_cast<double>(value));
            requireNear(file, voxel, samples.back().first);
        };
        if (isTile) {
            for (int corner = 0; corner < 8; ++corner)
                add({corner & 1 ? box.max().x() : box.min().x(),
                     corner & 2 ? box.max().y() : box.min().y(),
                     corner & 4 ? box.max().z() : box.min().z()});
            return;
        }
        // The first and the last of each leaf.
        const Coord origin = at & ~(kLeaf - 1);
        if (origin == leaf) samples.pop_back();
        if (origin != leaf) add(at);
        leaf = origin;
        add(at);
    });
    if (samples.empty()) throw InputError(file + ": no voxel is active; write the field again");
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
    const openvdb::Vec3d p = impl_->grid->base().transform().worldToIndex(
        openvdb::Vec3d(x[0], x[1], x[2]) / impl_->scale);
    // Far away voxels have no number.
    if (!(p.length() < 1e9)) return {};
    const Coord low = Coord::floor(p);
    double sum = 0, all = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        Coord voxel = low;
        for (int d = 0; d < 3; ++d) {
            const int up = corner >> d & 1;
            const double t = p[d] - low[d];
            weight *= up ? t : 1 - t;
            voxel[d] += up;
        }
        float value = 0;
        if (!(weight > 0) || !impl_->grid->probe(voxel, value)) continue;
        sum += weight * static_cast<double>(value);
        all += weight;
    }
    if (!(all > 0)) return {};
    return sum / all;
}

}  // namespace vdbpack
