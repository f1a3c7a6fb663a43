// A script for Blender and the pack beside it. What Blender makes of them is checked with Blender
// itself, by tests/clients/check_blender.
#include "formats/lattice_pack.h"
#include "support/test.h"

#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/domain.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/formats/pack_file.h"
#include "vdbpack/formats/write_blender.h"

#include <nlohmann/json.hpp>
#include <zlib.h>

namespace {

/// What the script knows of the pack: what it says is a literal of Python that JSON reads too.
nlohmann::json knownIn(const std::string& script) {
    const std::string begin = "\nPACK = {";
    const auto at = script.find(begin);
    REQUIRE(at != std::string::npos);
    std::string text = script.substr(at + begin.size() - 1);
    text = text.substr(0, text.find("\n}\n") + 2);
    text.erase(text.rfind(','), 1);
    return nlohmann::json::parse(text);
}

/// A level set without OpenVDB's headers.
std::shared_ptr<const VdbGrid> someLevelSet() {
    return surfaceLevelSet(*ballDomain<3>(5), 0.25);
}

}  // namespace

DIM_TEST_CASE("a Blender script names its pack, which lies beside it") {
    const auto unit = GENERATE(Unit::meter, Unit::millimeter);
    CAPTURE(Dim, unitName(unit));
    auto pack = latticePack<Dim>(2000, {}, 60, 3);
    pack.sliceHeight = Dim == 2 ? 12.5 : 0;
    pack.columns = {{"material", std::vector<double>(2000, 0.25), {}}};
    const TemporaryFolder scratch;
    PackWriteOptions options;
    options.unit = unit;
    options.generator = "vdb_pack \"test\" \\ '''";
    const std::vector<std::string> files = {scratch.file("b\xC3\xBCne.py"),
                                            scratch.file("b\xC3\xBCne.points.npz")};
    REQUIRE(writeBlender(pack, files[0], options) == files);
    REQUIRE(scratch.files() == 2);

    auto known = knownIn(contentOf(files[0]));
    std::uint32_t crc = 0;
    for (const auto& s : pack.spheres) {
        std::array<double, 3> place{0, 0, pack.sliceHeight / millimetersPer(unit)};
        for (std::size_t d = 0; d < Dim; ++d)
            place[d] = s.center[static_cast<int>(d)] / millimetersPer(unit);
        crc = static_cast<std::uint32_t>(
            crc32(crc, reinterpret_cast<const Bytef*>(place.data()), sizeof place));
    }
    CHECK(known == nlohmann::json{{"name", "b\xC3\xBCne.py"},
                                  {"points", "b\xC3\xBCne.points.npz"},
                                  {"volume", ""},
                                  {"count", 2000},
                                  {"crc32", crc},
                                  {"dim", Dim},
                                  {"unit", unitName(unit)},
                                  {"generator", options.generator}});
    const auto read = readPack(files[1]);
    REQUIRE(read.spheres.size() == 2000);
    CHECK(read.columns.at(0).numbers == pack.columns[0].numbers);
}

TEST_CASE("a Blender script finds the level sets beside it or in the file of the run") {
    const TemporaryFolder scratch;
    std::filesystem::create_directory(scratch.file("in"));
    const auto pack = latticePack<3>(10, {{0, 0, 0}}, 5, 1);
    PackWriteOptions options;
    options.levelSets = {someLevelSet()};
    const auto volumeOf = [](const std::string& script) {
        return knownIn(contentOf(script))["volume"].get<std::string>();
    };

    const auto alone = writeBlender(pack, scratch.file("a.py"), options);
    REQUIRE(alone == blenderFiles(scratch.file("a.py"), true));
    REQUIRE(alone.back() == scratch.file("a.vdb"));
    REQUIRE(std::filesystem::file_size(alone.back()) > 1000);
    REQUIRE(volumeOf(alone.front()) == "a.vdb");

    const auto shared =
        writeBlender(pack, scratch.file("b.py"), options, scratch.file("in/run.vdb"));
    REQUIRE(shared.size() == 2);
    REQUIRE(volumeOf(shared.front()) == "in/run.vdb");
    writeBlender(pack, scratch.file("in/c.py"), options, scratch.file("run.vdb"));
    REQUIRE(volumeOf(scratch.file("in/c.py")) == "../run.vdb");
    options.levelSets.clear();
    writeBlender(pack, scratch.file("d.py"), options, scratch.file("run.vdb"));
    REQUIRE(volumeOf(scratch.file("d.py")).empty());
}

TEST_CASE("a run's .vdb is shared with its Blender script, whichever comes first") {
    const TemporaryFolder scratch;
    const auto pack = latticePack<3>(10, {{0, 0, 0}}, 5, 1);
    RunOutputs<3> have;
    have.pack = &pack;
    have.options.levelSets = {someLevelSet()};
    const std::string script = scratch.file("a.py"), volume = scratch.file("p.vdb");
    const bool first = GENERATE(true, false);
    std::vector<OutputTarget> outputs = {"blender:" + script, volume};
    if (first) std::swap(outputs[0], outputs[1]);
    const auto files = writeOutputs(outputs, have, {});
    REQUIRE(files.size() == 3);
    REQUIRE(scratch.files() == 3);
    REQUIRE(knownIn(contentOf(script))["volume"] == "p.vdb");
}

TEST_CASE("what cannot be a Blender script is refused and leaves nothing") {
    const TemporaryFolder scratch;
    auto pack = latticePack<3>(10, {{0, 0, 0}}, 5, 1);
    for (const char* const name : {"a.txt", "a", ".py"})
        REQUIRE_THROWS_WITH(writeBlender(pack, scratch.file(name), {}),
                            Contains("blender:FILE.py"));
    REQUIRE_THROWS_WITH(writeBlender(pack, scratch.file("\xFF.py"), {}), Contains("UTF-8"));
    REQUIRE_THROWS_AS(writeBlender(pack, scratch.file("no/a.py"), {}), IoError);
    pack.spheres[3].radius = std::numeric_limits<double>::quiet_NaN();
    REQUIRE_THROWS_AS(writeBlender(pack, scratch.file("a.py"), {}), ParameterError);
    pack.spheres[3].radius = 1;
    pack.order.pop_back();
    REQUIRE_THROWS_WITH(writeBlender(pack, scratch.file("a.py"), {}), Contains("'order'"));
    REQUIRE(scratch.files() == 0);

    // The files beside a script are outputs like others.
    const std::string s = scratch.file("a.py");
    REQUIRE_THROWS_WITH(checkFiles({"blender:"}, "", {}), Contains("FILE.py"));
    REQUIRE_THROWS_WITH(checkFiles({"blender:a.csv"}, "", {}), Contains("blender:FILE.py"));
    REQUIRE_THROWS_WITH(checkFiles({"blender:" + s, "blender:" + s}, "", {}), Contains("twice"));
    REQUIRE_THROWS_WITH(checkOutputKinds({"blender:a.py"}, RunKind::measure, {}),
                        Contains("contacts"));
    REQUIRE_NOTHROW(checkFiles({"blender:" + s, scratch.file("a.vdb")}, "", {}));
}

TEST_CASE("no sphere at all is written too") {
    const TemporaryFolder scratch;
    const auto files = writeBlender(Pack<3>{}, scratch.file("a.py"), {});
    REQUIRE(readPack(files[1]).spheres.empty());
    REQUIRE(knownIn(contentOf(files[0]))["count"] == 0);
}
