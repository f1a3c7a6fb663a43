#include "support/generators.h"
#include "support/test.h"

#include "vdbpack/preview/color.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/preview/sphere_colors.h"

#include <fmt/format.h>

#include <set>

namespace {

/// A ball about the origin with a smaller one on each side: 1 to 6 at +x, -x, +y, -y, +z, -z.
Pack<3> markedBall() {
    Pack<3> pack;
    pack.spheres = {{{{0, 0, 0}}, 5}};
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            Vec<3> at;
            at[axis] = 8 * sign;
            pack.spheres.push_back({at, 1});
        }
    return pack;
}

/// A row of balls of radius 1 along an axis, `length` mm long.
Pack<3> rowOf(int axis, int length) {
    Pack<3> pack;
    for (int x = 1; x < length; x += 2) {
        Vec<3> at;
        at[axis] = x;
        pack.spheres.push_back({at, 1});
    }
    return pack;
}

PreviewOptions seenFrom(const std::string& view) {
    PreviewOptions options;
    options.width = 300;
    options.view = parsePreviewView(view);
    return options;
}

Picture drawn(const Pack<3>& pack, const PreviewOptions& options) {
    SpacePreview scene;
    scene.pack = &pack;
    return renderPreview(scene, options);
}

bool isPaper(const Picture& image, int x, int y) {
    const auto* p = image.pixel(x, y);
    return p[0] == 255 && p[1] == 255 && p[2] == 255;
}

bool shows(const Picture& image, const Color& color) {
    std::uint8_t rgb[3];
    toSrgb(color, rgb);
    const auto isClose = [](int a, int b) { return std::abs(a - b) < 5; };
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (std::equal(rgb, rgb + 3, image.pixel(x, y), isClose)) return true;
    return false;
}

std::string wordsOf(const Picture& image) {
    return image.texts.at(1).second;
}

}  // namespace

TEST_CASE("nothing but spheres is drawn where spheres are, and they end above the caption") {
    if (!canDrawSpace()) return;
    auto pack = markedBall();
    pack.region = {0, 1, 0, 1, 0, 1, 0};
    SpacePreview scene;
    scene.pack = &pack;
    PreviewOptions options = seenFrom(GENERATE("front", "top", "1,-1,0.5"));
    options.color = GENERATE(PreviewColor::radius, PreviewColor::region);
    const auto [width, height] =
        GENERATE(std::pair(300, 0), std::pair(320, 120), std::pair(90, 300), std::pair(40, 40));
    options.width = width;
    options.height = height;
    CAPTURE(width, height);
    const PreviewCamera camera = previewCamera(scene, options);
    const auto ids = visibleSpheres(scene, options);
    const Picture image = renderPreview(scene, options);
    const auto nearSphere = [&](int x, int y) {
        for (int j = std::max(0, y - 1); j <= std::min(camera.height - 1, y + 1); ++j)
            for (int i = std::max(0, x - 1); i <= std::min(camera.width - 1, x + 1); ++i)
                if (ids[static_cast<std::size_t>(j * camera.width + i)] >= 0) return true;
        return false;
    };
    REQUIRE(image.width == camera.width);
    int stray = 0, last = 0, ink = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            if (isPaper(image, x, y)) continue;
            last = y;
            stray += !nearSphere(x, y);
        }
    for (int y = camera.height; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) ink += !isPaper(image, x, y);
    CHECK(stray == 0);
    CHECK(last < camera.height - 1);
    CHECK((ink > 0) == (width > 40));  // in the smallest picture there is no room
}

TEST_CASE("a view from a side of the patient shows that side, in either space") {
    if (!canDrawSpace()) return;
    // Markers of a world in LPS: at the viewer, at the right and at the top of the picture.
    const auto [name, viewer, right, top] =
        GENERATE(table<std::string, int, int, int>({{"front", 4, 1, 5},
                                                    {"back", 3, 2, 5},
                                                    {"left", 1, 3, 5},
                                                    {"right", 2, 4, 5},
                                                    {"top", 5, 2, 4},
                                                    {"bottom", 6, 1, 4}}));
    const bool ras = GENERATE(false, true);
    CAPTURE(name, ras);
    auto pack = markedBall();
    if (ras)
        for (auto& s : pack.spheres) s.center[0] *= -1, s.center[1] *= -1;
    SpacePreview scene;
    scene.pack = &pack;
    PreviewOptions options = seenFrom(name);
    options.space = ras ? ImageSpace::ras : ImageSpace::lps;
    const PreviewCamera camera = previewCamera(scene, options);
    const auto ids = visibleSpheres(scene, options);
    std::vector<Vec<2>> middle(7);
    std::vector<int> pixels(7);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const auto id = ids[static_cast<std::size_t>(y * camera.width + x)];
            if (id < 0) continue;
            middle[static_cast<std::size_t>(id)] +=
                Vec<2>{{x + 0.5 - camera.width / 2.0, camera.height / 2.0 - y - 0.5}};
            ++pixels[static_cast<std::size_t>(id)];
        }
    for (std::size_t k = 0; k < 7; ++k)
        if (pixels[k] > 0) middle[k] *= 1.0 / pixels[k];
    const auto at = [&](int k) { return middle[static_cast<std::size_t>(k)]; };
    CHECK(pixels[static_cast<std::size_t>(viewer)] > 50);
    CHECK(length(at(viewer)) < 2);
    CHECK(at(right)[0] > 50);
    CHECK(std::fabs(at(right)[1]) < 2);
    CHECK(at(top)[1] > 50);
    CHECK(std::fabs(at(top)[0]) < 2);
}

