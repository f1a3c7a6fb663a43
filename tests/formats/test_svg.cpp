#include "formats/file_text.h"
#include "formats/lattice_pack.h"
#include "support/test.h"

#include <pugixml.hpp>

namespace {

/// A picture as an XML document.
struct Picture {
    explicit Picture(const std::string& xml) {
        REQUIRE(document.load_buffer(xml.data(), xml.size()));
        REQUIRE(std::string(svg().name()) == "svg");
    }
    pugi::xml_node svg() const { return document.document_element(); }
    std::vector<pugi::xml_node> named(const std::string& name) const {
        std::vector<pugi::xml_node> found;
        for (const pugi::xpath_node& node : document.select_nodes(("//" + name).c_str()))
            found.push_back(node.node());
        return found;
    }
    pugi::xml_document document;
};

double number(const pugi::xml_node& element, const char* key) {
    return element.attribute(key).as_double(std::nan(""));
}

struct View {
    double x = 0, y = 0, width = 0, height = 0;

    explicit View(const pugi::xml_node& svg) {
        std::istringstream(svg.attribute("viewBox").value()) >> x >> y >> width >> height;
    }
    void requireHolds(const pugi::xml_node& circle) const {
        const double cx = number(circle, "cx"), cy = number(circle, "cy"), r = number(circle, "r");
        if (!(cx - r > x && cx + r < x + width && cy - r > y && cy + r < y + height))
            FAIL("a circle at " << cx << ", " << cy << " is cut off");
    }
};

Pack<2> circles(const Vec<2>& center, std::size_t count = 500) {
    return latticePack<2>(count, center, 60, 12);
}

}  // namespace

TEST_CASE("a picture holds every circle where it is, y up, colored by region") {
    const double away = GENERATE(0.0, 730.0, -1e4);
    const auto unit = GENERATE(Unit::meter, Unit::centimeter, Unit::millimeter, Unit::micrometer);
    CAPTURE(away, unitName(unit));
    const auto pack = circles({{away, -0.7 * away}});
    PackWriteOptions options;
    options.unit = unit;
    const Picture picture(writtenText(pack, "p.svg", options));
    const View view(picture.svg());
    auto drawn = picture.named("circle");
    REQUIRE(drawn.size() == pack.spheres.size());

    // Trabecular circles first, each group in the order of the pack.
    std::vector<std::size_t> order;
    for (const int region : {1, 0})
        for (std::size_t i = 0; i < pack.spheres.size(); ++i)
            if (pack.region[i] == region) order.push_back(i);
    const double scale = millimetersPer(unit), step = 1e-5 * view.width * scale;
    for (std::size_t k = 0; k < drawn.size(); ++k) {
        const auto& s = pack.spheres[order[k]];
        CAPTURE(k);
        view.requireHolds(drawn[k]);
        REQUIRE(number(drawn[k], "cx") * scale == Approx(s.center[0]).margin(step));
        REQUIRE(number(drawn[k], "cy") * scale == Approx(-s.center[1]).margin(step));
        REQUIRE(number(drawn[k], "r") * scale == Approx(s.radius).margin(step));
        REQUIRE(drawn[k].parent().attribute("id").value() ==
                std::string(pack.region[order[k]] == 0 ? "cortical" : "trabecular"));
    }
    const auto groups = picture.named("g");
    REQUIRE(groups.size() == 2);
    REQUIRE(std::string(groups[0].attribute("fill").value()) !=
            groups[1].attribute("fill").value());
    REQUIRE_THAT(std::string(picture.named("desc").at(0).child_value()),
                 Contains(std::string("unit of length: ") + unitName(unit)));
    const auto svg = picture.svg();
    REQUIRE(std::max(number(svg, "width"), number(svg, "height")) == 900);
    REQUIRE(number(svg, "width") / number(svg, "height") ==
            Approx(view.width / view.height).epsilon(0.002));
}

