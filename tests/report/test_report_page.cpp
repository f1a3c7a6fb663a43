#include "report/sample_report.h"
#include "support/test.h"
#include "support/well_formed.h"

#include "vdbpack/report/markup.h"
#include "vdbpack/report/report_page.h"
#include "vdbpack/report/svg_chart.h"

#include <nlohmann/json.hpp>

#include <numeric>

namespace {

const char* const kCharts[] = {"chart-sizes",   "chart-cumulated", "chart-contacts",
                               "chart-profile", "chart-pairs",     "chart-seconds"};
const double kNothing = std::numeric_limits<double>::quiet_NaN();

/// A pack that has all there is to show.
ReportPage fullPage(int dim) {
    ReportPage page;
    page.subject = "femur.ply";
    page.report = sampleReport();
    page.report.dim = dim;
    page.structure.emplace();
    page.structure->dim = dim;
    page.structure->meanDiameter = 3;
    page.structure->profile = DensityProfile{0.4, {5, 4, 3}, {0.2, 0.7, 0.6}, {0.01, 0.02, 0.03}};
    page.structure->pairCorrelation =
        PairCorrelation{0.1, {0, 0, 2, 1}, {0, 0, 0.1, 0.1}, 500, 0.2};
    page.radii = radiusHistogram(
        {1, 1.2, 1.4, 1.9, 2}, [](double x) { return x - 1; }, {1, 2}, 8);
    page.settings = {{"--seed", "7"}};
    return page;
}

std::string htmlOf(const ReportPage& page) {
    nlohmann::ordered_json figures = toJson(page.report);
    if (page.morphometry)
        figures = {{"morphometry", toJson(*page.morphometry)}};
    else
        addTo(figures, *page.structure);
    return reportPage(page, figures);
}

std::size_t countOf(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++n;
    return n;
}

/// Whether a word occurs, not as a part of another ("information").
bool hasWord(const std::string& text, const std::string& word) {
    const auto isLetter = [](char c) { return c >= 'a' && c <= 'z'; };
    for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; ++at) {
        const std::size_t end = at + word.size();
        if ((at == 0 || !isLetter(text[at - 1])) && (end == text.size() || !isLetter(text[end])))
            return true;
    }
    return false;
}

/// What holds of every page.
void checkPage(const std::string& html) {
    CHECK(flawIn(html) == "");
    CHECK(countOf(html, "http") == 0);
    CHECK(countOf(html, "<script") == 0);
    CHECK(countOf(html, "url(") == 0);
    CHECK(countOf(html, "@import") == 0);
    for (const char* number : {"nan", "inf", "infinity"}) CHECK_FALSE(hasWord(html, number));
    CHECK_THAT(html, Contains("name='viewport'") && Contains("href='data:,'") &&
                         Contains("prefers-color-scheme"));
}

}  // namespace

TEST_CASE("a report page is whole, fetches nothing and has every chart") {
    const int dim = GENERATE(2, 3);
    CAPTURE(dim);
    const std::string html = htmlOf(fullPage(dim));
    checkPage(html);
    for (const char* id : kCharts) {
        CAPTURE(id);
        CHECK(countOf(html, std::string("id='") + id + "'") == 1);
    }
    CHECK(countOf(html, "<p class='none'>") == 2);  // regions and cells: not of this pack
    CHECK_THAT(html, Contains("1,101,921") && Contains("0.5860") && Contains("0000000000000abc") &&
                         Contains("vdb_pack pack femur.ply -o femur.vdb") &&
                         Contains("uniform:1,2"));
    CHECK(countOf(html, "circle</text>") == (dim == 2 ? 1 : 0));
    CHECK_THAT(html, Contains(dim == 2 ? "packed with circles" : "packed with spheres"));
    CHECK_THAT(html, Contains(dim == 2 ? "by area 0.005" : "by volume 0.005"));
    CHECK(html == htmlOf(fullPage(dim)));
}

