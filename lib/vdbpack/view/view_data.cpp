#include "vdbpack/view/view_data.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/parallel.h"
#include "vdbpack/preview/scene.h"
#include "vdbpack/preview/sphere_colors.h"
#include "vdbpack/report/report.h"
#include "vdbpack/view/coarse_mesh.h"
#include "vdbpack/view/contour_lines.h"
#include "vdbpack/view/packed_arrays.h"
#include "vdbpack/view/shown_spheres.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kMost = 65534;  // of 16 bits; the last one stands for no number
constexpr double kMostWhole = 4294967295;
constexpr std::size_t kMostWords = 255;
constexpr int kCodePlanes = 6;
constexpr int kRampColors = 65;

/// An array of whole numbers before it is compressed.
struct Array {
    std::string name;
    std::vector<std::uint64_t> numbers;
    int planes = 1;
};

/// Compresses arrays and lists them.
class Store {
public:
    explicit Store(ViewData& data) : data_(data) { data_.facts["arrays"] = Json::array(); }

    void add(const std::vector<Array>& arrays) {
        for (const auto& [array, bytes] : packed(arrays)) append(*array, bytes);
    }
    /// Adds those of a pack's columns that stay within `most` bytes; returns which did.
    std::vector<bool> addWithin(const std::vector<Array>& arrays, std::size_t most) {
        std::vector<bool> added;
        for (const auto& [array, bytes] : packed(arrays)) {
            added.push_back(data_.bytes.size() + bytes.size() <= most);
            if (added.back()) append(*array, bytes);
        }
        return added;
    }

private:
    using Packed = std::vector<std::pair<const Array*, std::string>>;

    static Packed packed(const std::vector<Array>& arrays) {
        Packed all(arrays.size());
        parallelFor(std::size_t{0}, arrays.size(), [&](std::size_t i) {
            all[i] = {&arrays[i], packedNumbers(arrays[i].numbers, arrays[i].planes)};
        });
        return all;
    }
    void append(const Array& array, const std::string& bytes) {
        data_.facts["arrays"].push_back({{"name", array.name},
                                         {"bytes", bytes.size()},
                                         {"count", array.numbers.size()},
                                         {"planes", array.planes}});
        data_.bytes += bytes;
    }

    ViewData& data_;
};

/// Columns have any names; those of other arrays have no colon.
std::string arrayOf(const std::string& column) {
    return ":" + column;
}

/// A column as the script knows it.
struct ViewColumn {
    Json facts;
    std::optional<Array> array;  ///< nothing: the row of the sphere, or left out
    bool shown = true;
};

/// A number is `lo` + `step` times that of the array.
ViewColumn numberColumn(const std::string& name, const std::vector<double>& values,
                        const std::vector<std::uint32_t>& rows, const char* unit) {
    ViewColumn column;
    column.facts = {{"name", name}, {"unit", unit}};
    const bool whole = std::all_of(values.begin(), values.end(), [](double v) {
        return v == std::floor(v) && std::fabs(v) <= 0x1p53;
    });
    const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
    if (whole && !values.empty() && *hi - *lo <= kMostWhole) {
        if (std::equal(values.begin(), values.end(), rows.begin(), rows.end(),
                       [](double v, std::uint32_t row) { return v == row; })) {
            column.facts["isRow"] = true;
            return column;
        }
        column.facts.update({{"lo", *lo}, {"step", 1}, {"whole", true}});
        Array array{arrayOf(name), {}, planesFor(static_cast<std::uint64_t>(*hi - *lo))};
        array.numbers.reserve(values.size());
        for (const double v : values) array.numbers.push_back(static_cast<std::uint64_t>(v - *lo));
        column.array = std::move(array);
        return column;
    }
    Quantized q = quantized(values, kMost);
    column.facts.update({{"lo", q.lo}, {"step", q.step}});
    column.array = Array{arrayOf(name), std::move(q.numbers), 2};
    return column;
}

ViewColumn wordColumn(const std::string& name, const std::vector<std::string>& texts,
                      const std::vector<std::uint32_t>& rows) {
    ViewColumn column;
    column.facts = {{"name", name}, {"unit", ""}};
    std::map<std::string, std::uint64_t> known;
    Array array{arrayOf(name), {}, 1};
    for (const std::uint32_t row : rows) {
        const auto at = known.emplace(texts[row], known.size()).first;
        if (known.size() > kMostWords) {
            column.shown = false;
            return column;
        }
        array.numbers.push_back(at->second);
    }
    std::vector<std::string> words(known.size());
    for (const auto& [word, number] : known) words[number] = word;
    column.facts.update({{"lo", 0}, {"step", 1}, {"whole", true}, {"words", words}});
    column.array = std::move(array);
    return column;
}

