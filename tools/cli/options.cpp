#include "cli/options.h"

#include "cli/completion.h"
#include "cli/help.h"
#include "cli/option_groups.h"
#include "cli/option_names.h"
#include "cli/recipe.h"
#include "cli/terminal.h"
#include "cli/usage_error.h"

#include "vdbpack/core/error.h"
#include "vdbpack/run/library_versions.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <limits>
#include <memory>
#include <utility>

using namespace vdbpack;

namespace {

const Names<Effort> kEfforts{
    {"fast", Effort::fast}, {"normal", Effort::normal}, {"dense", Effort::dense}};
const Names<Order> kOrders{{"sweep", Order::sweep},
                           {"wall", Order::wall},
                           {"centre", Order::center},
                           {"center", Order::center},
                           {"fifo", Order::fifo}};

/// Places that are looked at in an hour or so.
constexpr std::uint64_t kMostPlaces = 10'000'000'000;

std::string versionText() {
    std::string text = "vdb_pack " VDBPACK_VERSION "\n";
    std::string libraries;
    for (const auto& [name, version] : libraryVersions())
        libraries += (libraries.empty() ? "" : ", ") + name + ' ' + version;
    return text + wrapped(libraries + ", CLI11 " CLI11_VERSION, columnsOf(1), 0, 0) + '\n';
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

CLI::App* addPack(CLI::App& app, CliOptions& options, std::string& seeds) {
    CLI::App* command =
        app.add_subcommand("pack", "fill a domain with spheres (2D: circles)")->fallthrough();
    command->add_option("DOMAIN", options.pack.domain.source, kDomainHelp);
    addOutputs(*command, options.pack.outputs, kOutputHelp);
    addDomainOptions(*command, options.pack.domain);
    addUnit(*command, "--out-unit", options.pack.outUnit, "unit of what is written");
    addSizeOptions(*command, options.pack.radius, options.pack.weightBy,
                   " (default: uniform with ratio 1:2, about 100,000 spheres)");
    command
        ->add_option("--target-count", options.pack.targetCount,
                     "scale the radii so that about N spheres fill the domain (beside those of "
                     "--existing)")
        ->option_text("N")
        ->check(positive())
        ->group("Spheres");
    command->add_option("--max-count", options.pack.maxCount, "stop when N spheres are placed")
        ->option_text("N")
        ->transform(wholeNumber(1, std::numeric_limits<std::int64_t>::max()))
        ->group("Spheres");
    addChoice(*command, "--effort", options.pack.effort, kEfforts,
              "fast: places as they come; normal: the tightest first; dense: more pending radii")
        ->option_text("fast|normal|dense [normal]")
        ->group("Spheres");
    addChoice(*command, "--order", options.pack.order, kOrders,
              "which place is taken next: the lowest along a diagonal, the nearest to the wall or "
              "to the middle, the one found first; all but sweep run on one thread, for "
              "comparison")
        ->option_text("sweep|wall|centre|fifo [sweep]")
        ->group("Spheres");
    command
        ->add_option("--gap", options.pack.gap,
                     "least distance between spheres, and of spheres to the wall, mm")
        ->option_text("G [0]")
        ->check(notNegative())
        ->group("Spheres");
    addDensify(*command, options.pack.densify,
               "go on beyond the front, radii untouched: add and move spheres until the solid "
               "fraction is F, or as dense as it gets");
    command
        ->add_option(
            "--existing", options.pack.existing,
            "pack around the spheres of a pack file (as verify reads it); they are written "
            "again, before the others")
        ->option_text("FILE")
        ->check(notEmpty())
        ->group("Spheres");
    addUnit(*command, "--pack-unit", options.pack.packUnit, "unit of --existing, if it says none");
    addDensityOption(*command, options.pack.density);
    addVoidOptions(*command, options.pack.voids, VoidsIn::pack);
    command
        ->add_option("--seed", seeds,
                     "another seed, another pack; a range 1..50 or a list 1,4,9 makes one pack "
                     "each from one field ({seed} in names of outputs)")
        ->option_text("S [1]")
        ->group("Run");
    command->add_option("--table", options.table, "write a row for each seed")
        ->option_text("FILE.csv")
        ->group("Run");
    addThreads(*command, options.pack.threads, "threads; the pack does not depend on it");
    addMemoryLimit(*command, options.pack.memoryLimit);
    command
        ->add_flag("--dry-run", options.dryRun,
                   "tell count, solid fraction, time and memory to expect; writes nothing")
        ->group("Run");
    addContactTolerance(*command, options.pack.contactTolerance);
    command
        ->add_option("--report", options.pack.reportFile,
                     "write the report: .json for programs, .html as a page with charts for the "
                     "browser (measures more, as measure does)")
        ->option_text("FILE.json|FILE.html")
        ->group("Run");
    addPreviewOptions(*command, options.pack.preview);
    command->add_flag("--json", options.json, "print the report as JSON instead of the summary")
        ->group("Run");
    command->add_flag("--quiet", options.quiet, "print warnings and errors only")->group("Run");
    return command;
}

CLI::App* addVoids(CLI::App& app, CliOptions& options) {
    CLI::App* command =
        app.add_subcommand("voids", "the voids and the solid alone, without a pack")->fallthrough();
    command->add_option("DOMAIN", options.voids.domain.source, kDomainHelp);
    addOutputs(*command, options.voids.outputs,
               "file to write: .vdb (level sets surface, voids, solid), .stl (of solid; "
               "surface: or voids:FILE.stl chooses), fog:FILE.vdb, list:FILE.csv for the "
               "list of voids; may be repeated");
    addDomainOptions(*command, options.voids.domain);
    addUnit(*command, "--out-unit", options.voids.outUnit, "unit of what is written");
    addVoidOptions(*command, options.voids.voids, VoidsIn::nothing);
    addRunOptions(*command, options.voids.seed, options.voids.reportFile, options);
    addPreviewOptions(*command, options.voids.preview);
    addThreads(*command, options.voids.threads, "threads");
    addMemoryLimit(*command, options.voids.memoryLimit);
    return command;
}

CLI::App* addCarve(CLI::App& app, CliOptions& options) {
    CLI::App* command =
        app.add_subcommand("carve", "cut voids into a pack that exists")->fallthrough();
    addGivenPack(*command, options.carve, "PACK", kPackHelp);
    addOutputs(*command, options.carve.outputs, kOutputHelp);
    addUnit(*command, "--out-unit", options.carve.outUnit, "unit of what is written");
    addDensityOption(*command, options.carve.density);
    addVoidOptions(*command, options.carve.voids, VoidsIn::file);
    addRunOptions(*command, options.carve.seed, options.carve.reportFile, options);
    addPreviewOptions(*command, options.carve.preview);
    return command;
}

CLI::App* addDensifyCommand(CLI::App& app, CliOptions& options) {
    CLI::App* command =
        app.add_subcommand("densify",
                           "make a pack that exists denser, or free it of its overlaps; radii are "
                           "kept")
            ->fallthrough();
    addGivenPack(*command, options.densify, "PACK", kPackHelp);
    addOutputs(*command, options.densify.outputs, kOutputHelp);
    addUnit(*command, "--out-unit", options.densify.outUnit, "unit of what is written");
    addDensityOption(*command, options.densify.density);
    addDensify(*command, options.densify.fraction,
               "add and move spheres until the solid fraction is F, or as dense as it gets; left "
               "out, none is added and overlaps alone are removed");
    command
        ->add_option("--gap", options.densify.gap,
                     "least distance between spheres, and of spheres to the wall, mm")
        ->option_text("G [0]")
        ->check(notNegative())
        ->group("Spheres");
    addRunOptions(*command, options.densify.seed, options.densify.reportFile, options);
    addPreviewOptions(*command, options.densify.preview);
    return command;
}

CLI::App* addVerify(CLI::App& app, CliOptions& options) {
    CLI::App* command =
        app.add_subcommand("verify", "check any pack with code of its own")->fallthrough();
    addGivenPack(*command, options.verify, "PACK", kPackHelp);
    command->add_option("--gap", options.verify.gap, "least distance that spheres must keep, mm")
        ->option_text("G [0]")
        ->check(notNegative())
        ->group("Spheres");
    command
        ->add_option("--places", options.verify.placeSamples,
                     "look at N points of the domain for room for a sphere of 1.02 mean radii")
        ->option_text("N")
        ->transform(wholeNumber(1, kMostPlaces))
        ->group("Run");
    command->add_flag("--json", options.json, "print the certificate as JSON")->group("Run");
    return command;
}

CLI::App* addMeasure(CLI::App& app, CliOptions& options) {
    CLI::App* command =
        app.add_subcommand("measure",
                           "density, contacts, sizes and structure of any pack; morphometry of a "
                           "level set or a mesh")
            ->fallthrough();
    addGivenPack(*command, options.measure, "FILE",
                 std::string("a pack: ") + kPackHelp +
                     "; or a solid: a level set (.vdb) or a mesh (.stl .obj .off .ply)");
    addOutputs(*command, options.measure.outputs, "contacts:FILE.csv: the list of touching pairs");
    addUnit(*command, "--out-unit", options.measure.outUnit, "unit of what is written");
    command
        ->add_option("--shell", options.measure.shell,
                     "tell apart the layer of this thickness along the wall, mm")
        ->option_text("T")
        ->check(notNegative())
        ->group("Domain");
    command
        ->add_option("--report", options.measure.reportFile,
                     "write all figures: .json for programs, .html as a page with charts for the "
                     "browser")
        ->option_text("FILE.json|FILE.html")
        ->group("Run");
    command->add_flag("--json", options.json, "print all figures as JSON")->group("Run");
    return command;
}

CLI::App* addConvert(CLI::App& app, CliOptions& options) {
    CLI::App* command =
        app.add_subcommand("convert", "between formats: packs, level sets and meshes")
            ->fallthrough();
    command
        ->add_option("PACK", options.convert.pack,
                     std::string("a pack: ") + kPackHelp +
                         "; or a solid: a level set (.vdb) or a mesh (.stl .obj .off .ply)")
        ->required();
    addOutputs(*command, options.convert.outputs, kOutputHelp);
    addUnit(*command, "--pack-unit", options.convert.packUnit, "unit of PACK, if it says none");
    addUnit(*command, "--out-unit", options.convert.outUnit, "unit of what is written");
    addUnit(*command, "--unit", options.convert.domain.unit, "unit of the domain's file");
    command
        ->add_option("--grid", options.convert.packGrid,
                     "point grid (or level set) to take from a .vdb")
        ->option_text("NAME [first]")
        ->group("Domain");
    command
        ->add_option("--domain", options.convert.domain.source,
                     std::string("written as level set or surface too, and what a bulk density is "
                                 "of: ") +
                         kDomainHelp)
        ->option_text("DOMAIN")
        ->group("Domain");
    command
        ->add_option("--voxel", options.convert.domain.voxelSize,
                     "edge of a voxel of the level set made of a mesh, mm")
        ->option_text("H [chosen]")
        ->check(positive())
        ->group("Domain");
    addContactTolerance(*command, options.convert.contactTolerance);
    addDensityOption(*command, options.convert.density);
    addPreviewOptions(*command, options.convert.preview);
    addThreads(*command, options.convert.threads, "threads");
    addMemoryLimit(*command, options.convert.memoryLimit);
    command->add_flag("--json", options.json, "print what was converted as JSON")->group("Run");
    command->add_flag("--quiet", options.quiet, "print warnings and errors only")->group("Run");
    return command;
}

CLI::App* addMesh(CLI::App& app, CliOptions& options) {
    CLI::App* command = app.add_subcommand("mesh", "health report of a mesh, and its repair");
    command->add_option("FILE", options.mesh.domain.source, "mesh (.stl .obj .ply .off)")
        ->required();
    command->add_option("-o", options.mesh.outputs, "write the mesh, repaired if asked for: .stl")
        ->option_text("FILE.stl");
    addRepairOptions(*command, options.mesh.domain);
    addThreads(*command, options.mesh.threads, "threads");
    addUnit(*command, "--unit", options.mesh.domain.unit, "unit of the file");
    command->add_option("--scale", options.mesh.domain.scale, "further factor on its lengths")
        ->option_text("F [1]")
        ->group("Units");
    command->add_flag("--json", options.json, "print the report as JSON")->group("Run");
    return command;
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

    CLI::App* const pack = addPack(app, options, seeds);
    CLI::App* const voids = addVoids(app, options);
    CLI::App* const carve = addCarve(app, options);
    CLI::App* const densify = addDensifyCommand(app, options);
    CLI::App* const verify = addVerify(app, options);
    CLI::App* const measure = addMeasure(app, options);
    CLI::App* const convert = addConvert(app, options);
    addMesh(app, options);

    std::string shell;
    CLI::App* completion = app.add_subcommand(
        "completion", "what a shell needs to complete options: source <(vdb_pack completion bash)");
    setWords(*completion->add_option("SHELL", shell, "bash, zsh or fish")->required(),
             {"bash", "zsh", "fish"});

    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const auto refuse = [&](const std::string& message) {
        fmt::print(stderr, "{} {}\n", styled("vdb_pack:", Style::red, 2), withOptionNames(message));
        exitCode = 2;
    };
    try {
        app.parse(argc, argv);
        if (app.get_config_ptr()->count() > 0)
            options.config = app.get_config_ptr()->as<std::string>();
        options.seeds = parseSeeds(seeds);
        options.pack.seed = options.seeds.front();
        for (DomainRecipe* domain :
             {&options.pack.domain, &options.voids.domain, &options.carve.domain,
              &options.densify.domain, &options.verify.domain, &options.measure.domain})
            if (domain->source.empty()) domain->source = parseShells(domain->shells).outer;
        if ((pack->parsed() && options.pack.domain.source.empty()) ||
            (voids->parsed() && options.voids.domain.source.empty()))
            throw CLI::RequiredError("DOMAIN");
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
    for (const CLI::App* command : {pack, voids, carve, densify})
        if (command->parsed())
            options.pack.optionsText = options.voids.optionsText = options.carve.optionsText =
                options.densify.optionsText = recipeText(*command);
    std::string line;
    for (const auto& word : arguments) line += (line.empty() ? "" : " ") + shellQuoted(word);
    options.voids.command = options.carve.command = options.densify.command = line;
    options.convert.command = line;
    options.pack.command = options.verify.command = options.measure.command = line;
    options.command = pack->parsed()      ? CliOptions::Command::pack
                      : voids->parsed()   ? CliOptions::Command::voids
                      : carve->parsed()   ? CliOptions::Command::carve
                      : densify->parsed() ? CliOptions::Command::densify
                      : verify->parsed()  ? CliOptions::Command::verify
                      : measure->parsed() ? CliOptions::Command::measure
                      : convert->parsed() ? CliOptions::Command::convert
                                          : CliOptions::Command::mesh;
    return options;
}
