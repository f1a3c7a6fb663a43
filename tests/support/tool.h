// Runs vdb_pack and commands of the shell.
#pragma once

#include "support/paths.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

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

/// The report of a run with --json that has succeeded; what was printed before it does not count.
inline nlohmann::json jsonOf(const Output& output) {
    CAPTURE(output.text);
    REQUIRE(output.code == 0);
    return nlohmann::json::parse(output.text.substr(output.text.find('{')));
}

/// The words of a line, which blanks separate.
inline std::vector<std::string> wordsOf(const std::string& line) {
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
}

}  // namespace vdbpack::test