template <int Dim>
std::vector<ViewColumn> columnsOf(const Pack<Dim>& pack, const std::vector<std::uint32_t>& rows) {
    std::vector<ViewColumn> columns;
    const std::size_t count = pack.spheres.size();
    forEachAttribute(pack, [&](std::string_view name, const auto& values) {
        if (values.size() != count) return;
        using Value = typename std::decay_t<decltype(values)>::value_type;
        if constexpr (std::is_same_v<Value, std::string>) {
            columns.push_back(wordColumn(std::string(name), values, rows));
        } else {
            std::vector<double> numbers;
            numbers.reserve(rows.size());
            for (const std::uint32_t row : rows)
                numbers.push_back(static_cast<double>(values[row]));
            columns.push_back(numberColumn(std::string(name), numbers, rows,
                                           std::is_same_v<Value, float> ? "mm" : ""));
            if (std::is_same_v<Value, double> && areKinds(numbers))
                columns.back().facts["kinds"] = true;
        }
    });
    // Names are keys of the script.
    for (std::size_t i = 0; i < columns.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (columns[i].facts["name"] == columns[j].facts["name"]) columns[i].shown = false;
    return columns;
}

std::string hexColor(std::uint32_t rgb) {
    return fmt::format("#{:06x}", rgb);
}

Json colorsOf() {
    Json ramp = Json::array(), kinds = Json::array(), regions = Json::array();
    for (int i = 0; i < kRampColors; ++i) {
        std::uint8_t c[3];
        toSrgb(rampColor(static_cast<double>(i) / (kRampColors - 1)), c);
        ramp.push_back(hexColor(static_cast<std::uint32_t>(c[0] << 16 | c[1] << 8 | c[2])));
    }
    for (const std::uint32_t c : kindColors()) kinds.push_back(hexColor(c));
    for (const std::uint32_t c : regionColors()) regions.push_back(hexColor(c));
    return {{"ramp", ramp}, {"kinds", kinds}, {"regions", regions}};
}

Json jsonOf(const Vec<3>& v) {
    return {v[0], v[1], v[2]};
}

/// Points on a lattice of their own, as arrays NAME-x, NAME-y, NAME-z.
template <class Points>
void addPoints(const std::string& name, const Points& points, const Box<3>& bounds,
               std::vector<Array>& arrays, Json& facts) {
    const Lattice lattice(bounds);
    std::array<Array, 3> parts{{{name + "-x", {}, 2}, {name + "-y", {}, 2}, {name + "-z", {}, 2}}};
    for (const auto& p : points) {
        const auto at = lattice.at(inSpace(p));
        for (std::size_t d = 0; d < 3; ++d) parts[d].numbers.push_back(at[d]);
    }
    facts[name] = {{"lo", jsonOf(lattice.lo)}, {"step", lattice.step}};
    for (auto& part : parts) arrays.push_back(std::move(part));
}

void addWall(const ViewScene<3>& scene, const ViewOptions& options, std::vector<Array>& arrays,
             Json& facts) {
    if (!scene.wall) return;
    const TriangleMesh mesh = coarsened(*scene.wall, options.mostTriangles);
    addPoints("wall", mesh.vertices, mesh.bounds(), arrays, facts);
    facts["wall"]["triangles"] = mesh.triangles.size();
    facts["wall"]["of"] = scene.wall->triangles.size();
    const char* const names[] = {"wall-a", "wall-b", "wall-c"};
    for (std::size_t k = 0; k < 3; ++k) {
        Array corner{names[k], {}, planesFor(mesh.vertices.size())};
        for (const auto& t : mesh.triangles) corner.numbers.push_back(t[k]);
        arrays.push_back(std::move(corner));
    }
}

void addWall(const ViewScene<2>& scene, const ViewOptions&, std::vector<Array>& arrays,
             Json& facts) {
    if (!scene.field) return;
    const std::vector<Vec<2>> ends = contourLines(*scene.field);
    Box<3> bounds;
    for (const auto& p : ends) bounds.add(inSpace(p));
    if (!bounds.empty()) addPoints("outline", ends, bounds, arrays, facts);
}

/// The camera of a picture of 4 by 3.
void addCamera(const ViewScene<3>& scene, const ViewOptions& options, Json& facts) {
    SpacePreview space;
    space.pack = scene.pack;
    space.wall = scene.wall;
    PreviewOptions preview;
    preview.width = 800;
    preview.height = 600;
    preview.cut = options.cut;
    const PreviewCamera camera = previewCamera(space, preview);
    facts["camera"] = {{"position", jsonOf(camera.position)},
                       {"toward", jsonOf(camera.toward)},
                       {"target", camera.target},
                       {"tangent", camera.tanX}};
    if (options.cut)
        facts["cut"] = {{"axis", std::string(1, "xyz"[options.cut->axis])},
                        {"at", options.cut->at}};
}

void addCamera(const ViewScene<2>&, const ViewOptions&, Json&) {}

std::string colorName(const ViewOptions& options) {
    switch (options.color) {
        case PreviewColor::region:
            return "region";
        case PreviewColor::depth:
            return "depth";
        case PreviewColor::order:
            return "order";
        case PreviewColor::column:
            return options.column;
        default:
            return "radius";
    }
}

/// Facts on the columns; adds their arrays as far as there is room.
void addColumns(std::vector<ViewColumn> columns, const ViewOptions& options, Store& store,
                Json& facts) {
    std::vector<Array> arrays;
    for (auto& column : columns)
        if (column.shown && column.array) arrays.push_back(std::move(*column.array));
    const std::vector<bool> added = store.addWithin(arrays, options.mostBytes);
    Json shown = Json::array();
    std::string leftOut;
    std::size_t next = 0;
    for (const auto& column : columns) {
        if (column.shown && (!column.array || added[next++]))
            shown.push_back(column.facts);
        else
            leftOut += (leftOut.empty() ? "" : ", ") + column.facts["name"].get<std::string>();
    }
    facts["columns"] = std::move(shown);
    if (!leftOut.empty()) facts["leftOut"] = leftOut;
}

}  // namespace

