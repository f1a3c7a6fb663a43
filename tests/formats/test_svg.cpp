#include "formats/file_text.h"
#include "formats/lattice_pack.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/pack_file.h"

#include <algorithm>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

struct Element {
    std::string name;
    std::map<std::string, std::string> attributes;
    std::string parentId;
    std::string text;

    double number(const std::string& key) const { return std::stod(attributes.at(key)); }
};

/// The text between tags or quotes; a bare & or < is an error.
std::string unescaped(const std::string& text) {
    static const std::map<std::string, char> kEntities = {
        {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}};
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        REQUIRE(text[i] != '<');
        if (text[i] != '&') {
            out += text[i];
            continue;
        }
        const auto end = text.find(';', i);
        REQUIRE(end != std::string::npos);
        out += kEntities.at(text.substr(i, end + 1 - i));
        i = end;
    }
    return out;
}

/// All elements of a document in order; requires that tags match and attributes are quoted.
std::vector<Element> elementsOf(const std::string& xml) {
    std::vector<Element> elements;
    std::vector<std::size_t> open;
    const std::string head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    REQUIRE(xml.substr(0, head.size()) == head);
    for (std::size_t at = head.size(); at < xml.size();) {
        const auto begin = std::min(xml.find('<', at), xml.size());
        const std::string between = unescaped(xml.substr(at, begin - at));
        if (open.empty()) {
            if (between.find_first_not_of('\n') != std::string::npos) FAIL("text outside: " << at);
        } else {
            elements[open.back()].text += between;
        }
        if (begin == xml.size()) break;
        const auto end = xml.find('>', begin);
        if (end == std::string::npos) FAIL("a tag is not closed: " << begin);
        at = end + 1;
        if (xml[begin + 1] == '/') {
            if (open.empty() ||
                elements[open.back()].name != xml.substr(begin + 2, end - begin - 2))
                FAIL("closes what is not open: " << begin);
            open.pop_back();
            continue;
        }
        const bool closed = xml[end - 1] == '/';
        const std::string tag = xml.substr(begin + 1, end - begin - (closed ? 2 : 1));
        Element e;
        e.name = tag.substr(0, tag.find(' '));
        for (std::size_t i = e.name.size(); i < tag.size();) {
            const auto equals = tag.find("=\"", i);
            const auto quote = equals == std::string::npos ? equals : tag.find('"', equals + 2);
            if (tag[i] != ' ' || quote == std::string::npos) FAIL("bad attribute in " << tag);
            const auto value = unescaped(tag.substr(equals + 2, quote - equals - 2));
            if (!e.attributes.emplace(tag.substr(i + 1, equals - i - 1), value).second)
                FAIL("attribute twice in " << tag);
            i = quote + 1;
        }
        if (!open.empty()) {
            const auto& parent = elements[open.back()].attributes;
            if (parent.count("id") > 0) e.parentId = parent.at("id");
        }
        elements.push_back(std::move(e));
        if (!closed) open.push_back(elements.size() - 1);
    }
    REQUIRE(open.empty());
    REQUIRE(!elements.empty());
    REQUIRE(elements.front().name == "svg");
    return elements;
}

std::vector<Element> named(const std::vector<Element>& elements, const std::string& name) {
    std::vector<Element> found;
    std::copy_if(elements.begin(), elements.end(), std::back_inserter(found),
                 [&name](const Element& e) { return e.name == name; });
    return found;
}

struct View {
    double x = 0, y = 0, width = 0, height = 0;

    explicit View(const Element& svg) {
        std::istringstream(svg.attributes.at("viewBox")) >> x >> y >> width >> height;
    }
    void requireHolds(const Element& circle) const {
        const double cx = circle.number("cx"), cy = circle.number("cy"), r = circle.number("r");
        if (!(cx - r > x && cx + r < x + width && cy - r > y && cy + r < y + height))
            FAIL("a circle at " << cx << ", " << cy << " is cut off");
    }
};

Pack<2> circles(const Vec<2>& center, std::size_t count = 500) {
    return latticePack<2>(count, center, 60, 12);
}

}  // namespace