TEST_CASE("a picture without a height has the shape of its scene, within 1 : 3") {
    if (!canDrawSpace()) return;
    const auto [axis, length, aspect] = GENERATE(
        table<int, int, double>({{0, 4, 2}, {2, 4, 0.5}, {1, 4, 1}, {0, 40, 3}, {2, 40, 1.0 / 3}}));
    CAPTURE(axis, length);
    const auto pack = rowOf(axis, length);
    SpacePreview scene;
    scene.pack = &pack;
    PreviewOptions options = seenFrom("front");
    options.width = 600;
    const PreviewCamera camera = previewCamera(scene, options);
    CHECK(static_cast<double>(camera.width) / camera.height == Approx(aspect).epsilon(0.06));
    const Picture image = renderPreview(scene, options);
    CHECK(std::max(image.width, image.height) == 600);
    options.height = 200;
    const Picture asked = renderPreview(scene, options);
    CHECK(asked.width == 600);
    CHECK(asked.height == 200);
}

TEST_CASE("the letters name the visible sides") {
    if (!canDrawSpace()) return;
    const auto pack = markedBall();
    PreviewOptions options;
    options.width = 300;
    CHECK_THAT(wordsOf(drawn(pack, options)), Contains("sides x, -y, z;"));
    options.ofPatient = true;
    options.space = GENERATE(ImageSpace::lps, ImageSpace::ras);
    CHECK_THAT(wordsOf(drawn(pack, options)), Contains("sides L, A, S;"));
    options.view = parsePreviewView("left");
    const bool ras = options.space == ImageSpace::ras;
    CHECK_THAT(wordsOf(drawn(pack, options)),
               Contains(ras ? "sides L, A, P, S, I;" : "sides L, P, A, S, I;"));
    Pack<2> circles;
    circles.spheres = {{{{0, 0}}, 1}};
    PlanePreview plane;
    plane.pack = &circles;
    options.view.reset();
    CHECK_THAT(wordsOf(renderPreview(plane, options)),
               Contains(ras ? "sides R, L, A, P;" : "sides L, R, P, A;"));
}

TEST_CASE("a legend has the colors and names of what occurs") {
    if (!canDrawSpace()) return;
    auto pack = rowOf(0, 8);
    pack.spheres[0].radius = 0.5;
    PreviewOptions options;
    options.width = 400;
    const Picture ramp = drawn(pack, options);
    for (const double t : {0.1, 0.5, 0.9}) CHECK(shows(ramp, rampColor(t)));
    // The parts of a pack that has several, unless something else is asked for.
    pack.columns = {{"part", {0, 2, 2, 0}, {}}};
    const auto color = [](std::size_t k) { return fromSrgb(kindColors(kFewKinds)[k]); };
    const Picture parts = drawn(pack, options);
    CHECK(shows(parts, color(0)));
    CHECK(!shows(parts, color(1)));
    CHECK(shows(parts, color(2)));
    CHECK_THAT(wordsOf(parts), Contains("colored by part: 0, 2;"));
    pack.columns.front().names = {"L3", "disc", "L4 (cut)"};
    const Picture named = drawn(pack, options);
    CHECK_THAT(wordsOf(named), Contains("colored by part: L3, L4 (cut);"));
    CHECK(named.pixels != parts.pixels);
    options.color = PreviewColor::radius;
    CHECK_THAT(wordsOf(drawn(pack, options)), Contains("colored by radius"));
    options.color = PreviewColor::chosen;
    pack.columns.front().numbers = {1, 1, 1, 1};
    CHECK_THAT(wordsOf(drawn(pack, options)), Contains("colored by radius"));
}

TEST_CASE("many parts have colors and names of their own, or are counted") {
    const auto colors = kindColors(60);
    CHECK(std::set<std::uint32_t>(colors.begin(), colors.end()).size() == 60);
    CHECK(kindColors(9)[8] == colors[8]);
    if (!canDrawSpace()) return;
    auto pack = rowOf(0, 60);
    Column part{"part", {}, {}};
    for (std::size_t i = 0; i < pack.spheres.size(); ++i) {
        part.numbers.push_back(static_cast<double>(i));
        part.names.push_back(fmt::format("vertebra {}", i));
    }
    const std::size_t last = part.names.size() - 1;
    REQUIRE(last > 8);
    pack.columns = {part};
    PreviewOptions options;
    options.width = 1600;
    options.height = 400;
    const Picture all = drawn(pack, options);
    CHECK_THAT(wordsOf(all), Contains(part.names[last]));
    for (const std::size_t k : {std::size_t(9), last})
        CHECK(shows(all, fromSrgb(kindColors(last + 1)[k])));
}

TEST_CASE("a view decides which side of a cut is kept, and must face the cut") {
    if (!canDrawSpace()) return;
    const auto pack = rowOf(0, 20);
    SpacePreview scene;
    scene.pack = &pack;
    PreviewOptions options = seenFrom(GENERATE("left", "right"));
    options.cut = PreviewCut{0, 10};
    const bool fromHigher = options.view->from[0] > 0;
    for (const auto id : visibleSpheres(scene, options))
        if (id >= 0)
            CHECK((pack.spheres[static_cast<std::size_t>(id)].center[0] < 10) == fromHigher);
    CHECK_THAT(wordsOf(drawn(pack, options)),
               Contains(fromHigher ? "lower x stays" : "higher x stays"));
    options.view = parsePreviewView("front");
    CHECK_THROWS_WITH(renderPreview(scene, options),
                      Contains("`preview.view`") && Contains("x=10") && Contains("left or right"));
}
