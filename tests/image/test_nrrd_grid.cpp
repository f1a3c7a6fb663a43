#include "support/test.h"

#include "vdbpack/image/nrrd_grid.h"

namespace {

/// A header of lines "key: value".
TextHeader headerOf(const std::string& lines) {
    const TemporaryFolder folder;
    std::ofstream(folder.file("a.nrrd")) << "NRRD0005\ntype: uint8\n" << lines << "\n\n";
    return readTextHeader(folder.file("a.nrrd"));
}

struct Placed {
    ImageGrid grid;
    double unit = 0;
    std::vector<std::string> warnings;
    bool isSided = false;
};

Placed placed(const std::string& lines, std::size_t dimensions = 3) {
    Placed result;
    Callbacks callbacks;
    callbacks.warning = [&](const std::string& text) { result.warnings.push_back(text); };
    result.grid = nrrdGrid(headerOf(lines), dimensions, "a", callbacks, result.unit);
    result.isSided = namesSides(headerOf(lines));
    return result;
}

const std::string kSizes = "dimension: 3\nsizes: 4 3 2\n";

}  // namespace

TEST_CASE("NRRD: spaces of patients are turned to LPS, others are reported") {
    struct Space {
        const char* name;
        Vec<3> signs;
        bool known;
    };
    const auto space = GENERATE(values<Space>({
        {"space: left-posterior-superior", {{1, 1, 1}}, true},
        {"space: LPS", {{1, 1, 1}}, true},
        {"space: right-anterior-superior", {{-1, -1, 1}}, true},
        {"space: RAS", {{-1, -1, 1}}, true},
        {"space: left-anterior-superior", {{1, -1, 1}}, true},
        {"space: LAS", {{1, -1, 1}}, true},
        {"space: left-anterior-superior-time", {{1, -1, 1}}, true},
        {"space: RAST", {{-1, -1, 1}}, true},
        {"space: scanner-xyz", {{1, 1, 1}}, false},
        {"space: scanner-xyz-time", {{1, 1, 1}}, false},
        {"space: 3D-right-handed", {{1, 1, 1}}, false},
        {"space: 3D-left-handed", {{1, 1, 1}}, false},
        {"space dimension: 3", {{1, 1, 1}}, false},
    }));
    CAPTURE(space.name);
    const bool time = space.name[std::string(space.name).size() - 1] == 'T' ||
                      std::string(space.name).find("time") != std::string::npos;
    const std::string end = time ? ",0)" : ")";
    const Placed image =
        placed((time ? "dimension: 4\nsizes: 4 3 2 1\n" : kSizes) + std::string(space.name) +
                   "\nspace directions: (2,1,0" + end + " (0, 3, 0" + end + " (0,0,4" + end +
                   (time ? " (0,0,0,1)" : "") + "\nspace origin: (1,2,3" + end,
               time ? 4 : 3);
    CHECK(image.grid.origin == Vec<3>{{space.signs[0], 2 * space.signs[1], 3}});
    CHECK(image.grid.step[0] == Vec<3>{{2 * space.signs[0], space.signs[1], 0}});
    CHECK(image.grid.step[1] == Vec<3>{{0, 3 * space.signs[1], 0}});
    CHECK(image.grid.step[2] == Vec<3>{{0, 0, 4}});
    CHECK(image.warnings.size() == (space.known ? 0 : 1));
    CHECK(image.isSided == space.known);
    if (!space.known) CHECK_THAT(image.warnings.front(), Contains("left is unknown"));
}

TEST_CASE("NRRD: units that a header states are used and reported") {
    const std::string axes =
        kSizes +
        "space: LPS\nspace directions: (500,0,0) (0,600,0) (0,0,700)\nspace origin: (1,2,3)\n";
    const Placed micrometers = placed(axes + "space units: \"um\" \"um\" \"um\"");
    CHECK(length(micrometers.grid.spacing() - Vec<3>{{0.5, 0.6, 0.7}}) < 1e-12);
    CHECK(length(micrometers.grid.origin - Vec<3>{{0.001, 0.002, 0.003}}) < 1e-15);
    CHECK(micrometers.unit == 0.001);
    REQUIRE(micrometers.warnings.size() == 1);
    CHECK_THAT(micrometers.warnings.front(), Contains("0.001"));
    CHECK(placed(axes + "space units: \"mm\" \"mm\" \"mm\"").warnings.empty());
    CHECK(placed(axes + "space units: \"\" \"\" \"\"").unit == 0);
    CHECK_THAT(placed(axes + "space units: \"ft\" \"ft\" \"ft\"").warnings.at(0),
               Contains("no known unit"));
    CHECK_THROWS_AS(placed(axes + "space units: \"mm\" \"mm\" \"m\""), InputError);
    const Placed plain = placed(kSizes + "spacings: 1 2 3\nunits: \"cm\" \"cm\" \"cm\"");
    CHECK(plain.grid.spacing() == Vec<3>{{10, 20, 30}});
}

TEST_CASE("NRRD: borders and centers of axes place the voxels") {
    const std::string borders = kSizes + "axis mins: 10 20 30\n";
    const std::string both = borders + "axis maxs: 18 26 36\n";
    const auto check = [](const Placed& image, const Vec<3>& spacing, const Vec<3>& origin) {
        CHECK(image.grid.spacing() == spacing);
        CHECK(image.grid.origin == origin);
    };
    check(placed(both), {{2, 2, 3}}, {{11, 21, 31.5}});
    check(placed(both + "centers: cell cell cell"), {{2, 2, 3}}, {{11, 21, 31.5}});
    check(placed(both + "centers: node node node"), {{8.0 / 3, 3, 6}}, {{10, 20, 30}});
    check(placed(borders + "spacings: 1 2 4"), {{1, 2, 4}}, {{10.5, 21, 32}});
    check(placed(borders + "spacings: 1 2 4\ncenterings: node node node"), {{1, 2, 4}},
          {{10, 20, 30}});
    CHECK_THAT(placed(both).warnings.at(0), Contains("borders"));
    CHECK(placed(both + "centers: cell node cell").warnings.size() == 1);  // only of the space
    // Axes of voxels' values have none of them.
    check(placed("dimension: 4\nsizes: 2 4 3 2\nkinds: vector domain domain domain\n"
                 "spacings: nan 1 2 4"),
          {{1, 2, 4}}, {{0, 0, 0}});
    CHECK(std::isnan(placed(kSizes + "spacings: 1 2 nan").grid.spacing()[2]));
    CHECK(std::isnan(placed(kSizes).grid.spacing()[0]));
    CHECK_THROWS_AS(placed(kSizes + "kinds: vector domain domain"), InputError);
}
