// The command stiffness: what it prints, the bonds it writes, and bonds for a wanted stiffness.
#include "support/test.h"
#include "support/tool.h"

#include "vdbpack/io/text.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <map>
#include <sstream>
#include <string>

namespace {

const char* const kBox = "box:12,12,12";

/// A pack of some hundred spheres. @return its file
std::string packedIn(const TemporaryFolder& folder) {
    const std::string file = folder.file("p.csv");
    REQUIRE(vdbPack(std::string("pack ") + kBox + " --radius uniform:0.6,1.2 --quiet -o " + file)
                .code == 0);
    return file;
}

nlohmann::json stiffnessJson(const std::string& words) {
    const auto run = vdbPack("stiffness " + words + " --json");
    REQUIRE(run.code == 0);
    return nlohmann::json::parse(run.text);
}

}  // namespace

TEST_CASE("stiffness prints a symmetric matrix in proportion to the modulus of the bonds") {
    const TemporaryFolder folder;
    const std::string words = packedIn(folder) + " --domain " + kBox + " --contact-tol 0.01";
    const auto one = stiffnessJson(words), twice = stiffnessJson(words + " --bond-modulus 2000");
    CHECK(one["volume"].get<double>() == Approx(1728));
    const auto& c = one["stiffness"];
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b) {
            CAPTURE(a, b);
            const double largest = c[0][0].get<double>();
            CHECK(c[a][b].get<double>() ==
                  Approx(c[b][a].get<double>()).epsilon(1e-4).margin(1e-4 * largest));
            CHECK(twice["stiffness"][a][b].get<double>() ==
                  Approx(2 * c[a][b].get<double>()).epsilon(1e-4).margin(1e-4 * largest));
        }
    CHECK(one["E"][0].get<double>() > 0);
    CHECK(one["largest"]["E"].get<double>() >= one["smallest"]["E"].get<double>());
    CHECK_THAT(vdbPack("stiffness " + words).text, Contains("isotropic") && Contains("MPa"));
}

TEST_CASE("bonds for a wanted modulus and Poisson's ratio give the pack these") {
    const TemporaryFolder folder;
    const std::string words = packedIn(folder) + " --domain " + kBox + " --contact-tol 0.01";
    const auto found = stiffnessJson(words + " --bond-modulus-for 300,0.2");
    CHECK(found["isotropic"]["E"].get<double>() == Approx(300));
    CHECK(found["isotropic"]["nu"].get<double>() == Approx(0.2).margin(1e-3));
    const auto& bonds = found["bonds"];
    const auto again = stiffnessJson(words + " --bond-modulus " + bonds["modulus"].dump() +
                                     " --bond-shear " + bonds["shearRatio"].dump());
    CHECK(again["isotropic"]["E"].get<double>() == Approx(300).epsilon(1e-4));
    const auto beyond = vdbPack("stiffness " + words + " --bond-modulus-for 300,0.49");
    CHECK(beyond.code == 2);
    CHECK_THAT(beyond.text, Contains("--bond-modulus-for") && Contains("0.49"));
    CHECK(vdbPack("stiffness " + words + " --bond-modulus-for 300").code == 2);
    // Between grips, the modulus alone.
    const std::string pressed = words + " --press z --bond-shear 0.3";
    const auto sought = stiffnessJson(pressed + " --bond-modulus-for 300");
    CHECK(sought["pressed"]["modulus"].get<double>() == Approx(300));
    const auto same =
        stiffnessJson(pressed + " --bond-modulus " + sought["bonds"]["modulus"].dump());
    CHECK(same["pressed"]["modulus"].get<double>() == Approx(300).epsilon(1e-4));
    CHECK_THAT(vdbPack("stiffness " + pressed + " --bond-modulus-for 300,0.2").text,
               Contains("write E alone"));
}

