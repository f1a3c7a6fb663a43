// Runs vdb_pack and commands of the shell.
#pragma once

#include "support/paths.h"

#include <catch2/catch.hpp>
#include <sys/wait.h>

#include <cstdio>
#include <string>

namespace vdbpack::test {

struct Output {
    int code;
    std::string text;
};

/// Runs a command of the shell; `text` is its output and errors together.
inline Output shell(const std::string& command) {
    std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
    REQUIRE(pipe);
    Output output{0, {}};
    char buffer[4096];
    std::size_t n;
    while ((n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0) output.text.append(buffer, n);
    const int status = ::pclose(pipe);
    output.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return output;
}

/// Runs vdb_pack with these arguments.
inline Output vdbPack(const std::string& arguments) {
    return shell(kTool + " " + arguments);
}

}  // namespace vdbpack::test
