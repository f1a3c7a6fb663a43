#include "cli/options.h"

#include "cli/completion.h"
#include "cli/help.h"
#include "cli/recipe.h"
#include "cli/terminal.h"
#include "cli/usage_error.h"

#include "vdbpack/core/error.h"
#include "vdbpack/library_versions.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>

using namespace vdbpack;

namespace {

/// Names of values, in the order in which they are told.
template <class Value>
using Names = std::vector<std::pair<std::string, Value>>;

const Names<Unit> kUnits{{"m", Unit::meter},
                         {"cm", Unit::centimeter},
                         {"mm", Unit::millimeter},
                         {"um", Unit::micrometer}};
const Names<Effort> kEfforts{
    {"fast", Effort::fast}, {"normal", Effort::normal}, {"dense", Effort::dense}};
const Names<Order> kOrders{{"sweep", Order::sweep},
                           {"wall", Order::wall},
                           {"centre", Order::center},
                           {"center", Order::center},
                           {"fifo", Order::fifo}};
const Names<WeightBy> kWeights{{"count", WeightBy::count}, {"volume", WeightBy::volume}};

const Names<PreviewColor> kPreviewColors{{"radius", PreviewColor::radius},
                                         {"region", PreviewColor::region},
                                         {"depth", PreviewColor::depth},
                                         {"order", PreviewColor::order}};

const Names<Cull> kCulls{
    {"centre", Cull::center}, {"center", Cull::center}, {"touch", Cull::touch}};

const char* const kDomainHelp =
    "mesh (.stl .obj .ply .off), level set (.vdb) or shape about the origin: box:LX,LY,LZ  "
    "box:x0,y0,z0,x1,y1,z1  ball:R  cylinder:R,H  rect:W,H  rect:x0,y0,x1,y1  disc:R";
const std::string kRadiusSpec =
    "constant:R | uniform:A,B | normal:MEAN,SD,A,B | lognormal:MEDIAN,SIGMA,A,B | table:FILE | "
    "psd:FILE, in mm";

std::string versionText() {
    std::string text = "vdb_pack " VDBPACK_VERSION "\n";
    std::string libraries;
    for (const auto& [name, version] : libraryVersions())
        libraries += (libraries.empty() ? "" : ", ") + name + ' ' + version;
    return text + wrapped(libraries + ", CLI11 " CLI11_VERSION, columnsOf(1), 0, 0) + '\n';
}

/// CLI11's own range checks print a range of 300 digits.
CLI::Validator positive() {
    return CLI::Validator(
        [](const std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            return end != text.c_str() && value > 0 ? std::string()
                                                    : "'" + text + "' must be positive";
        },
        "");
}

CLI::Validator notNegative() {
    return CLI::Validator(
        [](const std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            return end != text.c_str() && *end == 0 && value >= 0 && std::isfinite(value)
                       ? std::string()
                       : "'" + text + "' must be a number of 0 or more";
        },
        "");
}

/// An option that takes one of some names; the first of those that mean its value is the default.
template <class Value>
CLI::Option* addChoice(CLI::App& command, const std::string& option, Value& value,
                       const Names<Value>& names, const std::string& help) {
    const auto set = [&value, &names, option](const std::string& text) {
        for (const auto& [name, meaning] : names)
            if (name == text) {
                value = meaning;
                return;
            }
        std::string all;
        for (const auto& [name, meaning] : names) all += (all.empty() ? "" : ", ") + name;
        throw CLI::ValidationError(option, "'" + text + "' is none of " + all);
    };
    auto* added = command.add_option_function<std::string>(option, set, help);
    std::vector<std::string> words;
    for (const auto& [name, meaning] : names) {
        words.push_back(name);
        if (meaning == value && added->get_default_str().empty()) added->default_str(name);
    }
    setWords(*added, words);
    return added;
}

CLI::Validator notEmpty() {
    return CLI::Validator(
        [](const std::string& text) {
            return text.empty() ? std::string("must not be empty") : std::string();
        },
        "");
}

void addDomainOptions(CLI::App& command, DomainRecipe& domain) {
    addChoice(command, "--unit", domain.unit, kUnits, "unit of the domain's file: m, cm, mm or um")
        ->option_text("UNIT [mm]")
        ->group("Units");
    command.add_option("--scale", domain.scale, "further factor on the file's lengths")
        ->option_text("F [1]")
        ->group("Units");
    command.add_option("--grid", domain.gridName, "level set to take from a .vdb")
        ->option_text("NAME [first]")
        ->group("Domain");
    command.add_option("--slice", domain.slices, "fill the plane z = V of the domain with circles")
        ->option_text("z=V")
        ->group("Domain")
        ->expected(1);
    command
        .add_option("--clip", domain.clips,
                    "cut the domain: box:x0,y0,z0,x1,y1,z1 or plane:nx,ny,nz,d (n.x <= d stays); "
                    "may be repeated")
        ->option_text("CLIP")
        ->group("Domain")
        ->take_all();
    command.add_option("--voxel", domain.voxelSize, "edge of a voxel of the distance field, mm")
        ->option_text("H [chosen]")
        ->check(positive())
        ->group("Domain");
}

void addSizeOptions(CLI::App& command, std::string& radius, WeightBy& weightBy,
                    const std::string& note) {
    command.add_option("--radius", radius, kRadiusSpec + note)
        ->option_text("SPEC")
        ->check(notEmpty())
        ->group("Spheres");
    addChoice(command, "--weight-by", weightBy, kWeights, "what the weights of table:FILE count")
        ->option_text("count|volume [count]")
        ->group("Spheres");
}

void addDensityOption(CLI::App& command, std::string& density) {
    command
        .add_option("--density", density,
                    "of the spheres in DEM files, kg/m3; bulk:D: such that all of them weigh what "
                    "the domain weighs at D")
        ->option_text("D|bulk:D [1000]")
        ->check(notEmpty())
        ->group("Spheres");
}

/// What -o of runs with spheres takes.
const char* const kOutputHelp =
    "file to write; may be repeated. Packs: .vdb .vtp .ply .csv .xyz .npz, .data or lammps:FILE or "
    "liggghts:FILE, lammps-bonds:FILE (with touching pairs as bonds), yade:FILE.txt, "
    "points:FILE.vdb "
    "(no level sets), .svg (circles). Solids: .stl (surface:, voids: or solid:FILE.stl chooses), "
    "levelsets:FILE.vdb, fog:FILE.vdb. blender:FILE.py: a script that shows the spheres. Lists: "
    "contacts:FILE.csv (touching pairs), list:FILE.csv (voids)";

const char* const kPackHelp =
    ".vdb (point grid), .csv, .vtp, .ply, .xyz, .npz, YADE text (yade:FILE.txt), LAMMPS or "
    "LIGGGHTS data "
    "or "
    "dump (.data, .dump, lammps:FILE, dump:FILE); from any program";

void addGivenPack(CLI::App& command, GivenPack& given, const char* name, const std::string& help) {
    command.add_option(name, given.pack, help)->required();
    command.add_option("--domain", given.domain.source, kDomainHelp)
        ->option_text("DOMAIN")
        ->group("Domain");
    addDomainOptions(command, given.domain);
    addChoice(command, "--pack-unit", given.packUnit, kUnits,
              "unit of " + std::string(name) + ", if it says none")
        ->option_text("UNIT [mm]")
        ->group("Units");
    addSizeOptions(command, given.radius, given.weightBy,
                   "; to hold the radii of the pack against");
    command
        .add_option("--contact-tol", given.contactTolerance,
                    "gap up to which spheres count as touching, in smaller radii")
        ->capture_default_str()
        ->option_text("T [0.001]")
        ->check(notNegative())
        ->group("Run");
    command.add_option("--threads", given.threads, "threads")
        ->option_text("T [all cores]")
        ->check(CLI::Range(1, 4096))
        ->group("Run");
}

/// A word as a shell takes it for one, so that a command in a report can be run again.
std::string shellQuoted(const std::string& word) {
    const char* plain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./:,=+@%{}";
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

/// What runs that are no study have in common.
void addRunOptions(CLI::App& command, std::uint64_t& seed, std::string& report,
                   CliOptions& options) {
    command.add_option("--seed", seed, "another seed, other voids")
        ->option_text("S [1]")
        ->group("Run");
    command
        .add_option("--report", report, "write the report as JSON, or as a page for the browser")
        ->option_text("FILE.json|.html")
        ->group("Run");
    command.add_flag("--json", options.json, "print the report as JSON instead of the summary")
        ->group("Run");
    command.add_flag("--quiet", options.quiet, "print warnings and errors only")->group("Run");
}

void addPreviewOptions(CLI::App& command, PreviewRecipe& preview) {
    command
        .add_option("--preview", preview.file,
                    "draw what was made; with a report page, also the picture in it")
        ->option_text("FILE.png")
        ->check(notEmpty())
        ->group("Run");
    command
        .add_option_function<std::string>(
            "--preview-cut", [&](const std::string& text) { preview.cut = parsePreviewCut(text); },
            "cut the picture open at a plane, mm; lower x and z stay, and higher y")
        ->option_text("x=V|y=V|z=V")
        ->group("Run");
    addChoice(command, "--preview-color", preview.color, kPreviewColors,
              "what spheres are colored by, from dark (small, outside, early) to light")
        ->option_text("NAME [radius]")
        ->group("Run");
    command
        .add_option_function<std::string>(
            "--preview-size",
            [&](const std::string& text) {
                const auto size = parsePreviewSize(text);
                preview.width = size[0];
                preview.height = size[1];
            },
            "width and height in pixels")
        ->option_text("WxH [1600x1200]")
        ->group("Run");
}

/// What there is to cut: spheres while they are packed, those of a file, or none.
enum class VoidsIn { pack, file, nothing };

void addVoidOptions(CLI::App& command, VoidRecipe& voids, VoidsIn in) {
    const auto option = [&](const char* name, auto& value, const std::string& help,
                            const std::string& text) {
        return command.add_option(name, value, help)->option_text(text)->group("Voids");
    };
    const bool front = in == VoidsIn::pack, spheres = in != VoidsIn::nothing;
    const std::string packed = front ? ", mixed, ellipses" : "";
    const auto orElse = [](bool first, const char* a, const char* b) {
        return std::string(first ? a : b);
    };
    option("--voids", voids.method,
           "how voids are made: grid, overlay, " + orElse(spheres, "concentric, threshold, ", "") +
               orElse(front, "mixed, ellipses, ", "") + "boolean or list:FILE",
           "METHOD")
        ->check(notEmpty());
    std::vector<std::string> methods{"grid", "overlay", "boolean", "list:"};
    if (spheres) methods.insert(methods.end(), {"concentric", "threshold"});
    if (front) methods.insert(methods.end(), {"mixed", "ellipses"});
    setWords(*command.get_option("--voids"), methods);
    option("--shell", voids.shell,
           "thickness of the layer along the wall that voids leave whole, mm" +
               orElse(spheres, "; alone it only sets the region of each sphere", ""),
           "T [0]")
        ->check(notNegative());
    auto* cull = addChoice(command, "--cull", voids.cull, kCulls,
                           "centre: spheres with centers in voids go; touch: all that reach into "
                           "one")
                     ->option_text("centre|touch [centre]")
                     ->group("Voids");
    command
        .add_flag("--keep-connected", voids.keepConnected,
                  "drop what does not hang together with the shell (without a shell: with the "
                  "largest piece)")
        ->group("Voids");
    option("--target-bvtv", voids.targetBvtv,
           "as many voids (boolean, overlay)" +
               orElse(spheres, ", the probability (grid", " or the probability (grid") + packed +
               ")" + orElse(spheres, " or D (concentric, threshold)", "") +
               " that leave this BV/TV deeper than the shell",
           "F");
    option("--target-tbth", voids.targetTbth,
           "with --target-bvtv: voids of such a size that the mean thickness Tb.Th is this, mm "
           "(boolean)",
           "T");
    option("--void-voxel", voids.voxelSize, "edge of a voxel of the level sets of voids, mm",
           "H [1/4 half-axis]")
        ->check(positive());
    option("--void-radius", voids.radius,
           "shorter half-axis b of the voids, as --radius is written, mm (" +
               orElse(front, "mixed: radius of the holes; ", "") +
               "overlay: spheres of b times aspect are packed)",
           orElse(spheres, "SPEC [1.5 to 2.5 largest spheres]", "SPEC"))
        ->check(notEmpty());
    option("--void-aspect", voids.aspect,
           "longer by shorter half-axis, a / b, as --radius is written", "SPEC [constant:2]")
        ->check(notEmpty());
    option("--void-count", voids.count,
           "number of voids: with centers deeper than the shell, on average, and as densely around "
           "it (boolean); overlay: of all that fit, which is the default",
           "N");
    option("--void-probability", voids.probability,
           "that a box holds a void (grid)" +
               orElse(front, ", that a sphere is a hole (mixed, ellipses)", ""),
           orElse(front, "P [1; 0.02]", "P [1]"));
    auto* share =
        option("--delete-fraction", voids.deleteFraction,
               "density relation D: concentric deletes this share of the spheres, about some "
               "within Rmin/D to Rmax/D; threshold those above Rmax - D (Rmax - Rmin)",
               "D");
    option("--void-matrix", voids.matrix, "0 and 1 for the boxes of grid, top row first", "FILE")
        ->check(notEmpty());
    option("--void-cell", voids.cell,
           "sides of a box of grid, mm: one, or one for each direction (default: as many boxes as "
           "the matrix has)",
           "SIZE")
        ->check(notEmpty());
    option("--void-angles", voids.orientation.angles,
           "\"tz=SPEC;tx=SPEC\": long axes turned from z by tx about x, then by tz about z; "
           "\"phi=SPEC\" (2D): from x by phi; isotropic. SPEC: V, uniform:A,B or "
           "normal:MEAN,SD,A,B, in rad or with suffix deg. With --void-axis or --void-field: "
           "scatter about that (default without those: isotropic for boolean, else up to 0.358 "
           "about z, 2D: x)",
           "ANGLES")
        ->check(notEmpty());
    option("--void-axis", voids.orientation.axis, "direction of the long axes", "X,Y,Z")
        ->check(notEmpty());
    option("--void-field", voids.orientation.field,
           "direction of the long axes by place: .vdb (vectors, or a tensor's main axis) or .csv "
           "(x, y, z and a direction or six stress components), in mm",
           "FILE")
        ->check(notEmpty());
    if (!spheres)
        for (auto* of : {cull, share}) of->group("");  // accepted, of no use
}

}  // namespace

std::optional<CliOptions> parseCommandLine(int argc, char** argv, int& exitCode) {
    CliOptions options;
    std::string seeds = "1";
    CLI::App app(
        "vdb_pack fills bones with spheres: a mesh becomes a signed distance field in OpenVDB, an "
        "advancing front packs it densely without overlap, and the result is checked and written "
        "for Houdini, Blender, ParaView and DEM programs.");
    app.name("vdb_pack");
    app.set_version_flag("--version", versionText, "print the versions of program and libraries");
    app.require_subcommand(1);
    app.set_help_flag("-h,--help", "print this and stop");
    app.footer(
        "Exit codes: 0 done, 1 a check failed, 2 usage, 3 unusable input, 4 reading or writing "
        "failed, 5 not enough memory or space, 130 interrupted.");
    app.formatter(std::make_shared<HelpPage>(columnsOf(1), hasColor(1)));
    app.set_config("--config", "",
                   "read options of the command from a TOML file (the same names); the command "
                   "line wins; runs leave one beside their first output, NAME.recipe.toml, that "
                   "repeats them")
        ->option_text("FILE")
        ->check(CLI::ExistingFile);
    app.config_formatter(std::make_shared<RecipeFormat>(app));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.fallthrough();

    CLI::App* pack =
        app.add_subcommand("pack", "fill a domain with spheres (2D: circles)")->fallthrough();
    pack->add_option("DOMAIN", options.pack.domain.source, kDomainHelp)->required();
    pack->add_option("-o,--output", options.pack.outputs, kOutputHelp)
        ->option_text("FILE")
        ->take_all()
        ->group("Output");
    addDomainOptions(*pack, options.pack.domain);
    addChoice(*pack, "--out-unit", options.pack.outUnit, kUnits, "unit of what is written")
        ->option_text("UNIT [mm]")
        ->group("Units");
    addSizeOptions(*pack, options.pack.radius, options.pack.weightBy,
                   " (default: uniform with ratio 1:2, about 100,000 spheres)");
    pack->add_option("--target-count", options.pack.targetCount,
                     "scale the radii so that about N spheres fill the domain (beside those of "
                     "--existing)")
        ->option_text("N")
        ->check(positive())
        ->group("Spheres");
    pack->add_option("--max-count", options.pack.maxCount, "stop when N spheres are placed")
        ->option_text("N")
        ->check(positive())
        ->group("Spheres");
    addChoice(*pack, "--effort", options.pack.effort, kEfforts,
              "fast: places as they come; normal: the tightest first; dense: more pending radii")
        ->option_text("fast|normal|dense [normal]")
        ->group("Spheres");
    addChoice(*pack, "--order", options.pack.order, kOrders,
              "which place is taken next: the lowest along a diagonal, the nearest to the wall or "
              "to the middle, the one found first; all but sweep run on one thread, for "
              "comparison")
        ->option_text("sweep|wall|centre|fifo [sweep]")
        ->group("Spheres");
    pack->add_option("--gap", options.pack.gap,
                     "least distance between spheres, and of spheres to the wall, mm")
        ->option_text("G [0]")
        ->check(notNegative())
        ->group("Spheres");
    pack->add_option(
            "--existing", options.pack.existing,
            "pack around the spheres of a pack file (as verify reads it); they are written "
            "again, before the others")
        ->option_text("FILE")
        ->check(notEmpty())
        ->group("Spheres");
    addChoice(*pack, "--pack-unit", options.pack.packUnit, kUnits,
              "unit of --existing, if it says none")
        ->option_text("UNIT [mm]")
        ->group("Units");
    addDensityOption(*pack, options.pack.density);
    addVoidOptions(*pack, options.pack.voids, VoidsIn::pack);
    pack->add_option("--seed", seeds,
                     "another seed, another pack; a range 1..50 or a list 1,4,9 makes one pack "
                     "each from one field ({seed} in names of outputs)")
        ->option_text("S [1]")
        ->group("Run");
    pack->add_option("--table", options.table, "write a row for each seed")
        ->option_text("FILE.csv")
        ->group("Run");
    pack->add_option("--threads", options.pack.threads, "threads; the pack does not depend on it")
        ->option_text("T [all cores]")
        ->check(CLI::Range(1, 4096))
        ->group("Run");
    pack->add_flag("--dry-run", options.dryRun,
                   "tell count, solid fraction, time and memory to expect; writes nothing")
        ->group("Run");
    pack->add_option("--contact-tol", options.pack.contactTolerance,
                     "gap up to which spheres count as touching, in smaller radii")
        ->capture_default_str()
        ->option_text("T [0.001]")
        ->check(notNegative())
        ->group("Run");
    pack->add_option("--report", options.pack.reportFile,
                     "write the report: .json for programs, .html as a page with charts for the "
                     "browser (measures more, as measure does)")
        ->option_text("FILE.json|FILE.html")
        ->group("Run");
    addPreviewOptions(*pack, options.pack.preview);
    pack->add_flag("--json", options.json, "print the report as JSON instead of the summary")
        ->group("Run");
    pack->add_flag("--quiet", options.quiet, "print warnings and errors only")->group("Run");

    CLI::App* voids =
        app.add_subcommand("voids", "the voids and the solid alone, without a pack")->fallthrough();
    voids->add_option("DOMAIN", options.voids.domain.source, kDomainHelp)->required();
    voids
        ->add_option("-o,--output", options.voids.outputs,
                     "file to write: .vdb (level sets surface, voids, solid), .stl (of solid; "
                     "surface: or voids:FILE.stl chooses), fog:FILE.vdb, list:FILE.csv for the "
                     "list of voids; may be repeated")
        ->option_text("FILE")
        ->take_all()
        ->group("Output");
    addDomainOptions(*voids, options.voids.domain);
    addChoice(*voids, "--out-unit", options.voids.outUnit, kUnits, "unit of what is written")
        ->option_text("UNIT [mm]")
        ->group("Units");
    addVoidOptions(*voids, options.voids.voids, VoidsIn::nothing);
    addRunOptions(*voids, options.voids.seed, options.voids.reportFile, options);
    addPreviewOptions(*voids, options.voids.preview);
    voids->add_option("--threads", options.voids.threads, "threads")
        ->option_text("T [all cores]")
        ->check(CLI::Range(1, 4096))
        ->group("Run");

    CLI::App* carve =
        app.add_subcommand("carve", "cut voids into a pack that exists")->fallthrough();
    addGivenPack(*carve, options.carve, "PACK", kPackHelp);
    carve->add_option("-o,--output", options.carve.outputs, kOutputHelp)
        ->option_text("FILE")
        ->take_all()
        ->group("Output");
    addChoice(*carve, "--out-unit", options.carve.outUnit, kUnits, "unit of what is written")
        ->option_text("UNIT [mm]")
        ->group("Units");
    addDensityOption(*carve, options.carve.density);
    addVoidOptions(*carve, options.carve.voids, VoidsIn::file);
    addRunOptions(*carve, options.carve.seed, options.carve.reportFile, options);
    addPreviewOptions(*carve, options.carve.preview);

    CLI::App* verify =
        app.add_subcommand("verify", "check any pack with code of its own")->fallthrough();
    addGivenPack(*verify, options.verify, "PACK", kPackHelp);
    verify->add_option("--gap", options.verify.gap, "least distance that spheres must keep, mm")
        ->option_text("G [0]")
        ->check(notNegative())
        ->group("Spheres");
    verify
        ->add_option("--places", options.verify.placeSamples,
                     "look at N points of the domain for room for a sphere of 1.02 mean radii")
        ->option_text("N")
        ->group("Run");
    verify->add_flag("--json", options.json, "print the certificate as JSON")->group("Run");

    CLI::App* measure =
        app.add_subcommand("measure",
                           "density, contacts, sizes and structure of any pack; morphometry of a "
                           "level set or a mesh")
            ->fallthrough();
    addGivenPack(*measure, options.measure, "FILE",
                 std::string("a pack: ") + kPackHelp +
                     "; or a solid: a level set (.vdb) or a mesh (.stl .obj .off .ply)");
    measure
        ->add_option("-o,--output", options.measure.outputs,
                     "contacts:FILE.csv: the list of touching pairs")
        ->option_text("FILE")
        ->take_all()
        ->group("Output");
    addChoice(*measure, "--out-unit", options.measure.outUnit, kUnits, "unit of what is written")
        ->option_text("UNIT [mm]")
        ->group("Units");
    measure
        ->add_option("--shell", options.measure.shell,
                     "tell apart the layer of this thickness along the wall, mm")
        ->option_text("T")
        ->check(notNegative())
        ->group("Domain");
    measure
        ->add_option("--report", options.measure.reportFile,
                     "write all figures: .json for programs, .html as a page with charts for the "
                     "browser")
        ->option_text("FILE.json|FILE.html")
        ->group("Run");
    measure->add_flag("--json", options.json, "print all figures as JSON")->group("Run");

    CLI::App* convert =
        app.add_subcommand("convert", "between formats: packs, level sets and meshes")
            ->fallthrough();
    convert
        ->add_option("PACK", options.convert.pack,
                     std::string("a pack: ") + kPackHelp +
                         "; or a solid: a level set (.vdb) or a mesh (.stl .obj .off .ply)")
        ->required();
    convert->add_option("-o,--output", options.convert.outputs, kOutputHelp)
        ->option_text("FILE")
        ->take_all()
        ->group("Output");
    addChoice(*convert, "--pack-unit", options.convert.packUnit, kUnits,
              "unit of PACK, if it says none")
        ->option_text("UNIT [mm]")
        ->group("Units");
    addChoice(*convert, "--out-unit", options.convert.outUnit, kUnits, "unit of what is written")
        ->option_text("UNIT [mm]")
        ->group("Units");
    addChoice(*convert, "--unit", options.convert.domain.unit, kUnits, "unit of the domain's file")
        ->option_text("UNIT [mm]")
        ->group("Units");
    convert
        ->add_option("--grid", options.convert.packGrid,
                     "point grid (or level set) to take from a .vdb")
        ->option_text("NAME [first]")
        ->group("Domain");
    convert
        ->add_option("--domain", options.convert.domain.source,
                     std::string("written as level set or surface too, and what a bulk density is "
                                 "of: ") +
                         kDomainHelp)
        ->option_text("DOMAIN")
        ->group("Domain");
    convert
        ->add_option("--voxel", options.convert.domain.voxelSize,
                     "edge of a voxel of the level set made of a mesh, mm")
        ->option_text("H [chosen]")
        ->check(positive())
        ->group("Domain");
    convert
        ->add_option("--contact-tol", options.convert.contactTolerance,
                     "gap up to which spheres count as touching, in smaller radii")
        ->option_text("T [0.001]")
        ->check(notNegative())
        ->group("Run");
    addDensityOption(*convert, options.convert.density);
    addPreviewOptions(*convert, options.convert.preview);
    convert->add_option("--threads", options.convert.threads, "threads")
        ->option_text("T [all cores]")
        ->check(CLI::Range(1, 4096))
        ->group("Run");
    convert->add_flag("--json", options.json, "print what was converted as JSON")->group("Run");
    convert->add_flag("--quiet", options.quiet, "print warnings and errors only")->group("Run");

    CLI::App* mesh = app.add_subcommand("mesh", "health report of a mesh");
    mesh->add_option("FILE", options.mesh.source, "mesh (.stl .obj .ply .off)")->required();
    addChoice(*mesh, "--unit", options.mesh.unit, kUnits, "unit of the file")
        ->option_text("UNIT [mm]");
    mesh->add_option("--scale", options.mesh.scale, "further factor on its lengths")
        ->option_text("F [1]");
    mesh->add_flag("--json", options.json, "print the report as JSON");

    std::string shell;
    CLI::App* completion = app.add_subcommand(
        "completion", "what a shell needs to complete options: source <(vdb_pack completion bash)");
    setWords(*completion->add_option("SHELL", shell, "bash, zsh or fish")->required(),
             {"bash", "zsh", "fish"});

    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const auto refuse = [&](const std::string& message) {
        fmt::print(stderr, "{} {}\n", styled("vdb_pack:", Style::red, 2), message);
        exitCode = 2;
    };
    try {
        app.parse(argc, argv);
        options.seeds = parseSeeds(seeds);
        options.pack.seed = options.seeds.front();
        if (completion->parsed()) {
            fmt::print("{}", completionScript(app, shell));
            exitCode = 0;
            return std::nullopt;
        }
    } catch (const ParameterError& e) {
        refuse(e.what());
        return std::nullopt;
    } catch (const CLI::ParseError& e) {
        exitCode = 0;
        if (e.get_exit_code() == 0) {
            app.exit(e);
            return std::nullopt;
        }
        refuse(usageError(app, e, arguments));
        const auto running = app.get_subcommands();
        fmt::print(stderr, "vdb_pack {}--help tells what there is\n",
                   running.empty() ? "" : running.front()->get_name() + ' ');
        return std::nullopt;
    }
    for (CLI::App* command : {pack, voids, carve})
        if (command->parsed())
            options.pack.optionsText = options.voids.optionsText = options.carve.optionsText =
                recipeText(*command);
    std::string line;
    for (const auto& word : arguments) line += (line.empty() ? "" : " ") + shellQuoted(word);
    options.voids.command = options.carve.command = line;
    options.convert.command = line;
    options.pack.command = options.verify.command = options.measure.command = line;
    options.command = pack->parsed()      ? CliOptions::Command::pack
                      : voids->parsed()   ? CliOptions::Command::voids
                      : carve->parsed()   ? CliOptions::Command::carve
                      : verify->parsed()  ? CliOptions::Command::verify
                      : measure->parsed() ? CliOptions::Command::measure
                      : convert->parsed() ? CliOptions::Command::convert
                                          : CliOptions::Command::mesh;
    return options;
}
