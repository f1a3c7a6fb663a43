#include "support/test.h"

#include "vdbpack/core/parallel.h"
#include "vdbpack/preview/color.h"
#include "vdbpack/preview/preview.h"
#include "vdbpack/preview/section.h"

namespace {

bool isWhite(const Picture& image, int x, int y) {
    const auto* p = image.pixel(x, y);
    return p[0] > 250 && p[1] > 250 && p[2] > 250;
}

struct Span {
    int first = -1, last = -1;
    int length() const { return last - first + 1; }
};
/// Columns that are not white between two rows.
Span drawn(const Picture& image, int y0, int y1) {
    Span span;
    for (int x = 0; x < image.width; ++x)
        for (int y = y0; y < y1; ++y)
            if (!isWhite(image, x, y)) {
                if (span.first < 0) span.first = x;
                span.last = x;
            }
    return span;
}

/// Rows of the scene, which the description states.
int sceneRows(const Picture& image) {
    const std::string& words = image.texts.at(1).second;
    const std::string key = "scene in the upper ";
    return std::atoi(words.c_str() + words.find(key) + key.size());
}

/// Length of the scale bar: of the longest line that begins at the left end of what is written.
int barLength(const Picture& image) {
    const int left = drawn(image, sceneRows(image), image.height).first;
    int longest = 0;
    for (int y = sceneRows(image); y < image.height; ++y) {
        int x = left;
        while (!isWhite(image, x, y)) ++x;
        longest = std::max(longest, x - left);
    }
    return longest;
}

double scaleBarIn(const Picture& image) {
    const std::string& words = image.texts.at(1).second;
    const std::string key = "scale bar ";
    return std::strtod(words.c_str() + words.find(key) + key.size(), nullptr);
}

/// A disc of radius 20 as a field.
PlaneField discField() {
    PlaneField field;
    field.step = 0.1;
    field.columns = field.rows = 441;
    field.origin = {{-22, -22}};
    for (int j = 0; j < 441; ++j)
        for (int i = 0; i < 441; ++i)
            field.distance.push_back(
                static_cast<float>(std::hypot(-22 + 0.1 * i, -22 + 0.1 * j) - 20));
    return field;
}

}  // namespace

TEST_CASE("circles, outline and scale bar are true to scale") {
    Pack<2> pack;
    pack.spheres = {{{{0, 0}}, 10}};
    const PlaneField field = discField();
    PlanePreview scene;
    scene.pack = &pack;
    scene.field = &field;
    scene.bounds.add({{-20, -20}});
    scene.bounds.add({{20, 20}});
    PreviewOptions options;
    options.width = 800;
    options.height = 800;
    const Picture image = renderPreview(scene, options);
    CHECK(scaleBarIn(image) == 10);
    const double pixel = scaleBarIn(image) / barLength(image);
    CAPTURE(pixel);
    const Span outline = drawn(image, 0, sceneRows(image));
    CHECK(outline.length() * pixel == Approx(40).margin(5 * pixel));
    // The area of the circle: pixels of the one color there is, rims left out.
    const int middle = (outline.first + outline.last) / 2;
    std::uint8_t color[3];
    toSrgb(rampColor(0.5), color);
    int count = 0, right = middle;
    for (int y = 0; y < sceneRows(image); ++y)
        for (int x = 0; x < image.width; ++x)
            if (std::equal(color, color + 3, image.pixel(x, y))) {
                ++count;
                right = std::max(right, x);
            }
    CHECK(count * pixel * pixel == Approx(kPi * 100).epsilon(0.03));
    CHECK((right - middle) * pixel == Approx(10).margin(3 * pixel));
}

TEST_CASE("y points up, and circles are drawn at their positions") {
    Pack<2> pack;
    pack.spheres = {{{{705, 905}}, 1}, {{{715, 915}}, 2}};
    PlanePreview scene;
    scene.pack = &pack;
    PreviewOptions options;
    options.width = options.height = 400;
    const Picture image = renderPreview(scene, options);
    const auto darkest = [&](int x0, int x1, int y0, int y1) {
        int sum = 765;
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) {
                const auto* p = image.pixel(x, y);
                sum = std::min(sum, p[0] + p[1] + p[2]);
            }
        return sum;
    };
    const int rows = sceneRows(image), upper = rows / 2 - 10, lower = rows / 2 + 10;
    CHECK(darkest(0, 190, lower, rows) < 765);
    CHECK(darkest(210, 400, 0, upper) < 765);
    CHECK(darkest(0, 190, 0, upper) == 765);
    CHECK(darkest(220, 400, lower, rows) == 765);
}

TEST_CASE("a plane picture is the same for any number of threads") {
    Pack<2> pack;
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 20; ++j) pack.spheres.push_back({{{2.0 * i, 2.0 * j}}, 0.5 + 0.02 * i});
    PlanePreview scene;
    scene.pack = &pack;
    PreviewOptions options;
    options.width = options.height = 200;
    const auto with = [&](int threads) {
        return withThreads(threads, [&] { return encodePng(renderPreview(scene, options)); });
    };
    CHECK(with(1) == with(3));
}

TEST_CASE("a plane picture refuses empty scenes, missing attributes, cuts and incomplete fields") {
    PlanePreview scene;
    PreviewOptions options;
    CHECK_THROWS_AS(renderPreview(scene, options), ParameterError);
    Pack<2> pack;
    pack.spheres = {{{{0, 0}}, 1}};
    scene.pack = &pack;
    options.color = PreviewColor::depth;
    CHECK_THROWS_WITH(renderPreview(scene, options), Contains("`preview.color` depth"));
    options.color = PreviewColor::radius;
    options.cut = PreviewCut{0, 0};
    CHECK_THROWS_WITH(renderPreview(scene, options), Contains("`preview.cut`"));
    options.cut.reset();
    PlaneField field;
    field.columns = field.rows = 3;
    field.step = 1;
    scene.field = &field;
    CHECK_THROWS_AS(renderPreview(scene, options), ParameterError);
}

TEST_CASE("distances to lines are found within the reach only") {
    const double reach = GENERATE(0.1, 0.30000000000000004, 1.7);
    const PlaneLines lines({{{{0, 0}}, {{10, 0}}}, {{{3, 5}}, {{3, 5}}}}, reach);
    CHECK(lines.distance({{5, 0.5 * reach}}) == Approx(0.5 * reach));
    CHECK(lines.distance({{-0.5 * reach, 0}}) == Approx(0.5 * reach));
    CHECK(lines.distance({{3, 5 + 0.5 * reach}}) == Approx(0.5 * reach));
    CHECK(std::isinf(lines.distance({{5, 1.001 * reach}})));
    CHECK(std::isinf(lines.distance({{100, 100}})));
}
