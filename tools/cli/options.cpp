#include "cli/options.h"

#include "cli/completion.h"
#include "cli/first_steps.h"
#include "cli/help.h"
#include "cli/man_page.h"
#include "cli/required_result.h"
#include "cli/terminal.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/version.h"
#include "vdbpack/io/text.h"
#include "vdbpack/options/command_line.h"
#include "vdbpack/options/usage_error.h"
#include "vdbpack/report/library_versions.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <memory>
#include <vector>

using namespace vdbpack;

namespace {

std::string versionText() {
    std::string text = std::string("vdb_pack ") + version() + '\n';
    std::string libraries;
    for (const auto& [name, version] : libraryVersions())
        libraries += (libraries.empty() ? "" : ", ") + name + ' ' + version;
    return text + wrapped(libraries + ", CLI11 " CLI11_VERSION, columnsOf(1), 0, 0) + '\n';
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
}

/// Commands beside those that do the work.
struct Further {
    CLI::App* completion;
    std::string shell;
    CLI::App* demo;
    std::string folder = "vdb_pack-demo";

    Further(CLI::App& app, bool& quiet)
        : completion(app.add_subcommand(
              "completion", "complete options in a shell: source <(vdb_pack completion bash)")),
          demo(app.add_subcommand("demo",
                                  "pack a femur that comes with the program, as a first example")) {
        completion->add_option("SHELL", shell, "bash, zsh or fish")
            ->required()
            ->type_name("bash|zsh|fish");
        demo->add_option("FOLDER", folder,
                         "where its files go; made if need be (default: vdb_pack-demo)");
        demo->add_flag("--quiet", quiet, "print warnings and errors only")->group("Run");
    }
};

/// `vdb_pack help COMMAND`, as other programs have it.
void askForHelp(const CLI::App& app, std::vector<std::string>& arguments) {
    if (arguments.empty() || arguments[0] != "help") return;
    arguments.erase(arguments.begin());
    const auto isNamed = [&](const CLI::App* c) { return c->get_name() == arguments[0]; };
    if (arguments.empty() || !app.get_subcommands(isNamed).empty())
        arguments.emplace_back("--help");
}

}  // namespace

std::optional<CliOptions> parseCommandLine(int argc, char** argv, int& exitCode) {
    CliOptions options;
    CLI::App app(
        "vdb_pack fills bones with spheres. It converts a mesh to a signed distance field "
        "(OpenVDB), packs it densely and without overlaps by an advancing front, checks the pack, "
        "and writes files for Houdini, Blender, ParaView and DEM programs.");
    describe(app);
    std::vector<Command> commands = addCommands(app, options.print);
    Further further(app, options.print.quiet);
    std::vector<std::string> arguments(argv + 1, argv + argc);
    askForHelp(app, arguments);
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
        app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
        if (further.completion->parsed()) {
            fmt::print("{}", completionScript(app, further.shell));
            exitCode = 0;
            return std::nullopt;
        }
        if (further.demo->parsed()) {
            options.job = demoJob(further.folder);
            if (!options.print.quiet) options.afterwards = demoText(further.folder, argv[0]);
            return options;
        }
        options.job = *parsedJob(commands, arguments);
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
