// VTK's XML polygon data for ParaView: one vertex cell per point, arrays appended as raw bytes.
#include "vdbpack/formats/pack_formats.h"
#include "vdbpack/formats/pack_text.h"
#include "vdbpack/io/byte_order.h"
#include "vdbpack/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace vdbpack {

namespace {

/// A text as VTK writes strings in ASCII: character codes, ended by 0.
std::string asCodes(const std::string& text) {
    std::string out;
    for (const char c : text) out += fmt::format("{} ", static_cast<unsigned char>(c));
    return out + "0";
}

/// An array of the appended section.
struct Block {
    std::uint64_t bytes = 0;
    std::function<void(OutputFile&)> write;
};

/// `count` numbers, made one by one.
template <typename T, typename Get>
Block block(std::size_t count, const Get& get) {
    return {count * sizeof(T), [count, get](OutputFile& out) {
                std::vector<T> part;
                part.reserve(std::min<std::size_t>(count, 1 << 15));
                for (std::size_t i = 0; i < count; ++i) {
                    part.push_back(static_cast<T>(get(i)));
                    if (part.size() < part.capacity() && i + 1 < count) continue;
                    out.write(part.data(), part.size() * sizeof(T));
                    part.clear();
                }
            }};
}

class Writer {
public:
    explicit Writer(OutputFile& out) : out_(out) {}

    void line(const std::string& text) { out_.write(text + "\n"); }
    void array(const std::string& element, const std::string& attributes, Block data) {
        line(fmt::format("        <{} {} format=\"appended\" offset=\"{}\"/>", element, attributes,
                         offset_));
        offset_ += sizeof(std::uint64_t) + data.bytes;
        blocks_.push_back(std::move(data));
    }
    template <typename T, typename Get>
    void numbers(std::string_view name, std::size_t count, const Get& get) {
        constexpr const char* kType = std::is_floating_point_v<T> ? "Float" : "Int";
        array("DataArray",
              fmt::format("type=\"{}{}\" Name=\"{}\"", kType, 8 * sizeof(T), escapedXml(name)),
              block<T>(count, get));
    }
    void texts(std::string_view name, const std::vector<std::string>& list) {
        // Each text ends with a 0, so it holds none itself.
        Block data;
        for (const auto& t : list) data.bytes += oneLine(t).size() + 1;
        data.write = [&list](OutputFile& file) {
            for (const auto& t : list) {
                const std::string clean = oneLine(t);
                file.write(clean.c_str(), clean.size() + 1);
            }
        };
        array("Array", fmt::format("type=\"String\" Name=\"{}\"", escapedXml(name)),
              std::move(data));
    }
    void finish() {
        out_.write(std::string("  <AppendedData encoding=\"raw\">\n   _"));
        for (const auto& b : blocks_) {
            out_.write(&b.bytes, sizeof b.bytes);
            b.write(out_);
        }
        out_.write(std::string("\n  </AppendedData>\n</VTKFile>\n"));
    }

private:
    OutputFile& out_;
    std::vector<Block> blocks_;
    std::uint64_t offset_ = 0;
};

}  // namespace

void writeVtp(const PackView& pack, const PackWriteOptions& options, OutputFile& out) {
    const std::size_t n = pack.size();
    Writer xml(out);
    xml.line("<?xml version=\"1.0\"?>");
    xml.line(fmt::format(
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\">",
        hostIsBigEndian() ? "BigEndian" : "LittleEndian"));
    xml.line("  <PolyData>");
    xml.line("    <FieldData>");
    const auto note = [&xml](const char* name, const std::string& lines) {
        const auto texts = splitAt(lines, '\n');
        std::string codes;
        for (const std::string& text : texts) codes += (codes.empty() ? "" : " ") + asCodes(text);
        xml.line(
            fmt::format("      <Array type=\"String\" Name=\"{}\" NumberOfTuples=\"{}\" "
                        "format=\"ascii\">{}</Array>",
                        name, texts.size(), codes));
    };
    note(kUnitKey, unitName(options.unit));
    if (pack.cell().any()) note(kCellKey, cellText(pack.cell()));
    if (const auto names = partLines(pack.attributes()); !names.empty()) note(kPartNamesKey, names);
    if (!options.generator.empty()) note(kGeneratorKey, oneLine(options.generator));
    xml.line("    </FieldData>");
    xml.line(
        fmt::format("    <Piece NumberOfPoints=\"{0}\" NumberOfVerts=\"{0}\" NumberOfLines=\"0\" "
                    "NumberOfStrips=\"0\" NumberOfPolys=\"0\">",
                    n));

    xml.line("      <PointData Scalars=\"radius\">");
    xml.numbers<double>("radius", n, [&pack](std::size_t i) { return pack.radius(i); });
    xml.numbers<std::int64_t>("id", n, [&pack](std::size_t i) { return pack.id(i); });
    pack.forEachAttribute(
        [&](std::string_view name, const auto& numbers) {
            xml.numbers<ValueOf<decltype(numbers)>>(
                name, n, [&pack, &numbers](std::size_t i) { return pack.value(numbers, i); });
        },
        [&](std::string_view name, const auto& texts) { xml.texts(name, texts); });
    xml.line("      </PointData>");

    xml.line("      <Points>");
    xml.array("DataArray", "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
              block<std::array<double, 3>>(n, [&pack](std::size_t i) { return pack.position(i); }));
    xml.line("      </Points>");
    xml.line("      <Verts>");
    xml.numbers<std::int64_t>("connectivity", n,
                              [](std::size_t i) { return static_cast<std::int64_t>(i); });
    xml.numbers<std::int64_t>("offsets", n,
                              [](std::size_t i) { return static_cast<std::int64_t>(i + 1); });
    xml.line("      </Verts>");
    xml.line("    </Piece>");
    xml.line("  </PolyData>");
    xml.finish();
}

}  // namespace vdbpack
