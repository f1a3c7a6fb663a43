#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/core/sphere.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/image/image_surface.h"
#include "vdbpack/image/label_map.h"
#include "vdbpack/mesh/mesh_check.h"

namespace {

/// Two half balls on an oblique, anisotropic grid.
Voxels<std::uint8_t> halves(bool leftHanded = false) {
    ImageGrid grid = turned(gridAround(12, {{1, 1.25, 1.5}}, {{0.2, 0.1, 0.3}}), 0.4, 0.9);
    grid.origin += {{100, -250, 700}};
    if (leftHanded) grid.step[2] = -grid.step[2];
    const Vec<3> center =
        grid.at({{0.5 * static_cast<double>(grid.size[0]), 0.5 * static_cast<double>(grid.size[1]),
                  0.5 * static_cast<double>(grid.size[2])}});
    return Voxels<std::uint8_t>::of(grid, [&](const Vec<3>& p) {
        return length(p - center) < 9 ? (p[0] < center[0] ? 3 : 7) : 0;
    });
}

void checkSame(const Image& image, const Voxels<std::uint8_t>& made, double margin) {
    REQUIRE(image.grid.size == made.grid.size);
    REQUIRE(image.type == NumberType::u8);
    for (const Vec<3>& index : {Vec<3>{{0, 0, 0}}, Vec<3>{{20, 3, 14}}, Vec<3>{{-1, 20, 7}}})
        CHECK(length(image.grid.at(index) - made.grid.at(index)) < margin);
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(image.bytes.get());
    CHECK(std::equal(made.values.begin(), made.values.end(), bytes));
}

std::vector<std::string> warningsOf(const std::string& path, Image* image = nullptr) {
    std::vector<std::string> warnings;
    ImageReadOptions options;
    options.callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
    Image read = readImage(path, options);
    if (image) *image = std::move(read);
    return warnings;
}

std::string messageFor(const std::string& path) {
    return messageOf<InputError>([&] { readImage(path); });
}

}  // namespace

TEST_CASE("one image is the same in the world in all formats") {
    const TemporaryFolder folder;
    const auto made = halves(GENERATE(false, true));
    writeMeta(folder.file("a.mha"), made, "MET_UCHAR");
    writeNrrd(folder.file("a.nrrd"), made, "uint8");
    writeNifti(folder.file("a.nii"), made, 2);
    checkSame(readImage(folder.file("a.mha")), made, 1e-9);
    checkSame(readImage(folder.file("a.nrrd")), made, 1e-9);
    checkSame(readImage(folder.file("a.nii")), made, 1e-3);
    CHECK(warningsOf(folder.file("a.nii")).empty());
    CHECK(readImage(folder.file("a.nrrd")).grid.orientation().size() == 3);
}

TEST_CASE("orientation names where each index grows to") {
    ImageGrid grid;
    CHECK(grid.orientation() == "LPS");
    grid.step = {{{{0, 0, -2}}, {{-1, 0.2, 0}}, {{0, 1, 0}}}};
    CHECK(grid.orientation() == "IRP");
    for (const Vec<3>& p : {Vec<3>{{1, 2, 3}}, Vec<3>{{-4, 0, 2.5}}})
        CHECK(length(grid.at(grid.indexOf(p)) - p) < 1e-12);
}

TEST_CASE("axes that are perpendicular up to rounding are made so, sheared ones are kept") {
    const TemporaryFolder folder;
    auto made = halves();
    made.grid.step[0] += 4e-4 * made.grid.step[1];
    writeNrrd(folder.file("rounded.nrrd"), made, "uint8");
    Image image;
    const auto warnings = warningsOf(folder.file("rounded.nrrd"), &image);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings.front(), Contains("perpendicular"));
    CHECK(std::fabs(dot(image.grid.step[0], image.grid.step[1])) < 1e-12);
    CHECK(length(image.grid.step[0]) == Approx(length(made.grid.step[0])));

    made.grid.step[0] += 0.1 * made.grid.step[1];
    writeNrrd(folder.file("sheared.nrrd"), made, "uint8");
    CHECK_THAT(warningsOf(folder.file("sheared.nrrd"), &image).at(0), Contains("sheared"));
    CHECK(length(image.grid.step[0] - made.grid.step[0]) < 1e-9);

    made.grid.step[0] = made.grid.step[1];
    writeNrrd(folder.file("flat.nrrd"), made, "uint8");
    CHECK_THAT(messageFor(folder.file("flat.nrrd")), Contains("plane"));
}

