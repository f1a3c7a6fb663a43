// vdb_pack: parses, calls, prints. Whatever deserves a test is in the library.
#include "cli/open_page.h"
#include "cli/options.h"
#include "cli/progress_line.h"
#include "cli/terminal.h"
#include "rank_session.h"

#include "vdbpack/core/error.h"
#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/output_file.h"
#include "vdbpack/io/text.h"
#include "vdbpack/report/image_result.h"
#include "vdbpack/run/run.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <type_traits>
#include <variant>
#include <vector>

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
/// Whether there may be completed spheres to write.
std::atomic<bool> worthKeeping{false};
/// Whether the pack is complete, and its files are being written under their own names.
std::atomic<bool> isWriting{false};
/// Whether this process speaks for all that work on one pack; the others tell errors alone.
std::atomic<bool> isSpeaker{true};

template <std::size_t N>
void sayFromHandler(const char (&text)[N]) {
    const auto written = ::write(STDERR_FILENO, text, N - 1);
    static_cast<void>(written);
}

void onSignal(int) {
    // The first signal requests an orderly end if there are spheres to keep, the second ends at
    // once.
    if (interrupted.exchange(true) || !worthKeeping) {
        removeTemporaryFiles();
        sayFromHandler("\nvdb_pack: interrupted.\n");
        ::_exit(kInterrupted);
    }
    if (!isSpeaker) return;
    if (isWriting) {
        sayFromHandler(
            "\nvdb_pack: interrupted; the pack is complete, and its files are still written. "
            "Interrupt again to stop at once.\n");
        return;
    }
    sayFromHandler(
        "\nvdb_pack: interrupted; the completed spheres of an unfinished pack are written to "
        "NAME.interrupted.EXT. Interrupt again to stop at once.\n");
}

