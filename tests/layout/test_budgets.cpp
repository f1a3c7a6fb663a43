// Lines of folders, files and functions stay below ceilings, which are lowered as code goes.
#include "support/paths.h"
#include "support/text_file.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

using namespace vdbpack::test;

namespace {

namespace fs = std::filesystem;

/// Most lines of a folder: *.h *.cpp *.py *.js *.in *.cl. Each room of the library has a row.
const std::map<std::string, std::size_t> kFolderLines{
    {"lib", 96515},
    {"lib/python", 2066},
    {"lib/vdbpack/core", 2623},
    {"lib/vdbpack/io", 2961},
    {"lib/vdbpack/mesh", 4183},
    {"lib/vdbpack/verify", 2453},
    {"lib/vdbpack/image", 5794},
    {"lib/vdbpack/field", 6109},
    {"lib/vdbpack/repair", 2843},
    {"lib/vdbpack/domain", 7116},
    {"lib/vdbpack/pack", 8165},
    {"lib/vdbpack/densify", 6031},
    {"lib/vdbpack/bonds", 696},
    {"lib/vdbpack/measure", 5668},
    {"lib/vdbpack/voids", 8216},
    {"lib/vdbpack/formats", 10384},
    {"lib/vdbpack/report", 4066},
    {"lib/vdbpack/preview", 3597},
    {"lib/vdbpack/view", 1583},
    {"lib/vdbpack/distributed", 448},
    {"lib/vdbpack/options", 3618},
    {"lib/vdbpack/run", 7803},
    {"tools", 3942},
    {"tests", 36157},
};
/// Most lines of a file, and of a function from its opening brace to its end.
constexpr std::size_t kFileLines = 420;
constexpr std::size_t kFunctionLines = 60;
/// Tables: rows rather than steps, of any length.
const std::set<std::string> kTables{};

struct Length {
    std::string where;
    std::size_t lines;
};

/// Length of the comment, literal or preprocessor line that starts at `at`; 0 if none does.
std::size_t lengthOfText(const std::string& code, std::size_t at) {
    const auto until = [&](const std::string& end, std::size_t from) {
        const std::size_t found = code.find(end, from);
        return (found == std::string::npos ? code.size() : found + end.size()) - at;
    };
    if (code.compare(at, 2, "//") == 0) return until("\n", at) - 1;
    if (code.compare(at, 2, "/*") == 0) return until("*/", at + 2);
    if (code.compare(at, 2, "R\"") == 0) {
        const std::size_t open = code.find('(', at);
        return until(")" + code.substr(at + 2, open - at - 2) + "\"", open);
    }
    std::size_t end = at;
    if (code[at] == '#') {
        do end = code.find('\n', end + 1);
        while (end < code.size() && code[end - 1] == '\\');
        return end - at;
    }
    // A quote between digits parts them.
    const bool parts =
        code[at] == '\'' && at > 0 && std::isalnum(static_cast<unsigned char>(code[at - 1]));
    if ((code[at] != '"' && code[at] != '\'') || parts) return 0;
    for (++end; end < code.size() && code[end] != code[at]; ++end)
        if (code[end] == '\\') ++end;
    return end + 1 - at;
}

/// The code with blanks for comments, literals and preprocessor lines; line breaks stay.
std::string plainCode(std::string code) {
    for (std::size_t at = 0; at < code.size(); ++at) {
        const std::size_t length = lengthOfText(code, at);
        for (std::size_t i = at; i < at + length; ++i)
            if (code[i] != '\n') code[i] = ' ';
        if (length > 0) at += length - 1;
    }
    return code;
}

std::size_t closingBrace(const std::string& code, std::size_t open) {
    int depth = 0;
    for (std::size_t at = open; at < code.size(); ++at) {
        if (code[at] == '{') ++depth;
        if (code[at] == '}' && --depth == 0) return at;
    }
    return code.size() - 1;
}

/// Whether the braces after `head` hold declarations: a namespace or a class.
bool opensScope(const std::string& head) {
    static const std::regex scope("(^|[>:])\\s*(inline )?(namespace|class|struct|union|enum)\\b");
    return std::regex_search(head, scope) || head.find("extern") != std::string::npos;
}

/// Whether the braces after `head` hold statements; if not, they initialize a value.
bool opensFunction(const std::string& head) {
    static const std::regex initializer("\\)\\s*(noexcept\\s*)?:[^:][^]*\\w\\s*$|=\\s*$");
    static const std::regex specifier("\\b(const|noexcept|override|final)\\s*$");
    return head.find(')') != std::string::npos &&
           (!std::regex_search(head, initializer) || std::regex_search(head, specifier));
}

/// Functions at the level of namespaces and classes, lambdas and test cases there included.
std::vector<Length> functionLengths(const std::string& text, const std::string& name) {
    const std::string code = plainCode(text);
    const auto lines = [&](std::size_t begin, std::size_t end) {
        return static_cast<std::size_t>(std::count(&code[begin], &code[end], '\n')) + 1;
    };
    std::vector<Length> found;
    std::string head;
    int parentheses = 0;
    for (std::size_t at = 0; at < code.size(); ++at) {
        const char c = code[at];
        parentheses += (c == '(') - (c == ')');
        if (c != '{') {
            head = c == ';' || c == '}' ? "" : head + c;
            continue;
        }
        if (parentheses == 0 && opensScope(head)) {
            head.clear();
            continue;
        }
        const std::size_t end = closingBrace(code, at);
        if (parentheses == 0 && opensFunction(head)) {
            found.push_back({name + ":" + std::to_string(lines(0, at)), lines(at, end)});
            head.clear();
        }
        at = end;
    }
    return found;
}

struct Tree {
    std::map<std::string, std::size_t> folders;
    std::vector<Length> files, functions;
};

/// The counted files below lib, tools and tests of `top`, the longest first.
Tree measuredTree(const std::string& top) {
    static const std::set<std::string> counted{".h", ".cpp", ".py", ".js", ".in", ".cl"};
    Tree tree;
    for (const char* root : {"lib", "tools", "tests"})
        for (const auto& entry : fs::recursive_directory_iterator(top + root)) {
            const std::string extension = entry.path().extension().string();
            if (!entry.is_regular_file() || counted.count(extension) == 0) continue;
            const std::string name = fs::relative(entry.path(), top).generic_string();
            const std::string text = contentOf(entry.path().string());
            const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
            for (fs::path folder = fs::path(name).parent_path(); !folder.empty();
                 folder = folder.parent_path())
                tree.folders[folder.generic_string()] += lines;
            if (kTables.count(name) == 1) continue;
            tree.files.push_back({name, lines});
            if (extension != ".h" && extension != ".cpp") continue;
            for (auto& each : functionLengths(text, name)) tree.functions.push_back(each);
        }
    const auto longer = [](const Length& a, const Length& b) { return a.lines > b.lines; };
    std::stable_sort(tree.files.begin(), tree.files.end(), longer);
    std::stable_sort(tree.functions.begin(), tree.functions.end(), longer);
    return tree;
}

/// "name: lines" of each that is longer than `most`.
std::vector<std::string> longerThan(std::size_t most, const std::vector<Length>& lengths) {
    std::vector<std::string> found;
    for (const auto& each : lengths)
        if (each.lines > most) found.push_back(each.where + ": " + std::to_string(each.lines));
    return found;
}

}  // namespace