template <int Dim>
ViewData viewData(const ViewScene<Dim>& scene, const ViewOptions& options) {
    const Pack<Dim>& pack = *scene.pack;
    if (pack.spheres.empty())
        throw ParameterError("view: the pack is empty; give one with spheres");
    Box<3> centers, bounds;
    for (const Box<Dim>& box : {boundsOf(pack), scene.bounds})
        if (!box.empty()) {
            bounds.add(inSpace(box.lo));
            bounds.add(inSpace(box.hi));
        }
    for (const auto& s : pack.spheres) centers.add(inSpace(s.center));
    const Lattice lattice(centers);
    const ShownSpheres shown = shownSpheres(pack.spheres, lattice, options);

    ViewData data;
    Json& facts = data.facts;
    facts = {{"dim", Dim},
             {"things", Measure<Dim>::kSpheres},
             {"count", shown.rows.size()},
             {"outer", shown.outer},
             {"inner", shown.inner},
             {"of", pack.spheres.size()},
             {"lo", jsonOf(lattice.lo)},
             {"step", lattice.step},
             {"bounds", {jsonOf(bounds.lo), jsonOf(bounds.hi)}},
             {"depth", shown.depth},
             {"color", colorName(options)}};
    if (!shown.words.empty()) facts["words"] = shown.words;
    if (Dim == 2) facts["height"] = pack.sliceHeight;
    facts["colors"] = colorsOf();
    Store store(data);

    std::vector<Array> arrays;
    Array codes{"code", {}, kCodePlanes}, rows{"row", {}, planesFor(pack.spheres.size())};
    std::uint64_t last = 0;
    for (std::size_t i = 0; i < shown.rows.size(); ++i) {
        // The curve starts again with each kind of sphere.
        const bool starts = i == 0 || i == shown.outer || i == shown.outer + shown.inner;
        codes.numbers.push_back(shown.codes[i] - (starts ? 0 : last));
        last = shown.codes[i];
        rows.numbers.push_back(shown.rows[i]);
    }
    std::vector<double> radii;
    radii.reserve(shown.rows.size());
    for (const std::uint32_t row : shown.rows) radii.push_back(pack.spheres[row].radius);
    Quantized radius = quantized(radii, kMost);
    facts["radius"] = {{"lo", radius.lo}, {"step", radius.step}};
    arrays.push_back(std::move(codes));
    arrays.push_back(std::move(rows));
    arrays.push_back({"radius", std::move(radius.numbers), 2});
    addWall(scene, options, arrays, facts);
    store.add(arrays);
    addCamera(scene, options, facts);
    addColumns(columnsOf(pack, shown.rows), options, store, facts);
    return data;
}

template ViewData viewData<2>(const ViewScene<2>&, const ViewOptions&);
template ViewData viewData<3>(const ViewScene<3>&, const ViewOptions&);

}  // namespace vdbpack
