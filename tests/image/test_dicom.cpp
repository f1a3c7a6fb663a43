#include "support/dicom_file.h"
#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/image/image_file.h"

namespace {

std::string refusalOf(const std::string& path) {
    return messageOf<InputError>([&] { readImage(path); });
}

double valueAt(const Image& image, std::size_t voxel) {
    return image.visit([&](const auto* numbers) { return image.value(numbers[voxel]); });
}

Image readWith(const std::string& path, const Vec<3>& spacing) {
    ImageReadOptions options;
    options.spacing = spacing;
    return readImage(path, options);
}

/// Frames at heights, in this order.
DicomElements framesAt(const std::vector<std::string>& heights) {
    std::vector<DicomElements> frames;
    for (const std::string& height : heights) frames.push_back(dicomFrame(height));
    return dicomFrames(frames);
}

}  // namespace

TEST_CASE("DICOM: values are numbers by slope and intercept, however they are displayed") {
    const TemporaryFolder folder;
    const std::string pixels = dicomShort(0) + dicomShort(24) + dicomShort(1024) + dicomShort(3071);
    for (const char* display : {"MONOCHROME2", "MONOCHROME1"})
        for (const char* slope : {"1", "0.5"}) {
            CAPTURE(display, slope);
            for (const char* height : {"0", "2"})
                writeBytes(folder.file(height), dicomSlice(height, pixels)
                                                    .set(0x28, 4, "CS", display)
                                                    .set(0x28, 0x1052, "DS", "-1024")
                                                    .set(0x28, 0x1053, "DS", slope)
                                                    .file());
            const Image image = readImage(folder.file(""));
            const double stored[] = {0, 24, 1024, 3071};
            for (std::size_t i = 0; i < 8; ++i)
                CHECK(valueAt(image, i) == std::stod(slope) * stored[i % 4] - 1024);
        }
    // Scales that differ.
    writeBytes(folder.file("2"), dicomSlice("2", pixels).set(0x28, 0x1053, "DS", "2").file());
    CHECK(valueAt(readImage(folder.file("")), 7) == 6142);
}

TEST_CASE("DICOM: slices without PixelSpacing are refused, or have the spacing that is set") {
    const TemporaryFolder folder;
    const bool detector = GENERATE(false, true);
    for (const char* height : {"0", "2"}) {
        DicomElements slice = dicomSlice(height).erase(0x28, 0x30);
        if (detector) slice.set(0x18, 0x1164, "DS", "0.7\\0.5");
        writeBytes(folder.file(height), slice.file());
    }
    CHECK_THAT(refusalOf(folder.file("")), Contains("axis 1, 2; set `voxelSpacing`"));
    const Image image = readWith(folder.file(""), {{0.5, 0.7, 5}});
    CHECK(image.grid.spacing() == Vec<3>{{0.5, 0.7, 2}});  // positions are stated
    CHECK_FALSE(image.isSpaced);
}

TEST_CASE("DICOM: a slice that lies beside the others is refused") {
    const TemporaryFolder folder;
    for (const char* height : {"0", "1", "2", "3"})
        writeBytes(folder.file(height), dicomSlice(height).file());
    CHECK(readImage(folder.file("")).grid.size[2] == 4);
    writeBytes(folder.file("1"), dicomSlice("1").set(0x20, 0x32, "DS", "0.5\\0\\1").file());
    CHECK_THAT(refusalOf(folder.file("")), Contains("0.5 mm beside"));
}

TEST_CASE("DICOM: frames lie where their functional groups place them") {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.dcm");
    writeBytes(path, framesAt({"0", "4", "2", "6"}).file());
    const Image image = readImage(path);
    CHECK(image.grid.size == std::array<std::size_t, 3>{2, 2, 4});
    CHECK(image.grid.spacing() == Vec<3>{{0.5, 0.7, 2}});
    CHECK(image.grid.origin == Vec<3>{{10, 20, 0}});
    const double order[] = {0, 2, 1, 3};
    for (std::size_t i = 0; i < 16; ++i)
        CHECK(valueAt(image, i) == 2 * (100 * order[i / 4] + static_cast<double>(i % 4)) - 1000);

    writeBytes(path, framesAt({"0", "2", "10"}).file());
    CHECK_THAT(refusalOf(path), Contains("0, 2, 10 mm"));
    writeBytes(path, framesAt({"0", "2", "0", "2"}).file());
    CHECK_THAT(refusalOf(path),
               Contains("frame 1") && Contains("frame 3") && Contains("same position"));
    writeBytes(path, dicomFrames({dicomFrame("0"), dicomFrame("2"), dicomFrame("4", "2")}).file());
    CHECK_THAT(refusalOf(path), Contains("stack 2") && Contains("several volumes"));
    writeBytes(path, framesAt({"0", "2"}).setItems(0x5200, 0x9230, {dicomFrame("0")}).file());
    CHECK_THAT(refusalOf(path), Contains("2 frames"));

    // Spacing, directions and scale of each frame.
    DicomElements measures, axes, scale;
    measures.set(0x28, 0x30, "DS", "3\\4");
    axes.set(0x20, 0x37, "DS", "0\\1\\0\\0\\0\\1");
    std::vector<DicomElements> frames;
    for (const char* x : {"7", "5"}) {
        DicomElements position;
        position.set(0x20, 0x32, "DS", std::string(x) + "\\1\\2");
        scale.set(0x28, 0x1052, "DS", x).set(0x28, 0x1053, "DS", "1");
        frames.push_back(DicomElements()
                             .setItems(0x20, 0x9113, {position})
                             .setItems(0x28, 0x9110, {measures})
                             .setItems(0x20, 0x9116, {axes})
                             .setItems(0x28, 0x9145, {scale}));
    }
    writeBytes(path, dicomFrames(frames).file());
    const Image turned = readImage(path);
    CHECK(turned.grid.origin == Vec<3>{{5, 1, 2}});
    CHECK(turned.grid.step == std::array<Vec<3>, 3>{{{{0, 4, 0}}, {{0, 0, 3}}, {{2, 0, 0}}}});
    CHECK(valueAt(turned, 0) == 105);
    CHECK(valueAt(turned, 5) == 8);
}

TEST_CASE("DICOM: frames without positions need distances that are stated or set") {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.dcm");
    DicomElements frames = framesAt({"0", "0", "0"}).erase(0x5200, 0x9229).erase(0x5200, 0x9230);
    frames.set(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.7.2");
    writeBytes(path, frames.file());
    CHECK_THAT(refusalOf(path), Contains("axis 1, 2, 3; set `voxelSpacing`"));
    CHECK(readWith(path, {{1, 2, 3}}).grid.spacing() == Vec<3>{{1, 2, 3}});
    writeBytes(path, frames.set(0x28, 0x30, "DS", "0.7\\0.5").file());
    CHECK_THAT(refusalOf(path), Contains("axis 3; set"));
    writeBytes(path, frames.set(0x18, 0x88, "DS", "4").file());
    CHECK(readImage(path).grid.spacing() == Vec<3>{{0.5, 0.7, 4}});
    writeBytes(path, frames.set(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.66.5").file());
    CHECK_THAT(refusalOf(path), Contains("surface segmentation"));
}
