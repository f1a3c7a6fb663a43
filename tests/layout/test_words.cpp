// Words that readers from anywhere stumble on stay out of the tree.
#include "support/paths.h"
#include "support/text_file.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

using namespace vdbpack::test;

namespace {

namespace fs = std::filesystem;

/// In parts, so that this file does not find itself.
const std::vector<std::string> kWords{
    "not to be "
    "had",
    "dear"
    "er",
    "hangs? "
    "together",
    "(is|are) "
    "told",
    "who"
    "ever",
    "comes? "
    "apart",
    "what "
    "stands",
    "judge?m"
    "ents?",
    "an"
    "ew"};

/// "file:line: text" for each line with one of the words.
std::vector<std::string> linesWith(const std::string& content, const std::string& name,
                                   const std::regex& words) {
    std::vector<std::string> found;
    std::size_t line = 1;
    for (std::size_t at = 0; at < content.size(); ++line) {
        const std::size_t end = std::min(content.find('\n', at), content.size());
        const std::string text = content.substr(at, end - at);
        if (std::regex_search(text, words))
            found.push_back(name + ":" + std::to_string(line) + ": " + text);
        at = end + 1;
    }
    return found;
}

std::regex wordsToAvoid() {
    std::string any;
    for (const auto& word : kWords) any += (any.empty() ? "\\b(" : "|") + word;
    return std::regex(any + ")\\b", std::regex::optimize);
}

/// How often the comments of a header put a pronoun where the reader looks for the noun.
std::size_t pronouns(const std::string& content) {
    static const std::regex pronoun(
        "\\b(those of|that of|the ones|is "
        "told)\\b");
    static const std::regex lineBreak("\n *///?<? *");
    const std::string text = std::regex_replace(content, lineBreak, " ");
    return static_cast<std::size_t>(
        std::distance(std::sregex_iterator(text.begin(), text.end(), pronoun), {}));
}

}  // namespace

TEST_CASE("texts avoid words that have to be read twice", "[layout]") {
    const std::regex words = wordsToAvoid();
    const std::string top = kTests + "/../";
    std::vector<std::string> found;
    std::size_t files = 0;
    for (const char* folder : {"lib", "tools", "tests", "assets"})
        for (const auto& entry : fs::recursive_directory_iterator(top + folder)) {
            const auto extension = entry.path().extension();
            if (extension != ".h" && extension != ".cpp" && extension != ".md" &&
                extension != ".py" && extension != ".toml")
                continue;
            ++files;
            for (auto& line : linesWith(contentOf(entry.path().string()),
                                        fs::relative(entry.path(), top).string(), words))
                found.push_back(std::move(line));
        }
    for (auto& line : linesWith(contentOf(top + "README.md"), "README.md", words))
        found.push_back(std::move(line));
    CHECK(files > 400);
    CHECK(found == std::vector<std::string>{});
}

TEST_CASE("the library names no option of the command line", "[layout]") {
    // Its messages mark the name of a setting, and the program adds the dashes.
    const std::regex option("\"--[a-z]");
    const std::string lib = kTests + "/../lib/vdbpack";
    std::vector<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(lib))
        if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
            for (auto& line : linesWith(contentOf(entry.path().string()),
                                        fs::relative(entry.path(), lib).string(), option))
                found.push_back(std::move(line));
    CHECK(found == std::vector<std::string>{});
}

TEST_CASE("a word to avoid is found with its line", "[layout]") {
    const std::string text =
        "One.\nThe user is "
        "told of it.\n";
    CHECK(linesWith(text, "a.md", wordsToAvoid()) == std::vector<std::string>{"a.md:2: The user is "
                                                                              "told of it."});
    CHECK(linesWith("It is reported.", "a.md", wordsToAvoid()).empty());
}

TEST_CASE("a header has one pronoun for a noun at the most", "[layout]") {
    CHECK(pronouns("/// The radii, or those\n    /// of the shell; that of none.\n") == 2);
    const std::string lib = kTests + "/../lib";
    for (const auto& entry : fs::recursive_directory_iterator(lib)) {
        if (entry.path().extension() != ".h") continue;
        CAPTURE(fs::relative(entry.path(), lib).string());
        CHECK(pronouns(contentOf(entry.path().string())) <= 1);
    }
}
