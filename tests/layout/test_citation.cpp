// What a paper cites is the same wherever the tree states it.
#include "support/paths.h"
#include "support/text_file.h"

#include <catch2/catch.hpp>

#include <regex>
#include <string>

using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

/// What the first match of `pattern` encloses; empty: none.
std::string found(const std::string& text, const char* pattern) {
    std::smatch match;
    return std::regex_search(text, match, std::regex(pattern)) ? match[1].str() : std::string();
}

}  // namespace

TEST_CASE("the citation has authors, version and date, alike in all its places", "[layout]") {
    const std::string top = kTests + "/../";
    const std::string citation = contentOf(top + "CITATION.cff");
    const std::string readme = contentOf(top + "README.md");
    const std::string version = found(citation, "\nversion: ([0-9.]+)\n");
    CHECK(version ==
          found(contentOf(top + "CMakeLists.txt"), "project\\(vdb_pack VERSION ([0-9.]+)"));
    CHECK(version == found(readme, "version = \\{([0-9.]+)\\}"));
    const std::string date = found(citation, "\ndate-released: (\\d{4}-\\d\\d-\\d\\d)\n");
    CHECK(date.substr(0, 4) == found(readme, "year    = \\{(\\d{4})\\}"));
    const std::string authors = found(citation, "\nauthors:\n  - name: ([^\n]+)\n");
    CHECK_FALSE(authors.empty());
    CHECK_THAT(readme, Contains("{{" + authors + "}}"));
    CHECK(found(citation, "\nlicense: (\\S+)\n") == "Apache-2.0");
    CHECK_THAT(contentOf(top + "LICENSE"), Contains("Apache License"));
    CHECK_THAT(readme, Contains("license = {Apache-2.0}"));
}

TEST_CASE("each paper that is cited has authors, a year and a DOI", "[layout]") {
    const std::string citation = contentOf(kTests + "/../CITATION.cff");
    const std::string papers = citation.substr(citation.find("\nreferences:\n"));
    const std::regex paper("  - type: article\n((?:    [^\n]*\n)+)");
    int papersSeen = 0;
    for (auto it = std::sregex_iterator(papers.begin(), papers.end(), paper);
         it != std::sregex_iterator(); ++it, ++papersSeen) {
        const std::string fields = (*it)[1];
        CAPTURE(fields);
        CHECK_FALSE(found(fields, "family-names: (\\S+)").empty());
        CHECK(found(fields, "year: (\\d{4})\n").size() == 4);
        CHECK_FALSE(found(fields, "doi: (10\\.\\d+/\\S+)\n").empty());
    }
    CHECK(papersSeen >= 2);
}
