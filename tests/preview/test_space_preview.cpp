#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/core/rng.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/preview/sphere_colors.h"

#include <cstdlib>

namespace {

PreviewOptions sized(int width, int height) {
    PreviewOptions options;
    options.width = width;
    options.height = height;
    return options;
}

/// Spheres in a cube of side 20 about `middle`, at random; those that overlap are thrown away.
Pack<3> randomPack(std::uint64_t seed, const Vec<3>& middle) {
    RandomStream random(seed, 0);
    Pack<3> pack;
    for (int tries = 0; tries < 4000; ++tries) {
        Sphere<3> s;
        for (int d = 0; d < 3; ++d) s.center[d] = middle[d] + 20 * random.uniform() - 10;
        s.radius = 0.2 + 1.3 * random.uniform() * random.uniform();
        if (std::none_of(pack.spheres.begin(), pack.spheres.end(),
                         [&](const auto& other) { return gap(s, other) < 0; }))
            pack.spheres.push_back(s);
    }
    return pack;
}

struct Seen {
    std::int32_t index = -1;
    bool sure = true;  ///< not within a hair of seeing something else
};

/// What a ray meets first from `start` on, all spheres looked at.
Seen firstAlong(const Pack<3>& pack, const Vec<3>& from, const Vec<3>& along, double start) {
    Seen seen;
    double nearest = std::numeric_limits<double>::infinity(), second = nearest;
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        const auto& s = pack.spheres[i];
        const Vec<3> to = s.center - from;
        const double middle = dot(to, along), off = length(to - along * middle);
        if (std::fabs(off - s.radius) < 1e-4 * s.radius) seen.sure = false;
        if (off >= s.radius) continue;
        const double t = middle - std::sqrt(s.radius * s.radius - off * off);
        if (t < start) continue;
        if (t < nearest) {
            second = nearest;
            nearest = t;
            seen.index = static_cast<std::int32_t>(i);
        } else {
            second = std::min(second, t);
        }
    }
    if (second - nearest < 1e-4) seen.sure = false;
    return seen;
}

/// Every pixel's middle against all spheres; pixels within a hair of a rim are not judged.
/// @return how many pixels show a sphere.
int checkAgainstAll(const Pack<3>& pack, const PreviewOptions& options) {
    SpacePreview scene;
    scene.pack = &pack;
    const auto camera = previewCamera(scene, options);
    const auto ids = visibleSpheres(scene, options);
    const int width = camera.width, height = camera.height;
    REQUIRE(ids.size() == static_cast<std::size_t>(width * height));
    int wrong = 0, unsure = 0, shown = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Vec<3> along =
                normalized(camera.direction(2 * (x + 0.5) / width - 1, 2 * (y + 0.5) / height - 1));
            double start = 0;
            bool sure = true;
            Seen seen;
            if (options.cut) {
                const int axis = options.cut->axis;
                start = (options.cut->at - camera.position[axis]) / along[axis];
                const Vec<3> at = camera.position + along * start;
                for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
                    const auto& s = pack.spheres[i];
                    const double off = length(at - s.center);
                    if (off < s.radius) seen.index = static_cast<std::int32_t>(i);
                    if (std::fabs(off - s.radius) < 1e-4) sure = false;
                }
            }
            if (seen.index < 0) {
                seen = firstAlong(pack, camera.position, along, start);
                sure = sure && seen.sure;
            }
            const auto got = ids[static_cast<std::size_t>(y * width + x)];
            shown += got >= 0;
            unsure += !sure;
            wrong += sure && got != seen.index;
        }
    CHECK(wrong == 0);
    CHECK(unsure < width * height / 50);
    return shown;
}

bool isWhite(const std::uint8_t* p) {
    return p[0] > 252 && p[1] > 252 && p[2] > 252;
}

/// Where the ray through the middle of a pixel meets a plane across an axis through zero.
Vec<3> inCut(const PreviewCamera& camera, const PreviewCut& cut, int x, int y) {
    const Vec<3> along =
        camera.direction(2 * (x + 0.5) / camera.width - 1, 2 * (y + 0.5) / camera.height - 1);
    return camera.position + along * (-camera.position[cut.axis] / along[cut.axis]);
}

}  // namespace

