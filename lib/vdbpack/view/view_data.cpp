#include "vdbpack/view/view_data.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/preview/scene.h"
#include "vdbpack/preview/sphere_colors.h"
#include "vdbpack/report/markup.h"
#include "vdbpack/report/report.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <string_view>
#include <type_traits>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kMost = 65534;  // of 16 bits; the last one stands for no number
constexpr double kMostWhole = 4294967295;
constexpr int kRampColors = 256;
const std::array<std::string, 5> kColorNames{"radius", "radius", "region", "depth", "order"};

std::string packedWords(const std::vector<std::uint32_t>& numbers) {
    const bool wide =
        std::any_of(numbers.begin(), numbers.end(), [](auto n) { return n >> 16 != 0; });
    std::string bytes;
    for (const std::uint32_t n : numbers)
        for (int shift = 0; shift < (wide ? 32 : 16); shift += 8)
            bytes += static_cast<char>(n >> shift & 255);
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    std::string packed(size, '\0');
    if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                  reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()),
                  Z_DEFAULT_COMPRESSION) != Z_OK)
        throw ResourceError("a view cannot be compressed: too little memory");
    packed.resize(size);
    return base64(packed);
}

Vec<3> inSpace(const Vec<3>& x) {
    return x;
}
Vec<3> inSpace(const Vec<2>& x) {
    return {{x[0], x[1], 0}};
}

/// Rows of the pack in order: all, or a random subset that is the same each time.
std::vector<std::uint32_t> shownRows(std::size_t count, std::size_t most) {
    std::vector<std::uint32_t> rows;
    RandomStream random(1, 0);
    for (std::size_t i = 0; i < count && rows.size() < most; ++i)
        if (random.uniform() * static_cast<double>(count - i) <
            static_cast<double>(most - rows.size()))
            rows.push_back(static_cast<std::uint32_t>(i));
    return rows;
}

/// x, y and z of points.
template <class Points>
Json packedPoints(const Points& points) {
    Json parts = Json::array();
    for (int d = 0; d < 3; ++d) {
        std::vector<double> values;
        values.reserve(points.size());
        for (const auto& p : points) values.push_back(inSpace(p)[d]);
        parts.push_back(packedNumbers(values));
    }
    return parts;
}

/// The spheres' x, y, z and radii; if not all are shown, their rows, each less the last one.
template <int Dim>
void addSpheres(const std::vector<Sphere<Dim>>& all, const std::vector<std::uint32_t>& rows,
                Json& facts, std::string& words) {
    std::vector<Vec<Dim>> centers;
    std::vector<double> radii;
    for (const std::uint32_t row : rows) {
        centers.push_back(all[row].center);
        radii.push_back(all[row].radius);
    }
    Json parts = packedPoints(centers);
    double rounding = 0;
    for (const Json& part : parts)
        if (!part["whole"]) rounding = std::max(rounding, part["step"].get<double>());
    if (rounding > 0) words += fmt::format("Positions are rounded to {:.1g} mm. ", rounding);
    parts.push_back(packedNumbers(radii));
    facts["spheres"] = std::move(parts);
    if (rows.size() == all.size()) return;
    std::vector<double> steps(rows.size());
    std::adjacent_difference(rows.begin(), rows.end(), steps.begin());
    facts["rows"] = packedNumbers(steps);
    words += fmt::format("{} of {} {} are shown, chosen at random. ", grouped(rows.size()),
                         grouped(all.size()), Measure<Dim>::kSpheres);
}

/// Red, green and blue of colors, each 0 to 255.
Json bytesOf(const std::vector<std::uint32_t>& colors) {
    Json bytes = Json::array();
    for (const std::uint32_t c : colors) bytes.push_back({c >> 16, c >> 8 & 255, c & 255});
    return bytes;
}

/// Colors from dark to light, for values from the least to the greatest.
Json ramp() {
    Json bytes = Json::array();
    for (int i = 0; i < kRampColors; ++i) {
        std::array<std::uint8_t, 3> c{};
        toSrgb(rampColor(static_cast<double>(i) / (kRampColors - 1)), c.data());
        bytes.push_back(c);
    }
    return bytes;
}