TEST_CASE("the frame of a picture is drawn and lies inside it") {
    PackWriteOptions options;
    options.unit = Unit::centimeter;
    options.frame = Box<2>{{{-100, -40}}, {{200, 20}}};
    const std::size_t count = GENERATE(0u, 30u);
    const auto pack = latticePack<2>(count, {{50, -10}}, 40, 1);
    const Picture picture(writtenText(pack, "p.svg", options));
    REQUIRE(picture.named("circle").size() == count);
    const auto frame = picture.named("rect").at(0);
    REQUIRE(number(frame, "x") == -10);
    REQUIRE(number(frame, "y") == -2);
    REQUIRE(number(frame, "width") == 30);
    REQUIRE(number(frame, "height") == 6);
    const View view(picture.svg());
    REQUIRE(view.x < -10);
    REQUIRE(view.y < -2);
    REQUIRE(view.x + view.width > 20);
    REQUIRE(view.y + view.height > 4);
    REQUIRE(view.width < 32);

    SECTION("an empty frame is the caller's mistake") {
        options.frame->hi[1] = GENERATE(-40.0, -50.0, std::numeric_limits<double>::quiet_NaN(),
                                        std::numeric_limits<double>::infinity());
        const TemporaryFolder scratch;
        REQUIRE_THROWS_AS(writePack(circles({}), scratch.file("q.svg"), options), ParameterError);
        REQUIRE(scratch.files() == 0);
    }
}

TEST_CASE("a picture stays well-formed whatever the generator is called") {
    PackWriteOptions options;
    options.generator = "a <test> & \"more\" ]]> --\n\t'x'";
    const auto text = writtenText(circles({}, 3), "p.svg", options);
    REQUIRE_THAT(text, Contains("a &lt;test&gt; &amp; "));
    const Picture picture(text);
    REQUIRE_THAT(std::string(picture.named("desc").at(0).child_value()),
                 Contains("generator: a <test> & \"more\" ]]> --  'x'"));
}

TEST_CASE("a picture of nothing, of one circle and without regions opens") {
    Pack<2> pack;
    if (GENERATE(false, true))  // usual, small or far out
        pack.spheres = {GENERATE(Sphere<2>{{{3, 4}}, 2}, Sphere<2>{{{3e-9, 4e-9}}, 2e-9},
                                 Sphere<2>{{{-1e29, 1e20}}, 1e-29})};
    const Picture picture(writtenText(pack, "p.svg"));
    const auto drawn = picture.named("circle");
    REQUIRE(drawn.size() == pack.spheres.size());
    const View view(picture.svg());
    REQUIRE(view.width > 0);
    REQUIRE(view.height > 0);
    for (const auto& circle : drawn) view.requireHolds(circle);
}

TEST_CASE("a picture of 40,000 circles takes about 2 MB") {
    const auto pack = latticePack<2>(40'000, {{300, 300}}, 600, 2);
    REQUIRE(writtenText(pack, "p.svg").size() < 2'200'000);
}

TEST_CASE("a picture is of circles, and is not read") {
    const TemporaryFolder scratch;
    REQUIRE_THROWS_AS(writePack(Pack<3>{}, scratch.file("p.svg"), {}), ParameterError);
    REQUIRE_THROWS_WITH(writePack(Pack<3>{}, scratch.file("p.svg"), {}),
                        Contains("circles") && Contains("`slice`"));
    REQUIRE(scratch.files() == 0);
    REQUIRE_NOTHROW(checkPackFormat("p.SVG"));
    REQUIRE_NOTHROW(checkPackFormat("p.svg", 2));
    REQUIRE_THROWS_AS(checkPackFormat("svg:p.txt", 3), ParameterError);
    writePack(circles({}), scratch.file("p.svg"), {});
    REQUIRE_THROWS_AS(readPack(scratch.file("p.svg")), ParameterError);
    REQUIRE_THROWS_WITH(readPack(scratch.file("p.svg")), Contains("use .vdb"));
}
