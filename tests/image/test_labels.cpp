#include "support/image_file.h"
#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/domain/domain_image.h"
#include "vdbpack/image/image_file.h"
#include "vdbpack/image/image_surface.h"
#include "vdbpack/mesh/mesh_check.h"

namespace {

ImageGrid cubes(std::size_t side) {
    ImageGrid grid;
    grid.size = {side, side, side};
    return grid;
}

/// An image whose value at each voxel is `valueAt(center)`.
template <class T, class F>
Image imageOf(NumberType type, std::size_t side, const F& valueAt) {
    const auto made = Voxels<T>::of(cubes(side), valueAt);
    Image image;
    image.grid = made.grid;
    image.type = type;
    image.bytes = voxelMemory(made.values.size() * sizeof(T));
    std::copy(made.values.begin(), made.values.end(), reinterpret_cast<T*>(image.bytes.get()));
    return image;
}

std::vector<std::int64_t> valuesOf(const std::optional<std::vector<LabelCount>>& labels) {
    std::vector<std::int64_t> values;
    for (const LabelCount& label : labels.value_or(std::vector<LabelCount>{}))
        values.push_back(label.value);
    return values;
}

}  // namespace

TEST_CASE("labels that a scale of 8 bits has rounded are whole again") {
    // As nibabel writes 0, 3 and 7 into bytes: slope 7/255, so that 3 becomes 109 * 7/255.
    const TemporaryFolder folder;
    const auto made = Voxels<std::uint8_t>::of(cubes(12), [](const Vec<3>& p) {
        return p[0] < 3 ? 0 : p[0] < 7 ? 109 : 255;
    });
    std::string header = niftiHeader(made, 2);
    const float slope = 7.0f / 255;
    header.replace(112, 4, reinterpret_cast<const char*>(&slope), 4);
    DomainRecipe domain;
    domain.source = folder.file("a.nii");
    writeBytes(domain.source, header + bytesOfValues(made.values));
    std::vector<std::string> warnings;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
    const Image image = readDomainImage(domain, callbacks);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings.front(), Contains("2.99216") && Contains("0.0078"));
    const auto labels = requiredLabels(domain, image);
    CHECK(valuesOf(labels) == std::vector<std::int64_t>{3, 7});
    CHECK(labels[0].voxels == 4 * 144);
    CHECK(valueRange(image) == std::pair<double, double>{0, 7});
    CHECK(labelSurfaces(image, labels, parseLabels("3,7", labels, "a")).size() == 2);

    // Values that lie farther from whole numbers than that, or side by side, are no labels.
    for (const float other : {2.98f, 6.999f}) {
        Image grey = imageOf<float>(NumberType::f32, 12, [&](const Vec<3>& p) {
            return p[0] < 3 ? 0 : p[0] < 7 ? other : 7;
        });
        roundLabels(grey, "a", callbacks);
        CHECK_FALSE(grey.isRounded);
    }
}

TEST_CASE("more labels than a thousand are labels, and messages count what they leave out") {
    // Cubes of four voxels.
    const Image image = imageOf<std::uint16_t>(NumberType::u16, 60, [](const Vec<3>& p) {
        const auto at = [&](int d) { return static_cast<int>(p[d]) / 4; };
        return at(0) == 0 ? 0 : (at(2) * 15 + at(1)) * 15 + at(0);
    });
    const auto labels = labelsOf(image).value();
    CHECK(labels.size() == 15 * 15 * 14);
    CHECK(labels.front().voxels == 64);
    CHECK_THAT(messageOf<ParameterError>([&] { parseLabels("9999", labels, "a"); }),
               Contains("and 3110 more"));
    const auto parts = parseLabels("1,3374", labels, "a");
    CHECK(labelSurfaces(image, labels, parts).back().bounds().hi[0] == Approx(59.5));
}

TEST_CASE("labels of 32 bits keep their values") {
    const Image image = imageOf<std::uint32_t>(
        NumberType::u32, 10, [](const Vec<3>& p) { return p[0] < 5 ? 0u : 4000000000u; });
    CHECK(valuesOf(labelsOf(image)) == std::vector<std::int64_t>{4000000000});
}

TEST_CASE("grey values are no labels unless they are asked for") {
    RandomStream random(4, 1);
    const auto noise = [&](const Vec<3>& p) {
        // Air around an object of 146 values.
        return length(p - Vec<3>{{20, 20, 20}}) < 10 ? 1 + 146 * random.uniform() : 200;
    };
    const auto smooth = [](const Vec<3>& p) {
        return 100 + 20 * std::sin(p[0] / 20) + 10 * std::sin(p[1] / 4) + 10 * std::sin(p[2] / 4);
    };
    for (const Image& image : {imageOf<std::uint8_t>(NumberType::u8, 40, noise),
                               imageOf<std::uint8_t>(NumberType::u8, 40, smooth)}) {
        CHECK_FALSE(labelsOf(image));
        CHECK(labelsOf(image, true).value().size() > 20);
    }
    // Few values: by their scale and sign.
    const auto few = [](const Vec<3>& p) { return std::floor(p[0] / 10); };
    Image image = imageOf<std::uint8_t>(NumberType::u8, 40, few);
    CHECK(labelsOf(image).value().size() == 3);
    image.intercept = -1000;
    CHECK_FALSE(labelsOf(image));
    image.names = {{"air", -1000, 0}};
    CHECK(labelsOf(image).value().front().name == "air");
}