/// A column of numbers. Numbers that differ from the rows by a constant, such as ids, have no data;
/// regions and small whole numbers have a name and a color each.
template <class Value>
Json columnOf(const std::string& name, const std::vector<Value>& all,
              const std::vector<std::uint32_t>& rows) {
    std::vector<double> values;
    for (const std::uint32_t row : rows) values.push_back(static_cast<double>(all[row]));
    Json column{{"name", name}, {"unit", std::is_same_v<Value, float> ? "mm" : ""}};
    const double shift = values.front() - rows.front();
    if (std::equal(values.begin(), values.end(), rows.begin(),
                   [&](double v, std::uint32_t row) { return v == row + shift; }))
        column.update({{"lo", shift}, {"step", 1}, {"whole", true}});
    else
        column.update(packedNumbers(values));
    if (name == "region" && *std::max_element(values.begin(), values.end()) == 1) {
        column["names"] = {"cortical", "trabecular"};
        column["colors"] = bytesOf(regionColors());
    } else if (std::is_same_v<Value, double> && areKinds(values)) {
        for (std::size_t k = 0; k < kFewKinds; ++k) column["names"].push_back(std::to_string(k));
        column["colors"] = bytesOf(kindColors(kFewKinds));
    }
    return column;
}

/// Shows the names of what numbers stand for, where each number has one.
void nameKinds(const Column& column, Json& facts) {
    const auto isNamed = [&](double v) {
        return v >= 0 && v < static_cast<double>(column.names.size()) && v == std::floor(v);
    };
    if (!std::all_of(column.numbers.begin(), column.numbers.end(), isNamed)) return;
    facts["names"] = column.names;
    facts["colors"] = bytesOf(kindColors(column.names.size()));
}

/// A column of texts: their indices in `names`.
Json columnOf(const std::string& name, const std::vector<std::string>& texts,
              const std::vector<std::uint32_t>& rows) {
    std::map<std::string, double> known;
    std::vector<double> indices;
    for (const std::uint32_t row : rows)
        indices.push_back(known.emplace(texts[row], known.size()).first->second);
    std::vector<std::string> names(known.size());
    for (const auto& [text, index] : known) names[static_cast<std::size_t>(index)] = text;
    Json column{{"name", name}, {"unit", ""}};
    column.update(packedNumbers(indices));
    column["colors"] = bytesOf(kindColors(names.size()));
    column["names"] = std::move(names);
    return column;
}

/// The columns of the pack as far as there is room.
template <int Dim>
void addColumns(const Pack<Dim>& pack, const std::vector<std::uint32_t>& rows, std::size_t most,
                Json& facts, std::string& words) {
    std::size_t bytes = facts["spheres"].dump().size();
    Json& columns = facts["columns"] = Json::array();
    std::string leftOut;
    forEachAttribute(pack, [&](std::string_view name, const auto& values) {
        if (values.size() != pack.spheres.size()) return;
        Json column = columnOf(std::string(name), values, rows);
        for (const Column& own : pack.columns)
            if (name == own.name && !own.names.empty()) nameKinds(own, column);
        const std::size_t more = column.dump(-1, ' ', false, Json::error_handler_t::replace).size();
        if (bytes + more > most) {
            leftOut += (leftOut.empty() ? "" : ", ") + std::string(name);
            return;
        }
        bytes += more;
        columns.push_back(std::move(column));
    });
    if (!leftOut.empty()) words += "Not in this page, which would be too large: " + leftOut + ". ";
}

/// The wall as triangles.
void addWall(const ViewScene<3>& scene, const ViewOptions& options, Json& facts,
             std::string& words) {
    if (!scene.wall) return;
    const TriangleMesh& mesh = *scene.wall;
    if (mesh.triangles.size() > options.mostTriangles) {
        words +=
            fmt::format("The wall, of {} triangles, is left out. ", grouped(mesh.triangles.size()));
        return;
    }
    if (scene.wallVoxel > 0)
        words +=
            fmt::format("The wall is shown as a contour in voxels of {:.2g} mm. ", scene.wallVoxel);
    std::vector<double> corners;
    for (const auto& t : mesh.triangles) corners.insert(corners.end(), t.begin(), t.end());
    facts["wall"] = {{"points", packedPoints(mesh.vertices)}, {"corners", packedNumbers(corners)}};
}

/// Names, colors and numbers of corners of the solids that the wall surrounds.
void addSolids(const std::vector<std::pair<std::string, std::size_t>>& solids, Json& facts) {
    facts["columns"] = Json::array();
    Json& all = facts["solids"] = Json::array();
    const Json colors = bytesOf(kindColors(solids.size()));
    for (const auto& [name, triangles] : solids)
        all.push_back({{"name", name}, {"corners", 3 * triangles}, {"color", colors[all.size()]}});
}