TEST_CASE("an implant keeps its modulus where bonds for a wanted modulus are sought") {
    const TemporaryFolder folder;
    // Lower half: bone of several moduli; upper half: an implant of one.
    const auto scaled = [&](double by) {
        const std::string file = folder.file("m.csv");
        std::ifstream from(packedIn(folder));
        std::ofstream to(file);
        std::string line;
        std::getline(from, line);
        to << "x,y,z,radius,part,modulus_MPa\n";
        for (int n = 0; std::getline(from, line); ++n) {
            std::istringstream fields(line);
            std::string id, x, y, z, r;
            for (std::string* field : {&id, &x, &y, &z, &r}) std::getline(fields, *field, ',');
            const bool implant = std::stod(z) > 0;
            to << x << ',' << y << ',' << z << ',' << r << ',' << implant << ','
               << (implant ? 5000 : by * (200 + n % 7)) << '\n';
        }
        return file + " --domain " + kBox + " --contact-tol 0.05";
    };
    const std::string ways[] = {" --press x", " --press z", " --bond-shear 0.1"};
    for (const std::string& way : ways) {
        CAPTURE(way);
        const bool pressed = way.find("press") != std::string::npos;
        const auto modulusIn = [&](const nlohmann::json& json) {
            return (pressed ? json["pressed"]["modulus"] : json["isotropic"]["E"]).get<double>();
        };
        const double wanted = 1.3 * modulusIn(stiffnessJson(scaled(1) + way));
        const std::string ask = " --bond-modulus-for " + std::to_string(wanted);
        const auto found = stiffnessJson(scaled(1) + (pressed ? way + ask : ask + ",0.2"));
        CHECK(modulusIn(found) == Approx(wanted).epsilon(1e-3));
        REQUIRE(found["bonds"]["keptModuli"].size() == 1);
        const auto& bonds = found["bonds"];
        const auto again =
            stiffnessJson(scaled(bonds["modulusFactor"].get<double>()) +
                          (pressed ? way : " --bond-shear " + bonds["shearRatio"].dump()));
        CHECK(modulusIn(again) == Approx(wanted).epsilon(1e-3));
    }
    const auto beyond = vdbPack("stiffness " + scaled(1) + " --press x --bond-modulus-for 1");
    CHECK(beyond.code == 2);
    CHECK_THAT(beyond.text, Contains("part 1") && Contains("own"));
}

TEST_CASE("parts that few bonds join are said to be a weak plane, by what would join them") {
    const TemporaryFolder folder;
    const auto apart = [&](double gap) {  // the upper half, raised
        std::ifstream from(packedIn(folder));
        const std::string file = folder.file("a.csv");
        std::ofstream to(file);
        std::string line;
        std::getline(from, line);
        to << "x,y,z,radius,part\n";
        while (std::getline(from, line)) {
            std::istringstream fields(line);
            std::string id, x, y, z, r;
            for (std::string* field : {&id, &x, &y, &z, &r}) std::getline(fields, *field, ',');
            const bool upper = std::stod(z) > 0;
            to << x << ',' << y << ',' << std::stod(z) + (upper ? gap : 0) << ',' << r << ','
               << upper << '\n';
        }
        return "stiffness " + file + " --press z --contact-tol 0.01 --domain box:12,12,12.2";
    };
    CHECK_THAT(vdbPack(apart(0)).text, !Contains("weak plane"));
    const auto run = vdbPack(apart(0.2));
    const std::string advice = "--interface-tol ";
    CHECK_THAT(run.text, Contains("part 0 and part 1") && Contains("weak plane"));
    const auto at = run.text.find(advice);
    REQUIRE(at != std::string::npos);
    const std::string word = run.text.substr(at, run.text.find(' ', at + advice.size()) - at);
    CHECK_THAT(vdbPack(apart(0.2) + " " + word).text, !Contains("weak plane"));
}

