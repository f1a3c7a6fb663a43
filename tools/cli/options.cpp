#include "cli/options.h"

#include "cli/completion.h"
#include "cli/first_steps.h"
#include "cli/help.h"
#include "cli/man_page.h"
#include "cli/option_groups.h"
#include "cli/option_names.h"
#include "cli/parts_file.h"
#include "cli/recipe.h"
#include "cli/required_result.h"
#include "cli/terminal.h"
#include "cli/usage_error.h"

#include "vdbpack/core/error.h"
#include "vdbpack/io/text.h"
#include "vdbpack/run/library_versions.h"
#include "vdbpack/run/recipe_file.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>

using namespace vdbpack;

namespace {

/// A value with its name.
template <class Enum>
std::pair<std::string, Enum> named(Enum value) {
    return {nameOf(value), value};
}

const Names<Effort> kEfforts{named(Effort::fast), named(Effort::normal), named(Effort::dense)};
const Names<Fill> kFills{{"domain", Fill::domain}, {"solid", Fill::solid}};
const Names<Order> kOrders{named(Order::sweep),
                           named(Order::wall),
                           named(Order::center),
                           {"center", Order::center},
                           named(Order::fifo)};

/// Number of points that are searched in about an hour.
constexpr std::uint64_t kMostVacancySamples = 10'000'000'000;

std::string versionText() {
    std::string text = "vdb_pack " VDBPACK_VERSION "\n";
    std::string libraries;
    for (const auto& [name, version] : libraryVersions())
        libraries += (libraries.empty() ? "" : ", ") + name + ' ' + version;
    return text + wrapped(libraries + ", CLI11 " CLI11_VERSION, columnsOf(1), 0, 0) + '\n';
}

/// Says so in the help. CLI11 cannot tell whether the domain comes from --cavities: the run
/// refuses.
void requireDomain(CLI::App& command) {
    command.get_option("--domain")->option_text("DOMAIN (required without a cell in PACK)");
}

/// Sizes of the spheres of `pack`, and how they are packed.
void addSphereOptions(CLI::App* command, PackJob& job) {
    addSizeOptions(*command, job.radius, job.weightBy,
                   " (default: uniform with ratio 1:2, about 100,000 spheres)");
    command
        ->add_option("--size-field", job.sizeField,
                     "factor on the radii by place, that of the center of each sphere: a .vdb grid "
                     "of floats, a .csv (x, y, z, value) or an image; from its smallest to its "
                     "largest value at most 1:20")
        ->option_text("FILE")
        ->check(notEmpty())
        ->group("Spheres");
    command
        ->add_option("--shell-radius", job.shellRadius,
                     "radii of the spheres with centers in the shell (--shell), like --radius, "
                     "which is then that of the others")
        ->option_text("SPEC")
        ->check(notEmpty())
        ->group("Spheres");
    command
        ->add_option("--target-count", job.targetCount,
                     "scale the radii so that about N spheres are written: those that voids leave, "
                     "with those that --densify adds, without those of --existing")
        ->option_text("N")
        ->check(positive())
        ->group("Spheres");
    command->add_option("--max-count", job.maxCount, "stop when N spheres are placed")
        ->option_text("N")
        ->transform(wholeNumber(1, std::numeric_limits<std::int64_t>::max()))
        ->group("Spheres");
    addChoice(*command, "--effort", job.effort, kEfforts,
              "fast: positions in the order of the sweep; normal: first those where the sphere "
              "touches an additional sphere or wall (equal ones: many); dense: the same with more "
              "pending radii to choose from (equal spheres: in larger blocks)")
        ->option_text("fast|normal|dense [normal]")
        ->group("Spheres");
    addChoice(*command, "--order", job.order, kOrders,
              "position that is filled next. sweep: the lowest along a diagonal; wall: nearest to "
              "the wall; centre: nearest to the middle; fifo: the first found. All but sweep run "
              "on one thread, for comparison")
        ->option_text("sweep|wall|centre|fifo [sweep]")
        ->group("Spheres");
    command
        ->add_option("--block-side", job.blockSide,
                     "edge of the blocks of which each is filled by one thread, at least 8 largest "
                     "radii. Shorter ones than the usual 20 keep more than some 500 cores busy, "
                     "and cost some solid fraction")
        ->option_text("MM")
        ->check(positive())
        ->group("Spheres");
    addGap(*command, job.gap);
    addDensify(*command, job.densify,
               "after packing, move and add spheres until the solid fraction is F, or as high as "
               "possible (max); radii do not change");
    command
        ->add_option("--existing", job.existing,
                     "pack around the spheres of a file in any pack format; outputs contain these "
                     "spheres first, unchanged")
        ->option_text("FILE")
        ->check(notEmpty())
        ->group("Spheres");
    addUnit(*command, "--pack-unit", job.packUnit, "unit of --existing, if the file states none");
}

/// --seed with several seeds, and the table of their runs. @param made  by each: "pack".
void addSeeds(CLI::App& command, Study& study, const std::string& made) {
    command
        .add_option_function<std::string>(
            "--seed", [&study](const std::string& text) { study.seeds = parseSeeds(text); },
            "seed of the random numbers; a range 1..50 or a list 1,4,9 makes one " + made +
                " for each seed in one domain ({seed} in names of outputs)")
        ->option_text("S [1]")
        ->group("Run");
    command.add_option("--table", study.table, "write a table with one row for each seed")
        ->option_text("FILE.csv")
        ->group("Run");
}

/// Options of a run that `pack` alone has (several seeds, dry run), among the common ones.
void addPackRunOptions(CLI::App* command, PackJob& job, PrintOptions& print) {
    addSeeds(*command, job.study, "pack");
    addThreads(*command, job.threads,
               "number of threads (of each process); the pack does not depend on it");
    addMemoryLimit(*command, job.memoryLimit);
    command
        ->add_flag("--dry-run", job.dryRun,
                   "predict count, solid fraction, time, memory and sizes of files; write nothing")
        ->group("Run");
    addContactTolerance(*command, job.contactTolerance);
    addReport(*command, job.reportFile,
              "write the report: .json for programs, .html as a page with charts for the browser "
              "(with the values of measure)");
    addPreviewOptions(*command, job.preview);
    addPrinting(*command, print);
}

void addPartsOption(CLI::App& command, std::string& file, const std::string& help) {
    command.add_option("--parts", file, help)
        ->option_text("FILE.toml")
        ->check(notEmpty())
        ->group("Domain");
}

CLI::App* addCommand(CLI::App& app, PackJob& job, PrintOptions& print) {
    CLI::App* command = app.add_subcommand("pack", "fill a domain with spheres (2D: circles)");
    command->add_option("DOMAIN", job.domain.source, kDomainHelp);
    addOutputs(*command, job.outputs, kOutputHelp);
    addDomainOptions(*command, job.domain);
    addPartsOption(*command, job.partsFile,
                   "pack several domains, each a table [[part]] of a TOML file: name, domain, and "
                   "options by their names. Where they overlap, the later one has the space");
    addUnit(*command, "--out-unit", job.outUnit, "unit of what is written");
    addImages(*command, job.images);
    addSphereOptions(command, job);
    addDensityOption(*command, job.density);
    addGreyOptions(*command, job.grey);
    addVoidOptions(*command, job.voids, job.domain, VoidsIn::pack);
    addChoice(*command, "--fill", job.voids.fill, kFills,
              "domain: fill the domain, then remove the spheres in voids; solid: cut the voids "
              "first, then fill what they leave")
        ->option_text("domain|solid [domain]")
        ->group("Voids");
    addPackRunOptions(command, job, print);
    return command;
}

CLI::App* addCommand(CLI::App& app, VoidsJob& job, PrintOptions& print) {
    CLI::App* command =
        app.add_subcommand("voids", "make voids and the remaining solid, without spheres");
    command->add_option("DOMAIN", job.domain.source, kDomainHelp);
    addOutputs(
        *command, job.outputs,
        "file to write; may be repeated: .vdb (level sets surface, voids, solid), .stl (of solid; "
        "surface:FILE.stl or voids:FILE.stl selects another), fog:FILE.vdb, list:FILE.csv (voids)");
    addDomainOptions(*command, job.domain);
    addUnit(*command, "--out-unit", job.outUnit, "unit of what is written");
    addVoidOptions(*command, job.voids, job.domain, VoidsIn::nothing);
    addSeeds(*command, job.study, "set of voids");
    addReport(*command, job.reportFile, kReportHelp);
    addPrinting(*command, print);
    addPreviewOptions(*command, job.preview);
    addThreads(*command, job.threads, "number of threads");
    addMemoryLimit(*command, job.memoryLimit);
    return command;
}

CLI::App* addCommand(CLI::App& app, CarveRecipe& job, PrintOptions& print) {
    CLI::App* command = app.add_subcommand("carve", "cut voids into an input pack");
    addInputPack(*command, job, "PACK", kPackHelp);
    addOutputs(*command, job.outputs, kOutputHelp);
    addUnit(*command, "--out-unit", job.outUnit, "unit of what is written");
    addDensityOption(*command, job.density);
    addGreyOptions(*command, job.grey);
    requireDomain(*command);
    addVoidOptions(*command, job.voids, job.domain, VoidsIn::file);
    addRunOptions(*command, job.seed, job.reportFile, print, "of the voids");
    addPreviewOptions(*command, job.preview);
    return command;
}

CLI::App* addCommand(CLI::App& app, DensifyRecipe& job, PrintOptions& print) {
    CLI::App* command = app.add_subcommand(
        "densify", "make an input pack denser, or remove its overlaps; radii do not change");
    addInputPack(*command, job, "PACK", kPackHelp);
    addOutputs(*command, job.outputs, kOutputHelp);
    addUnit(*command, "--out-unit", job.outUnit, "unit of what is written");
    addImages(*command, job.images);
    addDensityOption(*command, job.density);
    addGreyOptions(*command, job.grey);
    addDensify(*command, job.fraction,
               "add and move spheres until the solid fraction is F, or as high as possible (max); "
               "without this option, no sphere is added and only overlaps are removed");
    requireDomain(*command);
    addGap(*command, job.gap);
    addRunOptions(*command, job.seed, job.reportFile, print,
                  "of the radii and positions of added spheres, and of exchanges between spheres");
    addPreviewOptions(*command, job.preview);
    return command;
}

CLI::App* addCommand(CLI::App& app, VerifyRecipe& job, PrintOptions& print) {
    CLI::App* command = app.add_subcommand("verify",
                                           "check a pack of any program for overlaps and "
                                           "protrusions, with code independent of the packer");
    addInputPack(*command, job, "PACK", kPackHelp);
    addPartsOption(*command, job.partsFile,
                   "the parts that the pack was made with: each sphere is held against its own");
    command->add_option("--gap", job.gap, "least distance required between spheres, mm")
        ->option_text("G [0]")
        ->check(notNegative())
        ->group("Spheres");
    command
        ->add_option("--places", job.vacancySamples,
                     "search N points of the domain for vacancies that have room for a sphere of "
                     "1.02 mean radii")
        ->option_text("N")
        ->transform(wholeNumber(1, kMostVacancySamples))
        ->group("Run");
    command->add_flag("--json", print.json, "print the result as JSON")->group("Run");
    return command;
}

CLI::App* addCommand(CLI::App& app, MeasureRecipe& job, PrintOptions& print) {
    CLI::App* command = app.add_subcommand("measure",
                                           "measure density, contacts, sizes and structure of any "
                                           "pack; morphometry of a level set, a mesh or an image");
    addInputPack(*command, job, "FILE",
                 std::string("a pack: ") + kPackHelp +
                     "; or a solid: a level set (.vdb), a mesh (.stl .obj .off .ply .vtk) or an "
                     "image (with --label or --threshold)");
    addOutputs(*command, job.outputs, "contacts:FILE.csv: the pairs in contact");
    addUnit(*command, "--out-unit", job.outUnit, "unit of what is written");
    command
        ->add_option("--shell", job.shell,
                     "measure the layer of this thickness along the wall separately, mm")
        ->option_text("T")
        ->check(notNegative())
        ->group("Domain");
    addShellFrom(*command, job.domain, "Domain");
    command
        ->add_flag("--morphometry", job.sphereMorphometry,
                   "of a pack: measure the union of its spheres as a solid, too")
        ->group("Spheres");
    command
        ->add_option("--dilation", job.dilation,
                     "added to the radii for --morphometry, mm, so that contacts become necks")
        ->option_text("D [5 % of the mean radius]")
        ->check(notNegative())
        ->group("Spheres");
    addReport(*command, job.reportFile,
              "write all values: .json for programs, .html as a page with charts for the browser");
    command->add_flag("--json", print.json, "print all values as JSON")->group("Run");
    return command;
}

CLI::App* addCommand(CLI::App& app, ConvertRecipe& job, PrintOptions& print) {
    CLI::App* command =
        app.add_subcommand("convert", "convert packs, level sets and meshes to other formats");
    command
        ->add_option("PACK", job.pack,
                     std::string("a pack: ") + kPackHelp +
                         "; or a solid: a level set (.vdb) or a mesh (.stl .obj .off .ply .vtk)")
        ->required();
    addOutputs(*command, job.outputs, kOutputHelp);
    addUnit(*command, "--pack-unit", job.packUnit, "unit of PACK, if the file states none");
    addUnit(*command, "--out-unit", job.outUnit, "unit of what is written");
    addImages(*command, job.images);
    addUnit(*command, "--unit", job.domain.unit, "unit of the domain's file");
    command->add_option("--grid", job.packGrid, "point grid (or level set) to take from a .vdb")
        ->option_text("NAME [first]")
        ->group("Domain");
    command
        ->add_option("--domain", job.domain.source,
                     std::string("domain whose level set or surface can be written too, and to "
                                 "which --density bulk:D refers: ") +
                         kDomainHelp)
        ->option_text("DOMAIN")
        ->group("Domain");
    addImageOptions(*command, job.domain);
    command
        ->add_option("--voxel", job.domain.voxelSize,
                     "voxel size of the level set made from a mesh, mm")
        ->option_text("H [automatic]")
        ->check(positive())
        ->group("Domain");
    addContactTolerance(*command, job.contactTolerance);
    addDensityOption(*command, job.density);
    addGreyOptions(*command, job.grey);
    addPreviewOptions(*command, job.preview);
    addThreads(*command, job.threads, "number of threads");
    addMemoryLimit(*command, job.memoryLimit);
    command->add_flag("--json", print.json, "print the result as JSON")->group("Run");
    command->add_flag("--quiet", print.quiet, "print warnings and errors only")->group("Run");
    return command;
}

CLI::App* addCommand(CLI::App& app, ViewJob& job, PrintOptions& print) {
    CLI::App* command = app.add_subcommand(
        "view", "write a page that shows a pack, to turn, zoom and cut in a browser, and open it");
    command->add_option("PACK", job.pack, kPackHelp)->required();
    command
        ->add_option("-o,--output", job.reportFile,
                     "page to write: one file that needs no other, and no network")
        ->option_text("FILE.html [NAME.view.html]")
        ->check(notEmpty())
        ->group("Output");
    command
        ->add_flag_callback(
            "--no-open", [&job] { job.opens = false; },
            "do not open the page; without a display, it is not opened anyway")
        ->group("Output");
    addCutAndColor(*command, job.preview);
    addUnit(*command, "--pack-unit", job.packUnit, "unit of PACK, if the file states none");
    command
        ->add_option("--domain", job.domain.source,
                     std::string("domain whose wall is shown around the spheres: ") + kDomainHelp)
        ->option_text("DOMAIN")
        ->group("Domain");
    addDomainOptions(*command, job.domain);
    addThreads(*command, job.threads, "number of threads");
    addMemoryLimit(*command, job.memoryLimit);
    addPrinting(*command, print);
    return command;
}

/// Options of commands that report on the file of a domain.
void addFileOptions(CLI::App& command, RunSettings& settings, DomainRecipe& domain,
                    PrintOptions& print) {
    addThreads(command, settings.threads, "number of threads");
    addUnit(command, "--unit", domain.unit, "unit of the file");
    command.add_option("--scale", domain.scale, "further factor on its lengths")
        ->option_text("F [1]")
        ->group("Units");
    addMemoryLimit(command, settings.memoryLimit);
    addPrinting(command, print);
}

CLI::App* addCommand(CLI::App& app, MeshRecipe& job, PrintOptions& print) {
    CLI::App* command =
        app.add_subcommand("mesh", "report whether a mesh can be packed, and repair it");
    command->add_option("FILE", job.domain.source, "mesh (.stl .obj .ply .off .vtp .vtk)")
        ->required();
    command
        ->add_option("-o,--output", job.outputs,
                     "write the mesh as .stl; with --repair, the repaired mesh")
        ->option_text("FILE.stl")
        ->group("Output");
    command
        ->add_flag("--check", job.check,
                   "exit with code 1 if the mesh cannot be packed as it is; with --repair, if it "
                   "cannot be packed once repaired")
        ->group("Run");
    addRepairOptions(*command, job.domain);
    addFileOptions(*command, job, job.domain, print);
    return command;
}

CLI::App* addCommand(CLI::App& app, ImageRecipe& job, PrintOptions& print) {
    CLI::App* command =
        app.add_subcommand("image", "report what a label map or a CT contains, and where it lies");
    command
        ->add_option(
            "FILE", job.domain.source,
            "image (.nii .nii.gz .nrrd .nhdr .mha .mhd), or a folder of DICOM or TIFF files")
        ->required();
    addImagePlacement(*command, job.domain);
    addFileOptions(*command, job, job.domain, print);
    return command;
}

/// A command with the recipe that its options fill in.
struct Command {
    CLI::App* app;
    std::unique_ptr<Job> job;
};

template <class Recipe>
void add(std::vector<Command>& commands, CLI::App& app, PrintOptions& print) {
    auto job = std::make_unique<Job>(Recipe());
    CLI::App* const command = addCommand(app, std::get<Recipe>(*job), print);
    commands.push_back({command, std::move(job)});
}

std::vector<Command> addCommands(CLI::App& app, PrintOptions& print) {
    std::vector<Command> commands;
    add<PackJob>(commands, app, print);
    add<VoidsJob>(commands, app, print);
    add<CarveRecipe>(commands, app, print);
    add<DensifyRecipe>(commands, app, print);
    add<VerifyRecipe>(commands, app, print);
    add<MeasureRecipe>(commands, app, print);
    add<ConvertRecipe>(commands, app, print);
    add<MeshRecipe>(commands, app, print);
    add<ImageRecipe>(commands, app, print);
    add<ViewJob>(commands, app, print);
    return commands;
}

void describe(CLI::App& app) {
    app.name("vdb_pack");
    app.set_version_flag("--version", versionText, "print the versions of program and libraries");
    app.require_subcommand(1);
    app.set_help_flag("-h,--help", "print this and stop");
    app.footer(
        "Exit codes: 0 done, 1 a check failed, 2 usage, 3 unusable input, 4 reading or writing "
        "failed, 5 not enough memory or space, 130 interrupted.");
    app.formatter(std::make_shared<HelpPage>(columnsOf(1), hasColor(1)));
    app.set_config(
           "--config", "",
           "read options of the command from a TOML file, under the same names; the command "
           "line takes precedence. Each run writes such a file, NAME.recipe.toml, beside "
           "its first output, to repeat the run")
        ->option_text("FILE")
        ->check(CLI::ExistingFile);
    app.config_formatter(std::make_shared<RecipeFormat>(app));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.fallthrough();
}

/// The parts that a file names: each has the options of the command line, but for those of its own.
/// @param base  those options, without a domain.
std::vector<PackRecipe> partsIn(const std::string& file, const PackJob& base) {
    std::vector<PackRecipe> parts;
    if (!base.domain.source.empty())
        throw CLI::ValidationError("--parts", "the parts have domains of their own; leave out '" +
                                                  base.domain.source + "'");
    for (PartWords& words : readPartsFile(file)) {
        PackJob part = base;
        part.name = words.name;
        PrintOptions unused;
        CLI::App app;
        addCommand(app, part, unused);
        words.arguments.insert(words.arguments.begin(), "pack");
        std::reverse(words.arguments.begin(), words.arguments.end());
        try {
            app.parse(words.arguments);
        } catch (const CLI::ParseError& e) {
            throw CLI::ValidationError("--parts",
                                       file + ": part '" + words.name + "': " + e.what());
        }
        if (!part.partsFile.empty())
            throw CLI::ValidationError("--parts", "parts have no parts of their own");
        if (part.outputs.size() != base.outputs.size() || part.reportFile != base.reportFile ||
            part.preview.file != base.preview.file)
            throw CLI::ValidationError("--parts", file + ": part '" + words.name +
                                                      "': outputs, reports and pictures are of all "
                                                      "parts; give them outside of the file");
        parts.push_back(std::move(part));
    }
    return parts;
}

void addParts(PackJob& job) {
    if (job.partsFile.empty()) return;
    PackJob base = job;
    base.partsFile.clear();
    job.parts = partsIn(job.partsFile, base);
}

void addParts(VerifyRecipe& job) {
    if (job.partsFile.empty()) return;
    PackJob base;
    base.domain = job.domain;
    job.parts = partsIn(job.partsFile, base);
    job.domain = {};
}

/// What the options alone do not set in the recipe of the command that was parsed.
void complete(const Command& command, const std::vector<std::string>& arguments) {
    std::visit(
        [&](auto& recipe) {
            DomainRecipe& domain = recipe.domain;
            if (domain.source.empty()) domain.source = parseCavities(domain.cavities).outer;
            bool hasParts = false;
            using Recipe = std::decay_t<decltype(recipe)>;
            if constexpr (std::is_same_v<Recipe, PackJob> || std::is_same_v<Recipe, VerifyRecipe>) {
                addParts(recipe);
                hasParts = !recipe.parts.empty();
            }
            if (domain.source.empty() && !hasParts && command.app->get_option_no_throw("DOMAIN"))
                throw CLI::RequiredError("DOMAIN");
            const std::filesystem::path left = recipeFileFor(recipe.outputs);
            recipe.optionsText = recipeText(*command.app, left.parent_path().string());
            for (const auto& word : arguments)
                recipe.command += (recipe.command.empty() ? "" : " ") + shellQuoted(word);
        },
        *command.job);
}

}  // namespace

