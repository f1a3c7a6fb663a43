#include "vdbpack/domain/domain_text.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/box_planes.h"
#include "vdbpack/io/numbers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <string_view>
#include <utility>

namespace vdbpack {

namespace {

/// @param what  as messages name it: "`clips` 'box:1'".
[[noreturn]] void malformed(const std::string& what, const char* form) {
    throw ParameterError(
        fmt::format("{} is malformed; write {}, lengths in mm, decimals with a point", what, form));
}

/// The finite numbers in "a,b,c". @throws ParameterError showing `form`.
std::vector<double> numbersIn(const std::string& what, const std::string& list, const char* form) {
    auto values = parseNumberList(list);
    if (!values) malformed(what, form);
    return std::move(*values);
}

template <int Dim>
Box<Dim> boxFrom(const std::string& what, const std::vector<double>& v, const char* form) {
    Box<Dim> box;
    if (v.size() != Dim && v.size() != 2 * Dim) malformed(what, form);
    for (int d = 0; d < Dim; ++d) {
        const auto at = static_cast<std::size_t>(d);
        if (v.size() == Dim && !(v[at] > 0))
            throw ParameterError(
                fmt::format("{}: the length along {} is {:g} mm; give positive lengths", what,
                            "xyz"[d], v[at]));
        box.lo[d] = v.size() == Dim ? -v[at] / 2 : v[at];
        box.hi[d] = v.size() == Dim ? v[at] / 2 : v[at + Dim];
    }
    return box;
}

[[noreturn]] void malformedAxes(const std::string& axes, const char* all) {
    throw ParameterError(
        fmt::format("`periodic` '{}' is malformed; write each axis once: {}", axes, all));
}

template <int Dim>
std::shared_ptr<const Domain<Dim>> boxWith(const Box<Dim>& box, const std::array<bool, 3>& wraps) {
    PeriodicCell<Dim> cell{box, {}};
    std::copy_n(wraps.begin(), Dim, cell.wraps.begin());
    return cell.any() ? periodicDomain<Dim>(cell) : boxDomain<Dim>(box);
}

NamedShape periodicShape(const std::string& what, const std::string& lengths) {
    const char* form =
        "periodic:LX,LY,LZ or periodic:LX,LY (for other corners box:x0,y0,z0,x1,y1,z1 and "
        "`periodic` xyz)";
    const auto v = numbersIn(what, lengths, form);
    NamedShape shape;
    shape.wraps = {true, true, v.size() == 3};
    if (v.size() == 3) {
        shape.box = boxFrom<3>(what, v, form);
        shape.space = boxWith<3>(shape.box, shape.wraps);
    } else {
        if (v.size() != 2) malformed(what, form);
        shape.kind = NamedShape::Kind::rect;
        shape.rect = boxFrom<2>(what, v, form);
        shape.plane = boxWith<2>(shape.rect, shape.wraps);
    }
    return shape;
}

}  // namespace

const char* const kShapeForms =
    "box:LX,LY,LZ, box:x0,y0,z0,x1,y1,z1, ball:R, cylinder:R,H, rect:W,H, rect:x0,y0,x1,y1, "
    "disc:R, periodic:LX,LY,LZ or periodic:LX,LY";

bool namesUnknownShape(const std::string& text) {
    const auto colon = text.find(':');
    const bool word = colon != std::string::npos && colon > 0 &&
                      std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(colon),
                                  [](unsigned char c) { return std::isalpha(c) != 0; });
    return word && parseNumberList(text.substr(colon + 1)) && !parseShape(text);
}

Clip parseClip(const std::string& text) {
    const char* form = "box:x0,y0,z0,x1,y1,z1 or plane:nx,ny,nz,d (keeps n.x <= d)";
    const std::string what = fmt::format("`clips` '{}'", text);
    const auto colon = text.find(':');
    const std::string kind = text.substr(0, colon);
    if (colon == std::string::npos || (kind != "box" && kind != "plane")) malformed(what, form);
    const auto v = numbersIn(what, text.substr(colon + 1), form);
    if (kind == "box") return {text, halfSpacesOf(boxFrom<3>(what, v, form))};
    if (v.size() != 4) malformed(what, form);
    return {text, {{{{v[0], v[1], v[2]}}, v[3]}}};
}

double parseSlice(const std::string& text) {
    const std::string what = fmt::format("`slice` '{}'", text);
    if (text.rfind("x=", 0) == 0 || text.rfind("y=", 0) == 0)
        throw ParameterError(what +
                             ": a slice is a plane z = V; turn the domain with `rotate` first");
    if (text.rfind("z=", 0) != 0) malformed(what, "z=V");
    const auto v = numbersIn(what, text.substr(2), "z=V");
    if (v.size() != 1) malformed(what, "z=V");
    return v[0];
}

std::array<bool, 3> parseAxes(const std::string& text) {
    std::array<bool, 3> axes{};
    for (const char c : text) {
        const auto at = std::string_view("xyz").find(c);
        if (at == std::string_view::npos || axes[at])
            malformedAxes(text, "x, y, z, xy, xz, yz or xyz");
        axes[at] = true;
    }
    if (text.empty()) malformedAxes(text, "x, y, z, xy, xz, yz or xyz");
    return axes;
}

std::string textOf(const std::array<bool, 3>& axes) {
    std::string text;
    for (std::size_t d = 0; d < 3; ++d)
        if (axes[d]) text += "xyz"[d];
    return text;
}

