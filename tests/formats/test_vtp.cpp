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

namespace {

/// A legacy .vtk of the four spheres, with arrays in each kind of statement.
std::string legacyText(bool binary, bool offsets, bool polyData) {
    const auto numbers = [&](const auto& values) {
        std::string text;
        if (binary) return bytesOf(values, true) + "\n";
        for (const auto value : values)
            text += std::to_string(value) + (values.size() % 3 ? " " : "\n");
        return text + "\n";
    };
    std::string text = std::string("# vtk DataFile Version 5.1\ntitle\n") +
                       (binary ? "BINARY" : "ASCII") + "\nDATASET " +
                       (polyData ? "POLYDATA" : "UNSTRUCTURED_GRID") + "\nPOINTS 4 float\n" +
                       numbers(std::vector<float>{0, 0, 0, 10.5f, 0, 0, 0, -20, 0, 0, 0, 30});
    const std::string cells = polyData ? "VERTICES" : "CELLS";
    if (offsets)
        text += cells + " 5 4\nOFFSETS vtktypeint64\n" +
                numbers(std::vector<std::int64_t>{0, 1, 2, 3, 4}) + "CONNECTIVITY vtktypeint64\n" +
                numbers(std::vector<std::int64_t>{0, 1, 2, 3});
    else
        text += cells + " 4 8\n" + numbers(std::vector<std::int32_t>{1, 0, 1, 1, 1, 2, 1, 3});
    if (!polyData) text += "CELL_TYPES 4\n" + numbers(std::vector<std::int32_t>{1, 1, 1, 1});
    return text + "CELL_DATA 4\nSCALARS radius double 1\nLOOKUP_TABLE default\n" +
           numbers(std::vector<double>{9, 9, 9, 9}) + "POINT_DATA 4\nVECTORS v%20elocity float\n" +
           numbers(std::vector<float>{0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, -1}) +
           "SCALARS material int\nLOOKUP_TABLE own\n" +
           numbers(std::vector<std::int32_t>{7, -8, 9, 10}) + "LOOKUP_TABLE own 1\n" +
           (binary ? "abcd\n" : "0 0 0 1\n") + "FIELD FieldData 2\nDiameter 1 4 double\n" +
           numbers(std::vector<double>{2, 4, 1, 8}) + "name 1 4 string\n" +
           (binary ? "\xc3"
                     "a b\xc0\xc1"
                     "c\xc1"
                     "d\n"
                   : "a%20b\n\nc\nd\n");
}

}  // namespace

TEST_CASE("legacy VTK is read as text and binary, of every version and data set") {
    const bool binary = GENERATE(false, true), offsets = GENERATE(false, true);
    const bool polyData = GENERATE(false, true);
    CAPTURE(binary, offsets, polyData);
    const std::string text = legacyText(binary, offsets, polyData);
    const auto pack = readText("p.vtk", text);
    requireFourSpheres(pack);
    REQUIRE(pack.columns.size() == 5);
    CHECK(pack.columns[0].name == "v elocity_0");
    CHECK(pack.columns[2].numbers == std::vector<double>{1, 0, 0, -1});
    CHECK(pack.columns[3].numbers == std::vector<double>{7, -8, 9, 10});
    CHECK(pack.columns[4].texts == std::vector<std::string>{"a b", "", "c", "d"});
    for (std::size_t at = 0; at + 3 < text.size(); at += 7) {
        CAPTURE(at);
        CHECK_THROWS_AS(readText("p.vtk", text.substr(0, at)), InputError);
    }
    const auto changed = [&text](const std::string& from, const std::string& to) {
        auto other = text;
        return other.replace(other.find(from), from.size(), to);
    };
    CHECK_THAT(errorOf("p.vtk", changed("POINT_DATA 4", "POINT_DATA 3")), Contains("POINT_DATA"));
    CHECK_THAT(errorOf("p.vtk", changed("Diameter 1", "Dia 1")),
               Contains("radius") && Contains("Dia"));
    CHECK_THAT(errorOf("p.vtk", changed("Diameter 1 4", "Diameter 1 9000000000000")),
               Contains("more than the file holds"));
    CHECK_THAT(errorOf("p.vtk", changed("int\n", "bit\n")), Contains("'bit'"));
    CHECK_THAT(
        errorOf("p.vtk", changed(polyData ? "POLYDATA" : "UNSTRUCTURED_GRID", "RECTILINEAR")),
        Contains("rectilinear"));
}

TEST_CASE("a legacy .vtk that ParaView made of a pack of ours keeps its unit") {
    CHECK(readText(
              "p.vtk",
              "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nFIELD FieldData 2\n"
              "unit_of_length 1 1 string\nm\nperiodic_cell 1 1 string\nx%200%200%200%201%201%201\n"
              "METADATA\nINFORMATION 0\n\nPOINTS 1 double\n1 2 3\nPOINT_DATA 1\n"
              "SCALARS radius double\nLOOKUP_TABLE default\n0.5\nMETADATA\nINFORMATION 0\n\n")
              .cell.length(0) == 1000);
}

TEST_CASE("unstructured grids in XML are read as polygon data are, alone and in pieces") {
    Variant v;
    v.format = GENERATE(as<std::string>{}, "ascii", "binary", "raw");
    std::string text = VtpText(v).pack();
    for (std::size_t at = 0; (at = text.find("PolyData", at)) != std::string::npos;)
        text.replace(at, 8, "UnstructuredGrid");
    requireFourSpheres(readText("p.vtu", text));
    const TemporaryFolder folder;
    putContent(folder.file("p_0.vtu"), text);
    putContent(folder.file("empty.vtu"),
               "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><Piece NumberOfPoints='0'>"
               "<Points/></Piece></UnstructuredGrid></VTKFile>");
    putContent(folder.file("p.pvtu"),
               "<VTKFile type='PUnstructuredGrid'><PUnstructuredGrid><Piece Source='empty.vtu'/>"
               "<Piece Source='p_0.vtu'/></PUnstructuredGrid></VTKFile>");
    requireFourSpheres(readPack(folder.file("p.pvtu")));
    CHECK_THROWS_WITH(writePack(Pack<3>{}, "p.vtu"), Contains("read but not written"));
}
