// Files that are whole or absent, whatever name they are written under.

#include "support/test.h"

#include "vdbpack/formats/outputs.h"
#include "vdbpack/io/input_file.h"
#include "vdbpack/io/output_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <iterator>
#include <thread>

namespace fs = std::filesystem;

namespace {

void writeWhole(const std::string& path, const std::string& content) {
    OutputFile out(path);
    out.write(content);
    out.commit();
}

}  // namespace

TEST_CASE("a file has its new content once it is committed, and nothing else is left") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.csv");
    putContent(file, "former");
    {
        OutputFile out(file);
        out.write(std::string(3000000, 'x'));
        CHECK(contentOf(file) == "former");
    }
    CHECK(contentOf(file) == "former");
    CHECK(folder.files() == 1);
    writeWhole(file, std::string(3000000, 'y'));
    CHECK(contentOf(file) == std::string(3000000, 'y'));
    CHECK(folder.files() == 1);
}

TEST_CASE("a library writes the file by its temporary name") {
    const TemporaryFolder folder;
    OutputFile out(folder.file("a.vdb"));
    std::ofstream(out.temporaryPath(), std::ios::binary) << "grids";
    out.commit();
    CHECK(contentOf(folder.file("a.vdb")) == "grids");
    CHECK(folder.files() == 1);
}

TEST_CASE("symbolic links are written through to what they point to") {
    const TemporaryFolder folder, other;
    putContent(other.file("real.csv"), "former");
    fs::create_symlink(other.file("real.csv"), folder.file("link.csv"));
    fs::create_symlink("link.csv", folder.file("again.csv"));
    fs::create_symlink(other.file("new.csv"), folder.file("dangling.csv"));
    writeWhole(folder.file("again.csv"), "one");
    CHECK(contentOf(other.file("real.csv")) == "one");
    CHECK(fs::is_symlink(folder.file("link.csv")));
    CHECK(fs::is_symlink(folder.file("again.csv")));
    writeWhole(folder.file("dangling.csv"), "two");
    CHECK(contentOf(other.file("new.csv")) == "two");
    CHECK(other.files() == 2);
    fs::create_symlink("b.csv", folder.file("a.csv"));
    fs::create_symlink("a.csv", folder.file("b.csv"));
    CHECK_THROWS_WITH(OutputFile(folder.file("a.csv")), Contains("a.csv"));
}

TEST_CASE("the permissions of a former file stay") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.csv");
    putContent(file, "former");
    ::chmod(file.c_str(), 0640);
    writeWhole(file, "new");
    struct stat info {};
    REQUIRE(::stat(file.c_str(), &info) == 0);
    CHECK((info.st_mode & 0777) == 0640);
}

TEST_CASE("what cannot be replaced by a file is refused") {
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(OutputFile(folder.path()), Contains(folder.path()));
    CHECK_THROWS_WITH(OutputFile(folder.file("no/a.csv")), Contains("no/a.csv"));
    REQUIRE(::mkfifo(folder.file("pipe").c_str(), 0600) == 0);
    CHECK_THROWS_WITH(OutputFile(folder.file("pipe")), Contains("pipe"));
    CHECK_THROWS_WITH(OutputFile("/dev/null"), Contains("device"));
    if (::geteuid() != 0) {  // who may write everywhere
        putContent(folder.file("a.csv"), "former");
        ::chmod(folder.file("a.csv").c_str(), 0400);
        CHECK_THROWS_WITH(OutputFile(folder.file("a.csv")), Contains("a.csv"));
    }
}

TEST_CASE("a folder that is gone before the file is complete is reported, and nothing is left") {
    const TemporaryFolder folder;
    fs::create_directory(folder.file("f"));
    OutputFile out(folder.file("f/a.csv"));
    out.write(std::string("x"));
    fs::remove_all(folder.file("f"));
    CHECK_THROWS_AS(out.commit(), IoError);
    CHECK(folder.files() == 0);
}

TEST_CASE("of several that write one file at once, one leaves its own whole") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.csv");
    std::vector<std::thread> threads;
    for (char letter = 'a'; letter < 'i'; ++letter)
        threads.emplace_back([&file, letter] {
            for (int i = 0; i < 20; ++i) writeWhole(file, std::string(300000, letter));
        });
    for (int i = 0; i < 100; ++i) {
        const std::string content = contentOf(file);
        if (content.empty()) continue;
        REQUIRE(content == std::string(300000, content[0]));
    }
    for (auto& thread : threads) thread.join();
    CHECK(contentOf(file).size() == 300000);
    CHECK(folder.files() == 1);
}

TEST_CASE("a name with a NUL is refused where it would name another file") {
    const TemporaryFolder folder;
    putContent(folder.file("a.vdb"), "former");
    const std::string name = folder.file("a.vdb") + std::string(1, '\0') + ".csv";
    CHECK_THROWS_AS(writeWhole(name, "other"), IoError);
    CHECK_THROWS_AS(InputFile(name), IoError);
    CHECK_THROWS_AS(checkFiles({name}, "", {}), IoError);
    CHECK(contentOf(folder.file("a.vdb")) == "former");
    CHECK(folder.files() == 1);
}
