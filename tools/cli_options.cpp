#include "cli_options.h"

#include "vdbpack/core/error.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>

using namespace vdbpack;

namespace {

const std::map<std::string, Unit> kUnits{{"m", Unit::meter},
                                         {"cm", Unit::centimeter},
                                         {"mm", Unit::millimeter},
                                         {"um", Unit::micrometer}};
const std::map<std::string, Effort> kEfforts{
    {"fast", Effort::fast}, {"normal", Effort::normal}, {"dense", Effort::dense}};
const std::map<std::string, Order> kOrders{{"sweep", Order::sweep},
                                           {"wall", Order::wall},
                                           {"centre", Order::center},
                                           {"center", Order::center},
                                           {"fifo", Order::fifo}};
const std::map<std::string, WeightBy> kWeights{{"count", WeightBy::count},
                                               {"volume", WeightBy::volume}};

const std::map<std::string, Cull> kCulls{
    {"centre", Cull::center}, {"center", Cull::center}, {"touch", Cull::touch}};

const char* const kDomainHelp =
    "mesh (.stl .obj .ply .off), level set (.vdb) or shape about the origin: box:LX,LY,LZ  "
    "box:x0,y0,z0,x1,y1,z1  ball:R  cylinder:R,H  rect:W,H  rect:x0,y0,x1,y1  disc:R";
const std::string kRadiusSpec =
    "constant:R | uniform:A,B | normal:MEAN,SD,A,B | lognormal:MEDIAN,SIGMA,A,B | table:FILE | "
    "psd:FILE, in mm";

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

/// Turns a name into its value, or says which names there are.
template <class Value>
CLI::Validator oneOf(const std::map<std::string, Value>& names) {
    return CLI::Validator(
        [names](std::string& text) {
            const auto found = names.find(text);
            if (found != names.end()) {
                text = std::to_string(static_cast<int>(found->second));
                return std::string();
            }
            std::string all;
            for (const auto& [name, value] : names) all += (all.empty() ? "" : ", ") + name;
            return "'" + text + "' is none of " + all;
        },
        "");
}

CLI::Validator notEmpty() {
    return CLI::Validator(
        [](const std::string& text) {
            return text.empty() ? std::string("must not be empty") : std::string();
        },
        "");
}

/// A recipe names the options of one command without saying which: they go to the one that runs.
class RecipeFormat : public CLI::ConfigTOML {
public:
    explicit RecipeFormat(const CLI::App& app) : app_(app) {}

    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
        auto found = CLI::ConfigTOML::from_config(input);
        const auto running = app_.get_subcommands();
        if (running.empty()) return found;
        for (auto& item : found)
            if (item.parents.empty()) item.parents = {running.front()->get_name()};
        return found;
    }

private:
    const CLI::App& app_;
};

void addDomainOptions(CLI::App& command, DomainRecipe& domain) {
    command.add_option("--unit", domain.unit, "unit of the domain's file: m, cm, mm or um")
        ->transform(oneOf(kUnits))
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
    command.add_option("--weight-by", weightBy, "what the weights of table:FILE count")
        ->transform(oneOf(kWeights))
        ->option_text("count|volume [count]")
        ->group("Spheres");
}

const char* const kPackHelp =
    ".vdb (point grid), .csv, .vtp, .ply, YADE text (yade:FILE.txt), LAMMPS or LIGGGHTS data or "
    "dump (.data, .dump, lammps:FILE, dump:FILE); from any program";

