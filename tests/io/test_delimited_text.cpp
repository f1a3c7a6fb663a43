#include "support/test.h"

#include "vdbpack/io/delimited_text.h"
#include "vdbpack/io/numbers.h"
#include "vdbpack/io/text.h"

namespace {

using Rows = std::vector<std::vector<std::string>>;

Rows rowsOf(DelimitedText& text) {
    Rows rows;
    for (Cells cells; text.nextRow(cells);) rows.emplace_back(cells.begin(), cells.end());
    return rows;
}

struct Table {
    std::vector<std::string> names;
    Rows rows;
};

Table read(const std::string& content) {
    const TextFile made(content);
    DelimitedText text(made.path());
    text.readHeader("x,y");
    return {text.names(), rowsOf(text)};
}

}  // namespace

TEST_CASE("a table is the same with any separator") {
    for (const char* content :
         {"x,y z,r\n1,2,3\n4,5,6\n", "x;y z;r\n1;2;3\n4;5;6\n", "x\ty z\tr\n1\t2\t3\n4\t5\t6\n",
          "\xEF\xBB\xBFx, y z , r\r\n1 ,2, 3\r\n\r\n4,5,6", "sep=;\nx;y z;r\n1;2;3\n4;5;6\n",
          "x \"y z\"  r\n 1  2 3 \n4 5\t6\n", "# x,y z,r\n1,2,3\n# 9,9,9\n4,5,6\n",
          "# made on Monday\nx,\"y z\",r\n1,\"2\",3\n4,5,6\n"}) {
        CAPTURE(content);
        const Table table = read(content);
        CHECK(table.names == std::vector<std::string>{"x", "y z", "r"});
        CHECK(table.rows == Rows{{"1", "2", "3"}, {"4", "5", "6"}});
    }
}

TEST_CASE("quotes keep separators, and two quotes are one") {
    const Table table = read("x,name\n1,\"a,\"\"b\"\"; c\"\n2,\n");
    CHECK(table.rows == Rows{{"1", "a,\"b\"; c"}, {"2", ""}});
}

TEST_CASE("malformed tables are refused with their line") {
    const auto refusal = [](const std::string& content) {
        return messageOf<InputError>([&] { read(content); });
    };
    CHECK_THAT(refusal(""), Contains("x,y"));
    CHECK_THAT(refusal("# a comment\n"), Contains("x,y"));
    CHECK_THAT(refusal("1,2\n3,4\n"), Contains("line 1") && Contains("x,y"));
    CHECK_THAT(refusal("x,y\n1,2\n\n3\n"), Contains("line 4") && Contains("1 cells"));
    CHECK_THAT(refusal("x,y\n1,2,3\n"), Contains("line 2") && Contains("3 cells"));
    CHECK_THAT(refusal("x,y\n1,\"2\n"), Contains("line 2") && Contains("quote"));
    CHECK_THAT(refusal("x,\"y\n1,2\n"), Contains("line 1") && Contains("quote"));
}

TEST_CASE("a comment that may be a row of texts is refused only on request") {
    const TextFile made("name,x\n#1,2\na,3\n");
    DelimitedText text(made.path());
    text.readHeader("x");
    CHECK(rowsOf(text) == Rows{{"a", "3"}});
    text.file().seek(7, 1);
    text.refuseAmbiguousComments();
    CHECK_THAT(messageOf<InputError>([&] { rowsOf(text); }), Contains("line 2"));
}

TEST_CASE("without a header each row has its own separator") {
    const TextFile made("a b\n1,2\n3;4;5\n6\t7\n");
    DelimitedText text(made.path());
    CHECK(rowsOf(text) == Rows{{"a", "b"}, {"1", "2"}, {"3", "4", "5"}, {"6", "7"}});
}

TEST_CASE("names of columns count without case, signs and units") {
    CHECK(canonicalName("Theta_Z [rad]") == "thetaz");
    CHECK(canonicalName("Points:0") == "points0");
    CHECK(canonicalName("\xCE\xB8z (deg)") == "\xCE\xB8z");
}