/// Signals that request a stop, and those that would end the process if writing fails: the call
/// that writes reports that itself.
void handleSignals() {
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGINT, onSignal);
    std::signal(SIGTERM, onSignal);
    // A run started with nohup survives its terminal.
    if (std::signal(SIGHUP, onSignal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

/// Prints a message to standard error; ignores failures.
void tell(const char* kind, Style style, const std::string& message) {
    // Messages quote what damaged files hold.
    std::fputs(fmt::format("{} {}\n", styled(kind, style, STDERR_FILENO),
                           printable(withOptionNames(message)))
                   .c_str(),
               stderr);
}

/// Progress on a terminal, silence elsewhere; warnings always.
Callbacks makeCallbacks(bool quiet) {
    Callbacks callbacks;
    callbacks.warning = [](const std::string& text) {
        if (!isSpeaker) return;
        clearProgressLine();
        tell("warning:", Style::yellow, text);
    };
    callbacks.cancelled = [] { return interrupted.load(); };
    std::shared_ptr<ProgressLine> line;
    if (!quiet && isSpeaker && ::isatty(STDERR_FILENO)) line = std::make_shared<ProgressLine>();
    callbacks.progress = [line](const Progress& p) {
        if (p.stage == "pack") worthKeeping = true;
        isWriting = p.stage == "write";
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

template <class Result>
void print(const Result& result, const PrintOptions& how) {
    clearProgressLine();
    if (how.json)
        printJson(toJson(result));
    else if (!how.quiet)
        printText(summary(result));
}

/// The exit code of a pack that must pass its checks.
int judged(const RunResult& run) {
    if (run.report.interrupted || interrupted) return kInterrupted;
    if (run.passed) return kDone;
    if (isSpeaker) fmt::print(stderr, "{}", printable(withOptionNames(failures(run))));
    return kCheckFailed;
}

int dryRun(const PackJob& job, const PrintOptions& how, const Callbacks& callbacks) {
    const DryRun expected = dryRunPack(job, callbacks);
    if (interrupted) return kInterrupted;
    PrintOptions always = how;
    always.quiet = false;
    print(expected, always);
    std::fflush(stdout);
    requireResources(expected.estimate, job.memoryLimit);
    return kDone;
}

/// A run for each of several seeds and cases.
template <class Job>
int study(const Job& job, const PrintOptions& how, const Callbacks& callbacks) {
    const std::string& table = job.study.table;
    auto cases = job.cases;
    if (cases.empty()) cases.push_back(job);
    const StudyResult result = runStudy(cases, job.study.seeds, table, callbacks);
    clearProgressLine();
    if (how.json) {
        auto all = nlohmann::ordered_json::array();
        for (const auto& report : result.reports) all.push_back(toJson(report));
        printJson(all);
    } else if (!how.quiet) {
        printText(summary(result));
        if (!table.empty() && !result.reports.empty())
            fmt::print("written    {}\n", result.interrupted ? interruptedName(table) : table);
    }
    if (result.interrupted) return kInterrupted;
    if (result.passed) return kDone;
    fmt::print(stderr, "{}", printable(withOptionNames(result.failures)));
    return kCheckFailed;
}

/// The address of a file for a browser.
std::string uriOf(const std::string& file) {
    static const std::string plain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.~/";
    std::string uri = "file://";
    for (const char c : std::filesystem::absolute(file).lexically_normal().string())
        uri += plain.find(c) != std::string::npos
                   ? std::string(1, c)
                   : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    return uri;
}

/// Each command: runs, prints, and returns the exit code.
struct Perform {
    const PrintOptions& how;
    const Callbacks& callbacks;

    int operator()(const PackJob& job) const {
        if (job.dryRun) return dryRun(job, how, callbacks);
        if (!job.study.isOne()) return study(job, how, callbacks);
        const RunResult run = runPack(recipeForSeed(job, job.study.seeds.front()), callbacks);
        print(run, how);
        return judged(run);
    }
    int operator()(const DensifyRecipe& recipe) const {
        const RunResult run = runDensify(recipe, callbacks);
        print(run, how);
        return judged(run);
    }
    int operator()(const VoidsJob& job) const {
        if (!job.study.isOne()) return study(job, how, callbacks);
        return printed(runVoids(recipeForSeed(job, job.study.seeds.front()), callbacks));
    }
    int operator()(const CarveRecipe& recipe) const { return printed(runCarve(recipe, callbacks)); }
    int operator()(const VerifyRecipe& recipe) const {
        const RunResult run = runVerify(recipe, callbacks);
        print(run, how);
        return judged(run);
    }
    int operator()(const MeasureRecipe& recipe) const {
        return printed(runMeasure(recipe, callbacks));
    }
    int operator()(const StiffnessRecipe& recipe) const {
        return printed(runStiffness(recipe, callbacks));
    }
    int operator()(const ConvertRecipe& recipe) const {
        return printed(runConvert(recipe, callbacks));
    }
    int operator()(const ViewJob& job) const {
        const ViewResult result = runView(job, callbacks);
        print(result, how);
        const bool opened = job.opens && openPage(result.file);
        if (!how.json && !how.quiet)
            fmt::print("{:<11}{}\n", opened ? "opened" : "open it",
                       opened ? "in the browser" : "in a browser: " + uriOf(result.file));
        return kDone;
    }
    int operator()(const MeshRecipe& recipe) const {
        const MeshResult result = runMesh(recipe, callbacks);
        print(result, how);
        if (result.passed) return kDone;
        fmt::print(stderr, "{}", printable(withOptionNames(failures(result))));
        return kCheckFailed;
    }
    int operator()(const ImageRecipe& recipe) const { return printed(runImage(recipe, callbacks)); }

    template <class Result>
    int printed(const Result& result) const {
        print(result, how);
        return kDone;
    }
};

/// The file that options were read from is an input like others.
void keepConfig(const CliOptions& options) {
    if (options.config.empty()) return;
    std::visit(
        [&](const auto& job) {
            std::string table;
            if constexpr (std::is_same_v<decltype(job), const PackJob&> ||
                          std::is_same_v<decltype(job), const VoidsJob&>)
                table = job.study.table;
            checkFiles(job.outputs, job.reportFile, {options.config}, {job.preview.file, table});
        },
        options.job);
}

int runCommand(const CliOptions& options) {
    keepConfig(options);
    const Callbacks callbacks = makeCallbacks(options.print.quiet);
    return std::visit(Perform{options.print, callbacks}, options.job);
}

/// Refuses processes that were started together, but each for a pack of its own.
void requireSameCommand(Ranks& ranks, int argc, char** argv) {
    std::vector<char> words;
    for (int i = 1; i < argc; ++i)
        words.insert(words.end(), argv[i], argv[i] + std::strlen(argv[i]) + 1);
    const auto all = gathered(&ranks, words);
    if (std::any_of(all.begin(), all.end(), [&](const auto& each) { return each != all.front(); }))
        throw ParameterError(
            "the processes were given different arguments: those that mpirun or srun starts "
            "together share the work of one pack. Start processes for packs of their own by other "
            "means (xargs -P, a loop, or srun --mpi=none)");
}

/// Lets several processes work on one pack, of which the first speaks for all.
void shareOut(CliOptions& options, RankSession& session) {
    auto* const job = std::get_if<PackJob>(&options.job);
    if (!job || job->dryRun || !job->study.isOne())
        throw ParameterError(
            "several processes were started: they share the work of one pack alone. Start one "
            "process for other commands, for --dry-run and for several seeds");
    job->ranks = &session.ranks();
    if (job->threads == 0) job->threads = session.threads();
}

/// Parses, runs and prints. @return the exit code.
int runProgram(int argc, char** argv, RankSession* session) {
    isSpeaker = !session || session->ranks().isFirst();
    if (!isSpeaker && !std::freopen("/dev/null", "w", stdout))
        throw IoError("/dev/null: cannot be opened");
    int exitCode = kDone;
    if (session) requireSameCommand(session->ranks(), argc, argv);
    // What is wrong with it the first process alone tells.
    auto options = isSpeaker ? parseCommandLine(argc, argv, exitCode) : std::nullopt;
    if (session &&
        gathered(&session->ranks(), std::vector<int>{options.has_value()}).front().front()) {
        if (!isSpeaker) options = parseCommandLine(argc, argv, exitCode);
        shareOut(*options, *session);
    }
    if (options) exitCode = runCommand(*options);
    if (interrupted) exitCode = kInterrupted;
    if (options && exitCode == kDone) fmt::print("{}", options->afterwards);
    errno = 0;
    if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && exitCode == kDone)
        throw IoError(fmt::format("standard output: writing failed: {}{}",
                                  errno != 0 ? std::strerror(errno) : "not all was written",
                                  options ? "; files are complete" : ""));
    return exitCode;
}

}  // namespace

int main(int argc, char** argv) {
    handleSignals();
    std::unique_ptr<RankSession> session;
    const auto fail = [&](const char* message, int code) {
        const auto tellIt = [&] {
            try {
                clearProgressLine();
                tell("vdb_pack:", Style::red, message);
            } catch (const std::exception&) {  // no memory even for that
                std::fputs(message, stderr);
            }
        };
        if (session) return session->end(true, code, tellIt);
        tellIt();
        return code;
    };
    try {
        session = startRanks();
        const int exitCode = runProgram(argc, argv, session.get());
        return session ? session->end(false, exitCode, {}) : exitCode;
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
        if (!isShortage(e))
            return fail((std::string("unexpected error: ") + e.what()).c_str(), kIoFailed);
        return fail(fmt::format("not enough memory or threads: {}; use fewer --threads, or raise "
                                "the limits of the shell (ulimit -v, ulimit -u)",
                                e.what())
                        .c_str(),
                    kNoResources);
    }
}