/// The zero line of a field as line segments, two ends each, mm (marching squares).
std::vector<Vec<2>> contourLines(const PlaneField& field) {
    std::vector<Vec<2>> ends;
    const auto distance = [&](std::int64_t i, std::int64_t j) {
        return static_cast<double>(field.distance[static_cast<std::size_t>(j * field.columns + i)]);
    };
    for (std::int64_t j = 0; j + 1 < field.rows; ++j)
        for (std::int64_t i = 0; i + 1 < field.columns; ++i) {
            // The corners of a cell in turn around it. Of four crossings, each line joins two that
            // follow one another.
            const std::array<std::array<std::int64_t, 2>, 4> corners{
                {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}}};
            for (std::size_t k = 0; k < 4; ++k) {
                const auto &a = corners[k], &b = corners[(k + 1) % 4];
                const double da = distance(a[0], a[1]), db = distance(b[0], b[1]);
                if ((da < 0) == (db < 0)) continue;
                const auto along = [&, t = da / (da - db)](std::size_t d) {
                    return (static_cast<double>(a[d]) + t * static_cast<double>(b[d] - a[d])) *
                           field.step;
                };
                ends.push_back(field.origin + Vec<2>{{along(0), along(1)}});
            }
        }
    return ends;
}

/// The wall as ends of line segments.
void addWall(const ViewScene<2>& scene, const ViewOptions&, Json& facts, std::string&) {
    if (!scene.field) return;
    const std::vector<Vec<2>> ends = contourLines(*scene.field);
    if (!ends.empty()) facts["wall"] = {{"points", packedPoints(ends)}};
}

/// Around all that is shown.
template <int Dim>
Box<3> boundsOf(const ViewScene<Dim>& scene) {
    Box<3> bounds;
    for (const Box<Dim>& box : {scene.pack ? boundsOf(*scene.pack) : Box<Dim>{}, scene.bounds})
        if (!box.empty()) {
            bounds.add(inSpace(box.lo));
            bounds.add(inSpace(box.hi));
        }
    if (scene.wall)
        for (const Vec<3>& v : scene.wall->vertices) bounds.add(v);
    return bounds;
}

}  // namespace

Json packedNumbers(const std::vector<double>& values) {
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    bool whole = true;
    for (const double v : values) {
        whole = whole && std::isfinite(v) && v == std::floor(v);
        if (!std::isfinite(v)) continue;
        lo = std::min(lo, v);
        hi = std::max(hi, v);
    }
    if (!(lo <= hi)) lo = hi = 0;
    whole = whole && hi - lo <= kMostWhole;
    const double step = whole ? 1 : (hi - lo) / kMost;
    std::vector<std::uint32_t> numbers;
    numbers.reserve(values.size());
    for (const double v : values)
        numbers.push_back(!std::isfinite(v) ? kMost + 1
                          : step > 0 ? static_cast<std::uint32_t>(std::llround((v - lo) / step))
                                     : 0);
    return {{"lo", lo},
            {"step", step},
            {"whole", whole},
            {"count", values.size()},
            {"data", packedWords(numbers)}};
}

template <int Dim>
Json viewData(const ViewScene<Dim>& scene, const ViewOptions& options) {
    const Pack<Dim> none;
    const Pack<Dim>& pack = scene.pack ? *scene.pack : none;
    const PreviewOptions colored = withColor(options, pack);
    if (scene.pack && pack.spheres.empty())
        throw ParameterError("view: the pack is empty; give one with spheres");
    const Box<3> bounds = boundsOf(scene);
    std::string words;
    Json facts{{"plane", Dim == 2},
               {"middle", bounds.center().c},
               {"half", (bounds.size() * 0.5).c},
               {"color", colored.color == PreviewColor::column
                             ? colored.column
                             : kColorNames[static_cast<std::size_t>(colored.color)]},
               {"ramp", ramp()}};
    if (Dim == 3 && options.cut) {
        checkPreviewCut(*options.cut, bounds);
        facts["cut"] = {{"axis", std::string(1, "xyz"[options.cut->axis])},
                        {"at", options.cut->at}};
    }
    if (Dim == 3) facts["sides"] = sideNames(options);
    const std::vector<std::uint32_t> rows = shownRows(pack.spheres.size(), options.mostSpheres);
    addSpheres(pack.spheres, rows, facts, words);
    addWall(scene, options, facts, words);
    if (scene.pack)
        addColumns(pack, rows, options.mostBytes, facts, words);
    else
        addSolids(scene.solids, facts);
    facts["words"] = words;
    return facts;
}

template Json viewData<2>(const ViewScene<2>&, const ViewOptions&);
template Json viewData<3>(const ViewScene<3>&, const ViewOptions&);

}  // namespace vdbpack