TEST_CASE("what stiffness cannot mean is refused or warned of with what to set") {
    const TemporaryFolder folder;
    const std::string file = packedIn(folder), words = file + " --domain " + kBox;
    const auto says = [](const std::string& arguments, int code, const std::string& part) {
        const auto run = vdbPack(arguments);
        CAPTURE(arguments, run.text);
        CHECK(run.code == code);
        CHECK_THAT(run.text, Contains(part));
    };
    says("stiffness " + words + " --press z --grip 0.1 --contact-tol 0.05", 2, "--grip 0.1");
    says("stiffness " + file + " --domain box:30,30,30,40,40,40", 3, "all spheres");
    says("stiffness " + words + " --bond-strength 133", 2, "--bond-strength 133");
    says("stiffness " + words + " --contact-tol 0.01 --interface-tol 0.005", 0,
         "--interface-tol 0.005 has no effect");
    const std::string pack =
        std::string("pack ") + kBox + " --max-count 20 -o " + folder.file("o.csv");
    says(pack + " --density 1.9e6", 0, "heavier than any metal");
    says("convert " + file + " --density 1.9e6 -o " + folder.file("c.data"), 0, "heavier than");
}

TEST_CASE("bonds outside of the domain do not stiffen it") {
    const TemporaryFolder folder;
    const std::string file = packedIn(folder);
    const auto modulusIn = [&](const std::string& domain) {
        const auto run =
            vdbPack("stiffness " + file + " --contact-tol 0.01 --json --domain " + domain);
        return jsonOf(run)["isotropic"]["E"].get<double>();
    };
    // A half of a pack is about as stiff as the whole, of which more spheres are within.
    const double half = modulusIn("box:12,12,6"), whole = modulusIn(kBox);
    CHECK(half > whole);
    CHECK(half < 1.4 * whole);
    CHECK_THAT(
        vdbPack("stiffness " + file + " --domain box:12,12,6 --press z --contact-tol 0.01").text,
        Contains("protrudes"));
}

TEST_CASE("a boundary that holds less than a wall would is warned of, as are factors of bonds") {
    const TemporaryFolder folder;
    REQUIRE(vdbPack("pack periodic:30,30,30 --radius uniform:0.8,1.6 --quiet -o " +
                    folder.file("c.csv"))
                .code == 0);
    const std::string words = "stiffness " + folder.file("c.csv") + " --contact-tol 0.01";
    CHECK_THAT(vdbPack(words).text,
               Contains("of the wall") && Contains("of a periodic one its cell"));
    CHECK_THAT(vdbPack(words + " --domain periodic:30,30,30").text, !Contains("of the wall"));
    const std::string walled =
        "stiffness " + packedIn(folder) + " --contact-tol 0.01 --domain " + kBox;
    CHECK_THAT(vdbPack(walled).text, !Contains("warning"));
    CHECK_THAT(vdbPack(walled + " --bond-radius 30").text, Contains("--bond-radius 30"));
    CHECK_THAT(vdbPack(walled + " --bond-shear 40").text, Contains("--bond-shear 40"));
    CHECK_THAT(vdbPack(walled + " --bond-strength 0.78").text, Contains("0.78 % write 0.0078"));
    CHECK_THAT(vdbPack(walled + " --bond-strength 0.01 --bond-shear-strength 51").text,
               Contains("--bond-shear-strength 51"));
    CHECK_THAT(vdbPack(walled + " --bond-modulus-for 300,0.2 --bond-shear 0.3").text,
               Contains("--bond-shear 0.3 has no effect"));
}

