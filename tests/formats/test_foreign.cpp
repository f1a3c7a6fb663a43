// Packs as other programs write them.
#include "formats/foreign.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"

#include <catch2/catch.hpp>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

template <typename T>
std::string bytesOf(std::vector<T> values, bool bigEndian = false) {
    std::string out;
    for (T v : values) {
        char b[sizeof(T)];
        std::memcpy(b, &v, sizeof(T));
        if (bigEndian) std::reverse(b, b + sizeof(T));
        out.append(b, sizeof(T));
    }
    return out;
}

std::string base64(const std::string& bytes) {
    static const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group =
                group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
    }
    return out;
}

std::string deflated(const std::string& bytes) {
    uLongf size = ::compressBound(static_cast<uLong>(bytes.size()));
    std::string out(size, '\0');
    REQUIRE(::compress(reinterpret_cast<Bytef*>(out.data()), &size,
                       reinterpret_cast<const Bytef*>(bytes.data()),
                       static_cast<uLong>(bytes.size())) == Z_OK);
    out.resize(size);
    return out;
}

/// What one .vtp variant looks like.
struct Variant {
    std::string format;  ///< ascii, binary, raw, base64 (the last two appended)
    bool zlib = false;
    bool wide = false;  ///< UInt64 headers
    bool bigEndian = false;
    std::size_t blockBytes = 40;
};

class VtpText {
public:
    explicit VtpText(const Variant& variant) : v_(variant) {}

    std::string encoded(const std::string& data) const {
        const auto word = [this](std::size_t value) {
            return v_.wide ? vdbpackBytes<std::uint64_t>(value)
                           : vdbpackBytes<std::uint32_t>(value);
        };
        const bool text = v_.format != "raw";
        if (!v_.zlib) {
            const std::string all = word(data.size()) + data;
            return text ? base64(all) : all;
        }
        std::string sizes;
        std::string blocks;
        const std::size_t count = (data.size() + v_.blockBytes - 1) / v_.blockBytes;
        for (std::size_t b = 0; b < count; ++b) {
            const std::string block = deflated(data.substr(b * v_.blockBytes, v_.blockBytes));
            sizes += word(block.size());
            blocks += block;
        }
        const std::string header =
            word(count) + word(v_.blockBytes) + word(data.size() % v_.blockBytes) + sizes;
        return text ? base64(header) + base64(blocks) : header + blocks;
    }
    template <typename T>
    void array(const std::string& attributes, const std::vector<T>& values) {
        xml_ += "<DataArray " + attributes;
        if (v_.format == "ascii") {
            xml_ += " format=\"ascii\">\n";
            for (const T value : values) xml_ += " " + std::to_string(value) + "\n";
            xml_ += "</DataArray>\n";
        } else if (v_.format == "binary") {
            xml_ += " format=\"binary\">\n  " + encoded(bytesOf(values, v_.bigEndian)) +
                    "\n</DataArray>\n";
        } else {
            xml_ += " format=\"appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
            appended_ += encoded(bytesOf(values, v_.bigEndian));
        }
    }
    std::string pack() {
        xml_ = std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" byte_order=\"") +
               (v_.bigEndian ? "BigEndian" : "LittleEndian") + "\"" +
               (v_.wide ? " header_type=\"UInt64\"" : "") +
               (v_.zlib ? " compressor=\"vtkZLibDataCompressor\"" : "") +
               ">\n<!-- a > b --><PolyData><Piece NumberOfPoints=\"4\" NumberOfVerts=\"0\">\n"
               "<PointData Scalars='Radius'>\n";
        array<double>("type=\"Float64\" Name=\"Radius\"", {1, 2, 0.5, 4});
        array<std::int32_t>("type=\"Int32\" Name=\"material\"", {7, -8, 9, 10});
        array<float>("type=\"Float32\" Name=\"Normals\" NumberOfComponents=\"3\"",
                     {0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, -1});
        xml_ += "</PointData><CellData></CellData><Points>\n";
        array<float>("type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"",
                     {0, 0, 0, 10.5f, 0, 0, 0, -20, 0, 0, 0, 30});
        xml_ += "</Points></Piece></PolyData>\n";
        if (v_.format == "raw" || v_.format == "base64")
            xml_ += "<AppendedData encoding=\"" + v_.format + "\">\n_" + appended_ +
                    "\n</AppendedData>\n";
        return xml_ + "</VTKFile>\n";
    }