TEST_CASE("a picture holds every circle where it is, y up, colored by region", "[formats]") {
    const double away = GENERATE(0.0, 730.0, -1e4);
    const auto unit = GENERATE(Unit::meter, Unit::centimeter, Unit::millimeter, Unit::micrometer);
    CAPTURE(away, unitName(unit));
    const auto pack = circles({{away, -0.7 * away}});
    PackWriteOptions options;
    options.unit = unit;
    const auto elements = elementsOf(writtenText(pack, "p.svg", options));
    const View view(elements.front());
    auto drawn = named(elements, "circle");
    REQUIRE(drawn.size() == pack.spheres.size());

    // Trabecular circles first, each group in the order of the pack.
    std::vector<std::size_t> order;
    for (const int region : {1, 0})
        for (std::size_t i = 0; i < pack.spheres.size(); ++i)
            if (pack.region[i] == region) order.push_back(i);
    const double scale = millimetersPer(unit);
    const double step = 1e-5 * view.width * scale;
    for (std::size_t k = 0; k < drawn.size(); ++k) {
        const auto& s = pack.spheres[order[k]];
        CAPTURE(k);
        view.requireHolds(drawn[k]);
        REQUIRE(drawn[k].number("cx") * scale == Approx(s.center[0]).margin(step));
        REQUIRE(drawn[k].number("cy") * scale == Approx(-s.center[1]).margin(step));
        REQUIRE(drawn[k].number("r") * scale == Approx(s.radius).margin(step));
        REQUIRE(drawn[k].parentId == (pack.region[order[k]] == 0 ? "cortical" : "trabecular"));
    }
    const auto groups = named(elements, "g");
    REQUIRE(groups.size() == 2);
    REQUIRE(groups[0].attributes.at("fill") != groups[1].attributes.at("fill"));
    REQUIRE_THAT(named(elements, "desc").at(0).text,
                 Contains(std::string("unit of length: ") + unitName(unit)));
    const auto& svg = elements.front();
    REQUIRE(std::max(svg.number("width"), svg.number("height")) == 900);
    REQUIRE(svg.number("width") / svg.number("height") ==
            Approx(view.width / view.height).epsilon(0.002));
}

TEST_CASE("the frame of a picture is drawn and lies inside it", "[formats]") {
    PackWriteOptions options;
    options.unit = Unit::centimeter;
    options.frame = Box<2>{{{-100, -40}}, {{200, 20}}};
    const std::size_t count = GENERATE(0u, 30u);
    const auto pack = latticePack<2>(count, {{50, -10}}, 40, 1);
    const auto elements = elementsOf(writtenText(pack, "p.svg", options));
    REQUIRE(named(elements, "circle").size() == count);
    const auto frame = named(elements, "rect").at(0);
    REQUIRE(frame.number("x") == -10);
    REQUIRE(frame.number("y") == -2);
    REQUIRE(frame.number("width") == 30);
    REQUIRE(frame.number("height") == 6);
    const View view(elements.front());
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

TEST_CASE("a picture stays well-formed whatever the generator is called", "[formats]") {
    PackWriteOptions options;
    options.generator = "a <test> & \"more\" ]]> --\n\t'x'";
    const auto text = writtenText(circles({}, 3), "p.svg", options);
    const auto desc = named(elementsOf(text), "desc").at(0);
    REQUIRE_THAT(desc.text, Contains("generator: a <test> & \"more\" ]]> --  'x'"));
}

TEST_CASE("a picture of nothing, of one circle and without regions opens", "[formats]") {
    Pack<2> pack;
    SECTION("nothing") {}
    SECTION("one circle") {
        pack.spheres = {{{{3, 4}}, 2}};
    }
    SECTION("small") {
        pack.spheres = {{{{3e-9, 4e-9}}, 2e-9}};
    }
    SECTION("far out") {
        pack.spheres = {{{{-1e29, 1e20}}, 1e-29}};
    }
    const auto elements = elementsOf(writtenText(pack, "p.svg"));
    const auto drawn = named(elements, "circle");
    REQUIRE(drawn.size() == pack.spheres.size());
    const View view(elements.front());
    REQUIRE(view.width > 0);
    REQUIRE(view.height > 0);
    for (const auto& circle : drawn) view.requireHolds(circle);
}

TEST_CASE("a picture of 40,000 circles takes about 2 MB", "[formats]") {
    const auto pack = latticePack<2>(40'000, {{300, 300}}, 600, 2);
    REQUIRE(writtenText(pack, "p.svg").size() < 2'200'000);
}

TEST_CASE("a picture is of circles, and is not read", "[formats]") {
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