TEST_CASE("a page says what failed, and judges no pack that is measured") {
    ReportPage page = fullPage(3);
    CHECK_THAT(htmlOf(page), !Contains("CHECK FAILED"));
    page.report.overlap->pairs = 12;
    page.report.overlap->max = 0.25;
    page.report.warnings = {"the field is coarse"};
    CHECK_THAT(htmlOf(page), Contains("12 pairs") && Contains("CHECK FAILED") &&
                                 Contains("<li>the field is coarse</li>"));
    page.report.overlap->pairs = 1;
    CHECK_THAT(htmlOf(page), Contains("1 pair<"));
    page.report.overlap->pairs = 12;
    page.report.task = "measure";
    CHECK_THAT(htmlOf(page), Contains("12 pairs") && !Contains("CHECK FAILED"));
    page.report.voids.emplace();
    page.report.voids->method = "boolean";
    page.report.voids->count = 31;
    page.report.voids->bvtv = 0.154;
    CHECK_THAT(htmlOf(page), Contains("BV/TV 0.1540"));
}

TEST_CASE("names of files cannot break a page") {
    const std::string name =
        GENERATE(std::string("<script>alert('x')</script> & \"y\".ply"), std::string("für 測.ply"),
                 std::string("broken \xff\xc3.ply"), std::string("\xed\xa0\x80\xc0\x80\xf5.ply"),
                 std::string("line\nbreak\x01\x1f.ply"), std::string("]]>--></style></main>.ply"));
    CAPTURE(name);
    ReportPage page = fullPage(3);
    page.subject = name;
    page.report.command = "pack '" + name + "'";
    page.report.requested = "table:" + name;
    page.report.files = {name};
    page.report.chosen = {name};
    page.report.warnings = {name + ": is odd"};
    page.settings = {{"DOMAIN", name}};
    checkPage(htmlOf(page));
}

TEST_CASE("text is escaped and its broken bytes are replaced") {
    CHECK(escaped("a<b>&\"c\"'d'") == "a&lt;b&gt;&amp;&quot;c&quot;&#39;d&#39;");
    CHECK(escaped("für 測 🦴") == "für 測 🦴");
    const std::string gone = "\xEF\xBF\xBD";
    CHECK(escaped(std::string("a\0b", 3)) == "a" + gone + "b");
    CHECK(escaped("\xc3") == gone);
    CHECK(escaped("\xc3(") == gone + "(");
    CHECK(escaped("\xef\xbf\xbf") == gone + gone + gone);
    CHECK(escaped("\xe2\x82") == gone + gone);
}

TEST_CASE("a chart without data says why") {
    const auto reasons = [](const ReportPage& page) {
        const std::string html = htmlOf(page);
        checkPage(html);
        for (const char* id : kCharts)
            if (html.find(std::string("id='") + id + "'") == std::string::npos)
                CHECK(countOf(html, "<p class='none'>") > 0);
        return countOf(html, "</h3>\n<p class='none'>");
    };
    ReportPage nothing;
    nothing.report.task = "pack";
    nothing.structure.emplace();
    CHECK(reasons(nothing) == 6);
    ReportPage one = fullPage(3);
    one.report.count = 1;
    one.report.radius = {1, 1, 1, 0};
    one.report.contacts->histogram = {1};
    one.radii = radiusHistogram({1});
    one.structure->pairCorrelation.reset();
    CHECK(reasons(one) == 1);
    CHECK_THAT(htmlOf(one), Contains("Fewer than 100 spheres"));
    ReportPage loose = fullPage(3);
    loose.report.domain = {};
    loose.report.solidFractionTotal.reset();
    loose.report.solidFractionInterior.reset();
    loose.report.protrusion.reset();
    loose.structure.emplace();
    CHECK(reasons(loose) == 2);
    CHECK_THAT(htmlOf(loose), Contains("--domain"));
}

TEST_CASE("values that are no numbers are left out") {
    const double bad = GENERATE(as<double>{}, kNothing, std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity());
    ReportPage page = fullPage(3);
    page.structure->profile->fraction = {0.2, bad, 0.6};
    page.structure->profile->error = {bad, 0.1, 0.1};
    page.structure->pairCorrelation->g = {bad, bad, bad, bad};
    page.report.solidFractionInterior = bad;
    page.report.smallestGap = bad;
    checkPage(htmlOf(page));
}

TEST_CASE("a solid gets a page with its morphometry") {
    ReportPage page;
    page.subject = "solid.vdb";
    page.report.task = "measure";
    page.morphometry.emplace();
    page.morphometry->solidFraction = 0.1538;
    page.morphometry->thickness = LengthStatistics{0.2048, 0.104, 0.5742};
    page.morphometry->structureModelIndex = 1.234;
    page.morphometry->largestComponent = 0.9876;
    const std::string html = htmlOf(page);
    checkPage(html);
    CHECK_THAT(html, Contains("0.1538") && Contains("Tb.Th") && Contains("0.2048 mm") &&
                         Contains("1.234") && Contains("98.76 %") && !Contains("<svg"));
}

