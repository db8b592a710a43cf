#include "export/files.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "error.h"
#include "io/atomic_file.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

TEST_CASE("an export replaces its own files and leaves others in the folder", "[export]") {
    const TemporaryFolder folder;
    write_files(folder.file("out"), {{"a.csv", "1"}, {"sub/b.csv", "2"}});
    write_file(folder.file("out/notes.txt"), "mine");
    write_files(folder.file("out/export.20251125.tmp"), {{"thesis.tex", "mine"}});
    write_files(folder.file("out/"), {{"a.csv", "3"}});
    CHECK(read_file(folder.file("out/a.csv")) == "3");
    CHECK(read_file(folder.file("out/sub/b.csv")) == "2");
    CHECK(read_file(folder.file("out/notes.txt")) == "mine");
    CHECK(read_file(folder.file("out/export.20251125.tmp/thesis.tex")) == "mine");
    const auto entries = std::distance(std::filesystem::directory_iterator(folder.file("out")), {});
    CHECK(entries == 4);  // nothing is left within
    CHECK(folder.names() == std::vector<std::string>{"out"});
}

TEST_CASE("a name that leads out of the folder writes nothing at all", "[export]") {
    const TemporaryFolder folder;
    write_files(folder.file("out"), {{"a.csv", "1"}});
    for (const std::string name : {"../escaped.csv", "/tmp/escaped.csv", "b/../../escaped.csv"})
        CHECK_THAT(refusal<FileError>([&] { write_files(folder.file("out"), {{"a.csv", "2"}, {name, "2"}}); }),
                   Contains("leads out of it"));
    CHECK(read_file(folder.file("out/a.csv")) == "1");
    CHECK(folder.names() == std::vector<std::string>{"out"});
}

TEST_CASE("an export does not take a file's place", "[export]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("out", "mine");
    CHECK_THAT(refusal<FileError>([&] { write_files(file, {{"a.csv", "1"}}); }),
               Contains("is a file, wanted a folder"));
    CHECK(read_file(file) == "mine");
}

TEST_CASE("a folder OUT.tmp of the user's own, or a link of that name, is left alone by an export", "[export]") {
    const TemporaryFolder folder;
    write_files(folder.file("out.tmp"), {{"thesis.tex", "mine"}});
    write_files(folder.file("out"), {{"a.csv", "1"}});
    CHECK(read_file(folder.file("out.tmp/thesis.tex")) == "mine");
    CHECK(folder.names() == std::vector<std::string>{"out", "out.tmp"});
}

TEST_CASE("an export goes into a folder of another disk, by a link too", "[export]") {
    struct stat here {}, there {};
    const TemporaryFolder folder;
    if (::stat("/dev/shm", &there) != 0 || ::stat(folder.file("").c_str(), &here) != 0 || here.st_dev == there.st_dev) return;  // one disk for all
    char other[] = "/dev/shm/tissue_export_XXXXXX";
    REQUIRE(::mkdtemp(other) != nullptr);
    std::filesystem::create_directory_symlink(other, folder.file("out"));
    CHECK_NOTHROW(write_files(folder.file("out"), {{"a.csv", "1"}, {"sub/b.csv", "2"}}));
    CHECK(read_file(std::string(other) + "/sub/b.csv") == "2");
    std::filesystem::remove_all(other);
}
