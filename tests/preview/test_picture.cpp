#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/preview/color.h"
#include "vdbpack/preview/picture.h"
#include "vdbpack/preview/preview.h"

#include <png.h>

#include <iterator>

namespace {

Picture noise(int width, int height) {
    Picture image;
    image.width = width;
    image.height = height;
    RandomStream random(1, 0);
    for (int i = 0; i < 3 * width * height; ++i)
        image.pixels.push_back(static_cast<std::uint8_t>(random.bits() & 255));
    image.texts = {{"Title", "noise"}, {"Description", "0.5 mm³ <&>"}};
    return image;
}

std::vector<std::uint8_t> decoded(const std::string& bytes, int& width, int& height) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) != 0);
    png.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(png));
    REQUIRE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr) != 0);
    width = static_cast<int>(png.width);
    height = static_cast<int>(png.height);
    return pixels;
}

}  // namespace

TEST_CASE("a PNG file is read back with its pixels and texts") {
    const Picture image = noise(31, 17);
    const TemporaryFolder folder;
    const std::string path = folder.file("noise.png");
    writePng(image, path);
    const std::string bytes = contentOf(path);
    CHECK(bytes == encodePng(image));
    int width = 0, height = 0;
    CHECK(decoded(bytes, width, height) == image.pixels);
    CHECK(width == image.width);
    CHECK(height == image.height);
    CHECK(bytes.find("0.5 mm³ <&>") != std::string::npos);
}

TEST_CASE("a picture without enough pixels is refused, and no file is written") {
    Picture image = noise(4, 4);
    image.pixels.pop_back();
    CHECK_THROWS_AS(encodePng(image), ParameterError);
    CHECK_THROWS_AS(encodePng(Picture{}), ParameterError);
    const TemporaryFolder folder;
    CHECK_THROWS_AS(writePng(image, folder.file("a.png")), ParameterError);
    CHECK(!std::ifstream(folder.file("a.png")).good());
    CHECK_THROWS_AS(writePng(noise(2, 2), folder.file("no/a.png")), IoError);
}

TEST_CASE("equal steps along the ramp are equal steps of lightness") {
    // Lightness of Oklab, from linear light; the constants are those of its definition.
    const auto lightness = [](const Color& c) {
        const double l = 0.4122214708 * c.r + 0.5363325363 * c.g + 0.0514459929 * c.b;
        const double m = 0.2119034982 * c.r + 0.6806995451 * c.g + 0.1073969566 * c.b;
        const double s = 0.0883024619 * c.r + 0.2817188376 * c.g + 0.6299787005 * c.b;
        return 0.2104542553 * std::cbrt(l) + 0.7936177850 * std::cbrt(m) -
               0.0040720468 * std::cbrt(s);
    };
    const double low = lightness(rampColor(0)), high = lightness(rampColor(1));
    CHECK(high - low > 0.45);
    for (int i = 0; i <= 20; ++i) {
        CAPTURE(i);
        CHECK(lightness(rampColor(i / 20.0)) == Approx(low + (high - low) * i / 20).margin(0.003));
    }
    CHECK(lightness(rampColor(-3)) == low);
    CHECK(lightness(rampColor(7)) == high);
}

TEST_CASE("colors are unchanged by conversion to linear light and back") {
    for (const std::uint32_t rgb : {0x000000u, 0xffffffu, 0x4a78a8u, 0x010203u, 0x80fe7fu}) {
        std::uint8_t back[3];
        toSrgb(fromSrgb(rgb), back);
        CHECK((static_cast<std::uint32_t>(back[0]) << 16 |
               static_cast<std::uint32_t>(back[1]) << 8 | back[2]) == rgb);
    }
}

TEST_CASE("texts of preview options are parsed, or refused with the expected form") {
    CHECK(parsePreviewCut("y=-12.5").axis == 1);
    CHECK(parsePreviewCut("y=-12.5").at == -12.5);
    for (const char* bad : {"", "x", "x=", "w=1", "x=1mm", "x=nan", "x=inf", "1"}) {
        CAPTURE(bad);
        CHECK_THROWS_WITH(parsePreviewCut(bad), Contains("x=V"));
    }
    CHECK(parsePreviewView("left").from == Vec<3>{{1, 0, 0}});
    CHECK(parsePreviewView("left").ofPatient);
    CHECK(parsePreviewView("1,-2,0.5").from == Vec<3>{{1, -2, 0.5}});
    CHECK(!parsePreviewView("1,-2,0.5").ofPatient);
    for (const char* bad : {"", "Front", "1,2", "1,2,3,4", "0,0,0", "1,2,nan", "1,2,x"}) {
        CAPTURE(bad);
        CHECK_THROWS_WITH(parsePreviewView(bad), Contains("front, back"));
    }
    CHECK(parsePreviewSize("640x480") == std::array<int, 2>{640, 480});
    CHECK(parsePreviewSize("640") == std::array<int, 2>{640, 0});
    for (const char* bad :
         {"", "640,480", "640x", "640x0", "x480", "640x480x", "640 x 480", "1e3x10"}) {
        CAPTURE(bad);
        CHECK_THROWS_WITH(parsePreviewSize(bad), Contains("1600x1200"));
    }
    for (const char* bad : {"0x100", "15x100", "100x20000", "-100x100", "10", "0", "20000"})
        CHECK_THROWS_AS(parsePreviewSize(bad), ParameterError);
}
