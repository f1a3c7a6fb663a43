// What runs write: targets by prefix, and which of them a run refuses.
#include "formats/lattice_pack.h"
#include "support/test.h"

#include "vdbpack/formats/outputs.h"
#include "vdbpack/formats/sphere_density.h"

TEST_CASE("only the prefix of a format is cut from the name of a file") {
    REQUIRE(filePart("contacts:a.csv") == "a.csv");
    REQUIRE(filePart("list:b:c.csv") == "b:c.csv");
    REQUIRE(filePart("YADE:f.txt") == "f.txt");
    REQUIRE(filePart("monday:f.vtp") == "monday:f.vtp");
    REQUIRE(filePart("box:1,2,3") == "box:1,2,3");
    for (const char* misspelt :
         {"bond:b.csv", "contact:c.csv", "label:l.nii", "interface:i.csv", "lammps-bond:b.data",
          "bond-coefs:b.lmp", "Yede:y.txt", "point:p.vdb"}) {
        CAPTURE(misspelt);
        REQUIRE_THROWS_WITH(OutputTarget(misspelt), Contains("did you mean"));
        REQUIRE(filePart(misspelt) == misspelt);
        REQUIRE(OutputTarget(std::string("./") + misspelt).kind == OutputKind::pack);
    }
}

TEST_CASE("a pack written under a name with a colon stands in the file of that name") {
    const TemporaryFolder scratch;
    const auto pack = latticePack<3>(5, {{0, 0, 0}}, 3, 1);
    RunOutputs<3> have;
    have.pack = &pack;
    const std::string file = scratch.file("monday:f.csv");
    REQUIRE(writeOutput(file, have) == std::vector<std::string>{file});
    REQUIRE(contentOf(file).rfind("id,x,y,z", 0) == 0);
}

TEST_CASE("outputs that a run has nothing for are refused with what it has") {
    VoidRecipe none, voids, thinning;
    voids.method = BooleanVoids{};
    thinning.method = Thinning{Thinning::By::threshold, {}, {}};
    REQUIRE_THROWS_WITH(checkOutputKinds({"p.csv"}, RunKind::measure, none),
                        Contains("contacts:FILE.csv"));
    REQUIRE_THROWS_WITH(checkOutputKinds({"p.csv"}, RunKind::voids, voids),
                        Contains("list:FILE.csv"));
    REQUIRE_THROWS_WITH(checkOutputKinds({"p.vdb"}, RunKind::voids, voids, 2), Contains("p.vdb"));
    REQUIRE_THROWS_WITH(checkOutputKinds({"p.svg"}, RunKind::pack, none, 3), Contains("circles"));
    REQUIRE_THROWS_WITH(checkOutputKinds({"list:v.csv"}, RunKind::pack, none), Contains("`voids`"));
    REQUIRE_THROWS_WITH(checkOutputKinds({"list:v.csv"}, RunKind::pack, thinning),
                        Contains("`voids` threshold"));
    REQUIRE_NOTHROW(checkOutputKinds({"list:v.csv", "p.vdb"}, RunKind::voids, voids, 3));
    REQUIRE_NOTHROW(checkOutputKinds({"p.svg", "contacts:c.csv"}, RunKind::pack, none, 2));

    RunOutputs<3> nothing;
    REQUIRE_THROWS_AS(writeOutput("contacts:c.csv", nothing), ParameterError);
    REQUIRE_THROWS_AS(writeOutput("list:v.csv", nothing), ParameterError);
}

TEST_CASE("a bulk density is that of the spheres times their solid fraction") {
    REQUIRE(particleDensity("", std::nullopt).all == 0);
    REQUIRE(particleDensity("1900", std::nullopt).all == 1900);
    REQUIRE(particleDensity("bulk:1200", 0.6).all == 2000);
    REQUIRE(particleDensity("1=1100,0=1900", std::nullopt).ofRegions ==
            std::map<std::int32_t, double>{{0, 1900}, {1, 1100}});
    REQUIRE_THROWS_WITH(particleDensity("bulk:1200", std::nullopt), Contains("`domain`"));
    for (const char* bad : {"bulk:", "-3", "0", "heavy", "1900kg", "inf", "bulk:nan", "0=", "0=1,",
                            "0=1,0=2", "a=1", "0=1;1=2", "0=-1", "0=bulk:3", "9e9=1"}) {
        CAPTURE(bad);
        REQUIRE_THROWS_AS(checkDensity(bad), ParameterError);
    }
}