TEST_CASE("folders, files and functions stay below their ceilings", "[layout]") {
    const std::string top = kTests + "/../";
    const Tree tree = measuredTree(top);
    std::vector<Length> over;
    std::string table;
    for (const auto& [folder, ceiling] : kFolderLines) {
        const std::size_t lines = tree.folders.at(folder);
        table += folder + ": " + std::to_string(lines) + " of " + std::to_string(ceiling) + "\n";
        if (lines > ceiling) over.push_back({folder, lines});
    }
    table += "longest file " + longerThan(0, tree.files).front();
    table += "\nlongest function " + longerThan(0, tree.functions).front();
    SUCCEED(table);  // printed by -s
    CHECK(longerThan(0, over) == std::vector<std::string>{});
    CHECK(longerThan(kFileLines, tree.files) == std::vector<std::string>{});
    CHECK(longerThan(kFunctionLines, tree.functions) == std::vector<std::string>{});
    for (const auto& room : fs::directory_iterator(top + "lib/vdbpack"))
        if (room.is_directory() &&
            kFolderLines.count("lib/vdbpack/" + room.path().filename().string()) == 0)
            FAIL_CHECK(room.path() << " has no row in kFolderLines");
}

TEST_CASE("a function is found with its length, whatever stands around it", "[layout]") {
    const std::string code = R"code(#define OPEN {
namespace a {
/// Braces { in comments
template <class T>
struct B : C<T> {
    B(std::vector<int> x = {}) : x_{std::move(x)}, y_(1'000) {
        f("}");
    }
    int g() const noexcept override { return '{'; }
    int y_{0};
};
const int table[] = {f(1),
                     f(2)};
enum class E { one, two };
}  // namespace a
TEST_CASE("b") {
    if (true) {
    }
}
)code";
    std::vector<std::string> found = longerThan(0, functionLengths(code, "a.cpp"));
    CHECK(found == std::vector<std::string>{"a.cpp:6: 3", "a.cpp:9: 1", "a.cpp:16: 4"});
}