TEST_CASE("a cell or a box that is not the pack's is warned of") {
    const TemporaryFolder folder;
    REQUIRE(vdbPack("pack periodic:20,20,20 --radius uniform:0.8,1.6 --quiet -o " +
                    folder.file("c.vtp") + " -o " + folder.file("c.csv"))
                .code == 0);
    const auto warned = [&](const std::string& words) {
        return vdbPack("stiffness " + folder.file(words) + " --contact-tol 0.01").text;
    };
    CHECK_THAT(warned("c.vtp"), !Contains("warning"));
    CHECK_THAT(warned("c.vtp --domain periodic:20,20,20"), !Contains("warning"));
    CHECK_THAT(warned("c.vtp --domain periodic:20.5,20,20"), Contains("20 x 20 x 20 mm"));
    CHECK_THAT(warned("c.vtp --domain box:20,20,20"), Contains("20 x 20 x 20 mm"));
    CHECK_THAT(warned("c.csv --domain periodic:20,20,20"), !Contains("warning"));
    CHECK_THAT(warned("c.csv --domain periodic:20,19,20"),
               Contains("spheres overlap across the faces of the periodic cell along y"));
    CHECK_THAT(warned("c.csv --domain periodic:20.5,20,20"),
               Contains("bonds across the faces of the periodic cell along x are 0"));
    CHECK_THAT(warned("c.csv --domain periodic:20,19.9,20"),
               Contains("spheres overlap across the faces of the periodic cell along y"));
    CHECK_THAT(warned("c.csv --domain periodic:20,20,20 --pack-unit m"),
               Contains("less than 2 diameters of the largest sphere") && !Contains("memory"));
    // Walls, where a periodic pack would go on.
    REQUIRE(vdbPack("pack box:20,20,20 --radius uniform:0.8,1.6 --quiet -o " + folder.file("b.csv"))
                .code == 0);
    CHECK_THAT(warned("b.csv --domain periodic:20,20,20"),
               Contains("bonds across the faces of the periodic cell along z"));
    CHECK_THAT(warned("b.csv --domain box:20,20,20"), !Contains("reach through"));
    CHECK_THAT(warned("b.csv --domain box:20,20,24"), Contains("reach through 83 %"));
    CHECK_THAT(warned("c.csv --domain periodic:25,25,25"), Contains("the spheres reach through"));
    CHECK_THAT(warned("c.csv --domain box:20,20,20"), Contains("the spheres reach through"));
}

TEST_CASE("what a .csv alone does not hold of a pack is warned of where it is written") {
    const TemporaryFolder folder;
    const auto written = [&](const std::string& outputs) {
        std::string words =
            "pack box:8,8,8 --radius uniform:1,1.5 --contact-tol 0.05 "
            "--bond-shear 0.07 --quiet";
        for (const std::string& output : wordsOf(outputs)) words += " -o " + folder.file(output);
        return vdbPack(words).text;
    };
    CHECK_THAT(written("a.csv"), Contains("a.csv: does not hold --contact-tol 0.05, --bond-shear "
                                          "0.07"));
    CHECK_THAT(written("a.csv a.vtp"), !Contains("does not hold"));
    CHECK_THAT(vdbPack("convert " + folder.file("a.vtp") + " -o " + folder.file("b.csv")).text,
               Contains("b.csv: does not hold --contact-tol 0.05, --bond-shear 0.07"));
}

TEST_CASE("bonds are written in the unit of lengths, forces in N") {
    const TemporaryFolder folder;
    const std::string pack = packedIn(folder);
    const auto rowOf = [&](const std::string& unit) {
        const std::string file = folder.file("b" + unit + ".csv");
        REQUIRE(vdbPack("convert " + pack + " --contact-tol 0.01 --out-unit " + unit +
                        " -o bonds:" + file)
                    .code == 0);
        std::ifstream in(file);
        std::string names, values;
        std::getline(in, names);
        std::getline(in, values);
        std::map<std::string, double> row;
        const auto keys = splitAt(names, ','), cells = splitAt(values, ',');
        for (std::size_t k = 0; k < keys.size(); ++k) row[keys[k]] = std::stod(cells.at(k));
        return row;
    };
    auto mm = rowOf("mm"), m = rowOf("m");
    CHECK(mm["k_n"] == Approx(mm["modulus"] * mm["area"] / mm["length"]));
    CHECK(mm["modulus"] == Approx(1000));
    CHECK(mm["arm_i"] + mm["arm_j"] == Approx(mm["length"]));
    CHECK(m["modulus"] == Approx(1e9));
    CHECK(m["length"] == Approx(1e-3 * mm["length"]));
    CHECK(m["area"] == Approx(1e-6 * mm["area"]));
    CHECK(m["k_n"] == Approx(1e3 * mm["k_n"]));
    CHECK(m["k_bending"] == Approx(1e-3 * mm["k_bending"]));
}

