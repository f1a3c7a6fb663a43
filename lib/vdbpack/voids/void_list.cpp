#include "vdbpack/voids/void_list.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/number_table.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/stated_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace vdbpack {

namespace {

constexpr const char* kListColumns = "x,y,z,a,b,theta_z,theta_x,ux,uy,uz,id";
constexpr double kAngleTolerance = 1e-3;  ///< rad; the precision of tables with four digits

/// The columns that define the axis.
struct AxisColumns {
    std::optional<std::size_t> thetaZ, thetaX;
    std::vector<std::size_t> direction;  ///< ux, uy and, if present, uz; or empty
};

template <int Dim>
AxisColumns axisColumns(const NumberTable& table) {
    AxisColumns columns;
    columns.thetaZ = table.find({"thetaz", "tz", "θz"});
    columns.thetaX = table.find({"thetax", "tx", "θx"});
    if (columns.thetaZ.has_value() != columns.thetaX.has_value())
        table.failColumns("only one of 'theta_z' and 'theta_x'");
    if (table.find({"ux"}) || table.find({"uy"}) || table.find({"uz"})) {
        columns.direction = {table.require({"ux"}), table.require({"uy"})};
        const auto uz = Dim == 3 ? table.require({"uz"}) : table.find({"uz"});
        if (uz) columns.direction.push_back(*uz);
    }
    return columns;
}

/// `v` scaled to length one; unchanged, bit for bit, if its length is one up to rounding.
template <int Dim>
Vec<Dim> unit(const Vec<Dim>& v) {
    if (std::fabs(squaredLength(v) - 1) < 4e-15) return v;
    double most = 0;
    for (const double c : v.c) most = std::max(most, std::fabs(c));
    // The reciprocal of a smaller number overflows.
    if (most > 0 && most < 1e-290) return unit(v * 1e290);
    return most > 0 ? normalized(v * (1 / most)) : v;
}

/// The axis of the row's void, or nothing if the row does not define it.
template <int Dim>
std::optional<Vec<Dim>> readAxis(const NumberTable& table, const AxisColumns& columns,
                                 bool isBall) {
    const auto filled = [&table](std::size_t column) { return table.filled(column); };
    const auto& direction = columns.direction;
    std::optional<Vec<3>> axis;
    if (std::any_of(direction.begin(), direction.end(), filled)) {
        Vec<3> u;
        for (std::size_t d = 0; d < direction.size(); ++d) u.c[d] = table.number(direction[d]);
        if (u != Vec<3>{})
            axis = unit(u);
        else if (!isBall)
            table.failRow("direction (0, 0, 0) has no length; give the axis of the void");
    }
    if (columns.thetaZ && (filled(*columns.thetaZ) || filled(*columns.thetaX))) {
        const double thetaZ = table.number(*columns.thetaZ), thetaX = table.number(*columns.thetaX);
        const Vec<3> turned = axisOf(thetaZ, thetaX);
        if (axis && !isBall && length(cross(*axis, turned)) > kAngleTolerance)
            table.failRow(fmt::format(
                "direction ({:.6g}, {:.6g}, {:.6g}) and angles theta_z {:.6g}, theta_x {:.6g} rad "
                "({:.6g}, {:.6g}, {:.6g}) differ; correct one or leave it out",
                (*axis)[0], (*axis)[1], (*axis)[2], thetaZ, thetaX, turned[0], turned[1],
                turned[2]));
        if (!axis) axis = turned;
    }
    if (!axis) return std::nullopt;
    if constexpr (Dim == 3) {
        return *axis;
    } else {
        if (std::fabs((*axis)[2]) <= kAngleTolerance) return unit(Vec<2>{{(*axis)[0], (*axis)[1]}});
        if (!isBall)
            table.failRow(
                fmt::format("axis ({:.6g}, {:.6g}, {:.6g}) leaves the plane; voids of the plane "
                            "have uz = 0 and theta_x = pi/2",
                            (*axis)[0], (*axis)[1], (*axis)[2]));
        return std::nullopt;
    }
}

template <int Dim>
void appendRow(std::string& text, const Ellipsoid<Dim>& e, double unitLength, double sliceHeight) {
    Vec<3> center{{0, 0, sliceHeight}}, axis;
    for (int d = 0; d < Dim; ++d) {
        center[d] = e.center[d];
        axis[d] = e.axis[d];
    }
    const double across = std::hypot(axis[0], axis[1]);
    const double thetaZ = across > 0 ? std::atan2(axis[0], -axis[1]) : 0;
    const double thetaX = std::atan2(across, axis[2]);
    for (const double mm : {center[0], center[1], center[2], e.a, e.b}) {
        appendNumber(text, mm / unitLength);
        text += ',';
    }
    for (const double value : {thetaZ, thetaX, axis[0], axis[1], axis[2]}) {
        appendNumber(text, value);
        text += ',';
    }
    text += std::to_string(e.id) + '\n';
}

/// Millimeters in the unit that a comment above the table states; 1 if none does.
double statedScale(const std::string& path) {
    InputFile file(path);
    std::string_view line;
    while (file.nextLine(line) && line.substr(0, 1) == "#")
        if (const auto unit = statedUnit(line)) return millimetersPer(*unit);
    return 1;
}

/// The number of the row's void; without a column for it, that of the row.
std::uint32_t readId(const NumberTable& table, const std::optional<std::size_t>& column,
                     std::size_t row) {
    if (!column) return static_cast<std::uint32_t>(row);
    const double id = table.number(*column);
    if (!(id >= 0 && id < 0x1p32 && id == std::floor(id)))
        table.failRow(fmt::format("id {} is no whole number from 0 to 2^32 - 1; correct it", id));
    return static_cast<std::uint32_t>(id);
}

}  // namespace

