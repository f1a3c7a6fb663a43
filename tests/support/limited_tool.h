// Runs vdb_pack within a time limit and measures its time and memory.
#pragma once

#include "support/paths.h"

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <vector>

namespace vdbpack::test {

struct Measured {
    int code = -1;  ///< -1: ended by a signal or the time limit
    std::string text;
    double seconds = 0;
    double peakBytes = 0;
};

/// Runs vdb_pack with these arguments (without a shell) for at most `seconds`; `text` is its output
/// and errors together.
inline Measured vdbPackWithin(unsigned seconds, const std::vector<std::string>& arguments) {
    int ends[2];
    REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
    std::string program = kTool;
    std::vector<std::string> words = arguments;
    std::vector<char*> argv{program.data()};
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const auto start = std::chrono::steady_clock::now();
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        ::dup2(ends[1], STDOUT_FILENO);
        ::dup2(ends[1], STDERR_FILENO);
        ::alarm(seconds);  // survives exec; ends the program
        ::execv(argv[0], argv.data());
        ::_exit(126);
    }
    ::close(ends[1]);
    Measured result;
    char buffer[4096];
    for (ssize_t n = 0; (n = ::read(ends[0], buffer, sizeof buffer)) > 0;)
        result.text.append(buffer, static_cast<std::size_t>(n));
    ::close(ends[0]);
    int status = 0;
    rusage usage{};
    REQUIRE(::wait4(child, &status, 0, &usage) == child);
    if (WIFEXITED(status)) result.code = WEXITSTATUS(status);
    result.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    result.peakBytes = static_cast<double>(usage.ru_maxrss) * 1024;
    return result;
}

}  // namespace vdbpack::test
