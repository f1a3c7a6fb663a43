#include "support/test.h"

#include "vdbpack/core/error.h"
#include "vdbpack/pack/size_distribution.h"

TEST_CASE("a requested distribution is that of its text in each dimension") {
    const TemporaryFolder folder;
    const std::string table = folder.file("t.csv"), curve = folder.file("c.csv");
    putContent(table, "1,8\n2,1\n");
    putContent(curve, "1,0\n2,100\n");
    const std::string kind = GENERATE("lognormal", "table", "psd");
    const std::string spec = kind == "table" ? "table:" + table
                             : kind == "psd" ? "psd:" + curve
                                             : "lognormal:1,0.5,0.3,3";
    const int dim = GENERATE(2, 3);
    const WeightBy by = GENERATE(WeightBy::count, WeightBy::volume);
    CAPTURE(spec, dim, by == WeightBy::volume);
    const SizeRequest request = SizeRequest::parse(spec);
    const auto sizes = SizeDistribution::parse(spec, dim, by);
    CHECK(request.spec() == spec);
    for (const double u : {0.0, 0.3, 0.9, 1.0}) {
        CHECK(request.in(dim, by).quantile(u) == sizes.quantile(u));
        CHECK(request.scaled(3).in(dim, by).quantile(u) == sizes.scaled(3).quantile(u));
    }
    // The files are read once.
    std::filesystem::remove(table);
    std::filesystem::remove(curve);
    CHECK(request.in(dim, by).mean() == sizes.mean());
}

TEST_CASE("an empty text requests no distribution, and a malformed one is refused") {
    CHECK(SizeRequest::parse("").empty());
    CHECK(SizeRequest().scaled(2).empty());
    CHECK(SizeRequest().spec().empty());
    CHECK_FALSE(SizeRequest(SizeDistribution::constant(1)).empty());
    CHECK_THROWS_AS(SizeRequest::parse("uniform:2,1"), ParameterError);
}