template <int Dim>
std::vector<Ellipsoid<Dim>> readVoidList(const std::string& file, double scale) {
    if (!(scale > 0) || !std::isfinite(scale))
        throw ParameterError(fmt::format("{}: scale {} must be positive and finite", file, scale));
    NumberTable table(file, kListColumns);
    scale *= statedScale(file);
    std::vector<std::size_t> center{table.require({"x"}), table.require({"y"})};
    if (Dim == 3) center.push_back(table.require({"z"}));
    const std::size_t a = table.require({"a"}), b = table.require({"b"});
    const AxisColumns columns = axisColumns<Dim>(table);
    const auto id = table.find({"id"});

    std::vector<Ellipsoid<Dim>> voids;
    while (table.nextRow()) {
        Ellipsoid<Dim> e;
        for (std::size_t d = 0; d < Dim; ++d) e.center.c[d] = table.number(center[d]) * scale;
        e.a = table.number(a) * scale;
        e.b = table.number(b) * scale;
        if (!(e.a > 0) || !(e.b > 0) || !std::isfinite(e.a) || !std::isfinite(e.b))
            table.failRow(fmt::format(
                "half-axes a = {} and b = {} must be positive; correct or remove the row",
                table.number(a), table.number(b)));
        if (!isFinite(e.center)) table.failRow("center is not finite in mm; check the unit");
        const auto axis = readAxis<Dim>(table, columns, e.a == e.b);
        if (!axis && e.a != e.b)
            table.failRow(
                fmt::format("a = {} and b = {} differ, but the direction of a is missing; give "
                            "theta_z,theta_x or ux,uy,uz",
                            table.number(a), table.number(b)));
        e.axis[Dim == 3 ? 2 : 0] = 1;
        if (axis) e.axis = *axis;
        e.id = readId(table, id, voids.size());
        voids.push_back(e);
    }
    return voids;
}

template <int Dim>
std::string voidListText(const std::vector<Ellipsoid<Dim>>& voids, Unit unit, double sliceHeight) {
    std::string text;
    if (unit != Unit::millimeter) text = fmt::format("# {}{}\n", kUnitComment, unitName(unit));
    text += std::string(kListColumns) + '\n';
    for (const auto& e : voids) appendRow(text, e, millimetersPer(unit), sliceHeight);
    return text;
}

template <int Dim>
void writeVoidList(const std::vector<Ellipsoid<Dim>>& voids, const std::string& file, Unit unit,
                   double sliceHeight) {
    OutputFile out(file);
    out.write(voidListText(voids, unit, sliceHeight));
    out.commit();
}

template std::vector<Ellipsoid<2>> readVoidList<2>(const std::string&, double);
template std::vector<Ellipsoid<3>> readVoidList<3>(const std::string&, double);
template std::string voidListText<2>(const std::vector<Ellipsoid<2>>&, Unit, double);
template std::string voidListText<3>(const std::vector<Ellipsoid<3>>&, Unit, double);
template void writeVoidList<2>(const std::vector<Ellipsoid<2>>&, const std::string&, Unit, double);
template void writeVoidList<3>(const std::vector<Ellipsoid<3>>&, const std::string&, Unit, double);

}  // namespace vdbpack
