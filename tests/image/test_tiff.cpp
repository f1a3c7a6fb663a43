#include "support/dicom_file.h"
#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/image/image_file.h"

namespace {

/// A grey page of 2 x 2 pixels, 100 a cm, with further entries of numbers in ascending order.
struct Tiff {
    std::string data = std::string(4, '\1');  ///< of its one strip or tile
    std::size_t bits = 8, color = 1, format = 1;
    bool tiled = false;  ///< 16 x 16 pixels

    std::string bytes() const {
        const auto entry = [](std::size_t tag, std::size_t type, std::size_t value) {
            return littleEndian(tag, 2) + littleEndian(type, 2) + littleEndian(1, 4) +
                   littleEndian(value, 4);
        };
        const std::size_t at = 8 + data.size();
        std::string page = entry(256, 4, 2) + entry(257, 4, 2) + entry(258, 3, bits) +
                           entry(259, 3, 1) + entry(262, 3, color);
        if (!tiled) page += entry(273, 4, 8);
        page += entry(277, 3, 1);
        if (!tiled) page += entry(278, 4, 2) + entry(279, 4, data.size());
        page += entry(282, 5, at) + entry(283, 5, at) + entry(296, 3, 3);
        if (tiled)
            page += entry(322, 3, 16) + entry(323, 3, 16) + entry(324, 4, 8) +
                    entry(325, 4, data.size());
        page += entry(339, 3, format);
        return "II*" + std::string(1, '\0') + littleEndian(at + 8, 4) + data +
               littleEndian(100, 4) + littleEndian(1, 4) + littleEndian(page.size() / 12, 2) +
               page + std::string(4, '\0');
    }
};

Tiff filledWith(char value) {
    Tiff tiff;
    tiff.data = std::string(4, value);
    return tiff;
}

ImageReadOptions spaced() {
    ImageReadOptions options;
    options.spacing = {{0.5, 0.5, 2}};
    return options;
}

std::string refusalOf(const std::string& path) {
    return messageOf<InputError>([&] { readImage(path, spaced()); });
}

}  // namespace

TEST_CASE("slices of a stack are in the order of their numbers") {
    const TemporaryFolder folder;
    for (int k = 1; k <= 12; ++k)
        writeBytes(folder.file("s" + std::to_string(k) + ".tif"),
                   filledWith(static_cast<char>(k)).bytes());
    for (const char* which : {"", "s*.tif"}) {
        const Image image = readImage(folder.file(which), spaced());
        REQUIRE(image.grid.size == std::array<std::size_t, 3>{2, 2, 12});
        CHECK_FALSE(image.isSided);
        CHECK(image.grid.step[2] == Vec<3>{{0, 0, 2}});
        for (std::size_t k = 0; k < 12; ++k)
            CHECK(std::to_integer<int>(image.bytes[4 * k]) == static_cast<int>(k) + 1);
        std::string warning;
        ImageReadOptions options;
        options.callbacks.warning = [&](const std::string& text) { warning = text; };
        CHECK_THAT(messageOf<InputError>([&] { readImage(folder.file(which), options); }),
                   Contains("voxelSpacing"));
        CHECK_THAT(warning, Contains("0.1 x 0.1 mm"));
    }
}

TEST_CASE("slices that are missing or stray in a stack are refused by name") {
    struct Row {
        std::vector<std::string> names;
        const char* text;  ///< null: read
    };
    const Row rows[] = {
        {{"s_05.tif", "s_06.tif", "s_08.tif"}, "number 7 is missing"},
        {{"s1.tif", "s2.tif", "s9.tif", "s10.tif"}, "number 3 is missing"},
        {{"s0.tif", "s10.tif", "s20.tif"}, nullptr},                  // every tenth
        {{"d7_t13_1.tif", "d7_t15_2.tif", "d7_t29_3.tif"}, nullptr},  // with the time
        {{"d7_t13_1.tif", "d7_t15_2.tif", "d7_t29_4.tif"}, "is missing"},
        {{"top.tif", "middle.tif", "bottom.tif"}, nullptr},
        {{"s1.tif", "s2.tif", "mask.tif"}, "mask.tif: is not named as the other slices"},
    };
    for (const Row& row : rows) {
        const TemporaryFolder folder;
        for (const std::string& name : row.names) writeBytes(folder.file(name), Tiff().bytes());
        CAPTURE(row.names);
        if (row.text)
            CHECK_THAT(refusalOf(folder.file("")), Contains(row.text));
        else
            CHECK(readImage(folder.file(""), spaced()).grid.size[2] == row.names.size());
    }
}

TEST_CASE("grey pixels in tiles and of one bit are read, others are refused for what they are") {
    const TemporaryFolder folder;
    Tiff tiled;
    tiled.tiled = true;
    tiled.data = std::string(256, '\0');
    tiled.data.replace(0, 2, "\5\6").replace(16, 2, "\7\x64");
    Tiff bits;
    bits.bits = 1;
    bits.data = "\x40\x80";  // 0 1, 1 0
    const auto valuesOf = [&](const Tiff& tiff) {
        for (const char* name : {"1.tif", "2.tif"}) writeBytes(folder.file(name), tiff.bytes());
        const Image image = readImage(folder.file(""), spaced());
        std::vector<int> values;
        for (std::size_t i = 4; i < 8; ++i) values.push_back(std::to_integer<int>(image.bytes[i]));
        return values;
    };
    for (const std::size_t color : {1u, 0u}) {
        tiled.color = bits.color = color;
        CAPTURE(color);
        CHECK(valuesOf(tiled) == std::vector{5, 6, 7, 100});
        CHECK(valuesOf(bits) == std::vector{0, 255, 255, 0});
    }
    tiled.bits = 16;
    tiled.data.resize(512);
    writeBytes(folder.file("2.tif"), tiled.bytes());
    CHECK_THAT(refusalOf(folder.file("")), Contains("tiled") && Contains("16 bits"));
    Tiff nibbles;
    nibbles.bits = 4;
    writeBytes(folder.file("2.tif"), nibbles.bytes());
    CHECK_THAT(refusalOf(folder.file("")), Contains("4 bits"));
}
