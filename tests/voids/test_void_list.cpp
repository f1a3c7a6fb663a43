#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/voids/void_list.h"

#include <iterator>

using Catch::Matchers::StartsWith;

namespace {

template <int Dim>
std::vector<Ellipsoid<Dim>> randomVoids(int count, std::uint64_t seed) {
    RandomStream random(seed, Dim);
    std::vector<Ellipsoid<Dim>> voids;
    for (int n = 0; n < count; ++n) {
        Ellipsoid<Dim> e;
        for (int d = 0; d < Dim; ++d) e.center[d] = 800 * random.uniform() - 400;
        e.a = 0.1 + random.uniform();
        e.b = n % 7 == 0 ? e.a : 0.1 + random.uniform();
        if constexpr (Dim == 3)
            e.axis = axisOf(7 * random.uniform(), 7 * random.uniform());
        else
            e.axis = axisOf(7 * random.uniform());
        if (n < Dim) {  // along the axes of coordinates, where angles are on an edge
            e.axis = {};
            e.axis[n] = n % 2 == 0 ? 1 : -1;
        }
        e.id = static_cast<std::uint32_t>(7 * n);
        voids.push_back(e);
    }
    return voids;
}

/// The rows of a table as numbers.
std::vector<std::vector<double>> rowsOf(const std::string& text) {
    std::vector<std::vector<double>> rows;
    std::istringstream in(text);
    std::string line, cell;
    std::getline(in, line);
    while (std::getline(in, line)) {
        std::istringstream cells(line);
        rows.emplace_back();
        while (std::getline(cells, cell, ',')) rows.back().push_back(std::stod(cell));
    }
    return rows;
}

template <int Dim>
std::string failure(const std::string& content) {
    const TextFile file(content, "list.csv");
    return messageOf<InputError>([&] { readVoidList<Dim>(file.path()); });
}

template <int Dim>
Ellipsoid<Dim> onlyVoid(const std::string& content, double scale = 1) {
    const TextFile file(content);
    const auto voids = readVoidList<Dim>(file.path(), scale);
    REQUIRE(voids.size() == 1);
    return voids[0];
}

}  // namespace

DIM_TEST_CASE("a void list is read back to the last bit") {
    const auto voids = randomVoids<Dim>(500, 3);
    const TemporaryFolder folder;
    const std::string path = folder.file("list.csv");
    writeVoidList(voids, path, Unit::millimeter, 12.5);
    const auto back = readVoidList<Dim>(path);
    REQUIRE(back.size() == voids.size());
    for (std::size_t i = 0; i < voids.size(); ++i) {
        CAPTURE(Dim, i);
        REQUIRE(back[i].center == voids[i].center);
        REQUIRE(back[i].a == voids[i].a);
        REQUIRE(back[i].b == voids[i].b);
        REQUIRE(back[i].axis == voids[i].axis);
        REQUIRE(back[i].id == voids[i].id);
    }
}

DIM_TEST_CASE("angles in a void list give the axis, in the plane too") {
    const auto voids = randomVoids<Dim>(100, 4);
    const std::string text = voidListText(voids, Unit::millimeter, 12.5);
    REQUIRE_THAT(text, StartsWith("x,y,z,a,b,theta_z,theta_x,ux,uy,uz,id\n"));
    const auto rows = rowsOf(text);
    REQUIRE(rows.size() == voids.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        CAPTURE(Dim, i);
        REQUIRE(rows[i].size() == 11);
        Vec<3> axis;
        for (int d = 0; d < Dim; ++d) axis[d] = voids[i].axis[d];
        CHECK(length(axisOf(rows[i][5], rows[i][6]) - axis) < 1e-14);
        if (Dim == 2) {
            CHECK(rows[i][2] == 12.5);
            CHECK(rows[i][6] == Approx(kPi / 2));
            CHECK(rows[i][9] == 0);
        }
    }
}

TEST_CASE("a list in another unit is the same list") {
    const auto voids = randomVoids<3>(50, 5);
    const TextFile file(voidListText(voids, Unit::meter));
    CHECK(voidListText(voids, Unit::meter).rfind("# unit of length: m\nx,y,z", 0) == 0);
    const auto back = readVoidList<3>(file.path());
    for (std::size_t i = 0; i < voids.size(); ++i) {
        CHECK(length(back[i].center - voids[i].center) < 1e-12);
        CHECK(back[i].a == Approx(voids[i].a));
        CHECK(back[i].axis == voids[i].axis);
    }
}

TEST_CASE("columns of a void list may have any order and any of their names") {
    const auto e = onlyVoid<3>("# from a scanner\nid;B;A;Z;Y;X;uz;uy;ux\n7;1;2;5;4;3;0;-3;0\n");
    CHECK(e.center == Vec<3>{{3, 4, 5}});
    CHECK(e.a == 2);
    CHECK(e.b == 1);
    CHECK(e.axis == Vec<3>{{0, -1, 0}});
    const auto turned = onlyVoid<3>("# x y z a b tz tx\n\n3 4 5 2 1 0.5 0.25\n", 10);
    CHECK(turned.axis == axisOf(0.5, 0.25));
    CHECK(turned.center == Vec<3>{{30, 40, 50}});
    CHECK(turned.b == 10);
    const auto flat = onlyVoid<2>("x,y,a,b,ux,uy\n1,2,3,1,0.6,0.8\n");
    CHECK(flat.center == Vec<2>{{1, 2}});
    CHECK(length(flat.axis - Vec<2>{{0.6, 0.8}}) < 1e-15);
}

