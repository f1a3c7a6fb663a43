#include "vdbpack/voids/direction_field.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/field_grids.h"
#include "vdbpack/io/number_table.h"
#include "vdbpack/io/text.h"
#include "vdbpack/voids/field_points.h"
#include "vdbpack/voids/tensor_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

constexpr const char* kColumns = "x,y,z and ux,uy,uz or sxx,syy,szz,sxy,syz,sxz";

constexpr double kLargestStress = 1e300;  ///< so that sums of several are finite

using Columns = std::vector<std::optional<std::size_t>>;

/// The columns of the direction; empty if there are none.
Columns directionColumns(const NumberTable& table, bool planar) {
    Columns found;
    for (const std::string name : {"u", "d", "v"}) {
        const std::array<std::string, 3> names{name + "x", name + "y", name + "z"};
        if (!table.find({names[0]}) && !table.find({names[1]})) continue;
        if (!found.empty()) table.failColumns("more than one direction; keep one in the file");
        found = {table.require({names[0]}), table.require({names[1]}),
                 planar ? table.find({names[2]}) : table.require({names[2]})};
    }
    return found;
}

/// The columns of the tensor in the order of `Tensor`; empty if there are none.
Columns tensorColumns(const NumberTable& table, bool planar) {
    struct Component {
        std::array<const char*, 4> suffixes;
        const char* brief;  ///< name in Ansys
        bool inPlane;
    };
    constexpr std::array<Component, 6> kComponents{{{{"xx", "11", "", ""}, "sx", true},
                                                    {{"yy", "22", "", ""}, "sy", true},
                                                    {{"zz", "33", "", ""}, "sz", false},
                                                    {{"xy", "12", "yx", "21"}, "sxy", true},
                                                    {{"yz", "23", "zy", "32"}, "syz", false},
                                                    {{"xz", "13", "zx", "31"}, "sxz", false}}};
    Columns found;
    bool any = false;
    std::string missing;
    for (const auto& c : kComponents) {
        std::vector<std::string> names{c.brief};
        for (const std::string prefix : {"s", "ss", "sigma", "stress", ""})
            for (const std::string suffix : c.suffixes)
                if (!suffix.empty()) names.push_back(prefix + suffix);
        found.push_back(table.find(names));
        any = any || found.back().has_value();
        if (!found.back() && (c.inPlane || !planar))
            missing += fmt::format("{}s{}", missing.empty() ? "" : ", ", c.suffixes[0]);
    }
    if (!any) return {};
    if (!missing.empty()) table.failColumns(fmt::format("no column for {}", missing));
    return found;
}

/// The field of a table.
class TableField : public DirectionField {
public:
    TableField(std::vector<PointTensors::Sample> samples, const Box<3>& bounds, bool planar)
        : tensors_(std::move(samples)), bounds_(bounds), planar_(planar) {}

    Box<3> bounds() const override { return bounds_; }
    Vec<3> at(const Vec<3>& x) const override {
        return tensors_.mainAxisAt(planar_ ? Vec<3>{{x[0], x[1], 0}} : x);
    }

private:
    PointTensors tensors_;
    Box<3> bounds_;
    bool planar_;
};

std::shared_ptr<const DirectionField> readTable(const std::string& file, double scale) {
    NumberTable table(file, kColumns);
    const PointColumns place(table);
    const bool planar = place.planar();
    const Columns direction = directionColumns(table, planar);
    const Columns tensor = tensorColumns(table, planar);
    if (direction.empty() == tensor.empty())
        table.failColumns(direction.empty() ? "neither direction nor stress"
                                            : "both direction and stress");
    const auto number = [&table](const std::optional<std::size_t>& column) {
        return column ? table.number(*column) : 0.0;
    };

    std::vector<PointTensors::Sample> samples;
    Box<3> points;
    double most = 0;
    while (table.nextRow()) {
        PointTensors::Sample s;
        s.x = place.point(table, scale);
        if (!direction.empty()) {
            const Vec<3> u{{number(direction[0]), number(direction[1]), number(direction[2])}};
            s.tensor = dyad(u);
            if (u == Vec<3>{}) table.failRow("direction (0, 0, 0) has no length; remove the row");
        } else {
            for (std::size_t c = 0; c < s.tensor.size(); ++c) s.tensor[c] = number(tensor[c]);
            if (!(magnitude(s.tensor) < kLargestStress))
                table.failRow("a stress exceeds 1e300; check the unit");
        }
        most = std::max(most, magnitude(s.tensor));
        points.add(s.x);
        samples.push_back(s);
    }
    if (samples.empty())
        throw InputError(fmt::format("{}: has no rows; give points as {}", file, kColumns));
    if (!(most > 0))
        throw InputError(file + ": all stresses are zero; give those of a loaded bone");
    return std::make_shared<TableField>(std::move(samples), coveredBy(points, planar), planar);
}

/// A field on the voxels of a grid; beyond them, that of the nearest.
class GridField : public DirectionField {
public:
    GridField(const std::string& file, double scale)
        : grid_(file, scale), beyond_(grid_.samples()) {}

    Box<3> bounds() const override { return grid_.bounds(); }

    Vec<3> at(const Vec<3>& x) const override {
        const auto tensor = grid_.at(x);
        return tensor ? mainAxis(*tensor) : beyond_.mainAxisAt(x);
    }

private:
    TensorGrid grid_;
    PointTensors beyond_;
};

}  // namespace

std::shared_ptr<const DirectionField> readDirectionField(const std::string& file, double scale) {
    if (!(scale > 0) || !std::isfinite(scale))
        throw ParameterError(fmt::format("{}: scale {} must be positive and finite", file, scale));
    const std::string extension = extensionOf(file);
    if (extension == ".vdb") return std::make_shared<GridField>(file, scale);
    if (extension == ".csv" || extension == ".tsv" || extension == ".txt")
        return readTable(file, scale);
    throw ParameterError(fmt::format(
        "{}: '{}' is not a type of direction field; give a .vdb file or a table as .csv", file,
        extension));
}

}  // namespace vdbpack
