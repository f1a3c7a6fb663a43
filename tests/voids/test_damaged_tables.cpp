// Tables of voids and directions that are truncated, damaged or contain absurd numbers.

#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/voids/direction_field.h"
#include "vdbpack/voids/void_list.h"

namespace {

/// A reader, a small file of its format, and the check of what was read.
struct Format {
    const char* name;
    std::string content;
    std::function<void(const std::string& path)> read;
};

void readField(const std::string& path) {
    const auto field = readDirectionField(path);
    for (const Vec<3>& x : {Vec<3>{}, Vec<3>{{1, 2, 3}}, Vec<3>{{-1e9, 1e9, 0.5}}})
        REQUIRE(length(field->at(x)) == Approx(1));
}

template <int Dim>
void readList(const std::string& path) {
    for (const auto& e : readVoidList<Dim>(path)) {
        REQUIRE(isFinite(e.center));
        REQUIRE(e.a > 0);
        REQUIRE(e.b > 0);
        REQUIRE(length(e.axis) == Approx(1));
    }
}

const Format kFormats[] = {
    {"list", "x,y,z,a,b,theta_z,theta_x,ux,uy,uz\n1,2,3,0.5,0.25,0,1.5707963267948966,0,-1,0\n",
     readList<3>},
    {"list of the plane", "x,y,a,b,ux,uy\n1,2,0.5,0.25,0.6,0.8\n3,4,1,1,0,0\n", readList<2>},
    {"matrix", "# cells\n0 1 1\n1,0,0\n\n011\n100\n",
     [](const std::string& path) {
         const VoidMatrix m = readVoidMatrix(path);
         REQUIRE(m.cells.size() == static_cast<std::size_t>(m.size[0] * m.size[1] * m.size[2]));
     }},
    {"directions", "x,y,z,ux,uy,uz\n0,0,0,1,0,0\n1,0,0,0,1e-3,0\n0,5,0,0,0,-1\n", readField},
    {"stresses", "X [mm];Y [mm];Sx;Sy;Sxy\n0;0;1;-2;0.5\n3;1e-3;1e6;2;0\n", readField}};

/// Whether the file is read; any error but an InputError that names it escapes.
bool reads(const Format& format, const TextFile& file) {
    try {
        format.read(file.path());
        return true;
    } catch (const InputError& e) {
        REQUIRE_THAT(e.what(), Contains(file.path()));
        return false;
    }
}

}  // namespace

TEST_CASE("a truncated table is refused or read as a shorter one") {
    for (const Format& format : kFormats) {
        REQUIRE(reads(format, TextFile(format.content)));
        for (std::size_t n = 0; n < format.content.size(); ++n) {
            CAPTURE(format.name, n);
            CHECK_NOTHROW(reads(format, TextFile(format.content.substr(0, n))));
        }
        CHECK(!reads(format, TextFile("")));
    }
}

TEST_CASE("a table with changed bytes is refused or read as another one") {
    RandomStream random(8, 1);
    for (const Format& format : kFormats)
        for (int trial = 0; trial < 200; ++trial) {
            std::string content = format.content;
            for (std::uint64_t k = 0; k <= random.bits() % 3; ++k)
                content[random.bits() % content.size()] =
                    random.bits() % 2 == 0 ? static_cast<char>(random.bits() % 256)
                                           : "0123456789-+.e \n,;#"[random.bits() % 19];
            CAPTURE(format.name, trial, content);
            CHECK_NOTHROW(reads(format, TextFile(content)));
        }
}

TEST_CASE("every table reader throws IoError for a folder, a missing file or a device") {
    const TemporaryFolder folder;
    for (const Format& format : kFormats) {
        CAPTURE(format.name);
        CHECK_THROWS_AS(format.read(folder.file("none.csv")), IoError);
        std::filesystem::create_directories(folder.file("f.csv"));
        CHECK_THROWS_AS(format.read(folder.file("f.csv")), IoError);
    }
    CHECK_THROWS_AS(readVoidMatrix("/dev/zero"), IoError);
}

TEST_CASE("numbers too small for a reciprocal still define a direction") {
    for (const std::string tiny : {"1e-320", "4.9e-324", "1e-300"}) {
        CAPTURE(tiny);
        const TextFile list("x,y,z,a,b,ux,uy,uz\n0,0,0,2,1,0," + tiny + ",0\n");
        CHECK(readVoidList<3>(list.path())[0].axis[1] == Approx(1));
        const TextFile directions("x,y,z,ux,uy,uz\n0,0,0,0,0,-" + tiny + "\n");
        CHECK(std::fabs(readDirectionField(directions.path())->at({})[2]) == Approx(1));
        const TextFile stresses("x,y,z,sxx,syy,szz,sxy,syz,sxz\n0,0,0,0,-" + tiny + ",0,0,0,0\n");
        CHECK(std::fabs(readDirectionField(stresses.path())->at({{1, 0, 0}})[1]) == Approx(1));
    }
}

TEST_CASE("positions and stresses beyond any bone are refused with their line") {
    const auto message = [](const std::string& row) {
        const TextFile file("x,y,z,sxx,syy,szz,sxy,syz,sxz\n" + row + "\n");
        return messageOf<InputError>([&] { readDirectionField(file.path()); });
    };
    CHECK_THAT(message("1e10,0,0,1,2,3,0,0,0"), Contains("line 2") && Contains("unit"));
    CHECK_THAT(message("0,0,0,1,2,1e301,0,0,0"), Contains("line 2") && Contains("stress"));
    CHECK_THAT(message("0,0,inf,1,2,3,0,0,0"), Contains("line 2"));
    CHECK_THAT(message("0,0,0,1,2,nan,0,0,0"), Contains("line 2"));
}
