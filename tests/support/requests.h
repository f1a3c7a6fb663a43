// Requests that vdb_pack refuses, in tables.
#pragma once

#include "support/limited_tool.h"
#include "support/temporary_folder.h"
#include "support/tool.h"

#include <catch2/catch.hpp>

#include <set>
#include <string>
#include <vector>

namespace vdbpack::test {

constexpr unsigned kSoon = 10;  // seconds, on a busy machine; most take a twentieth
constexpr double kLittle = 1e9;

/// Words are separated by blanks; @ is the test's folder.
struct Request {
    std::string words;
    int code;
    std::string names;  ///< what the message must name: options, files, values
};

inline std::vector<std::string> wordsIn(const std::string& line, const std::string& folder) {
    auto words = wordsOf(line);
    for (std::string& word : words)
        if (const auto at = word.find('@'); at != std::string::npos)
            word.replace(at, 1, folder + '/');
    return words;
}

/// Runs that make something are asked for its numbers.
inline Measured asked(std::vector<std::string> words) {
    static const std::set<std::string> kMaking{"pack", "voids", "carve", "densify"};
    if (kMaking.count(words.front()) != 0) words.push_back("--json");
    return vdbPackWithin(kSoon, words);
}

/// Each request ends soon, without much memory, with its code, and leaves no file in the folder.
inline void check(const std::vector<Request>& requests, const std::string& folder = {}) {
    const auto filesIn = [&] {
        return folder.empty() ? std::vector<std::string>{} : namesIn(folder);
    };
    const auto before = filesIn();
    for (const Request& request : requests) {
        CAPTURE(request.words);
        const auto run = asked(wordsIn(request.words, folder));
        CHECK(run.code == request.code);
        for (const std::string& fact : wordsIn(request.names, folder))
            CHECK_THAT(run.text, Catch::Matchers::Contains(fact));
        CHECK(run.peakBytes < kLittle);
    }
    CHECK(filesIn() == before);
}

}  // namespace vdbpack::test