TEST_CASE("an image of two values has the volume of its voxels at any threshold between them") {
    const auto inBall = [](const Vec<3>& p) { return length(p - Vec<3>{{9, 9, 9}}) < 6; };
    const Image image = imageOf<std::uint8_t>(NumberType::u8, 20,
                                              [&](const Vec<3>& p) { return inBall(p) ? 255 : 0; });
    const double voxels = static_cast<double>(labelsOf(image).value().front().voxels);
    Callbacks callbacks;
    callbacks.warning = [](const std::string& text) { FAIL_CHECK(text); };
    for (const double threshold : {1.0, 128.0, 255.0})
        CHECK(checkMesh(thresholdSurface(image, threshold, "a", callbacks)).signedVolume ==
              Approx(voxels).epsilon(0.005));
}

TEST_CASE("a warning tells how much of thin parts a threshold loses") {
    // A plate one voxel thick between values that fall off beside it.
    const Image image = imageOf<std::uint8_t>(NumberType::u8, 20, [](const Vec<3>& p) {
        return p[0] == 9 ? 200 : p[0] == 8 || p[0] == 10 ? 20 : 0;
    });
    std::vector<std::string> warnings;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warnings.push_back(text); };
    const double volume = checkMesh(thresholdSurface(image, 190, "a", callbacks)).signedVolume;
    // Its sides lie 10/180 of a voxel off the middle, its rim up to half a voxel inside.
    CHECK(volume / (2 * 10.0 / 180) > 19 * 19);
    CHECK(volume / (2 * 10.0 / 180) < 20 * 20);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Contains("400 voxels") && Contains("-89 %"));
}

TEST_CASE("a grey image as mask causes a warning") {
    const TemporaryFolder folder;
    writeHalves(folder.file("halves.nrrd"));
    const auto grey = Voxels<std::uint8_t>::of(
        cubes(20), [](const Vec<3>& p) { return int(31 * p[0] + 17 * p[1] + 7 * p[2]) % 61; });
    writeNrrd(folder.file("ct.nrrd"), grey, "uint8");
    DomainRecipe domain;
    domain.source = folder.file("halves.nrrd");
    domain.mask = "22=" + folder.file("ct.nrrd");
    std::string warnings;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { warnings += text; };
    readDomainImage(domain, callbacks);
    CHECK_THAT(warnings, Contains("ct.nrrd: seems to be a grey image") && Contains("label 22"));
}

TEST_CASE("a mask keeps the voxels that lie in a label of another image, on its own grid") {
    const TemporaryFolder folder;
    writeHalves(folder.file("halves.nrrd"));
    const auto mask = Voxels<std::uint8_t>::of(turned(gridAround(20, {{0.7, 0.8, 0.9}}), 0.1, -0.2),
                                               [](const Vec<3>& p) {
                                                   return p[2] > 3 ? 22 : p[2] > -5 ? 21 : 0;
                                               });
    writeNrrd(folder.file("mask.nrrd"), mask, "uint8");
    DomainRecipe domain;
    domain.source = folder.file("halves.nrrd");
    const Image all = readDomainImage(domain, {});
    const auto kept = GENERATE(std::pair("22", 3.0), std::pair("21+22", -5.0));
    domain.mask = kept.first + ("=" + folder.file("mask.nrrd"));
    const Image image = readDomainImage(domain, {});
    const auto at = [](const Image& i, std::size_t n) {
        return reinterpret_cast<const std::uint8_t*>(i.bytes.get())[n];
    };
    std::size_t n = 0, within = 0;
    for (std::size_t k = 0; k < all.grid.size[2]; ++k)
        for (std::size_t j = 0; j < all.grid.size[1]; ++j)
            for (std::size_t i = 0; i < all.grid.size[0]; ++i, ++n) {
                const Vec<3> x = all.grid.at({{double(i), double(j), double(k)}});
                if (std::fabs(x[2] - kept.second) < 1) continue;  // a voxel of the mask
                const bool in = x[2] > kept.second;
                within += in && at(all, n) != 0;
                REQUIRE(at(image, n) == (in ? at(all, n) : 0));
            }
    CHECK(within > 500);
    domain.mask = "23=" + folder.file("mask.nrrd");
    CHECK_THROWS_AS(readDomainImage(domain, {}), ParameterError);
    domain.mask = folder.file("mask.nrrd");
    CHECK_THROWS_AS(readDomainImage(domain, {}), ParameterError);
    domain.mask = "22=" + folder.file("other.nrrd");
    CHECK_THROWS_AS(readDomainImage(domain, {}), IoError);
}