private:
    template <typename T>
    std::string vdbpackBytes(std::size_t value) const {
        return bytesOf<T>({static_cast<T>(value)}, v_.bigEndian);
    }

    Variant v_;
    std::string xml_;
    std::string appended_;
};

void requireFourSpheres(const Pack<3>& pack) {
    REQUIRE(pack.spheres ==
            std::vector<Sphere<3>>{
                {{{0, 0, 0}}, 1}, {{{10.5, 0, 0}}, 2}, {{{0, -20, 0}}, 0.5}, {{{0, 0, 30}}, 4}});
}

}  // namespace

TEST_CASE("VTP is read in every encoding that ParaView writes", "[export]") {
    Variant v;
    v.format = GENERATE(as<std::string>{}, "ascii", "binary", "raw", "base64");
    v.zlib = GENERATE(false, true);
    v.wide = GENERATE(false, true);
    v.bigEndian = GENERATE(false, true);
    v.blockBytes = GENERATE(16u, 40u, 32768u);
    CAPTURE(v.format, v.zlib, v.wide, v.bigEndian, v.blockBytes);
    const auto pack = readText("p.vtp", VtpText(v).pack());
    requireFourSpheres(pack);
    REQUIRE(pack.columns.size() == 4);
    REQUIRE(pack.columns[0].name == "material");
    REQUIRE(pack.columns[0].numbers == std::vector<double>{7, -8, 9, 10});
    REQUIRE(pack.columns[3].name == "Normals_2");
    REQUIRE(pack.columns[3].numbers == std::vector<double>{1, 0, 0, -1});
}

TEST_CASE("an ASCII array needs no compressor, whatever the header names", "[export]") {
    Variant v;
    v.format = "ascii";
    v.zlib = true;
    auto text = VtpText(v).pack();
    text.replace(text.find("ZLib"), 4, "LZ4");
    requireFourSpheres(readText("p.vtp", text));
}

TEST_CASE("damaged VTP is refused with the reason", "[export]") {
    Variant v;
    v.format = "raw";
    v.zlib = GENERATE(false, true);
    const auto whole = VtpText(v).pack();
    const auto changed = [&whole](const std::string& from, const std::string& to) {
        auto text = whole;
        text.replace(text.find(from), from.size(), to);
        return text;
    };
    REQUIRE_THAT(errorOf("p.vtp", changed("Points=\"4\"", "Points=\"5\"")), Contains("expected"));
    REQUIRE_THAT(errorOf("p.vtp", changed("Points=\"4\"", "Points=\"900000000000000000\"")),
                 Contains("expected"));
    REQUIRE_THAT(errorOf("p.vtp", changed("Points=\"4\"", "Points=\"-4\"")), Contains("usable"));
    REQUIRE_THAT(errorOf("p.vtp", changed("PolyData", "UnstructuredGrid")), Contains("PolyData"));
    REQUIRE_THAT(errorOf("p.vtp", changed("offset=\"0\"", "offset=\"9223372036854775807\"")),
                 Contains("behind the end"));
    REQUIRE_THAT(errorOf("p.vtp", changed("Int32", "Int33")), Contains("unknown type"));
    REQUIRE_THAT(errorOf("p.vtp", changed("Radius\"", "Rodius\"")), Contains("radius"));
    if (v.zlib) {
        REQUIRE_THAT(errorOf("p.vtp", changed("ZLib", "LZ4")), Contains("not supported"));
        // The first block of the first array, past its header.
        auto text = whole;
        text[text.find("\n_") + 2 + 20 + 4] ^= 0x55;
        REQUIRE_THAT(errorOf("p.vtp", text), Contains("inflate"));
    }
}

TEST_CASE("CSV columns are found by name in any order and case", "[export]") {
    const auto pack = readText("p.csv",
                               "\xef\xbb\xbf Z, \"Radius\",material,X,y,Region\r\n"
                               "3,+0.5,steel,1,2,1\r\n\r\n"
                               "-6 , 1e0,\"bone, \"\"wet\"\"\",4,5.0,0\r\n"
                               "9,2,7,7,8,1.0");
    REQUIRE(pack.spheres ==
            std::vector<Sphere<3>>{{{{1, 2, 3}}, 0.5}, {{{4, 5, -6}}, 1}, {{{7, 8, 9}}, 2}});
    REQUIRE(pack.region == std::vector<std::int32_t>{1, 0, 1});
    REQUIRE(pack.columns.size() == 1);
    REQUIRE(pack.columns[0].name == "material");
    REQUIRE(pack.columns[0].numbers.empty());
    REQUIRE(pack.columns[0].texts == std::vector<std::string>{"steel", "bone, \"wet\"", "7"});
}

