#include "support/dicom_file.h"
#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/image/image_file.h"
#include "vdbpack/image/image_surface.h"

#include <filesystem>

namespace {

constexpr std::int16_t kBytes = 2;  // of NIfTI

/// A mask of the voxels from x = `low` to `high`; its grid has 8 x 4 x 4.
Voxels<std::uint8_t> slab(double low, double high, int value = 1) {
    ImageGrid grid;
    grid.size = {8, 4, 4};
    grid.origin = {{5, -7, 9}};
    grid.step = {{{{2, 0, 0}}, {{0, 2, 0}}, {{0, 0, 3}}}};
    return Voxels<std::uint8_t>::of(grid, [&](const Vec<3>& p) {
        const double x = (p[0] - 5) / 2;
        return x >= low && x <= high ? value : 0;
    });
}

/// Values of a layer along the first row.
std::vector<int> rowOf(const Image& image, std::size_t layer) {
    std::vector<int> row;
    image.visit([&](const auto* numbers) {
        for (std::size_t x = 0; x < image.grid.size[0]; ++x)
            row.push_back(static_cast<int>(numbers[x * image.layers + layer]));
    });
    return row;
}

/// A file of the kind that `path` names.
void write(const std::string& path, const Voxels<std::uint8_t>& voxels) {
    if (path.back() == 'i') writeNifti(path, voxels, kBytes);
    if (path.back() == 'd') writeNrrd(path, voxels, "uint8");
    if (path.back() == 'a') writeMeta(path, voxels, "MET_UCHAR");
}

}  // namespace

TEST_CASE("a folder of masks is a label map with the names of the files, without empty ones") {
    const TemporaryFolder folder;
    const std::string path = folder.file("masks");
    std::filesystem::create_directory(path);
    write(path + "/femur_left.nii", slab(0, 1, 255));
    write(path + "/hip.nrrd", slab(2, 3));
    write(path + "/rib.1.mha", slab(9, 9));
    write(path + "/sacrum.nii", slab(4, 6));
    writeBytes(path + "/statistics.json", "{}");
    writeBytes(path + "/._sacrum.nii", "of macOS");
    std::vector<std::string> warnings;
    ImageReadOptions options;
    options.callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
    const Image image = readImage(path, options);
    CHECK(image.format == "4 masks, NIfTI");
    CHECK(image.layers == 1);
    CHECK(image.grid.at({}) == Vec<3>{{5, -7, 9}});
    CHECK(rowOf(image, 0) == std::vector<int>{1, 1, 2, 2, 4, 4, 4, 0});
    CHECK(warnings == std::vector<std::string>{path + ": empty masks are left out, 1 of 4: rib.1"});
    const auto labels = labelsOf(image).value();
    REQUIRE(labels.size() == 3);
    CHECK(labels[2].name == "sacrum");
    CHECK(labels[2].voxels == 3 * 16);
    const auto parts = parseLabels("femur_left+hip,sacrum", labels, path);
    REQUIRE(parts.size() == 2);
    CHECK(parts[0].voxels() == 4 * 16);
}

TEST_CASE("masks that overlap lie in layers of their own") {
    const TemporaryFolder folder;
    write(folder.file("a.nii"), slab(0, 3));
    write(folder.file("b.nii"), slab(3, 5));
    write(folder.file("c.nii"), slab(6, 7));
    const Image image = readImage(folder.file("."));
    REQUIRE(image.layers == 2);
    CHECK(rowOf(image, 0) == std::vector<int>{1, 1, 1, 1, 0, 0, 3, 3});
    CHECK(rowOf(image, 1) == std::vector<int>{0, 0, 0, 2, 2, 2, 0, 0});
    const auto labels = labelsOf(image).value();
    REQUIRE(labels.size() == 3);
    CHECK(labels[2].name == "b");
    CHECK(labels[2].layer == 1);
}

TEST_CASE("what is no mask beside masks is refused by name") {
    auto other = slab(0, 3), shifted = other, larger = other;
    other.values[5] = 2;
    shifted.grid.origin[0] += 0.5;
    larger.grid.size[2] = 3;
    larger.values.resize(larger.grid.voxels());
    struct Row {
        std::string name;
        std::function<void(const std::string&)> make;
        std::string text;
    };
    const Row rows[] = {
        {"ct.nii", [&](const auto& file) { write(file, other); },
         "ct.nii: has the values 0, 1 and 2"},
        {"moved.nii", [&](const auto& file) { write(file, shifted); },
         "moved.nii: lies 0.25 voxels"},
        {"flat.nrrd", [&](const auto& file) { write(file, larger); },
         "flat.nrrd: has 8 x 4 x 3 voxels"},
        {"s1.tif", [](const auto& file) { writeBytes(file, "II"); }, "slices such as"},
        {"IM0001", [](const auto& file) { writeBytes(file, dicomSlice("0").file()); }, "IM0001"}};
    for (const Row& row : rows) {
        const TemporaryFolder folder;
        write(folder.file("a.nii"), slab(0, 1));
        row.make(folder.file(row.name));
        CHECK_THAT(messageOf<InputError>([&] { readImage(folder.file(".")); }), Contains(row.text));
    }
    const TemporaryFolder folder;
    write(folder.file("a.nii"), slab(9, 9));
    CHECK_THAT(messageOf<InputError>([&] { readImage(folder.file(".")); }), Contains("are empty"));
}

TEST_CASE("labels have the names in the extension of a NIfTI header") {
    const TemporaryFolder folder;
    auto voxels = slab(0, 3);
    std::fill_n(voxels.values.begin(), 2, std::uint8_t{27});
    std::string header = niftiHeader(voxels, kBytes);
    std::string table =
        "<?xml version=\"1.0\"?><CaretExtension><VolumeInformation Index=\"0\"><LabelTable>"
        "<Label Key=\"0\"><![CDATA[???]]></Label><Label Key=\"1\" Red=\"0.5\"><![CDATA[spleen]]>"
        "</Label>\n<Label Key=\"27\">vertebrae_L5</Label></LabelTable></VolumeInformation>"
        "</CaretExtension>";
    table.resize((table.size() + 8 + 15) / 16 * 16 - 8, ' ');
    const float begin = static_cast<float>(352 + 8 + table.size());
    header.replace(108, 4, reinterpret_cast<const char*>(&begin), 4);
    header[348] = 1;
    writeBytes(folder.file("a.nii"), header + littleEndian(8 + table.size(), 4) +
                                         littleEndian(0, 4) + table + bytesOfValues(voxels.values));
    const auto labels = labelsOf(readImage(folder.file("a.nii"))).value();
    REQUIRE(labels.size() == 2);
    CHECK(labels[0].name == "spleen");
    CHECK(labels[1].name == "vertebrae_L5");
    CHECK(parseLabels("vertebrae_L5", labels, "a").front().voxels() == 2);
}
