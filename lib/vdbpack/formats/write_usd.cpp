// Pixar's USD as text: the spheres as a Points prim, their surface as a Mesh beside them.
//
// Sources: UsdGeom's schemas (widths of Points are diameters); the grammar of text files in
// pxr/usd/sdf/textFileFormatParser.h; the specification of USDZ. `points` and `widths` are floats
// by schema, and written with the digits of doubles: programs round them.
#include "vdbpack/formats/format_words.h"
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/formats/zip_writer.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/row_writer.h"
#include "vdbpack/io/text.h"
#include "vdbpack/mesh/triangle_mesh.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

namespace vdbpack {

namespace {

constexpr const char* kSphereColor = "(0.87, 0.82, 0.72)";
constexpr const char* kSurfaceColor = "(0.75, 0.78, 0.82)";
constexpr double kSurfaceOpacity = 0.25;

/// `text` in quotes. Control characters and bytes that are no UTF-8 are written by their numbers.
std::string quotedText(std::string_view text) {
    std::string out = "\"";
    while (!text.empty()) {
        const char c = text.front();
        const auto byte = static_cast<unsigned char>(c);
        const std::size_t bytes = byte < 0x20 || byte == 0x7f ? 0 : utf8Bytes(text);
        if (bytes == 0)
            out += fmt::format("\\x{:02x}", byte);
        else if (c == '"' || c == '\\')
            out.append(1, '\\').append(1, c);
        else
            out += text.substr(0, bytes);
        text.remove_prefix(std::max<std::size_t>(bytes, 1));
    }
    return out + '"';
}

/// A name that every version of USD accepts.
std::string usdName(std::string_view name) {
    const std::string identifier = identifierOf(name);
    const bool begins = !identifier.empty() && (identifier[0] < '0' || identifier[0] > '9');
    return begins ? identifier : '_' + identifier;
}

/// @tparam T  float or double, of which the digits are written.
template <class T>
void appendTriple(std::string& text, const Vec<3>& numbers) {
    text += '(';
    for (int d = 0; d < 3; ++d) {
        if (d > 0) text += ", ";
        appendShortest(text, static_cast<T>(numbers[d]));
    }
    text += ')';
}

std::string triple(const Vec<3>& numbers) {
    std::string text;
    appendTriple<double>(text, numbers);
    return text;
}

/// Two corners, rounded outwards to floats.
std::string extentText(const Box<3>& box) {
    const auto bound = [](double value, float beyond) {
        float rounded = static_cast<float>(value);
        const bool inside = beyond < 0 ? static_cast<double>(rounded) > value
                                       : static_cast<double>(rounded) < value;
        if (inside) rounded = std::nextafter(rounded, beyond);
        return static_cast<double>(rounded);
    };
    constexpr float kFar = std::numeric_limits<float>::infinity();
    Vec<3> lo, hi;
    for (int d = 0; d < 3 && !box.empty(); ++d) {
        lo[d] = bound(box.lo[d], -kFar);
        hi[d] = bound(box.hi[d], kFar);
    }
    return fmt::format("[{}, {}]", triple(lo), triple(hi));
}

/// Where to put the local origin on an axis: near spheres that lie far from 0 for their extent,
/// so that floats are finer there. All `lo` to `hi` are within a factor of 2 of it then, so that
/// subtracting it is exact (Sterbenz 1974), and adding it again, too.
double originBetween(double lo, double hi) {
    if (hi < 0) return -originBetween(-hi, -lo);
    if (!(lo > 0 && hi <= 2 * lo)) return 0;
    const double quantum = hi > lo ? std::exp2(std::floor(std::log2(hi - lo)) - 3) : lo;
    const double origin = std::nearbyint((lo + hi) / 2 / quantum) * quantum;
    return origin >= hi / 2 && origin <= 2 * lo ? origin : 0;
}

class UsdText {
public:
    using Sink = std::function<void(const std::string&)>;
    using Append = std::function<void(std::string&, std::size_t)>;

    UsdText(const PackView& pack, const PackWriteOptions& options, Sink sink)
        : pack_(pack), options_(options), sink_(std::move(sink)) {
        const Box<3> centers = pack.boundsOfCenters();
        for (int d = 0; d < 3 && !centers.empty(); ++d)
            origin_[d] = originBetween(centers.lo[d], centers.hi[d]);
    }

    void write() {
        writeHeader();
        sink_("def Xform \"pack\" (\n    kind = \"component\"\n)\n{\n");
        if (origin_ != Vec<3>{})
            sink_(
                fmt::format("    double3 xformOp:translate = {}\n"
                            "    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n",
                            triple(origin_)));
        writeSpheres();
        if (options_.surface != nullptr) writeSurface(*options_.surface);
        sink_("}\n");
    }

private:
    void writeHeader() {
        std::string header = "#usda 1.0\n(\n    customLayerData = {\n";
        const auto note = [&header](const char* key, const std::string& text) {
            header += fmt::format("        string {} = {}\n", key, quotedText(text));
        };
        if (!options_.generator.empty()) note(kGeneratorKey, options_.generator);
        note(kUnitKey, unitName(options_.unit));
        if (pack_.cell().any()) note(kCellKey, cellText(pack_.cell()));
        header += "    }\n    defaultPrim = \"pack\"\n    metersPerUnit = ";
        appendShortest(header, millimetersPer(options_.unit) / 1000);
        sink_(header + "\n    upAxis = \"Z\"\n)\n\n");
    }

