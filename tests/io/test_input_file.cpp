#include "support/test.h"

#include "vdbpack/io/input_file.h"

#include <sys/stat.h>

#include <thread>

namespace {

std::vector<std::string> linesOf(InputFile& file) {
    std::vector<std::string> lines;
    for (std::string_view line; file.nextLine(line);) lines.emplace_back(line);
    return lines;
}

}  // namespace

TEST_CASE("lines are the same whichever way they end") {
    const std::vector<std::string> lines{"first", "", "a third one ", "x"};
    for (const std::string end : {"\n", "\r\n", "\r"})
        for (const bool closed : {true, false}) {
            CAPTURE(end, closed);
            std::string text;
            for (const auto& line : lines) text += line + end;
            if (!closed) text.resize(text.size() - end.size());
            const TextFile made(text);
            InputFile file(made.path());
            CHECK(linesOf(file) == lines);
            CHECK(file.lineNumber() == lines.size());
            CHECK(file.remaining() == 0);
        }
}

TEST_CASE("lines and blocks larger than the buffer are read whole") {
    const std::string longest(9'000'000, 'x'), last(5'000'000, 'y');
    const TextFile made("a\n" + longest + "\nb\n" + last);
    InputFile file(made.path());
    CHECK(linesOf(file) == std::vector<std::string>{"a", longest, "b", last});
    file.seek(2, 1);
    const char* const block = file.take(longest.size());
    REQUIRE(block != nullptr);
    CHECK(std::string_view(block, longest.size()) == longest);
    CHECK(file.take(last.size() + 100) == nullptr);
    std::string_view line;
    REQUIRE(file.nextLine(line));
    CHECK(file.lineNumber() == 2);
}

TEST_CASE("any order of seeking, peeking and taking returns the bytes at the offset") {
    std::string content;
    for (int i = 0; content.size() < 6'000'000; ++i) content += std::to_string(i) + '\n';
    const TextFile made(content);
    InputFile file(made.path());
    std::uint64_t offset = 1;
    for (int i = 0; i < 300; ++i) {
        offset = (offset * 48271) % content.size();
        const std::size_t bytes = offset % 4000 + 1;
        CAPTURE(offset, bytes);
        const std::string expected = content.substr(offset, bytes);
        file.seek(offset);
        REQUIRE(file.offset() == offset);
        REQUIRE(std::string(file.peek(bytes)) == expected);
        const char* const taken = file.take(bytes);
        REQUIRE((taken != nullptr) == (expected.size() == bytes));
        if (taken != nullptr) REQUIRE(std::string(taken, bytes) == expected);
        std::string at(expected.size(), ' ');
        file.readAt(offset, at.data(), at.size());
        REQUIRE(at == expected);
    }
}

TEST_CASE("a pipe is read like a file") {
    const TemporaryFolder folder;
    const std::string path = folder.file("pipe");
    REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
    const std::string content = "ab\ncd\n" + std::string(200'000, 'z');
    std::thread writer([&] { std::ofstream(path) << content; });
    InputFile file(path);
    writer.join();
    CHECK(file.size() == content.size());
    CHECK(linesOf(file).size() == 3);
    file.seek(3, 1);
    std::string_view line;
    REQUIRE(file.nextLine(line));
    CHECK(line == "cd");
    CHECK(file.lineNumber() == 2);
}

TEST_CASE("files that cannot be read are refused with their name") {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder.file("folder"));
    for (const std::string& path :
         {folder.file("none"), folder.file("folder"), std::string("/dev/zero")})
        CHECK_THAT(messageOf<IoError>([&] { InputFile file(path); }), Contains(path));
    const TextFile made("short");
    const InputFile file(made.path());
    char bytes[6];
    CHECK_THAT(messageOf<InputError>([&] { file.readAt(3, bytes, 6); }),
               Contains(made.path()) && Contains("byte 5"));
}
