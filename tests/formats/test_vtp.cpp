// .vtp of ParaView and others, in every encoding.
#include "formats/file_text.h"
#include "support/test.h"
#include "support/vtk_encoding.h"

namespace {

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

TEST_CASE("VTP is read in every encoding that ParaView writes") {
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

TEST_CASE("an ASCII array needs no compressor, whatever the header names") {
    Variant v;
    v.format = "ascii";
    v.zlib = true;
    auto text = VtpText(v).pack();
    text.replace(text.find("ZLib"), 4, "LZ4");
    requireFourSpheres(readText("p.vtp", text));
}

TEST_CASE("damaged VTP is refused with the reason") {
    Variant v;
    v.format = "raw";
    v.zlib = GENERATE(false, true);
    const auto whole = VtpText(v).pack();
    const auto changed = [&whole](const std::string& from, const std::string& to) {
        auto text = whole;
        text.replace(text.find(from), from.size(), to);
        return text;
    };
    REQUIRE_THAT(errorOf("p.vtp", changed("Points=\"4\"", "Points=\"5\"")), Contains("p.vtp"));
    REQUIRE_THAT(errorOf("p.vtp", changed("Points=\"4\"", "Points=\"900000000000000000\"")),
                 Contains("p.vtp"));
    REQUIRE_THAT(errorOf("p.vtp", changed("Points=\"4\"", "Points=\"-4\"")),
                 Contains("NumberOfPoints"));
    REQUIRE_THAT(errorOf("p.vtp", changed("PolyData", "UnstructuredGrid")), Contains("PolyData"));
    REQUIRE_THAT(errorOf("p.vtp", changed("offset=\"0\"", "offset=\"9223372036854775807\"")),
                 Contains("p.vtp"));
    REQUIRE_THAT(errorOf("p.vtp", changed("Int32", "Int33")), Contains("unknown type"));
    REQUIRE_THAT(errorOf("p.vtp", changed("Radius\"", "Rodius\"")), Contains("radius"));
    if (v.zlib) {
        REQUIRE_THAT(errorOf("p.vtp", changed("ZLib", "LZ4")), Contains("LZ4"));
        // The first block of the first array, past its header.
        auto text = whole;
        text[text.find("\n_") + 2 + 20 + 4] ^= 0x55;
        REQUIRE_THAT(errorOf("p.vtp", text), Contains("block"));
    }
}

TEST_CASE("a .vtp may use whatever XML allows") {
    const auto file = [](const std::string& before, const std::string& name) {
        return before +
               "<!DOCTYPE VTKFile [<!ELEMENT a (b)>]><?paraview x?>\n<VTKFile type='PolyData'\n"
               " byte_order=\"LittleEndian\"><!-- <PolyData> --><PolyData><Piece\n"
               "NumberOfPoints = '1' ><PointData><DataArray Name='radius' type='Float64'> 2.5\n"
               "<InformationKey name='L2' location='x'/></DataArray><DataArray Name='" +
               name +
               "' type='Int8' format='ascii'>7</DataArray></PointData><Points><DataArray "
               "type='Float32' NumberOfComponents='3'><![CDATA[1 2]]> 3</DataArray></Points>"
               "</Piece></PolyData></VTKFile>";
    };
    const std::vector<Sphere<3>> sphere = {{{{1, 2, 3}}, 2.5}};
    const auto text = file("", "a &lt;b&gt; &amp; &#233;&#xe9;");
    // Texts after a CDATA section are further texts, which VTK does not write.
    REQUIRE_THAT(errorOf("p.vtp", text), Contains("2 numbers"));
    auto plain = text;
    plain.replace(plain.find("<![CDATA[1 2]]>"), 15, "1 2");
    const auto pack = readText("p.vtp", plain);
    REQUIRE(pack.spheres == sphere);
    REQUIRE(pack.columns.size() == 1);
    REQUIRE(pack.columns[0].name == "a <b> & \xc3\xa9\xc3\xa9");
    REQUIRE(readText("p.vtp", "\xef\xbb\xbf" + plain).spheres == sphere);
}

TEST_CASE("a .vtp that is not well-formed is refused with its byte") {
    REQUIRE_THAT(errorOf("p.vtp", "<VTKFile type=\"PolyData\"><PolyData></VTKFile>"),
                 Contains("byte "));
    REQUIRE_THAT(errorOf("p.vtp", "<VTKFile type=PolyData></VTKFile>"), Contains("byte "));
    REQUIRE_THAT(errorOf("p.vtp", "no XML"), Contains("p.vtp"));
}

TEST_CASE("a .vtp without its last tags is refused as cut short") {
    Variant v;
    v.format = GENERATE(as<std::string>{}, "raw", "base64");
    const auto whole = VtpText(v).pack();
    for (const char* tag : {"</VTKFile>", "</AppendedData>"}) {
        CAPTURE(v.format, tag);
        REQUIRE_THAT(errorOf("p.vtp", whole.substr(0, whole.find(tag))),
                     Contains("cut short") && Contains("p.vtp"));
        REQUIRE_THAT(errorOf("p.vtp", whole.substr(0, whole.find(tag) + 4)), Contains("cut short"));
    }
    // Bytes after the end are none of the file's.
    REQUIRE_THAT(errorOf("p.vtp", whole + "more"), Contains("cut short"));
}

TEST_CASE("messages name an array without a name by the tag around it") {
    const std::string message = errorOf(
        "p.vtp",
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"2\"><PointData><DataArray "
        "type=\"Float32\" Name=\"radius\" format=\"ascii\">1 1</DataArray></PointData><Points>"
        "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 x 1"
        "</DataArray></Points></Piece></PolyData></VTKFile>");
    REQUIRE_THAT(message, Contains("<Points>") && Contains("'x'") && !Contains("''"));
}