void addGivenPack(CLI::App& command, GivenPack& given, const char* name, const std::string& help) {
    command.add_option(name, given.pack, help)->required();
    command.add_option("--domain", given.domain.source, kDomainHelp)
        ->option_text("DOMAIN")
        ->group("Domain");
    addDomainOptions(command, given.domain);
    command
        .add_option("--pack-unit", given.packUnit,
                    "unit of " + std::string(name) + ", if it says none")
        ->transform(oneOf(kUnits))
        ->option_text("UNIT [mm]")
        ->group("Units");
    addSizeOptions(command, given.radius, given.weightBy,
                   "; to hold the radii of the pack against");
    command
        .add_option("--contact-tol", given.contactTolerance,
                    "gap up to which spheres count as touching, in smaller radii")
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
    option("--shell", voids.shell,
           "thickness of the layer along the wall that voids leave whole, mm" +
               orElse(spheres, "; alone it only sets the region of each sphere", ""),
           "T [0]")
        ->check(notNegative());
    auto* cull = option("--cull", voids.cull,
                        "centre: spheres with centers in voids go; touch: all that reach into one",
                        "centre|touch [centre]")
                     ->transform(oneOf(kCulls));
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
        "vdb_pack fills bones with spheres: a mesh becomes a signed distance field in OpenVDB,\n"
        "an advancing front packs it densely without overlap, and the result is checked and\n"
        "written for Houdini, Blender, ParaView and DEM programs.");
    app.set_version_flag("--version", "vdb_pack " VDBPACK_VERSION);
    app.require_subcommand(1);
    app.footer(
        "--config FILE reads options from a TOML file (the same names); the command line wins.\n"
        "Exit codes: 0 done, 1 a check failed, 2 usage, 3 unusable input, 4 reading or writing\n"
        "failed, 5 not enough memory or space, 130 interrupted.");
    app.get_formatter()->column_width(30);
    app.set_config("--config", "",
                   "read options of the command from a TOML file (the same names); "
                   "the command line wins")
        ->option_text("FILE")
        ->check(CLI::ExistingFile);
    app.config_formatter(std::make_shared<RecipeFormat>(app));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.fallthrough();

    CLI::App* pack =
        app.add_subcommand("pack", "fill a domain with spheres (2D: circles)")->fallthrough();
    pack->add_option("DOMAIN", options.pack.domain.source, kDomainHelp)->required();
    pack->add_option(
            "-o,--output", options.pack.outputs,
            "file to write: .vdb .vtp .ply .csv yade:FILE.txt, .svg for circles, contacts:FILE.csv "
            "for the list of touching pairs, list:FILE.csv for that of voids; may be repeated")
        ->option_text("FILE")
        ->take_all();
    addDomainOptions(*pack, options.pack.domain);
    pack->add_option("--out-unit", options.pack.outUnit, "unit of what is written")
        ->transform(oneOf(kUnits))
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
    pack->add_option(
            "--effort", options.pack.effort,
            "fast: places as they come; normal: the tightest first; dense: more pending radii")
        ->transform(oneOf(kEfforts))
        ->option_text("fast|normal|dense [normal]")
        ->group("Spheres");
    pack->add_option(
            "--order", options.pack.order,
            "which place is taken next: the lowest along a diagonal, the nearest to the wall or "
            "to the middle, the one found first; all but sweep run on one thread, for "
            "comparison")
        ->transform(oneOf(kOrders))
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
    pack->add_option("--pack-unit", options.pack.packUnit, "unit of --existing, if it says none")
        ->transform(oneOf(kUnits))
        ->option_text("UNIT [mm]")
        ->group("Units");
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
        ->option_text("T [0.001]")
        ->check(notNegative())
        ->group("Run");
    pack->add_option("--report", options.pack.reportFile,
                     "write the report: .json for programs, .html as a page with charts for the "
                     "browser (measures more, as measure does)")
        ->option_text("FILE.json|FILE.html")
        ->group("Run");
    pack->add_flag("--json", options.json, "print the report as JSON instead of the summary")
        ->group("Run");
    pack->add_flag("--quiet", options.quiet, "print warnings and errors only")->group("Run");

    CLI::App* voids =
        app.add_subcommand("voids", "the voids and the solid alone, without a pack")->fallthrough();
    voids->add_option("DOMAIN", options.voids.domain.source, kDomainHelp)->required();
    voids
        ->add_option("-o,--output", options.voids.outputs,
                     "file to write: .vdb (level sets surface, voids, solid), list:FILE.csv for "
                     "the list of voids; may be repeated")
        ->option_text("FILE")
        ->take_all();
    addDomainOptions(*voids, options.voids.domain);
    voids->add_option("--out-unit", options.voids.outUnit, "unit of what is written")
        ->transform(oneOf(kUnits))
        ->option_text("UNIT [mm]")
        ->group("Units");
    addVoidOptions(*voids, options.voids.voids, VoidsIn::nothing);
    addRunOptions(*voids, options.voids.seed, options.voids.reportFile, options);
    voids->add_option("--threads", options.voids.threads, "threads")
        ->option_text("T [all cores]")
        ->check(CLI::Range(1, 4096))
        ->group("Run");

    CLI::App* carve =
        app.add_subcommand("carve", "cut voids into a pack that exists")->fallthrough();
    addGivenPack(*carve, options.carve, "PACK", kPackHelp);
    carve
        ->add_option(
            "-o,--output", options.carve.outputs,
            "file to write, as pack does (.vdb: with level sets surface, voids and solid); "
            "may be repeated")
        ->option_text("FILE")
        ->take_all();
    carve->add_option("--out-unit", options.carve.outUnit, "unit of what is written")
        ->transform(oneOf(kUnits))
        ->option_text("UNIT [mm]")
        ->group("Units");
    addVoidOptions(*carve, options.carve.voids, VoidsIn::file);
    addRunOptions(*carve, options.carve.seed, options.carve.reportFile, options);

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
        ->take_all();
    measure->add_option("--out-unit", options.measure.outUnit, "unit of what is written")
        ->transform(oneOf(kUnits))
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

    CLI::App* mesh = app.add_subcommand("mesh", "health report of a mesh");
    mesh->add_option("FILE", options.mesh.source, "mesh (.stl .obj .ply .off)")->required();
    mesh->add_option("--unit", options.mesh.unit, "unit of the file")
        ->transform(oneOf(kUnits))
        ->option_text("UNIT [mm]");
    mesh->add_option("--scale", options.mesh.scale, "further factor on its lengths")
        ->option_text("F [1]");
    mesh->add_flag("--json", options.json, "print the report as JSON");

    try {
        app.parse(argc, argv);
        options.seeds = parseSeeds(seeds);
        options.pack.seed = options.seeds.front();
    } catch (const ParameterError& e) {
        fmt::print(stderr, "vdb_pack: {}\n", e.what());
        exitCode = 2;
        return std::nullopt;
    } catch (const CLI::ParseError& e) {
        exitCode = app.exit(e) == 0 ? 0 : 2;
        return std::nullopt;
    }
    std::string line;
    for (int i = 1; i < argc; ++i) line += (line.empty() ? "" : " ") + shellQuoted(argv[i]);
    options.voids.command = options.carve.command = line;
    options.pack.command = options.verify.command = options.measure.command = line;
    options.command = pack->parsed()      ? CliOptions::Command::pack
                      : voids->parsed()   ? CliOptions::Command::voids
                      : carve->parsed()   ? CliOptions::Command::carve
                      : verify->parsed()  ? CliOptions::Command::verify
                      : measure->parsed() ? CliOptions::Command::measure
                                          : CliOptions::Command::mesh;
    return options;
}