TEST_CASE("CSV from ParaView, with semicolons, tabs or diameters", "[export]") {
    REQUIRE(
        readText("p.csv", "\"radius\",\"Points:0\",\"Points:1\",\"Points:2\"\n2,1,2,3\n").spheres ==
        std::vector<Sphere<3>>{{{{1, 2, 3}}, 2}});
    REQUIRE(readText("p.csv", "#x;y;z;diameter\n1;2;3;4\n").spheres ==
            std::vector<Sphere<3>>{{{{1, 2, 3}}, 2}});
    REQUIRE(readText("p.csv", "x\ty\tz\tr\n1\t2\t3\t2\n").spheres ==
            std::vector<Sphere<3>>{{{{1, 2, 3}}, 2}});
}

TEST_CASE("CSV is read with any separator, line end, quotes and comments", "[export]") {
    const std::string separator = GENERATE(as<std::string>{}, ",", ";", "\t", " ", ", ", "  ");
    const std::string end = GENERATE(as<std::string>{}, "\n", "\r\n", "\r");
    const bool quoted = GENERATE(false, true);
    const bool mark = GENERATE(false, true);
    const std::string above = GENERATE(as<std::string>{}, "", "# a, b; c,", "sep=;");
    const bool hidden = GENERATE(false, true);
    CAPTURE(separator, end, quoted, mark, above, hidden);
    const auto row = [&](const std::vector<std::string>& cells, bool quotes) {
        std::string text;
        for (const auto& cell : cells) {
            if (!text.empty()) text += separator;
            text += quotes ? "\"" + cell + "\"" : cell;
        }
        return text + end;
    };
    std::string content = mark ? "\xef\xbb\xbf" : "";
    if (!above.empty()) content += above + end;
    content += (hidden ? "# " : "") + row({"z", "Radius", "material", "x", "Y"}, quoted);
    content += "# lengths in mm" + end;
    content += row({"3", "0.5", "7", "1", "2"}, false) + end + "#" +
               row({"9", "9", "9", "9", "9"}, false) + row({"-6", "1e0", "8", "4", "+5"}, quoted);
    const auto pack = readText("p.csv", content);
    REQUIRE(pack.spheres == std::vector<Sphere<3>>{{{{1, 2, 3}}, 0.5}, {{{4, 5, -6}}, 1}});
    REQUIRE(pack.columns.at(0).name == "material");
    REQUIRE(pack.columns[0].numbers == std::vector<double>{7, 8});
}

TEST_CASE("a CSV column may have no name, as the index that pandas writes", "[export]") {
    const std::string separator = GENERATE(as<std::string>{}, ",", "\t", ";");
    CAPTURE(separator);
    const auto read = [&separator](std::string content) {
        for (std::size_t at = 0; (at = content.find('|', at)) != std::string::npos;)
            content.replace(at, 1, separator);
        return errorOf("p.csv", content).empty() ? readText("p.csv", content) : Pack<3>{};
    };
    const auto first = read("|x|y|z|radius\n5|1|2|3|4\n");
    const auto last = read("x|y|z|radius|\n1|2|3|4|5\n");
    REQUIRE(first.spheres == std::vector<Sphere<3>>{{{{1, 2, 3}}, 4}});
    REQUIRE(last.spheres == first.spheres);
    REQUIRE(first.columns.at(0).numbers == std::vector<double>{5});
    REQUIRE(last.columns.at(0).numbers == std::vector<double>{5});
    // Two columns without a name are one too many.
    REQUIRE(read("|x|y|z|radius|\n0|1|2|3|4|5\n").spheres.empty());
}

TEST_CASE("a row that may be a comment is not dropped in silence", "[export]") {
    REQUIRE_THAT(errorOf("p.csv", "name,x,y,z,r\na,1,2,3,1\n#b,4,5,6,1\n"),
                 Contains("line 3") && Contains("comment or a row"));
    REQUIRE(readText("p.csv", "name,x,y,z,r\n# two\na,1,2,3,1\n\"#b\",4,5,6,1\n").spheres.size() ==
            2);
}

TEST_CASE("a text that looks like a number stays as it was written", "[export]") {
    const auto pack = readText("p.csv", "x,y,z,r,name\n1,2,3,1,007\n1,2,9,1,1e3\n5,5,5,1,x\n");
    REQUIRE(pack.columns[0].texts == std::vector<std::string>{"007", "1e3", "x"});
}

