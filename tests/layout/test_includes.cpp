// Checks that files of the library include only rooms listed before their own.
#include "support/paths.h"
#include "support/temporary_folder.h"
#include "support/text_file.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

using namespace vdbpack::test;

namespace {

namespace fs = std::filesystem;

/// A file may include its own room, which is a folder with its sub-folders, and earlier rooms, so
/// that no cycle runs through folders. vdbpack.h, at the root, is for users alone.
const std::vector<std::string> kRooms{"core",    "io",     "mesh",        "verify",  "image",
                                      "field",   "repair", "domain",      "pack",    "densify",
                                      "measure", "bonds",  "voids",       "formats", "report",
                                      "preview", "view",   "distributed", "options", "run"};

/// The files that `verify` may include besides its own: plain values and triangles, nothing that
/// finds, places or accepts spheres.
const std::set<std::string> kForVerify{"core/box.h",      "core/error.h",         "core/pack.h",
                                       "core/parallel.h", "core/periodic_cell.h", "core/progress.h",
                                       "core/sphere.h",   "core/symmetric.h",     "core/units.h",
                                       "core/vec.h",      "mesh/triangle_mesh.h"};

using Includes = std::map<std::string, std::set<std::string>>;

/// The files below `root` with what each includes as "vdbpack/...", all relative to `root`.
Includes includesOf(const std::string& root) {
    Includes includes;
    const std::string start = "#include \"vdbpack/";
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
        const auto extension = entry.path().extension();
        if (extension != ".h" && extension != ".cpp" && extension != ".cl") continue;
        auto& of = includes[fs::relative(entry.path(), root).string()];
        std::ifstream file(entry.path());
        for (std::string line; std::getline(file, line);)
            if (line.compare(0, start.size(), start) == 0)
                of.insert(line.substr(start.size(), line.find('"', start.size()) - start.size()));
    }
    return includes;
}

/// Index of a file's room in kRooms; the number of rooms for files at the root and in other
/// folders.
std::size_t rankOf(const std::string& file) {
    const auto room = std::find(kRooms.begin(), kRooms.end(), file.substr(0, file.find('/')));
    return static_cast<std::size_t>(room - kRooms.begin());
}

/// "a -> b" for each include of a later room.
std::vector<std::string> arrowsUp(const Includes& includes) {
    std::vector<std::string> arrows;
    for (const auto& [file, of] : includes)
        for (const auto& included : of)
            if (rankOf(included) > rankOf(file)) arrows.push_back(file + " -> " + included);
    return arrows;
}

/// "a -> b -> a" for a cycle among files, each cycle once.
std::vector<std::string> cycles(const Includes& includes) {
    std::vector<std::string> found, path;
    std::set<std::string> done;
    const auto visit = [&](const auto& self, const std::string& file) -> void {
        const auto again = std::find(path.begin(), path.end(), file);
        if (again != path.end()) {
            std::string cycle;
            for (auto at = again; at != path.end(); ++at) cycle += *at + " -> ";
            found.push_back(cycle + file);
            return;
        }
        if (!done.insert(file).second) return;
        path.push_back(file);
        if (const auto of = includes.find(file); of != includes.end())
            for (const auto& included : of->second) self(self, included);
        path.pop_back();
    };
    for (const auto& each : includes) visit(visit, each.first);
    return found;
}

Includes ofTheLibrary() {
    return includesOf(kTests + "/../lib/vdbpack");
}

/// A small tree with these includes.
class Tree : public TemporaryFolder {
public:
    explicit Tree(const Includes& includes) {
        for (const auto& [name, of] : includes) {
            fs::create_directories(fs::path(file(name)).parent_path());
            std::string text = "#pragma once\n\n";
            for (const auto& included : of) text += "#include \"vdbpack/" + included + "\"\n";
            putContent(file(name), text);
        }
    }
};

}  // namespace

TEST_CASE("includes of the library point down the rooms, without cycles", "[layout]") {
    const Includes includes = ofTheLibrary();
    REQUIRE(includes.size() > 100);
    CHECK(arrowsUp(includes) == std::vector<std::string>{});
    CHECK(cycles(includes) == std::vector<std::string>{});
    for (const auto& [file, of] : includes) {
        CAPTURE(file);
        CHECK((rankOf(file) < kRooms.size() || file == "vdbpack.h"));
        for (const auto& included : of) CHECK(includes.count(included) == 1);
    }
}

TEST_CASE("verify includes nothing of what it judges", "[layout]") {
    for (const auto& [file, of] : ofTheLibrary()) {
        if (file.compare(0, 7, "verify/") != 0) continue;
        for (const auto& included : of) {
            CAPTURE(file, included);
            CHECK((included.compare(0, 7, "verify/") == 0 || kForVerify.count(included) == 1));
        }
    }
}

TEST_CASE("an include that points up is found and named", "[layout]") {
    const Tree tree({{"core/box.h", {"core/vec.h"}},
                     {"core/vec.h", {"pack/front/site.h"}},
                     {"pack/front/site.h", {}},
                     // No cycle of files, but one of the rooms field and mesh.
                     {"field/band/leaf.h", {"mesh/polygon.h"}},
                     {"mesh/polygon.h", {}},
                     {"mesh/formats/read_obj.h", {"field/level_set.h"}},
                     {"field/level_set.h", {}}});
    CHECK(arrowsUp(includesOf(tree.path())) ==
          std::vector<std::string>{"core/vec.h -> pack/front/site.h",
                                   "mesh/formats/read_obj.h -> field/level_set.h"});
    CHECK(cycles(includesOf(tree.path())).empty());
}

TEST_CASE("a cycle of includes is found and named", "[layout]") {
    const Tree tree({{"core/a.h", {"core/b.h"}},
                     {"core/b.h", {"core/c.h"}},
                     {"core/c.h", {"core/a.h"}},
                     {"core/d.h", {"core/a.h"}}});
    CHECK(arrowsUp(includesOf(tree.path())).empty());
    CHECK(cycles(includesOf(tree.path())) ==
          std::vector<std::string>{"core/a.h -> core/b.h -> core/c.h -> core/a.h"});
}