TEST_CASE("a file without the spacing of its voxels is refused unless one is given") {
    const TemporaryFolder folder;
    const auto made = halves();
    const auto& s = made.grid.size;
    const std::string sizes =
        std::to_string(s[0]) + ' ' + std::to_string(s[1]) + ' ' + std::to_string(s[2]);
    writeBytes(folder.file("a.nrrd"), "NRRD0001\ntype: uint8\ndimension: 3\nsizes: " + sizes +
                                          "\nencoding: raw\n\n" + bytesOfValues(made.values));
    writeBytes(folder.file("a.mha"),
               "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = " + sizes +
                   "\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                   bytesOfValues(made.values));
    for (const char* name : {"a.nrrd", "a.mha"}) {
        CHECK_THAT(messageFor(folder.file(name)), Contains("voxelSpacing"));
        ImageReadOptions options;
        options.spacing = {{1, 2, 3}};
        CHECK(readImage(folder.file(name), options).grid.spacing() == Vec<3>{{1, 2, 3}});
    }
}

TEST_CASE("voxels that are not numbers are outside of the surface at a threshold") {
    const TemporaryFolder folder;
    const auto valueAt = [](const Vec<3>& p) { return std::max(-1000.0, 200 * (8 - length(p))); };
    auto made = Voxels<float>::of(gridAround(14, {{1, 1, 1}}), valueAt);
    writeNifti(folder.file("whole.nii"), made, 16);
    const auto volumeAbove = [](const Image& image, const Callbacks& callbacks) {
        return checkMesh(thresholdSurface(image, 0, "a", callbacks)).signedVolume;
    };
    std::size_t unknown = 0;
    forEachVoxel(made.grid, [&](std::size_t i, const Vec<3>& p) {
        if (length(p) < 11) return;
        made.values[i] = std::nanf("");
        ++unknown;
    });
    writeNifti(folder.file("padded.nii"), made, 16);
    writeNrrd(folder.file("padded.nrrd"), made, "float");
    const double volume = volumeAbove(readImage(folder.file("whole.nii")), {});
    CHECK(volume == Approx(4.0 / 3 * kPi * 512).epsilon(0.02));
    for (const char* name : {"padded.nii", "padded.nrrd"}) {
        std::vector<std::string> warnings;
        Callbacks callbacks;
        callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
        const Image image = readImage(folder.file(name));
        CHECK(volumeAbove(image, callbacks) == volume);
        REQUIRE(warnings.size() == 1);
        CHECK_THAT(warnings.front(), Contains(std::to_string(unknown) + " of"));
    }
}

TEST_CASE("NIfTI: the sform counts, and a qform elsewhere is reported") {
    const TemporaryFolder folder;
    const auto made = halves();
    std::string header = niftiHeader(made, 2);
    const std::int16_t code = 1;
    header.replace(252, 2, reinterpret_cast<const char*>(&code), 2);
    writeBytes(folder.file("both.nii"), header + bytesOfValues(made.values));
    Image image;
    CHECK_THAT(warningsOf(folder.file("both.nii"), &image).at(0), Contains("qform"));
    checkSame(image, made, 1e-3);
    CHECK(image.isSided);
    // As a program leaves it that changes the voxels, and not the sform.
    std::string finer = header;
    float spacing;
    std::memcpy(&spacing, finer.data() + 80, sizeof spacing);
    spacing *= 2;
    finer.replace(80, 4, reinterpret_cast<const char*>(&spacing), 4);
    writeBytes(folder.file("finer.nii"), finer + bytesOfValues(made.values));
    CHECK_THAT(warningsOf(folder.file("finer.nii"), &image).at(0), Contains("mm³ by its qform"));
    checkSame(image, made, 1e-3);
    const std::int16_t none = 0;
    for (const std::size_t at : {252u, 254u})
        header.replace(at, 2, reinterpret_cast<const char*>(&none), 2);
    writeBytes(folder.file("none.nii"), header + bytesOfValues(made.values));
    CHECK_THAT(warningsOf(folder.file("none.nii"), &image).at(0), Contains("unknown"));
    CHECK_FALSE(image.isSided);
}

TEST_CASE("NIfTI: distances that are no positive numbers count as not stated") {
    const TemporaryFolder folder;
    const auto made = halves();
    std::string header = niftiHeader(made, 2);
    header.replace(254, 2, 2, '\0');  // no sform, no qform
    for (const float distance : {0.0f, std::nanf("")}) {
        header.replace(88, 4, reinterpret_cast<const char*>(&distance), 4);
        writeBytes(folder.file("a.nii"), header + bytesOfValues(made.values));
        CHECK_THAT(messageFor(folder.file("a.nii")), Contains("axis 3; set `voxelSpacing`"));
        ImageReadOptions options;
        options.spacing = {{7, 8, 9}};
        const Vec<3> spacing = readImage(folder.file("a.nii"), options).grid.spacing();
        CHECK(length(spacing - Vec<3>{{1, 1.25, 9}}) < 1e-6);
    }
}

TEST_CASE("units that files state are used once, and those of others do not apply to them") {
    const TemporaryFolder folder;
    const auto made = halves();
    writeMeta(folder.file("mm.mha"), made, "MET_UCHAR");
    std::ifstream in(folder.file("mm.mha"), std::ios::binary);
    std::string meta{std::istreambuf_iterator<char>(in), {}};
    meta.insert(meta.find("ElementType"), "DistanceUnits = um\n");
    writeBytes(folder.file("um.mha"), meta);
    std::string header = niftiHeader(made, 2);
    header[123] = 3;  // um
    writeBytes(folder.file("um.nii"), header + bytesOfValues(made.values));
    writeNrrd(folder.file("um.nrrd"), made, "uint8", "space units: \"um\" \"um\" \"um\"\n");
    for (const char* name : {"um.mha", "um.nii", "um.nrrd"}) {
        CAPTURE(name);
        DomainRecipe domain;
        domain.source = folder.file(name);
        std::vector<std::string> warnings;
        Callbacks callbacks;
        callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
        for (const Unit unit : {Unit::millimeter, Unit::micrometer}) {
            domain.unit = unit;
            const ImageGrid grid = readDomainImage(domain, callbacks).grid;
            CHECK(length(grid.origin - 0.001 * made.grid.origin) < 1e-6);
            CHECK(length(grid.spacing() - 0.001 * made.grid.spacing()) < 1e-9);
        }
        CHECK_THAT(warnings.at(0), Contains("0.001"));
        domain.unit = Unit::meter;
        CHECK_THROWS_AS(readDomainImage(domain, {}), ParameterError);
        CHECK(length(readGreyImage(folder.file(name), domain, {}).grid.spacing()) < 0.003);
    }
}

TEST_CASE("damaged images are refused without memory for what they claim") {
    const TemporaryFolder folder;
    const auto made = halves();
    writeNrrd(folder.file("a.nrrd"), made, "uint8");
    writeMeta(folder.file("a.mha"), made, "MET_UCHAR");
    writeNifti(folder.file("a.nii"), made, 2);
    for (const char* name : {"a.nrrd", "a.mha", "a.nii"}) {
        CAPTURE(name);
        const auto path = folder.file(name);
        std::filesystem::resize_file(path, std::filesystem::file_size(path) - 500);
        CHECK_FALSE(messageFor(path).empty());
        std::filesystem::resize_file(path, 200);
        CHECK_FALSE(messageFor(path).empty());
        writeBytes(path, "");
        CHECK_FALSE(messageFor(path).empty());
    }
    auto lying = made;
    lying.grid.size = {60000, 60000, 60000};
    writeNrrd(folder.file("b.nrrd"), lying, "uint8");
    writeMeta(folder.file("b.mha"), lying, "MET_UCHAR");
    lying.grid.size = {30000, 30000, 30000};
    writeNifti(folder.file("b.nii"), lying, 2);
    for (const char* name : {"b.nrrd", "b.mha", "b.nii"})
        CHECK_THAT(messageFor(folder.file(name)), Contains("damaged"));
    CHECK_THROWS_AS(readImage(folder.file("absent.nii")), IoError);
    CHECK_THROWS_AS(readImage(folder.file("absent.mhd")), IoError);
    CHECK_FALSE(messageFor(folder.file("")).empty());
}

TEST_CASE("labels are found by value, by name and in layers") {
    const TemporaryFolder folder;
    writeNrrd(folder.file("a.seg.nrrd"), halves(), "uint8",
              "Segment0_Name:=left half\nSegment0_LabelValue:=3\nSegment0_Layer:=0\n"
              "Segment1_Name:=right half\nSegment1_LabelValue:=7\nSegment1_Layer:=0\n");
    const Image image = readImage(folder.file("a.seg.nrrd"));
    const auto labels = *labelsOf(image);
    REQUIRE(labels.size() == 2);
    CHECK(labels[0].value == 3);
    CHECK(labels[1].name == "right half");
    CHECK(parseLabels("all", labels, "a").size() == 2);
    CHECK(parseLabels("7", labels, "a").front().labels.front().voxels == labels[1].voxels);
    CHECK(parseLabels("left half+7", labels, "a").front().labels.size() == 2);
    CHECK(parseLabels("3, right half", labels, "a").size() == 2);
    CHECK(parseLabels("7@0", labels, "a").front().labels.front().value == 7);
    // A name that is the value of another label.
    std::vector<LabelCount> crossed(2);
    for (std::size_t i = 0; i < 2; ++i)
        crossed[i].value = static_cast<std::int64_t>(i) + 1, crossed[i].name = i ? "1" : "2";
    CHECK_THAT(messageOf<ParameterError>([&] { parseLabels("1", crossed, "a"); }),
               Contains("1@0") && Contains("2@0"));
    CHECK(parseLabels("1@0", crossed, "a").front().labels.front().name == "2");
    for (const char* bad : {"4", "left", "3+3", "3,7+3", "", "3@1"})
        CHECK_THROWS_AS(parseLabels(bad, labels, "a"), ParameterError);
    const auto meshes = labelSurfaces(image, labels, parseLabels("all", labels, "a"));
    REQUIRE(meshes.size() == 2);
    for (const auto& mesh : meshes) CHECK_FALSE(mesh.triangles.empty());
}

TEST_CASE("label maps are written in the world that they lie in") {
    const TemporaryFolder folder;
    LabelMap map;
    map.grid = turned(gridAround(12, {{0.7, 0.9, 1.3}}), 0.4, -0.8);
    map.grid.step[1] = -map.grid.step[1];  // left-handed
    const std::int32_t most = GENERATE(200, 60000, 3000000);
    for (std::size_t i = 0; i < map.grid.voxels(); ++i)
        map.labels.push_back(i % 7 == 0 ? 0 : static_cast<std::int32_t>(i * 7919 % 1000003) % most);
    map.labels[5] = most;
    for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
        CAPTURE(name, most);
        writeLabelMap(map, folder.file(name), "test");
        ImageReadOptions options;
        options.callbacks.warning = [](const std::string& text) { FAIL_CHECK(text); };
        const Image image = readImage(folder.file(name), options);
        REQUIRE(image.grid.size == map.grid.size);
        CHECK(nameOf(image.type) == std::string(most == 200     ? "uint8"
                                                : most == 60000 ? "uint16"
                                                                : "int32"));
        const double rounding = std::string(name).find("nii") != std::string::npos ? 1e-5 : 1e-12;
        CHECK(length(image.grid.origin - map.grid.origin) < rounding);
        for (std::size_t d = 0; d < 3; ++d)
            CHECK(length(image.grid.step[d] - map.grid.step[d]) < rounding);
        const bool same = image.visit([&](const auto* numbers) {
            return std::equal(map.labels.begin(), map.labels.end(), numbers,
                              [](std::int32_t a, auto b) { return a == static_cast<double>(b); });
        });
        CHECK(same);
    }
    CHECK_THROWS_AS(writeLabelMap(map, folder.file("a.tif"), ""), ParameterError);
}
