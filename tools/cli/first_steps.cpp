#include "cli/first_steps.h"

#include "vdbpack/core/error.h"
#include "vdbpack/options/command_line.h"

#include <fmt/format.h>

#include <filesystem>
#include <variant>

namespace fs = std::filesystem;
using namespace vdbpack;

namespace {

constexpr const char* kMesh = "femur.ply";

}  // namespace

const std::array<FirstStep, 3>& firstSteps() {
    static const std::array<FirstStep, 3> steps = {
        FirstStep{"demo",
                  "packs a femur that comes with the program, draws it, and tells how to "
                  "open the files"},
        FirstStep{"pack box:60,60,60 --radius uniform:1,2 -o box.csv --preview box.png",
                  "fills a cube of side 60 mm with spheres of 1 to 2 mm"},
        FirstStep{"pack bone.stl -o bone.vdb --preview bone.png",
                  "fills your own mesh, in mm (or --unit m, cm, um), with about 100,000 spheres"}};
    return steps;
}

std::string firstStepsText(const std::string& program) {
    std::string text = "vdb_pack fills bones with spheres. Three commands to try:\n\n";
    for (const FirstStep& step : firstSteps())
        text += fmt::format("  {} {}\n      {}\n", program, step.words, step.effect);
    return text + fmt::format(
                      "\n{} --help lists all commands, and --help after a command its "
                      "options.\n",
                      program);
}

std::string bundledMesh() {
    std::error_code failed;
    const fs::path self = fs::canonical("/proc/self/exe", failed);
    for (fs::path folder = self.parent_path(); !failed && !folder.empty();
         folder = folder.parent_path()) {
        for (const char* place : {"share/vdbpack", "assets/meshes"}) {
            const fs::path mesh = folder / place / kMesh;
            if (fs::is_regular_file(mesh, failed)) return mesh.string();
            failed.clear();
        }
        if (folder == folder.root_path()) break;
    }
    throw IoError(fmt::format(
        "{}: is not in share/vdbpack beside the program {}; install it again, or pack a "
        "mesh of your own",
        kMesh, self.string()));
}

PackJob demoJob(const std::string& folder) {
    const std::string mesh = bundledMesh();
    std::error_code failed;
    fs::create_directories(folder, failed);
    if (failed)
        throw IoError(
            fmt::format("{}: folder cannot be made: {}; name another: vdb_pack demo "
                        "FOLDER",
                        folder, failed.message()));
    const auto in = [&folder](const char* file) { return (fs::path(folder) / file).string(); };
    return std::get<PackJob>(jobOf({"pack", mesh, "--radius", "uniform:1,2", "--target-count",
                                    "100000", "-o", in("femur.vdb"), "-o", in("femur.vtp"), "-o",
                                    in("femur.csv"), "-o", "blender:" + in("femur.py"), "--preview",
                                    in("femur.png"), "--report", in("femur.html")}));
}

std::string demoText(const std::string& folder, const std::string& program) {
    const auto in = [&folder](const char* file) { return (fs::path(folder) / file).string(); };
    return fmt::format(R"(
How to open the files
  Picture    {png}
  Browser    {html}: report with picture, charts, all numbers and the recipe.
  Blender    blender -P {py} shows the spheres. Or File > Import > OpenVDB: {vdb}
             shows the surface of the bone (grid "surface").
  Houdini    File node on {vdb}: "surface", and "points" with the radius as pscale
             (switch off delayed loading).
  ParaView   {vtp}: representation Point Gaussian, scaled by the array "radius".
  Tables     {csv}: id,x,y,z,radius,region,order,depth,contacts in mm.
  Other      {program} convert {vdb} -o FILE, with the ending .usda, .data, .xyz, .npz, ...
  Numbers    {program} measure {vdb} --domain {mesh}
  Check      {program} verify {vdb} --domain {mesh}
  Repeat     {program} pack --config {recipe} gives the same pack.
Your own bone, in mm (or --unit m, cm, um):
  {program} {own}
)",
                       fmt::arg("png", in("femur.png")), fmt::arg("html", in("femur.html")),
                       fmt::arg("py", in("femur.py")), fmt::arg("vdb", in("femur.vdb")),
                       fmt::arg("vtp", in("femur.vtp")), fmt::arg("csv", in("femur.csv")),
                       fmt::arg("mesh", bundledMesh()), fmt::arg("recipe", in("femur.recipe.toml")),
                       fmt::arg("program", program), fmt::arg("own", firstSteps()[2].words));
}