Cavities parseCavities(const std::string& text) {
    Cavities choice;
    if (text == "keep") return choice;
    if (text == "fill") {
        choice.fill = true;
        return choice;
    }
    const std::string outer = "outer=", inner = "inner=";
    std::string rest = text;
    if (rest.rfind(outer, 0) == 0) {
        const auto end = rest.find("," + inner);
        choice.outer =
            rest.substr(outer.size(), end == std::string::npos ? end : end - outer.size());
        rest = end == std::string::npos ? "" : rest.substr(end + 1);
    }
    if (rest.rfind(inner, 0) == 0) choice.inner = rest.substr(inner.size());
    if (choice.inner.empty() || (text.rfind(outer, 0) == 0 && choice.outer.empty()))
        throw ParameterError("`cavities` " + text +
                             ": write keep, fill, inner=FILE or outer=FILE,inner=FILE");
    return choice;
}

std::string textOf(const Cavities& cavities) {
    if (cavities.fill) return "fill";
    if (cavities.inner.empty()) return {};
    const std::string inner = "inner=" + cavities.inner;
    return cavities.outer.empty() ? inner : "outer=" + cavities.outer + ',' + inner;
}

std::string textOf(const Vec<3>& spacing) {
    return fmt::format("{}", fmt::join(spacing.c, ","));
}

std::vector<double> parseCounted(const std::string& setting, const std::string& text,
                                 const char* form, std::initializer_list<std::size_t> counts) {
    const std::string what = fmt::format("`{}` '{}'", setting, text);
    auto numbers = numbersIn(what, text, form);
    if (std::find(counts.begin(), counts.end(), numbers.size()) == counts.end())
        malformed(what, form);
    return numbers;
}

std::vector<double> parseRotation(const std::string& text) {
    auto r = parseCounted("rotate", text, "X,Y,Z,DEGREES or X,Y,Z,DEGREES,CX,CY,CZ", {4, 7});
    if (r[0] == 0 && r[1] == 0 && r[2] == 0)
        throw ParameterError("`rotate` " + text +
                             ": the axis has no direction; give one such as "
                             "0,0,1,90, a quarter turn about z");
    r.resize(7, 0.0);
    return r;
}

std::vector<double> parseMatrix(const std::string& text) {
    auto m = parseCounted("matrix", text, "3 or 4 rows of 4 numbers", {12, 16});
    if (m.size() == 16 && (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1))
        throw ParameterError("`matrix` " + text +
                             ": its last row must be 0,0,0,1, and its shift "
                             "is the last column");
    m.resize(12);
    return m;
}

Vec<3> parseVoxelSpacing(const std::string& text) {
    const std::string what = fmt::format("`voxelSpacing` '{}'", text);
    const char* form = "X,Y,Z or a single distance, above 0";
    auto v = numbersIn(what, text, form);
    if (v.size() == 1) v.resize(3, v.front());
    if (v.size() != 3 || !(v[0] > 0 && v[1] > 0 && v[2] > 0)) malformed(what, form);
    return {{v[0], v[1], v[2]}};
}

std::optional<NamedShape> parseShape(const std::string& text, const std::array<bool, 3>& periodic) {
    const auto colon = text.find(':');
    if (colon == std::string::npos) return std::nullopt;
    const std::string kind = text.substr(0, colon), rest = text.substr(colon + 1);
    const std::string what = fmt::format("'{}'", text);
    NamedShape shape;
    if (const std::string axes = textOf(periodic); !axes.empty() && kind != "box" && kind != "rect")
        throw ParameterError(fmt::format(
            "`periodic` {}: {} is {}; it is for box: and rect:", axes, what,
            kind == "periodic" ? "periodic along all axes already" : "no box and no rectangle"));
    if (kind == "periodic") return periodicShape(what, rest);
    if (kind == "box") {
        const char* form = "box:LX,LY,LZ or box:x0,y0,z0,x1,y1,z1";
        shape.kind = NamedShape::Kind::box;
        shape.box = boxFrom<3>(what, numbersIn(what, rest, form), form);
        shape.wraps = periodic;
        shape.space = boxWith<3>(shape.box, shape.wraps);
    } else if (kind == "rect") {
        const char* form = "rect:W,H or rect:x0,y0,x1,y1";
        shape.kind = NamedShape::Kind::rect;
        shape.rect = boxFrom<2>(what, numbersIn(what, rest, form), form);
        if (periodic[2]) malformedAxes(textOf(periodic), "x, y or xy");
        shape.wraps = periodic;
        shape.plane = boxWith<2>(shape.rect, shape.wraps);
    } else if (kind == "cylinder") {
        const auto v = numbersIn(what, rest, "cylinder:R,H");
        if (v.size() != 2) malformed(what, "cylinder:R,H");
        shape.kind = NamedShape::Kind::cylinder;
        shape.radius = v[0];
        shape.height = v[1];
        shape.space = cylinderDomain(v[0], v[1]);
    } else if (kind == "ball" || kind == "disc") {
        const char* form = kind == "ball" ? "ball:R" : "disc:R";
        const auto v = numbersIn(what, rest, form);
        if (v.size() != 1) malformed(what, form);
        shape.radius = v[0];
        if (kind == "ball") {
            shape.kind = NamedShape::Kind::ball;
            shape.space = ballDomain<3>(v[0]);
        } else {
            shape.kind = NamedShape::Kind::disc;
            shape.plane = ballDomain<2>(v[0]);
        }
    } else {
        return std::nullopt;
    }
    return shape;
}

}  // namespace vdbpack
