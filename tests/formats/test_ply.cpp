// PLY files of other programs.
#include "formats/file_text.h"
#include "support/test.h"

TEST_CASE("PLY is read as text and in both byte orders, whatever else it holds") {
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

TEST_CASE("unusable PLY is refused with line or byte") {
    const std::string properties =
        "property float x\nproperty float y\nproperty float z\nproperty float radius\nend_header\n";
    REQUIRE_THAT(errorOf("p.ply", "off\n"), Contains("PLY"));
    REQUIRE_THAT(errorOf("p.ply", "ply\nformat ascii 1.0\nelement face 1\nend_header\n"),
                 Contains("vertex"));
    for (const char* const length : {"9.3e19", "-1", "1e400", "nan", "2.5"})
        REQUIRE_THAT(errorOf("p.ply",
                             "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int i\n"
                             "element vertex 1\n" +
                                 properties + length + " 0 0 0\n1 2 3 4\n"),
                     Contains("line 11") && Contains("property 'i'"));
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
                 Contains("line 10"));
    REQUIRE_THAT(errorOf("p.ply", "ply\nformat pdp 1.0\n"), Contains("line 2"));
    REQUIRE_THAT(errorOf("p.ply",
                         "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty "
                         "list uint float bones\n" +
                             properties + "\xff\xff\xff\x7f"),
                 Contains("p.ply"));
}