TEST_CASE("a sphere covers the pixels given by the projection") {
    if (!canDrawSpace()) return;
    const double radius = GENERATE(1e-3, 1.0, 4000.0);
    CAPTURE(radius);
    Pack<3> pack;
    pack.spheres = {{{{731.0, -94.0, -590.0}}, radius}};
    SpacePreview scene;
    scene.pack = &pack;
    const PreviewOptions options = sized(400, 300);
    const auto camera = previewCamera(scene, options);
    // In the middle, a sphere is the disc of the cone that touches it.
    const double distance = length(camera.position - pack.spheres[0].center);
    const double tangent = radius / std::sqrt(distance * distance - radius * radius);
    const double inPixels = tangent / camera.tanX * camera.width / 2;
    const auto ids = visibleSpheres(scene, options);
    double count = 0;
    for (const auto id : ids) count += id == 0;
    CHECK(count == Approx(kPi * inPixels * inPixels).epsilon(0.005));
    CHECK(ids[static_cast<std::size_t>(camera.height / 2 * 400 + 200)] == 0);
    // It fills the height but a margin.
    CHECK(2 * inPixels > 0.85 * camera.height);
    CHECK(2 * inPixels < camera.height);
    const Picture image = renderPreview(scene, options);
    double drawn = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < 400; ++x) drawn += !isWhite(image.pixel(x, y));
    CHECK(drawn == Approx(kPi * inPixels * inPixels).epsilon(0.03));
}

TEST_CASE("the nearest sphere is visible, wherever the pack lies") {
    if (!canDrawSpace()) return;
    const auto seed = GENERATE(range(1u, 4u));
    CAPTURE(seed);
    const Vec<3> middle = seed == 2 ? Vec<3>{{700, -300, 900}} : Vec<3>{};
    const int shown = checkAgainstAll(randomPack(seed, middle), sized(120, 90));
    CHECK(shown > 120 * 90 / 8);
}

TEST_CASE("a cut shows the spheres that it intersects") {
    if (!canDrawSpace()) return;
    const int axis = GENERATE(0, 1, 2);
    CAPTURE(axis);
    const Vec<3> middle{{700, -300, 900}};
    PreviewOptions options = sized(120, 90);
    options.cut = PreviewCut{axis, middle[axis] + 1.3};
    CHECK(checkAgainstAll(randomPack(7, middle), options) > 120 * 90 / 8);
}

TEST_CASE("the whole scene fits into the picture") {
    if (!canDrawSpace()) return;
    const bool tall = GENERATE(false, true), cut = GENERATE(false, true);
    PreviewOptions options = tall ? sized(60, 200) : sized(200, 60);
    if (cut) options.cut = PreviewCut{1, 0.5};
    const auto pack = randomPack(3, {});
    SpacePreview scene;
    scene.pack = &pack;
    const auto ids = visibleSpheres(scene, options);
    const PreviewCamera camera = previewCamera(scene, options);
    const auto at = [&](int x, int y) {
        return ids[static_cast<std::size_t>(y * camera.width + x)];
    };
    int onEdge = 0;
    for (int x = 0; x < camera.width; ++x) onEdge += at(x, 0) >= 0 || at(x, camera.height - 1) >= 0;
    for (int y = 0; y < camera.height; ++y) onEdge += at(0, y) >= 0 || at(camera.width - 1, y) >= 0;
    CHECK(onEdge == 0);
    CHECK(std::count_if(ids.begin(), ids.end(), [](auto id) { return id >= 0; }) >
          camera.width * camera.height / 12);
}

TEST_CASE("a cut sphere shows a flat face, not a hollow shell") {
    if (!canDrawSpace()) return;
    Pack<3> pack;
    pack.spheres = {{{{10, 20, 30}}, 5}};
    SpacePreview scene;
    scene.pack = &pack;
    PreviewOptions options = sized(200, 150);
    const int axis = GENERATE(0, 1, 2);
    options.cut = PreviewCut{axis, pack.spheres[0].center[axis]};
    const Picture image = renderPreview(scene, options);
    std::set<std::array<int, 3>> colors;
    const int middle = previewCamera(scene, options).height / 2;
    for (int y = middle - 10; y < middle + 10; ++y)
        for (int x = 90; x < 110; ++x) {
            const auto* p = image.pixel(x, y);
            colors.insert({p[0], p[1], p[2]});
        }
    CHECK(colors.size() == 1);
    // The middle of the ramp, next to unshaded.
    std::uint8_t ramp[3];
    toSrgb(rampColor(0.5), ramp);
    for (std::size_t c = 0; c < 3; ++c) CHECK(std::abs((*colors.begin())[c] - ramp[c]) < 10);
}