TEST_CASE("ticks are round numbers within the range") {
    CHECK(roundTicks(0, 1, 5) == std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1});
    CHECK(roundTicks(0, 7, 8, true).size() == 8);
    CHECK(roundTicks(0.2, 0.8, 5, true).empty());
    CHECK(roundTicks(3, 3, 5) == std::vector<double>{3});
    for (double high = 1e-9; high < 1e12; high *= 3.7)
        for (const double low : {0.0, -high, 0.99 * high}) {
            CAPTURE(low, high);
            const auto ticks = roundTicks(low, high, 6);
            CHECK(ticks.size() >= 2);
            CHECK(ticks.size() <= 7);
            for (const double t : ticks) {
                CHECK(t >= low - 1e-5 * (high - low));
                CHECK(t <= high + 1e-5 * (high - low));
            }
        }
}

TEST_CASE("a histogram of radii counts all of them, beside the requested shares") {
    std::vector<double> radii;
    for (int i = 0; i <= 1000; ++i) radii.push_back(static_cast<float>(1 + i / 1000.0));
    const auto uniform = [](double r) { return std::clamp(r - 1, 0.0, 1.0); };
    const auto h = radiusHistogram(radii, uniform, {1, 2}, 40);
    CHECK(h.low == 1);
    CHECK(h.low + 40 * h.width == Approx(2));
    CHECK(std::accumulate(h.counts.begin(), h.counts.end(), std::uint64_t{0}) == radii.size());
    CHECK(std::accumulate(h.requested.begin(), h.requested.end(), 0.0) == Approx(1));
    for (std::size_t b = 0; b < h.counts.size(); ++b) {
        CHECK(h.requested[b] == Approx(0.025).epsilon(1e-3));
        CHECK(static_cast<double>(h.counts[b]) == Approx(25).margin(1));
    }
    // One size, and sizes at the ends of bins, as 32-bit floats of a file.
    const auto atOne = [](double r) { return r > 1 ? 1.0 : 0.0; };
    const auto one = radiusHistogram({1, 1, 1}, atOne, {1, 1});
    for (std::size_t b = 0; b < one.counts.size(); ++b)
        CHECK(static_cast<double>(one.counts[b]) / 3 == one.requested[b]);
    const std::vector<double> sizes{0.1, 0.2, 0.3, 0.4, 0.5};
    const auto steps = [&](double r) {
        return static_cast<double>(
                   std::count_if(sizes.begin(), sizes.end(), [&](double s) { return s < r; })) /
               5;
    };
    std::vector<double> rounded;
    for (const double s : sizes) rounded.push_back(static_cast<float>(s));
    const auto table = radiusHistogram(rounded, steps, {0.1, 0.5}, 40);
    for (std::size_t b = 0; b < table.counts.size(); ++b) {
        CAPTURE(b);
        CHECK(table.requested[b] == Approx(static_cast<double>(table.counts[b]) / 5).margin(1e-12));
    }
    CHECK(radiusHistogram({}).counts.empty());
}

TEST_CASE("a page shows its picture, and says what it shows") {
    ReportPage page = fullPage(3);
    const auto without = reportPage(page, {});
    CHECK(without.find("<img") == std::string::npos);
    page.picture.png = "picture";
    page.picture.width = 40;
    page.picture.height = 30;
    page.picture.words = "5 spheres <'&\">";
    const auto with = reportPage(page, {});
    CHECK(flawIn(with).empty());
    CHECK(with.find("<img src='data:image/png;base64,cGljdHVyZQ==' width='40' height='30'") !=
          std::string::npos);
    CHECK(with.find("<figcaption class='words'>5 spheres &lt;") != std::string::npos);
}

TEST_CASE("bytes in base64 are those of RFC 4648") {
    const std::string text = "foobar";
    std::size_t n = 0;
    for (const char* known : {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"})
        CHECK(base64(text.substr(0, n++)) == known);
    CHECK(base64(std::string("\xff\xfe\x00", 3)) == "//4A");
}
