// A script for Blender and the array beside it. What Blender makes of them is checked with Blender
// itself, by tests/clients/check_blender.
#include "formats/lattice_pack.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

#include "vdbpack/core/error.h"
#include "vdbpack/domain/analytic_domain.h"
#include "vdbpack/domain/surface_level_set.h"
#include "vdbpack/formats/write_blender.h"
#include "vdbpack/formats/outputs.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

using namespace vdbpack;
using namespace vdbpack::test;
using Catch::Matchers::Contains;

namespace {

/// An array of records, read by what its header says.
struct Records {
    std::map<std::string, std::pair<std::string, std::size_t>> fields;  ///< type and offset
    std::size_t count = 0, stride = 0;
    std::string bytes;

    explicit Records(const std::string& content) {
        REQUIRE(content.substr(0, 8) == std::string("\x93NUMPY\x02\x00", 8));
        std::uint32_t length = 0;
        std::memcpy(&length, content.data() + 8, 4);
        REQUIRE((12 + length) % 64 == 0);
        const std::string header = content.substr(12, length);
        REQUIRE(header.back() == '\n');
        REQUIRE_THAT(header, Contains("'fortran_order': False"));
        for (std::size_t at = header.find("('"); at != std::string::npos;
             at = header.find("('", at + 1)) {
            const auto middle = header.find("', '", at), end = header.find("')", middle);
            const std::string type = header.substr(middle + 4, end - middle - 4);
            fields[header.substr(at + 2, middle - at - 2)] = {type, stride};
            stride += static_cast<std::size_t>(type.back() - '0');
        }
        const std::string shape = "'shape': (";
        count = std::stoul(header.substr(header.find(shape) + shape.size()));
        bytes = content.substr(12 + length);
        REQUIRE(bytes.size() == count * stride);
    }

    double at(const std::string& name, std::size_t i) const {
        const auto& [type, offset] = fields.at(name);
        const char* const from = bytes.data() + i * stride + offset;
        const auto load = [from](auto value) {
            std::memcpy(&value, from, sizeof value);
            return static_cast<double>(value);
        };
        if (type == "<f4") return load(0.0f);
        if (type == "<f8") return load(0.0);
        if (type == "<i4") return load(std::int32_t{0});
        REQUIRE(type == "<i8");
        return load(std::int64_t{0});
    }
};

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

std::uint32_t crcOf(const std::string& bytes) {
    return static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

/// A level set without OpenVDB's headers.
std::shared_ptr<const VdbGrid> someLevelSet() {
    return surfaceLevelSet(*ballDomain<3>(5), 0.25);
}

}  // namespace

TEMPLATE_TEST_CASE_SIG("the array beside a Blender script holds every sphere from the middle",
                       "[formats]", ((int Dim), Dim), 2, 3) {
    const auto unit = GENERATE(Unit::meter, Unit::millimeter, Unit::micrometer);
    const double away = GENERATE(0.0, 730.0, -1e5);
    CAPTURE(Dim, unitName(unit), away);
    Vec<Dim> middle;
    for (int d = 0; d < Dim; ++d) middle[d] = away * (d + 1);
    // More than are written at once.
    auto pack = latticePack<Dim>(20000, middle, 60, 3);
    pack.sliceHeight = Dim == 2 ? 12.5 : 0;
    pack.columns = {{"material", std::vector<double>(20000, 0.25), {}},
                    {"no plain name", std::vector<double>(20000, 1), {}},
                    {"label", {}, std::vector<std::string>(20000, "a")}};
    const TemporaryFolder scratch;
    PackWriteOptions options;
    options.unit = unit;
    options.generator = "vdb_pack \"test\" \\ '''";
    const std::vector<std::string> files = {scratch.file("b\xC3\xBCne.py"),
                                            scratch.file("b\xC3\xBCne.points.npy")};
    REQUIRE(writeBlender(pack, files[0], options) == files);
    REQUIRE(scratch.files() == 2);

    const auto known = knownIn(contentOf(files[0]));
    REQUIRE(known["name"] == "b\xC3\xBCne.py");
    REQUIRE(known["points"] == "b\xC3\xBCne.points.npy");
    REQUIRE(known["volume"] == "");
    REQUIRE(known["count"] == 20000);
    REQUIRE(known["dim"] == Dim);
    REQUIRE(known["unit"] == unitName(unit));
    REQUIRE(known["generator"] == options.generator);
    const Records records(contentOf(files[1]));
    REQUIRE(records.count == 20000);
    REQUIRE(known["crc32"] == crcOf(records.bytes));
    REQUIRE(records.fields.count("material") == 1);
    REQUIRE(records.fields.size() == 10);

    const double scale = millimetersPer(unit);
    const char* const axes[] = {"x", "y", "z"};
    for (std::size_t i = 0; i < records.count; ++i) {
        const auto& s = pack.spheres[i];
        for (int d = 0; d < 3; ++d) {
            const double truth = d < Dim ? s.center[d < Dim ? d : 0] : pack.sliceHeight;
            const double center = known["center"][static_cast<std::size_t>(d)];
            const double error = (records.at(axes[d], i) + center) * scale - truth;
            if (!(std::abs(error) < 3e-6)) FAIL("sphere " << i << " is off by " << error);
        }
        if (!(std::abs(records.at("radius", i) * scale - s.radius) < 1e-7 * s.radius) ||
            records.at("id", i) != static_cast<double>(i) ||
            records.at("region", i) != pack.region[i] ||
            records.at("order", i) != static_cast<double>(pack.order[i]) ||
            records.at("contacts", i) != pack.contacts[i] ||
            !(std::abs(records.at("depth", i) * scale - static_cast<double>(pack.depth[i])) <
              1e-5) ||
            records.at("material", i) != 0.25)
            FAIL("an attribute of sphere " << i << " is another");
    }
}

TEST_CASE("a Blender script finds the level sets beside it or in the file of the run",
          "[formats]") {
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

TEST_CASE("a run's .vdb is shared with its Blender script, whichever comes first", "[outputs]") {
    const TemporaryFolder scratch;
    const auto pack = latticePack<3>(10, {{0, 0, 0}}, 5, 1);
    RunOutputs<3> have;
    have.pack = &pack;
    have.options.levelSets = {someLevelSet()};
    const std::string script = scratch.file("a.py"), volume = scratch.file("p.vdb");
    const bool first = GENERATE(true, false);
    std::vector<std::string> outputs = {"blender:" + script, volume};
    if (first) std::swap(outputs[0], outputs[1]);
    const auto files = writeOutputs(outputs, have, {});
    REQUIRE(files.size() == 3);
    REQUIRE(scratch.files() == 3);
    REQUIRE(knownIn(contentOf(script))["volume"] == "p.vdb");
}

TEST_CASE("what cannot be a Blender script is refused and leaves nothing", "[formats]") {
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

TEST_CASE("no sphere at all is written too", "[formats]") {
    const TemporaryFolder scratch;
    const auto files = writeBlender(Pack<3>{}, scratch.file("a.py"), {});
    REQUIRE(Records(contentOf(files[1])).count == 0);
    REQUIRE(knownIn(contentOf(files[0]))["count"] == 0);
}