TEST_CASE("a cut solid shows its inside and its holes") {
    if (!canDrawSpace()) return;
    // A ball with a hollow.
    const auto solid = merged(ballMesh(10, 4), flipped(ballMesh(5, 4)));
    SpacePreview scene;
    scene.solid = &solid;
    PreviewOptions options = sized(400, 300);
    options.cut = PreviewCut{GENERATE(0, 1, 2), 0};
    const auto camera = previewCamera(scene, options);
    const Picture image = renderPreview(scene, options);
    std::uint8_t face[3];
    toSrgb(boneCutColor() * 0.95f, face);
    int wrong = 0, judged = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < 400; ++x) {
            const double r = length(inCut(camera, *options.cut, x, y));
            if (std::fabs(r - 10) < 0.4 || std::fabs(r - 5) < 0.4) continue;
            ++judged;
            const auto* p = image.pixel(x, y);
            wrong += std::equal(p, p + 3, face) != (r > 5 && r < 10);
        }
    CHECK(judged > 40000);
    CHECK(wrong == 0);
}

TEST_CASE("a cut wall is drawn as a line") {
    if (!canDrawSpace()) return;
    const auto wall = ballMesh(10, 4);
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 1}};
    SpacePreview scene;
    scene.pack = &pack;
    scene.wall = &wall;
    PreviewOptions options = sized(400, 300);
    options.cut = PreviewCut{1, 0};
    const auto camera = previewCamera(scene, options);
    const Picture image = renderPreview(scene, options);
    int dark = 0, at = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < 400; ++x) {
            if (std::fabs(length(inCut(camera, *options.cut, x, y)) - 10) > 0.02) continue;
            ++at;
            const auto* c = image.pixel(x, y);
            dark += c[0] + c[1] + c[2] < 300;
        }
    CHECK(at > 20);
    CHECK(dark == at);
}

TEST_CASE("a picture of space is the same for any number of threads") {
    if (!canDrawSpace()) return;
    const auto pack = randomPack(5, {{700, 0, 0}});
    const auto wall = translated(ballMesh(18, 4), {{700, 0, 0}});
    SpacePreview scene;
    scene.pack = &pack;
    scene.wall = &wall;
    PreviewOptions options = sized(200, 150);
    const bool cut = GENERATE(false, true);
    if (cut) options.cut = PreviewCut{0, 701};
    const auto with = [&](int threads) {
        return withThreads(threads, [&] { return encodePng(renderPreview(scene, options)); });
    };
    const auto one = with(1);
    CHECK(one == with(3));
    CHECK(one == with(3));
}

TEST_CASE("the texts of a picture describe it") {
    if (!canDrawSpace()) return;
    const auto pack = randomPack(5, {});
    SpacePreview scene;
    scene.pack = &pack;
    PreviewOptions options = sized(100, 80);
    options.cut = PreviewCut{2, 1.5};
    const Picture image = renderPreview(scene, options);
    REQUIRE(image.texts.size() == 2);
    CHECK_THAT(image.texts[0].second, Catch::EndsWith(" spheres"));
    for (const char* part : {"colored by radius, 0.2", "cut at z = 1.5 mm, lower z stays",
                             "seen from (", "scale bar "})
        CHECK_THAT(image.texts[1].second, Contains(part));
}

TEST_CASE(
    "a picture of space refuses empty scenes, bad sizes, missing attributes and cuts that miss") {
    SpacePreview scene;
    if (!canDrawSpace()) {
        CHECK_THROWS_WITH(renderPreview(scene, {}), Contains("Embree"));
        CHECK_THROWS_WITH(visibleSpheres(scene, {}), Contains("Embree"));
        return;
    }
    CHECK_THROWS_AS(renderPreview(scene, {}), ParameterError);
    Pack<3> pack;
    scene.pack = &pack;
    CHECK_THROWS_AS(renderPreview(scene, {}), ParameterError);
    pack.spheres = {{{{0, 0, 0}}, 1}};
    CHECK_THROWS_WITH(renderPreview(scene, sized(8, 100)), Contains("8x100"));
    PreviewOptions options = sized(64, 64);
    options.color = PreviewColor::depth;
    CHECK_THROWS_WITH(renderPreview(scene, options), Contains("`preview.color` depth"));
    options.color = PreviewColor::order;
    CHECK_THROWS_WITH(renderPreview(scene, options), Contains("`preview.color` order"));
    options.color = PreviewColor::radius;
    options.cut = PreviewCut{0, 1.5};
    CHECK_THROWS_WITH(renderPreview(scene, options),
                      Contains("`preview.cut` x=1.5") && Contains("-1 and 1 mm"));
    options.cut.reset();
    pack.spheres[0].center[1] = std::nan("");
    CHECK_THROWS_WITH(renderPreview(scene, options), Contains("sphere 0"));
}