std::optional<CliOptions> parseCommandLine(int argc, char** argv, int& exitCode) {
    CliOptions options;
    CLI::App app(
        "vdb_pack fills bones with spheres. It converts a mesh to a signed distance field "
        "(OpenVDB), packs it densely and without overlaps by an advancing front, checks the pack, "
        "and writes files for Houdini, Blender, ParaView and DEM programs.");
    describe(app);
    const std::vector<Command> commands = addCommands(app, options.print);
    std::string shell;
    CLI::App* completion = app.add_subcommand(
        "completion", "complete options in a shell: source <(vdb_pack completion bash)");
    setWords(*completion->add_option("SHELL", shell, "bash, zsh or fish")->required(),
             {"bash", "zsh", "fish"});
    std::string demoFolder = "vdb_pack-demo";
    CLI::App* demo =
        app.add_subcommand("demo", "pack a femur that comes with the program, as a first example");
    demo->add_option("FOLDER", demoFolder,
                     "where its files go; made if need be (default: vdb_pack-demo)")
        ->check(notEmpty());
    demo->add_flag("--quiet", options.print.quiet, "print warnings and errors only")->group("Run");

    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const auto refuse = [&](const std::string& message) {
        fmt::print(stderr, "{} {}\n", styled("vdb_pack:", Style::red, 2),
                   printable(withOptionNames(message)));
        exitCode = 2;
        return std::nullopt;
    };
    try {
        if (arguments.empty() && isTerminal(1)) {
            fmt::print("{}", firstStepsText(argv[0]));
            return std::nullopt;
        }
        if (arguments.size() == 2 && arguments[0] == "--man-pages") {
            writeManPages(app, arguments[1]);
            return std::nullopt;
        }
        app.parse(argc, argv);
        if (completion->parsed()) {
            fmt::print("{}", completionScript(app, shell));
            exitCode = 0;
            return std::nullopt;
        }
        if (demo->parsed()) {
            options.job = demoJob(demoFolder);
            if (!options.print.quiet) options.afterwards = demoText(demoFolder, argv[0]);
            return options;
        }
        const auto command = std::find_if(commands.begin(), commands.end(),
                                          [](const Command& c) { return c.app->parsed(); });
        complete(*command, arguments);
        options.job = std::move(*command->job);
        requireResult(options);
        if (app.get_config_ptr()->count() > 0)
            options.config = app.get_config_ptr()->as<std::string>();
        return options;
    } catch (const ParameterError& e) {
        return refuse(e.what());
    } catch (const CLI::ParseError& e) {
        exitCode = 0;
        if (e.get_exit_code() == 0) {
            app.exit(e);
            return std::nullopt;
        }
        refuse(usageError(app, e, arguments));
        const auto running = app.get_subcommands();
        fmt::print(stderr, "vdb_pack {}--help lists the options\n",
                   running.empty() ? "" : running.front()->get_name() + ' ');
        return std::nullopt;
    }
}

Job jobOf(const std::vector<std::string>& words, const std::vector<std::string>& unset) {
    CLI::App app;
    PrintOptions print;
    const std::vector<Command> commands = addCommands(app, print);
    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
        const auto command = std::find_if(commands.begin(), commands.end(),
                                          [](const Command& c) { return c.app->parsed(); });
        if (command == commands.end()) throw ParameterError("no command is named");
        for (const std::string& option : unset)
            if (command->app->get_option_no_throw(option) == nullptr &&
                app.get_option_no_throw(option) == nullptr)
                throw ParameterError(unknownOption(app, *command->app, option));
        complete(*command, words);
        return std::move(*command->job);
    } catch (const CLI::ParseError& e) {
        throw ParameterError(usageError(app, e, words));
    }
}
