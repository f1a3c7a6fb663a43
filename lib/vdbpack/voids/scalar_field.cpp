#include "vdbpack/voids/scalar_field.h"

#include "vdbpack/core/error.h"
#include "vdbpack/field/field_grids.h"
#include "vdbpack/io/number_table.h"
#include "vdbpack/io/text.h"
#include "vdbpack/voids/field_points.h"
#include "vdbpack/voids/table_lattice.h"
#include "vdbpack/voids/tensor_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace vdbpack {

namespace {

/// Numbers at scattered points, as the first component of tensors; the second is 1, so that a
/// number of zero counts.
class PointNumbers {
public:
    explicit PointNumbers(const std::vector<std::pair<Vec<3>, double>>& numbers)
        : tensors_(tensorsOf(numbers)) {}

    double at(const Vec<3>& x) const { return tensors_.at(x)[0]; }

private:
    static std::vector<PointTensors::Sample> tensorsOf(
        const std::vector<std::pair<Vec<3>, double>>& numbers) {
        std::vector<PointTensors::Sample> samples;
        samples.reserve(numbers.size());
        for (const auto& [x, number] : numbers) samples.push_back({x, {number, 1, 0, 0, 0, 0}});
        return samples;
    }
    PointTensors tensors_;
};

class TableNumbers : public ScalarField {
public:
    TableNumbers(const std::vector<std::pair<Vec<3>, double>>& numbers, const Box<3>& bounds,
                 bool planar)
        : nodes_(TableLattice::from(numbers)), bounds_(bounds), planar_(planar) {
        if (!nodes_) numbers_.emplace(numbers);
        least_ = most_ = numbers.front().second;
        Box<3> points;
        for (const auto& [x, number] : numbers) points.add(x);
        // Half the distance of points that are spread evenly.
        double space = 1;
        int axes = 0;
        for (int d = 0; d < 3; ++d)
            if (const double side = points.size()[d]; side > 0) space *= side, ++axes;
        const double each = space / static_cast<double>(numbers.size());
        const double half = nodes_ ? 0.5 * nodes_->step() : 0.5 * std::pow(each, 1.0 / axes);
        lattice_ = {numbers.front().first, axes > 0 ? half : 1};
        for (const auto& [x, number] : numbers) {
            least_ = std::min(least_, number);
            most_ = std::max(most_, number);
        }
    }
    Box<3> bounds() const override { return bounds_; }
    std::pair<Vec<3>, double> lattice() const override { return lattice_; }
    double at(const Vec<3>& x) const override {
        const Vec<3> point = planar_ ? Vec<3>{{x[0], x[1], 0}} : x;
        return nodes_ ? nodes_->at(point) : std::clamp(numbers_->at(point), least_, most_);
    }

private:
    std::optional<TableLattice> nodes_;
    std::optional<PointNumbers> numbers_;  // of points that are no lattice
    Box<3> bounds_;
    bool planar_;
    std::pair<Vec<3>, double> lattice_;
};

class GridNumbers : public ScalarField {
public:
    GridNumbers(const std::string& file, double scale, const ScalarMeaning& meaning)
        : grid_(file, scale,
                [&](double value) -> std::string {
                    if (!std::isfinite(value))
                        return fmt::format("{} {} is not finite; write the field again",
                                           meaning.name, value);
                    least_ = first_ ? value : std::min(least_, value);
                    most_ = first_ ? value : std::max(most_, value);
                    first_ = false;
                    return meaning.fault ? meaning.fault(value) : std::string();
                }),
          beyond_(grid_.samples()) {}

    Box<3> bounds() const override { return grid_.bounds(); }
    std::pair<Vec<3>, double> lattice() const override {
        return {grid_.samples().front().first, grid_.step()};
    }
    double at(const Vec<3>& x) const override {
        const auto number = grid_.at(x);
        return std::clamp(number ? *number : beyond_.at(x), least_, most_);
    }

private:
    bool first_ = true;  // initialized before the grid is read
    ScalarGrid grid_;
    PointNumbers beyond_;
};

std::shared_ptr<const ScalarField> readTable(const std::string& file, const ScalarMeaning& meaning,
                                             double scale) {
    const std::string expected = "x,y,z and " + meaning.columns.front();
    NumberTable table(file, expected);
    const PointColumns place(table);
    const std::size_t column = table.require(meaning.columns);
    std::vector<std::pair<Vec<3>, double>> numbers;
    Box<3> points;
    while (table.nextRow()) {
        const Vec<3> x = place.point(table, scale);
        const double number = table.number(column);
        if (const std::string wrong = meaning.fault ? meaning.fault(number) : std::string();
            !wrong.empty())
            table.failRow(
                fmt::format("at ({:.6g}, {:.6g}, {:.6g}) mm: {}", x[0], x[1], x[2], wrong));
        points.add(x);
        numbers.emplace_back(x, number);
    }
    if (numbers.empty())
        throw InputError(fmt::format("{}: has no rows; give points as {}", file, expected));
    return std::make_shared<TableNumbers>(numbers, coveredBy(points, place.planar()),
                                          place.planar());
}

}  // namespace

bool namesScalarField(const std::string& file) {
    const std::string extension = extensionOf(file);
    return extension == ".vdb" || extension == ".csv" || extension == ".tsv" || extension == ".txt";
}

std::shared_ptr<const ScalarField> readScalarField(const std::string& file,
                                                   const ScalarMeaning& meaning, double scale) {
    if (!(scale > 0) || !std::isfinite(scale))
        throw ParameterError(fmt::format("{}: scale {} must be positive and finite", file, scale));
    if (!namesScalarField(file))
        throw ParameterError(fmt::format(
            "{}: '{}' is not a type of field of {}; give a .vdb file or a table as .csv", file,
            extensionOf(file), meaning.name));
    if (extensionOf(file) == ".vdb") return std::make_shared<GridNumbers>(file, scale, meaning);
    return readTable(file, meaning, scale);
}

template <int Dim>
std::function<double(const Vec<Dim>&)> valuesOver(std::shared_ptr<const ScalarField> field,
                                                  const std::string& file,
                                                  const ScalarMeaning& meaning,
                                                  const Box<Dim>& bounds, double sliceHeight) {
    requireCovered(file + ": the field of " + meaning.name, field->bounds(), bounds, sliceHeight);
    return [field = std::move(field), sliceHeight](const Vec<Dim>& x) {
        Vec<3> at{{0, 0, sliceHeight}};
        for (int d = 0; d < Dim; ++d) at[d] = x[d];
        return field->at(at);
    };
}

template std::function<double(const Vec<2>&)> valuesOver(std::shared_ptr<const ScalarField>,
                                                         const std::string&, const ScalarMeaning&,
                                                         const Box<2>&, double);
template std::function<double(const Vec<3>&)> valuesOver(std::shared_ptr<const ScalarField>,
                                                         const std::string&, const ScalarMeaning&,
                                                         const Box<3>&, double);

}  // namespace vdbpack
