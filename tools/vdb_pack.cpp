// vdb_pack: parses, calls, prints. Whatever deserves a test is in the library.
#include "cli/option_names.h"
#include "cli/options.h"
#include "cli/progress_line.h"
#include "cli/terminal.h"

#include "vdbpack/core/error.h"
#include "vdbpack/core/memory.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/run/convert.h"
#include "vdbpack/run/forecast.h"
#include "vdbpack/run/outputs.h"
#include "vdbpack/run/run.h"
#include "vdbpack/run/run_mesh.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <system_error>

using namespace vdbpack;

namespace {

enum ExitCode {
    kDone = 0,
    kCheckFailed = 1,
    kUsage = 2,
    kBadInput = 3,
    kIoFailed = 4,
    kNoResources = 5,
    kInterrupted = 130
};

std::atomic<bool> interrupted{false};
/// Spheres may stand that are to be written.
std::atomic<bool> worthKeeping{false};

template <std::size_t N>
void sayFromHandler(const char (&text)[N]) {
    const auto written = ::write(STDERR_FILENO, text, N - 1);
    static_cast<void>(written);
}

void onSignal(int) {
    // The first asks for an orderly end where there is something to keep, the second ends at once.
    if (interrupted.exchange(true) || !worthKeeping) {
        removeTemporaryFiles();
        sayFromHandler("\nvdb_pack: interrupted.\n");
        ::_exit(kInterrupted);
    }
    sayFromHandler(
        "\nvdb_pack: interrupted; what is complete is kept. Once more to stop at once.\n");
}

/// Signals that ask to stop, and those that would end the process where writing fails: the call
/// that writes reports that itself.
void handleSignals() {
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGINT, onSignal);
    std::signal(SIGTERM, onSignal);
    // A run that is to survive its terminal (nohup) does.
    if (std::signal(SIGHUP, onSignal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

/// Says it on standard error; nobody there to hear it is no reason to stop.
void tell(const std::string& text) {
    std::fputs(text.c_str(), stderr);
}

/// Progress on a terminal, silence elsewhere; warnings always.
Callbacks makeCallbacks(bool quiet) {
    Callbacks callbacks;
    callbacks.warning = [](const std::string& text) {
        clearProgressLine();
        tell(fmt::format("{} {}\n", styled("warning:", Style::yellow, STDERR_FILENO),
                         withOptionNames(text)));
    };
    callbacks.cancelled = [] { return interrupted.load(); };
    std::shared_ptr<ProgressLine> line;
    if (!quiet && ::isatty(STDERR_FILENO)) line = std::make_shared<ProgressLine>();
    callbacks.progress = [line](const Progress& p) {
        if (p.stage == "pack") worthKeeping = true;
        if (line) line->show(p);
    };
    return callbacks;
}

void printText(const std::string& text) {
    fmt::print("{}", withOptionNames(text));
}

/// Bytes of names that are no UTF-8 show as the replacement character.
void printJson(const nlohmann::ordered_json& json) {
    fmt::print("{}\n", withOptionNames(json.dump(
                           2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)));
}

/// A pack for each of several seeds.
int study(const CliOptions& options, const Callbacks& callbacks) {
    const StudyResult result = runStudy(options.pack, options.seeds, options.table, callbacks);
    clearProgressLine();
    if (options.json) {
        auto all = nlohmann::ordered_json::array();
        for (const auto& report : result.reports) all.push_back(toJson(report));
        printJson(all);
    } else if (!options.quiet) {
        printText(summary(result));
        if (!options.table.empty() && !result.reports.empty())
            fmt::print("written    {}\n", options.table);
    }
    if (result.interrupted) return kInterrupted;
    if (result.passed) return kDone;
    fmt::print(stderr, "{}", result.failures);
    return kCheckFailed;
}

int printed(const RunResult& run, const CliOptions& options) {
    clearProgressLine();
    if (options.json)
        printJson(toJson(run));
    else if (!options.quiet)
        printText(summary(run.report));
    return kDone;
}

/// The same of a pack that must pass its checks.
int judged(const RunResult& run, const CliOptions& options) {
    printed(run, options);
    if (run.report.interrupted) return kInterrupted;
    if (run.passed) return kDone;
    fmt::print(stderr, "{}", failures(run));
    return kCheckFailed;
}

/// The file that options were read from is an input like others.
void keepConfig(const CliOptions& options) {
    if (options.config.empty()) return;
    const auto check = [&](const auto& recipe, const std::string& report,
                           const std::string& picture) {
        auto outputs = recipe.outputs;
        if (!options.table.empty()) outputs.push_back("contacts:" + options.table);
        checkFiles(outputs, report, {options.config}, picture);
    };
    switch (options.command) {
        case CliOptions::Command::pack:
            return check(options.pack, options.pack.reportFile, options.pack.preview.file);
        case CliOptions::Command::densify:
            return check(options.densify, options.densify.reportFile, options.densify.preview.file);
        case CliOptions::Command::voids:
            return check(options.voids, options.voids.reportFile, options.voids.preview.file);
        case CliOptions::Command::carve:
            return check(options.carve, options.carve.reportFile, options.carve.preview.file);
        case CliOptions::Command::measure:
            return check(options.measure, options.measure.reportFile, {});
        case CliOptions::Command::convert:
            return check(options.convert, {}, options.convert.preview.file);
        case CliOptions::Command::mesh:
            return check(options.mesh, {}, {});
        case CliOptions::Command::verify:
            return;
    }
}

int runCommand(const CliOptions& options) {
    keepConfig(options);
    const Callbacks callbacks = makeCallbacks(options.quiet);
    switch (options.command) {
        case CliOptions::Command::pack: {
            if (options.dryRun) {
                const Forecast forecast = forecastPack(options.pack, callbacks);
                if (interrupted) return kInterrupted;
                if (options.json)
                    printJson(toJson(forecast));
                else
                    printText(summary(forecast));
                std::fflush(stdout);
                requireResources(forecast.needs, memoryLimit(options.pack.memoryLimit));
                return kDone;
            }
            if (options.seeds.size() > 1 || !options.table.empty())
                return study(options, callbacks);
            PackRecipe recipe = options.pack;
            for (auto& output : recipe.outputs) output = withSeed(output, recipe.seed);
            recipe.reportFile = withSeed(recipe.reportFile, recipe.seed);
            recipe.preview.file = withSeed(recipe.preview.file, recipe.seed);
            const RunResult run = runPack(recipe, callbacks);
            return judged(run, options);
        }
        case CliOptions::Command::densify:
            return judged(runDensify(options.densify, callbacks), options);
        case CliOptions::Command::voids:
            return printed(runVoids(options.voids, callbacks), options);
        case CliOptions::Command::carve:
            return printed(runCarve(options.carve, callbacks), options);
        case CliOptions::Command::verify: {
            const RunResult run = runVerify(options.verify, callbacks);
            clearProgressLine();
            if (options.json)
                printJson(toJson(run));
            else
                printText(summary(run.report));
            if (run.places && !options.json)
                fmt::print(
                    "places     {} of {} points have room for {:.5g} mm (1.02 mean radii); "
                    "largest {:.5g} mm\n",
                    run.places->count, run.places->samples, run.places->radius,
                    run.places->largest);
            if (run.passed) return kDone;
            fmt::print(stderr, "{}", failures(run));
            return kCheckFailed;
        }
        case CliOptions::Command::measure: {
            const MeasureResult result = runMeasure(options.measure, callbacks);
            clearProgressLine();
            if (options.json)
                printJson(toJson(result));
            else
                printText(summary(result));
            return kDone;
        }
        case CliOptions::Command::convert: {
            const ConvertResult result = runConvert(options.convert, callbacks);
            clearProgressLine();
            if (options.json)
                printJson(toJson(result));
            else if (!options.quiet)
                printText(summary(result));
            return kDone;
        }
        case CliOptions::Command::mesh: {
            const MeshResult result = runMesh(options.mesh, callbacks);
            clearProgressLine();
            if (options.json)
                printJson(toJson(result));
            else
                printText(summary(result));
            return kDone;
        }
    }
    return kUsage;
}

}  // namespace

int main(int argc, char** argv) {
    handleSignals();
    const auto fail = [](const char* message, int code) {
        try {
            clearProgressLine();
            tell(fmt::format("{} {}\n", styled("vdb_pack:", Style::red, STDERR_FILENO),
                             withOptionNames(message)));
        } catch (const std::exception&) {  // no memory even for that
            std::fputs(message, stderr);
        }
        return code;
    };
    try {
        int exitCode = kDone;
        const auto options = parseCommandLine(argc, argv, exitCode);
        if (options) exitCode = runCommand(*options);
        if (interrupted) exitCode = kInterrupted;
        errno = 0;
        if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && exitCode == kDone)
            throw IoError(fmt::format("standard output: writing failed: {}; files are complete",
                                      errno != 0 ? std::strerror(errno) : "not all was written"));
        return exitCode;
    } catch (const Interrupted& e) {
        return fail(e.what(), kInterrupted);
    } catch (const ParameterError& e) {
        return fail(e.what(), kUsage);
    } catch (const InputError& e) {
        return fail(e.what(), kBadInput);
    } catch (const IoError& e) {
        return fail(e.what(), kIoFailed);
    } catch (const ResourceError& e) {
        return fail(e.what(), kNoResources);
    } catch (const std::bad_alloc&) {
        return fail("out of memory; choose larger radii or voxels, or clip the domain",
                    kNoResources);
    } catch (const std::exception& e) {
        return fail(e.what(), isShortage(e) ? kNoResources : kIoFailed);
    }
}
