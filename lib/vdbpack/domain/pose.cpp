#include "vdbpack/domain/pose.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbpack {

namespace {

/// The map that applies `first`, then `second`.
AffineMap inTurn(const AffineMap& first, const AffineMap& second) {
    AffineMap both;
    for (std::size_t i = 0; i < 3; ++i) {
        both.rows[i] = {};
        for (std::size_t k = 0; k < 3; ++k) both.rows[i] += second.rows[i].c[k] * first.rows[k];
    }
    both.shift = second(first.shift);
    return both;
}

/// @throws InputError for a map that flattens. @param where  for messages
AffineMap inverse(const AffineMap& map, const std::string& where) {
    const double determinant = map.determinant();
    if (!(std::fabs(determinant) > 1e-12))
        throw InputError(where + ": its determinant is 0, it flattens space; give a rigid one");
    const auto& [a, b, c] = map.rows;
    const Vec<3> columns[] = {cross(b, c), cross(c, a), cross(a, b)};
    AffineMap back;
    for (int i = 0; i < 3; ++i)
        back.rows[static_cast<std::size_t>(i)] =
            Vec<3>{{columns[0][i], columns[1][i], columns[2][i]}} * (1 / determinant);
    back.shift = -back.turned(map.shift);
    return back;
}

/// The numbers behind the colon of a line.
std::vector<double> numbersBehind(std::string_view line, std::size_t count, const InputFile& file) {
    std::vector<double> numbers;
    Words words(line.substr(line.find(':') + 1));
    double number = 0;
    for (auto word = words.next(); !word.empty(); word = words.next())
        if (parseReal(word, number) && std::isfinite(number)) numbers.push_back(number);
    if (numbers.size() != count)
        file.failAtLine(fmt::format("has {} numbers, {} are needed", numbers.size(), count));
    return numbers;
}

/// The map of a text file of ITK with one linear transform, as it stands there.
AffineMap readTransform(const std::string& path) {
    InputFile file(path);
    std::string_view line;
    const auto fail = [&](const std::string& what) {
        throw InputError(fmt::format(
            "{}: {}; save a linear transform as text (.tfm) with 3D Slicer", path, what));
    };
    if (!file.nextLine(line) || !startsWith(line, "#Insight Transform File"))
        fail("is no text file of an ITK transform");
    std::string type;
    std::vector<double> p, center(3, 0.0);
    while (file.nextLine(line)) {
        if (startsWith(line, "Transform:")) {
            if (!type.empty()) fail("has several transforms");
            type = trimmed(line.substr(line.find(':') + 1));
            const bool isAffine = startsWith(type, "AffineTransform_") ||
                                  startsWith(type, "MatrixOffsetTransformBase_");
            if (!isAffine || !endsWith(type, "_3_3")) fail("holds a " + type);
        } else if (startsWith(line, "Parameters:")) {
            p = numbersBehind(line, 12, file);
        } else if (startsWith(line, "FixedParameters:")) {
            center = numbersBehind(line, 3, file);
        }
    }
    if (type.empty() || p.empty()) fail("has no transform or no parameters");
    AffineMap map;
    map.rows = {{{{p[0], p[1], p[2]}}, {{p[3], p[4], p[5]}}, {{p[6], p[7], p[8]}}}};
    const Vec<3> c{{center[0], center[1], center[2]}};
    map.shift = Vec<3>{{p[9], p[10], p[11]}} + c - map.turned(c);
    return map;
}

AffineMap ofMatrix(const std::vector<double>& m) {
    AffineMap map;
    for (std::size_t i = 0; i < 3; ++i) {
        map.rows[i] = {{m[4 * i], m[4 * i + 1], m[4 * i + 2]}};
        map.shift.c[i] = m[4 * i + 3];
    }
    return map;
}

/// @param r  axis, degrees, point
AffineMap ofRotation(const std::vector<double>& r) {
    const Vec<3> axis = normalized(Vec<3>{{r[0], r[1], r[2]}}), about{{r[4], r[5], r[6]}};
    const double angle = r[3] * 3.14159265358979323846 / 180;
    // Right angles are exact.
    const double c = std::remainder(r[3], 90) == 0 ? std::round(std::cos(angle)) : std::cos(angle);
    const double s = std::remainder(r[3], 90) == 0 ? std::round(std::sin(angle)) : std::sin(angle);
    AffineMap map;
    for (int i = 0; i < 3; ++i) {
        Vec<3> unit;
        unit[i] = 1;
        // A row of the matrix is a base vector turned back.
        map.rows[static_cast<std::size_t>(i)] =
            c * unit - s * cross(axis, unit) + (1 - c) * axis[i] * axis;
    }
    map.shift = about - map.turned(about);
    return map;
}

/// Warns of a map that changes the shape of what it moves. @param what  for messages
void warnOfShape(const AffineMap& map, const std::string& what, const Callbacks& callbacks) {
    constexpr double kSame = 1e-4;
    const double determinant = map.determinant(), scale = std::cbrt(std::fabs(determinant));
    double shear = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            shear = std::max(shear, std::fabs(dot(map.rows[i], map.rows[k]) / (scale * scale) -
                                              (i == k ? 1 : 0)));
    if (shear > kSame)
        callbacks.warn(what + " is not rigid: it shears, or scales the axes differently");
    else if (std::fabs(scale - 1) > kSame)
        callbacks.warn(fmt::format("{} multiplies all lengths by {:.6g}", what, scale));
    if (determinant < 0) callbacks.warn(what + " mirrors: right becomes left");
}

}  // namespace

AffineMap poseMap(const DomainRecipe& recipe, const Callbacks& callbacks) {
    const Pose& pose = recipe.pose;
    AffineMap map;
    if (!pose.file.empty() && !pose.matrix.empty())
        throw ParameterError("`matrix` and `transform`: a domain has one of them");
    if (!pose.file.empty()) {
        map = inverse(readTransform(pose.file), pose.file);
        for (std::size_t i = 0; recipe.space == ImageSpace::ras && i < 3; ++i) {
            if (i < 2) map.shift.c[i] *= -1;
            for (std::size_t k = 0; k < 3; ++k)
                if ((i < 2) != (k < 2)) map.rows[i].c[k] *= -1;
        }
    }
    if (!pose.matrix.empty()) map = ofMatrix(pose.matrix);
    const std::string what = recipe.source + ": " + (pose.file.empty() ? "`matrix`" : pose.file);
    (void)inverse(map, what);
    warnOfShape(map, what, callbacks);
    if (!pose.rotate.empty()) map = inTurn(map, ofRotation(pose.rotate));
    if (pose.translate) map.shift += *pose.translate;
    return map;
}

void place(TriangleMesh& mesh, const DomainRecipe& recipe, const Callbacks& callbacks) {
    if (!recipe.pose.any()) return;
    const AffineMap map = poseMap(recipe, callbacks);
    for (Vec<3>& vertex : mesh.vertices) vertex = map(vertex);
    if (map.determinant() < 0)
        for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

void place(ImageGrid& grid, const DomainRecipe& recipe, const Callbacks& callbacks) {
    if (!recipe.pose.any()) return;
    const AffineMap map = poseMap(recipe, callbacks);
    grid.origin = map(grid.origin);
    for (Vec<3>& step : grid.step) step = map.turned(step);
}

}  // namespace vdbpack