    /// An attribute of `count` values, one a line.
    void array(const std::string& declaration, std::size_t count, const Append& append,
               const std::string& metadata = {}) {
        sink_("        " + declaration + " = [");
        writeRows(sink_, count, [&append](std::string& text, std::size_t i) {
            if (i > 0) text += ',';
            text += '\n';
            append(text, i);
        });
        sink_(metadata.empty() ? "]\n" : "] (\n" + metadata + "        )\n");
    }

    void writeSpheres() {
        const std::size_t n = pack_.size();
        const Box<3> spheres = pack_.boundsOfSpheres();
        sink_("\n    def Points \"spheres\"\n    {\n        float3[] extent = " +
              extentText({spheres.lo - origin_, spheres.hi - origin_}) + "\n");
        array("int64[] ids", n,
              [this](std::string& text, std::size_t i) { appendNumber(text, pack_.id(i)); });
        array("point3f[] points", n, [this](std::string& text, std::size_t i) {
            appendTriple<double>(text, pack_.center(i) - origin_);
        });
        array(
            "float[] widths", n,
            [this](std::string& text, std::size_t i) { appendShortest(text, 2 * pack_.radius(i)); },
            kPerSphere);
        sink_(fmt::format("        color3f[] primvars:displayColor = [{}]\n", kSphereColor));
        pack_.forEachAttribute(
            [this, n](std::string_view name, const auto& numbers) {
                using Value = ValueOf<decltype(numbers)>;
                const char* type = std::is_same_v<Value, std::int32_t>   ? "int"
                                   : std::is_same_v<Value, std::int64_t> ? "int64"
                                   : std::is_same_v<Value, float>        ? "float"
                                                                         : "double";
                primvar(type, name, n, [this, &numbers](std::string& text, std::size_t i) {
                    const auto value = pack_.value(numbers, i);
                    if constexpr (std::is_integral_v<Value>)
                        appendNumber(text, value);
                    else
                        appendShortest(text, static_cast<Value>(value));
                });
            },
            [this, n](std::string_view name, const auto& texts) {
                primvar("string", name, n, [&texts](std::string& text, std::size_t i) {
                    text += quotedText(texts[i]);
                });
            });
        sink_("    }\n");
    }

    void primvar(const char* type, std::string_view name, std::size_t count, const Append& append) {
        const std::string identifier = unique_(usdName(name));
        std::string metadata = kPerSphere;
        if (identifier != name)
            metadata = fmt::format("            displayName = {}\n", quotedText(name)) + metadata;
        array(fmt::format("{}[] primvars:{}", type, identifier), count, append, metadata);
    }

    void writeSurface(const TriangleMesh& mesh) {
        const auto vertex = [&mesh, this](std::size_t i) {
            Vec<3> p;
            for (int d = 0; d < 3; ++d) p[d] = fromMillimeters(mesh.vertices[i][d], options_.unit);
            return p - origin_;
        };
        const std::size_t vertices = mesh.vertices.size();
        Box<3> box;
        for (std::size_t i = 0; i < vertices; ++i) box.add(vertex(i));
        // Coordinates of 6 to 7 digits.
        const Vec<3> size = box.size();
        const double extent = *std::max_element(size.c.begin(), size.c.end());
        const double step = extent > 0 ? std::pow(10, std::floor(std::log10(extent)) - 6) : 1;
        const auto rounded = [step](Vec<3> p) {
            for (double& x : p.c)
                x = static_cast<double>(static_cast<float>(std::nearbyint(x / step) * step));
            return p;
        };
        if (!box.empty()) box = {rounded(box.lo), rounded(box.hi)};
        sink_(fmt::format("\n    def Mesh \"{}\"\n    {{\n        float3[] extent = {}\n",
                          usdName(options_.surfaceName), extentText(box)));
        const std::size_t n = mesh.triangles.size();
        array("int[] faceVertexCounts", n, [](std::string& text, std::size_t) { text += '3'; });
        array("int[] faceVertexIndices", n, [&mesh](std::string& text, std::size_t i) {
            const auto& t = mesh.triangles[i];
            fmt::format_to(std::back_inserter(text), "{}, {}, {}", t[0], t[1], t[2]);
        });
        array("point3f[] points", vertices, [&](std::string& text, std::size_t i) {
            appendTriple<float>(text, rounded(vertex(i)));
        });
        sink_(
            fmt::format("        color3f[] primvars:displayColor = [{}]\n"
                        "        float[] primvars:displayOpacity = [{}]\n"
                        "        uniform token subdivisionScheme = \"none\"\n    }}\n",
                        kSurfaceColor, kSurfaceOpacity));
    }

    static constexpr const char* kPerSphere = "            interpolation = \"vertex\"\n";

    const PackView& pack_;
    const PackWriteOptions& options_;
    Sink sink_;
    Vec<3> origin_;
    UniqueNames unique_{"displaycolor", "displayopacity"};
};

}  // namespace

void writeUsd(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    UsdText(pack, options, [&out](const std::string& text) { out.write(text); }).write();
}

void writeUsdz(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    // Size and checksum stand before the text: it is composed twice rather than kept in memory.
    std::uint64_t size = 0;
    uLong crc = 0;
    UsdText(pack, options, [&](const std::string& text) {
        size += text.size();
        crc = crc32_z(crc, reinterpret_cast<const unsigned char*>(text.data()), text.size());
    }).write();
    ZipWriter zip(out, ZipWriter::Form::usdz);
    zip.begin("pack.usda", size, static_cast<std::uint32_t>(crc));
    writeUsd(pack, options, out);
    zip.finish();
}

}  // namespace vdbpack