TEST_CASE("unusable CSV is refused with line and column", "[export]") {
    REQUIRE_THAT(errorOf("p.csv", ""), Contains("is empty"));
    REQUIRE_THAT(errorOf("p.csv", "1,2,3,4\n5,6,7,8\n"), Contains("yade:FILE"));
    REQUIRE_THAT(errorOf("p.csv", "# made in 2019\n1,2,3,4\n"), Contains("line 2"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z\n1,2,3\n"), Contains("radius") && Contains("x, y, z"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,X,z,r\n"), Contains("'x' appears twice"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n1,2,3,1\n1,2,3\n"), Contains("line 3: has 3 cells"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n\n1,2,oops,1\n"),
                 Contains("line 3: column 'z' is 'oops'"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n1,nan,3,1\n"),
                 Contains("line 2") && Contains("finite"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n1,2,3,-1\n"), Contains("radius is -1"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r\n1,2,3,1e999\n"), Contains("1e999"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r,id\n1,2,3,1,1.5\n"), Contains("whole number"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r,region\n1,2,3,1,5000000000\n"), Contains("region"));
    REQUIRE_THAT(errorOf("p.csv", "x,y,z,r,\"n\n1,2,3,1,1\n"), Contains("quote"));
}

TEST_CASE("PLY is read as text and in both byte orders, whatever else it holds", "[export]") {
    const std::string before =
        "comment unit of length: cm\nelement camera 2\nproperty list uchar int v\n"
        "property double w\nelement vertex 2\nproperty uchar red\n"
        "property double z\nproperty float y\nproperty short x\n"
        "property list uint16 float extra\nproperty float Diameter\n"
        "element face 1\nproperty list uchar int i\nend_header\n";
    std::string content;
    SECTION("text") {
        content = "ply\r\nformat ascii 1.0\n" + before +
                  "1 5 0.5\n0 1.5\n255 3 2 1 2 0.5 0.25 1\n0 -3 -2.5 -1 0 0.5\n3 0 1 1\n";
    }
    for (const bool big : {false, true}) {
        SECTION(big ? "big endian" : "little endian") {
            const auto f = [big](float v) { return bytesOf<float>({v}, big); };
            const auto d = [big](double v) { return bytesOf<double>({v}, big); };
            const auto s = [big](std::int16_t v) { return bytesOf<std::int16_t>({v}, big); };
            const auto i = [big](std::int32_t v) { return bytesOf<std::int32_t>({v}, big); };
            content = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\n" + before + "\x01" + i(5) + d(0.5) + std::string(1, '\0') +
                      d(1.5) + "\xff" + d(3) + f(2) + s(1) + s(2) + f(0.5f) + f(0.25f) + f(1) +
                      std::string(1, '\0') + d(-3) + f(-2.5f) + s(-1) + s(0) + f(0.5f) + "\x03" +
                      i(0) + i(1) + i(1);
        }
    }
    const auto pack = readText("p.ply", content);
    REQUIRE(pack.spheres == std::vector<Sphere<3>>{{{{10, 20, 30}}, 5}, {{{-10, -25, -30}}, 2.5}});
    REQUIRE(pack.columns.size() == 1);
    REQUIRE(pack.columns[0].name == "red");
    REQUIRE(pack.columns[0].numbers == std::vector<double>{255, 0});
}

TEST_CASE("unusable PLY is refused with line or byte", "[export]") {
    const std::string properties =
        "property float x\nproperty float y\nproperty float z\nproperty float radius\nend_header\n";
    REQUIRE_THAT(errorOf("p.ply", "off\n"), Contains("not a PLY"));
    REQUIRE_THAT(errorOf("p.ply", "ply\nformat ascii 1.0\nelement face 1\nend_header\n"),
                 Contains("vertex"));
    REQUIRE_THAT(errorOf("p.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000000000000\n" +
                                      properties + "1 2 3 4\n"),
                 Contains("cut short"));
    REQUIRE_THAT(errorOf("p.ply",
                         "ply\nformat binary_little_endian 1.0\nelement vertex "
                         "4000000000000000000\n" +
                             properties + "1234567890123456"),
                 Contains("cut short"));
    REQUIRE_THAT(errorOf("p.ply", "ply\nformat ascii 1.0\nelement vertex 2\n" + properties +
                                      "1 2 3 4\n1 2 inf 4\n"),
                 Contains("line 10") && Contains("finite"));
    REQUIRE_THAT(errorOf("p.ply", "ply\nformat pdp 1.0\n"), Contains("line 2"));
    REQUIRE_THAT(errorOf("p.ply",
                         "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty "
                         "list uint float bones\n" +
                             properties + "\xff\xff\xff\x7f"),
                 Contains("longer than the file"));
}

TEST_CASE("YADE text is read with and without its format line", "[export]") {
    const std::vector<Sphere<3>> spheres = {{{{1, 2, 3}}, 0.5}, {{{4, 5, 6}}, 1}};
    REQUIRE(readText("p.txt", "1 2 3 0.5\n\n4\t5  6 1").spheres == spheres);
    REQUIRE(
        readText("p.txt", "\n# made by hand\r\n1 2 3 0.5\r\n# the second\r\n4 5 6 1\r\n").spheres ==
        spheres);
    const auto pack = readText("p.txt", "#format x_y_z_r_matId\n# hello\n1 2 3 .5 4\n4 5 6 1 0\n");
    REQUIRE(pack.spheres == spheres);
    REQUIRE(pack.region == std::vector<std::int32_t>{4, 0});
    REQUIRE(readText("p.txt", "").spheres.empty());
    REQUIRE_THAT(errorOf("p.txt", "#format x1_y1_z1_x2_y2_z2_x3_y3_z3\n"), Contains("x1_y1_z1"));
    REQUIRE_THAT(errorOf("p.txt", "#format x_y_z_r_mass\n"), Contains("x_y_z_r_mass"));
    REQUIRE_THAT(errorOf("p.txt", "#format\n1 2 3 4\n"), Contains("format ''"));
    REQUIRE_THAT(errorOf("p.txt", "1 2 3 4\n#format x_y_z_r\n"), Contains("before the spheres"));
    REQUIRE_THAT(errorOf("p.txt", "1 2 3 4\n1 2 3 4 5\n"), Contains("line 2: has 5 numbers"));
    REQUIRE_THAT(errorOf("p.txt", "1 2 3 4\n1 2 x 4\n"), Contains("line 2") && Contains("'x'"));
    REQUIRE_THAT(errorOf("p.txt", "# unit of length: furlong\n1 2 3 4\n"), Contains("furlong"));
    REQUIRE_THAT(errorOf("p.txt", "1 2 nan 4\n"), Contains("not finite"));
}

TEST_CASE("every format of YADE's textExt and textClumps is read", "[export]") {
    const std::vector<Sphere<3>> spheres = {{{{1e-05, -2, 3}}, 0.5}, {{{4, 5, 6}}, 1}};
    const auto ids = readText("p.txt",
                              "#format id_x_y_z_r_matId\n7\t1e-05\t-2\t3\t0.5\t2\n"
                              "9\t4\t5\t6\t1\t0\n");
    REQUIRE(ids.spheres == spheres);
    REQUIRE(ids.id == std::vector<std::int64_t>{7, 9});
    REQUIRE(ids.region == std::vector<std::int32_t>{2, 0});

    const auto clumps = readText("p.txt",
                                 "#format x_y_z_r_clumpId\n1e-05\t-2\t3\t0.5\t12\n"
                                 "4\t5\t6\t1\t12\n");
    REQUIRE(clumps.spheres == spheres);
    REQUIRE(clumps.columns.at(0).name == "clumpId");
    REQUIRE(clumps.columns[0].numbers == std::vector<double>{12, 12});

    const std::string rows = "1e-05\t-2\t3\t0.5\t7.5\tbone\n4\t5\t6\t1\t8\t1\n";
    const auto named = readText("p.txt", "#format x_y_z_r_attrs\n# x y z r distance kind\n" + rows);
    REQUIRE(named.spheres == spheres);
    REQUIRE(named.columns.at(0).name == "distance");
    REQUIRE(named.columns[0].numbers == std::vector<double>{7.5, 8});
    REQUIRE(named.columns.at(1).name == "kind");
    REQUIRE(named.columns[1].texts == std::vector<std::string>{"bone", "1"});

    const auto unnamed = readText("p.txt", "#format x_y_z_r_attrs\n# of a run\n" + rows);
    REQUIRE(unnamed.spheres == spheres);
    REQUIRE(unnamed.columns.at(1).name == "attribute2");
    REQUIRE_THAT(errorOf("p.txt", "#format x_y_z_r_attrs\n1 2 3 4 5\n1 2 3 4\n"),
                 Contains("line 3: has 4 numbers"));
}