TEST_CASE("columns of touching spheres between two grips are springs one after another") {
    const TemporaryFolder folder;
    const int columns = 4, layers = 10;
    std::ofstream file(folder.file("bar.csv"));
    file << "x,y,z,radius,modulus_MPa\n";
    const char axis = GENERATE('x', 'z');
    for (int i = 0; i < columns; ++i)
        for (int j = 0; j < columns; ++j)
            for (int k = 0; k < layers; ++k)
                if (axis == 'z')
                    file << i - 1.5 << ',' << j - 1.5 << ',' << k - 4.5 << ",0.5,800\n";
                else
                    file << k - 4.5 << ',' << j - 1.5 << ',' << i - 1.5 << ",0.5,800\n";
    file.close();
    const std::string words = folder.file("bar.csv") + " --contact-tol 0.01 --domain box:" +
                              (axis == 'z' ? "4,4,10" : "10,4,4") + " --press " + axis;
    const auto pressed = stiffnessJson(words + " --grip 1.6")["pressed"];
    // Two layers in each grip, and seven bonds from one to the other.
    CHECK(pressed["held"] == nlohmann::json({32, 32}));
    const double bond = 800 * 3.14159265358979 * 0.25;  // E A / length
    CHECK(pressed["stiffness"].get<double>() == Approx(16 * bond / 7).epsilon(1e-4));
    CHECK(pressed["gauge"].get<double>() == Approx(6.8));
    CHECK(pressed["modulus"].get<double>() == Approx(bond / 7 * 6.8).epsilon(1e-4));
    CHECK_THAT(vdbPack("stiffness " + words + " --grip 1.6").text, Contains("MPa apparent"));
    CHECK_THAT(vdbPack("stiffness " + words + " --grip 5").text, Contains("--grip"));
    CHECK(vdbPack("stiffness " + words + " --boundary 1").code == 2);
}

TEST_CASE("grips reach past hollow ends, or warn, as do spheres outside of the domain") {
    const TemporaryFolder folder;
    const auto press = [&](int spike, const std::string& domain) {
        std::ofstream file(folder.file("bar.csv"));
        file << "x,y,z,radius\n";
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                for (int k = 0; k < 16 + (i + j == 0 ? spike : 0); ++k)
                    file << i - 1.5 << ',' << j - 1.5 << ',' << k - 7.5 << ",0.5\n";
        file.close();
        return vdbPack("stiffness " + folder.file("bar.csv") + " --contact-tol 0.01 --domain " +
                       domain + " --press z")
            .text;
    };
    CHECK_THAT(press(0, "box:4,4,16"), Contains("grips of 2 mm") && !Contains("warning"));
    CHECK_THAT(press(2, "box:4,4,20"), Contains("grips of 2.75 mm") && !Contains("warning"));
    CHECK_THAT(press(6, "box:4,4,28"), Contains("of the cross-section at one end"));
    CHECK_THAT(press(0, "box:4,4,8"), Contains("outside of"));
    CHECK_THAT(press(0, "box:4,4,40"), Contains("40 % of box:4,4,40 along z"));
    CHECK_THAT(press(0, "box:4,4,40 --clip box:-2,-2,-8,2,2,8"), !Contains("warning"));
    CHECK_THAT(press(0, "box:4,4,16 --bond-modulus 17"), Contains("moduli are in MPa"));
    CHECK_THAT(press(0, "box:4,4,16 --bond-modulus-for 2e9"), Contains("moduli are in MPa"));
}

TEST_CASE("stiffness warns of a box that is not the domain, and of bonds across wide gaps") {
    const TemporaryFolder folder;
    const std::string file = folder.file("ball.vtp");
    REQUIRE(vdbPack("pack ball:5 --radius uniform:0.4,0.8 --contact-tol 0.01 --quiet -o " + file)
                .code == 0);
    const std::string words = "stiffness " + file;
    CHECK_THAT(vdbPack(words + " --contact-tol 0.01").text, Contains("box around them"));
    const std::string right = words + " --domain ball:5 --contact-tol 0.0";
    CHECK_THAT(vdbPack(right + "1").text, !Contains("warning"));
    CHECK_THAT(vdbPack(right + "6").text, Contains("across gaps"));
}
