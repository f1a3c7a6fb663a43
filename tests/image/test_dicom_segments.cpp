#include "support/dicom_file.h"
#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/image/image_file.h"
#include "vdbpack/image/image_surface.h"

namespace {

/// A frame of a segmentation: the segment (0: none is stated) at a height.
DicomElements frameOf(std::size_t segment, const std::string& height) {
    DicomElements frame = dicomFrame(height), identification;
    identification.set(0x62, 0xb, "US", dicomShort(segment));
    return segment > 0 ? frame.setItems(0x62, 0xa, {identification}) : frame;
}

/// Segments 1, "hip bone", and 2, "femur", in frames of 2 x 2 pixels, 0.5 x 0.7 mm apart.
DicomElements segmentation(const std::string& kind, std::size_t bits, const std::string& pixels,
                           const std::vector<DicomElements>& frames) {
    std::vector<DicomElements> names(2);
    names[0].set(0x62, 4, "US", dicomShort(1)).set(0x62, 5, "LO", "hip bone");
    names[1].set(0x62, 4, "US", dicomShort(2)).set(0x62, 5, "LO", "femur");
    return dicomFrames(frames)
        .set(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.66." + std::string(bits == 16 ? "7" : "4"))
        .set(0x28, 0x100, "US", dicomShort(bits))
        .set(0x28, 0x101, "US", dicomShort(bits))
        .set(0x28, 0x102, "US", dicomShort(bits - 1))
        .set(0x62, 1, "CS", kind)
        .setItems(0x62, 2, names)
        .set(0x7fe0, 0x10, "OW", pixels);
}

std::vector<double> valuesOf(const Image& image, std::size_t layer = 0) {
    std::vector<double> values;
    image.visit([&](const auto* numbers) {
        for (std::size_t i = layer; i < image.values(); i += image.layers)
            values.push_back(image.value(numbers[i]));
    });
    return values;
}

}  // namespace

TEST_CASE("DICOM: segments are labels with names, where their frames lie") {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.dcm");
    // Slices at 0, 2 and 6 mm: the one at 4 mm has no frame. Segment 2 in two slices, 1 in one.
    const std::vector<DicomElements> frames{frameOf(2, "6"), frameOf(1, "0"), frameOf(2, "2")};
    const std::vector<double> right{1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 2, 2};
    // Pixels of the frames: 0011, 1000, 0100; bits begin with the lowest.
    const std::string bits("\x1c\x02", 2);
    const std::string fractions("\0\x63\x64\xc8\xff\0\0\x63\0\x64\x63\0", 12);
    std::vector<std::string> warnings;
    ImageReadOptions options;
    options.callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
    for (const bool fractional : {false, true}) {
        DicomElements file = fractional ? segmentation("FRACTIONAL", 8, fractions, frames)
                                        : segmentation("BINARY", 1, bits, frames);
        writeBytes(path, file.set(0x62, 0xe, "US", dicomShort(200)).file());
        const Image image = readImage(path, options);
        CHECK(image.grid.size == std::array<std::size_t, 3>{2, 2, 4});
        CHECK(image.grid.spacing() == Vec<3>{{0.5, 0.7, 2}});
        CHECK(image.grid.origin == Vec<3>{{10, 20, 0}});
        CHECK(image.layers == 1);
        CHECK(valuesOf(image) == right);
        const auto labels = labelsOf(image).value();
        REQUIRE(labels.size() == 2);
        CHECK(labels[0].name == "hip bone");
        CHECK(labels[1].name == "femur");
        CHECK(labels[1].voxels == 3);
        CHECK(warnings.size() == (fractional ? 1 : 0));
    }
    CHECK_THAT(warnings.at(0), Contains("100 of 200"));

    std::string numbers;
    for (const double label : {0, 1, 2, 2, 0, 0, 0, 1})
        numbers += dicomShort(static_cast<std::size_t>(label));
    writeBytes(path, segmentation("LABELMAP", 16, numbers, {frameOf(0, "3"), frameOf(0, "0")})
                         .set(0x28, 4, "CS", "PALETTE COLOR")
                         .file());
    const Image map = readImage(path);
    CHECK(valuesOf(map) == std::vector<double>{0, 0, 0, 1, 0, 1, 2, 2});
    CHECK(labelsOf(map).value().back().name == "femur");
}

TEST_CASE("DICOM: segments that overlap lie in layers, and what cannot be placed is refused") {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.dcm");
    const auto write = [&](const std::vector<DicomElements>& frames) {
        // 0011, 0110: one pixel in common.
        writeBytes(path, segmentation("BINARY", 1, std::string("\x6c\0", 2), frames).file());
    };
    DicomElements between;
    between.set(0x28, 0x30, "DS", "0.7\\0.5").set(0x18, 0x88, "DS", "3");
    std::vector<DicomElements> frames{frameOf(1, "5"), frameOf(2, "5")};
    write(frames);
    CHECK_THAT(messageOf<InputError>([&] { readImage(path); }), Contains("SpacingBetweenSlices"));
    for (DicomElements& frame : frames) frame.setItems(0x28, 0x9110, {between});
    write(frames);
    const Image image = readImage(path);
    CHECK(image.grid.step[2] == Vec<3>{{0, 0, 3}});
    REQUIRE(image.layers == 2);
    CHECK(valuesOf(image, 0) == std::vector<double>{0, 0, 1, 1, 0, 0, 0, 0});
    CHECK(valuesOf(image, 1) == std::vector<double>{0, 2, 2, 0, 0, 0, 0, 0});
    const auto labels = labelsOf(image).value();
    CHECK(labelSurfaces(image, labels, parseLabels("femur", labels, "a")).size() == 1);

    DicomElements aside = frameOf(2, "2"), position;
    aside.setItems(0x20, 0x9113, {position.set(0x20, 0x32, "DS", "11\\20\\2")});
    struct Row {
        std::vector<DicomElements> frames;
        const char* text;
    };
    const Row rows[] = {{{frameOf(1, "0"), frameOf(1, "0"), frameOf(1, "2")}, "frame 1"},
                        {{frameOf(1, "0"), frameOf(1, "2"), aside}, "frame 3: lies beside"},
                        {{frameOf(1, "0"), frameOf(2, "2"), frameOf(1, "5")}, "0, 2, 5 mm"},
                        {{frameOf(0, "0"), frameOf(2, "2")}, "does not state its segment"},
                        {{frameOf(1, "0"), frameOf(2, "0.01"), frameOf(1, "9999")}, "9999 mm"}};
    for (const Row& row : rows) {
        write(row.frames);
        CAPTURE(row.text);
        CHECK_THAT(messageOf<InputError>([&] { readImage(path); }), Contains(row.text));
    }
}

TEST_CASE("DICOM: damaged segmentations are read or refused") {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.dcm");
    const std::string whole =
        segmentation("BINARY", 1, std::string("\x6c\0", 2), {frameOf(1, "0"), frameOf(2, "2")})
            .file();
    for (std::size_t at = 132; at < whole.size(); ++at) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x41);
        CAPTURE(at);
        writeBytes(path, damaged);
        try {
            readImage(path);
        } catch (const InputError&) {
        }
        writeBytes(path, whole.substr(0, at));
        CHECK_FALSE(messageOf<InputError>([&] { readImage(path); }).empty());
    }
}