TEST_CASE("an axis is given by angles or a direction, by neither where a equals b") {
    CHECK(onlyVoid<3>("x,y,z,a,b\n0,0,0,2,2\n").axis == Vec<3>{{0, 0, 1}});
    CHECK(onlyVoid<2>("x,y,a,b\n0,0,2,2\n").axis == Vec<2>{{1, 0}});
    CHECK(onlyVoid<3>("x,y,z,a,b,ux,uy,uz\n0,0,0,2,2,,,\n").axis == Vec<3>{{0, 0, 1}});
    CHECK(onlyVoid<3>("x,y,z,a,b,ux,uy,uz\n0,0,0,2,2,0,0,0\n").axis == Vec<3>{{0, 0, 1}});
    // The direction takes precedence; its sign and length have no meaning.
    const auto e = onlyVoid<3>("x,y,z,a,b,theta_z,theta_x,ux,uy,uz\n0,0,0,2,1,0,0.5,0,479,-878\n");
    CHECK(length(e.axis - normalized(Vec<3>{{0, 479, -878}})) < 1e-15);
    CHECK_THAT(failure<3>("x,y,z,a,b\n0,0,0,2,2\n1,1,1,3,2\n"),
               Contains("list.csv: line 3") && Contains("a = 3 and b = 2") && Contains("ux,uy,uz"));
    CHECK_THAT(failure<3>("x,y,z,a,b,theta_z,theta_x,ux,uy,uz\n0,0,0,2,1,0,0.5,0,0.484,-0.878\n"),
               Contains("line 2") && Contains("(0, 0.48") && Contains("theta_x 0.5"));
    CHECK_THAT(failure<3>("x,y,z,a,b,ux,uy,uz\n0,0,0,2,1,0,0,0\n"),
               Contains("line 2") && Contains("(0, 0, 0)"));
}

TEST_CASE("a void of the plane may lie at any height, but its axis lies in the plane") {
    CHECK(onlyVoid<2>("x,y,z,a,b,ux,uy,uz\n1,2,99,3,1,0,2,0.0001\n").axis[1] == 1);
    CHECK(length(onlyVoid<2>("x,y,a,b,theta_z,theta_x\n0,0,3,1,1.5707963,1.5707963\n").axis -
                 Vec<2>{{1, 0}}) < 1e-7);
    CHECK_THAT(failure<2>("x,y,z,a,b,ux,uy,uz\n1,2,0,3,1,0,1,0.1\n"),
               Contains("list.csv: line 2") && Contains("(0, 0.995037, 0.0995037)"));
    CHECK_THAT(failure<2>("x,y,a,b,theta_z,theta_x\n0,0,3,1,0,1.5\n"),
               Contains("line 2") && Contains("plane"));
}

TEST_CASE("a malformed void list is refused with its line and value") {
    CHECK_THAT(failure<3>("x,y,z,a,b\n0,0,0,1,1\n0,0,0,-2,1\n"),
               Contains("list.csv: line 3") && Contains("a = -2 and b = 1"));
    CHECK_THAT(failure<3>("x,y,z,a,b\n\n0,0,0,1,0\n"),
               Contains("line 3") && Contains("a = 1 and b = 0"));
    CHECK_THAT(failure<3>("x,y,z,a,b\n0,nan,0,1,1\n"),
               Contains("line 2") && Contains("'nan'") && Contains("'y'"));
    CHECK_THAT(failure<3>("x,y,z,a,b\n0,0,0,inf,1\n"),
               Contains("line 2") && Contains("'inf'") && Contains("'a'"));
    CHECK_THAT(failure<3>("x,y,z,a,b\n0,0,0,1 mm,1\n"),
               Contains("line 2") && Contains("'1 mm'") && Contains("'a'"));
    CHECK_THAT(failure<3>("x,y,z,a,b\n0,0,0,1\n"),
               Contains("line 2") && Contains("4 cells") && Contains("5 columns"));
    CHECK_THAT(failure<3>("x,y,a,b\n0,0,1,1\n"),
               Contains("list.csv: line 1") && Contains("'z'") && Contains("x,y,a,b"));
    CHECK_THAT(failure<3>("x,y,z,a\n0,0,0,1\n"), Contains("'b'"));
    CHECK_THAT(failure<3>("x,y,z,a,b,X\n"), Contains("'x' and 'X'"));
    CHECK_THAT(failure<3>("x,y,z,a,b,theta_z\n"), Contains("'theta_z' and 'theta_x'"));
    CHECK_THAT(failure<3>("x,y,z,a,b,ux,uy\n"), Contains("'uz'"));
    CHECK_THAT(failure<3>("0,0,0,1,1\n"), Contains("line 1"));
    CHECK_THAT(failure<3>("# nothing\n"), Contains("list.csv"));
    CHECK(failure<3>("x,y,z,a,b\n").empty());
    CHECK_THAT(messageOf<ParameterError>([] { readVoidList<3>("list.csv", -1); }),
               Contains("list.csv: scale -1"));
    CHECK_THROWS_AS(readVoidList<3>("/nowhere/list.csv"), IoError);
}