TEST_CASE("numbers are read whole or not at all") {
    double value = 7;
    for (const char* text :
         {"", "1 2", "1,5", "0x10", "--1", "+-1", "1e", "one", "1e999", "1e-999"})
        CHECK(!parseNumber(text, value));
    CHECK(value == 7);
    CHECK((parseNumber(" +1.5e3\t", value) && value == 1500));
    CHECK((parseReal("-1e-999", value) && value == 0));
    CHECK((parseReal("+0.0000001e-999", value) && value == 0));
    CHECK((parseReal("1e999", value) && std::isinf(value)));
    CHECK(!parseReal(" 1", value));
    std::int64_t whole = 7;
    for (const char* text : {"1.5", "1e30", "9223372036854775808"})
        CHECK(!parseNumber(text, whole));
    CHECK((parseNumber("3.0", whole) && whole == 3));
    CHECK(!parseInteger("3.0", whole));
    CHECK((parseInteger("-9223372036854775808", whole) && whole == INT64_MIN));
    CHECK(parseNumberList("1,-2.5, 3") == std::vector<double>{1, -2.5, 3});
    for (const char* text : {"", "1,", ",1", "1;2", "1,inf", "1,nan"})
        CHECK(!parseNumberList(text).has_value());
}

TEST_CASE("texts are cut, compared and quoted without a locale") {
    CHECK(extensionOf("a.b/c.d/Skull.STL") == ".stl");
    CHECK(extensionOf("a.b/skull").empty());
    CHECK((endsWith("a.stl", ".stl") && !endsWith("stl", ".stl")));
    CHECK((equalsNoCase("SoLiD", "solid") && !equalsNoCase("solids", "solid")));
    CHECK(quotedExcerpt("a\nb") == "'a?b'");
    CHECK(quotedExcerpt(std::string(41, 'x')) == "'" + std::string(40, 'x') + "...'");
    CHECK(oneLine("a\tb\nc") == "a b c");
    std::string text;
    for (const std::uint32_t c : {0x41u, 0xe9u, 0x20acu, 0x1f9b4u}) appendUtf8(text, c);
    CHECK(text == "A\xC3\xA9\xE2\x82\xAC\xF0\x9F\xA6\xB4");
}

TEST_CASE("texts of damaged files are fit for a terminal") {
    CHECK(printable("K\xc3\xb6rper \xf0\x9f\xa6\xb4\n\t.") ==
          "K\xc3\xb6rper \xf0\x9f\xa6\xb4\n\t.");
    CHECK(printable("a\x1b[2J\x7f\xff\xc3") == "a?[2J???");
    CHECK(printable("\xc2\x9b"
                    "0m") == "??0m");                     // a control of 8 bits
    CHECK(printable("\xed\xa0\x80\xc0\x80") == "?????");  // a surrogate, and NUL in two bytes
    CHECK(quotedExcerpt("a\nb\xff") == "'a?b?'");
    const std::string umlauts = "\xc3\xb6\xc3\xb6\xc3\xb6\xc3\xb6";
    CHECK(quotedExcerpt(std::string(39, 'x') + umlauts) == "'" + std::string(39, 'x') + "...'");
}

TEST_CASE("sizes of memory are read as people write them") {
    constexpr double kGibi = 1 << 30;
    const std::vector<std::pair<const char*, double>> sizes{{"65536", 65536},
                                                            {"8G", 8 * kGibi},
                                                            {"8g", 8 * kGibi},
                                                            {"500M", 500 * kGibi / 1024},
                                                            {"500MB", 5e8},
                                                            {"500 MB", 5e8},
                                                            {"1.5GiB", 1.5 * kGibi},
                                                            {"2K", 2048},
                                                            {"1e3", 1000},
                                                            {"3T", 3 * 1024 * kGibi},
                                                            {"7B", 7}};
    for (const auto& [text, bytes] : sizes) {
        CAPTURE(text);
        CHECK(parseBytes(text).value_or(0) == bytes);
    }
    for (const char* bad : {"", "0", "-1G", "nan", "inf", "G", "8X", "8GG", "8Gi", "8 G B", "1e400",
                            "0.5", "8G,", "all"}) {
        CAPTURE(bad);
        CHECK_FALSE(parseBytes(bad).has_value());
    }
}
