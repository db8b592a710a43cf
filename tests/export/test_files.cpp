#include "export/files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "error.h"
#include "io/atomic_file.h"
#include "io/folder.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

TEST_CASE("an export replaces its own files and leaves other files in the folder", "[export]") {
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
    CHECK(entries == 4);  // no temporary file is left
    CHECK(folder.names() == std::vector<std::string>{"out"});
}

TEST_CASE("an export with a file name outside its folder writes nothing", "[export]") {
    const TemporaryFolder folder;
    write_files(folder.file("out"), {{"a.csv", "1"}});
    for (const std::string name : {"../escaped.csv", "/tmp/escaped.csv", "b/../../escaped.csv"})
        CHECK_THAT(refusal<FileError>([&] { write_files(folder.file("out"), {{"a.csv", "2"}, {name, "2"}}); }),
                   Contains("leads out of this folder"));
    CHECK(read_file(folder.file("out/a.csv")) == "1");
    CHECK(folder.names() == std::vector<std::string>{"out"});
}

TEST_CASE("an export to the name of a file is refused", "[export]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("out", "mine");
    CHECK_THAT(refusal<FileError>([&] { write_files(file, {{"a.csv", "1"}}); }),
               Contains("is a file; give a folder"));
    CHECK(read_file(file) == "mine");
}

TEST_CASE("an export leaves the folder OUT.tmp of a user unchanged", "[export]") {
    const TemporaryFolder folder;
    write_files(folder.file("out.tmp"), {{"thesis.tex", "mine"}});
    write_files(folder.file("out"), {{"a.csv", "1"}});
    CHECK(read_file(folder.file("out.tmp/thesis.tex")) == "mine");
    CHECK(folder.names() == std::vector<std::string>{"out", "out.tmp"});
}

TEST_CASE("an export follows a link into a folder on another file system", "[export]") {
    struct stat here {}, there {};
    const TemporaryFolder folder;
    // no second file system: nothing to test
    if (::stat("/dev/shm", &there) != 0 || ::stat(folder.file("").c_str(), &here) != 0 || here.st_dev == there.st_dev) return;
    char other[] = "/dev/shm/tissue_export_XXXXXX";
    REQUIRE(::mkdtemp(other) != nullptr);
    std::filesystem::create_directory_symlink(other, folder.file("out"));
    CHECK_NOTHROW(write_files(folder.file("out"), {{"a.csv", "1"}, {"sub/b.csv", "2"}}));
    CHECK(read_file(std::string(other) + "/sub/b.csv") == "2");
    std::filesystem::remove_all(other);
}

TEST_CASE("writing follows links of the user and refuses links of another user", "[export]") {
    const TemporaryFolder folder;
    write_files(folder.file("target"), {{"kept.csv", "precious"}});
    for (const char* name : {"own", "planted"}) std::filesystem::create_directory_symlink("target", folder.file(name));
    write_files(folder.file("own"), {{"a.csv", "1"}, {"sub/b.csv", "2"}});
    write_file(folder.file("own/sub/c.csv"), "3");
    CHECK(read_file(folder.file("target/a.csv")) == "1");
    CHECK(read_file(folder.file("target/sub/c.csv")) == "3");
    // only root can make a link of another user
    if (::lchown(folder.file("planted").c_str(), 65534, 65534) != 0) return;
    const std::string why = "'planted' is a link of another user, which is not followed: give the path of its target";
    CHECK_THAT(refusal<FileError>([&] { write_files(folder.file("planted"), {{"a.csv", "4"}}); }), Contains(why));
    CHECK_THAT(refusal<FileError>([&] { write_files(folder.file("planted/new"), {{"a.csv", "4"}}); }), Contains(why));
    CHECK_THAT(refusal<FileError>([&] { write_file(folder.file("planted/a.csv"), "4"); }), Contains(why));
    CHECK_THAT(refusal<FileError>([&] { place_behind_links(folder.file("planted/a.csv")); }), Contains(why));
    CHECK(read_file(folder.file("target/a.csv")) == "1");
    // also within the folder of an export
    std::filesystem::create_directory_symlink("../target", folder.file("target/inner"));
    REQUIRE(::lchown(folder.file("target/inner").c_str(), 65534, 65534) == 0);
    CHECK_THAT(refusal<FileError>([&] { write_files(folder.file("target"), {{"a.csv", "5"}, {"inner/b.csv", "5"}}); }), Contains("'inner' is a link of another user"));
    CHECK(read_file(folder.file("target/a.csv")) == "1");
    // a new file replaces the link and is not written through it
    std::filesystem::create_symlink("target/kept.csv", folder.file("file"));
    REQUIRE(::lchown(folder.file("file").c_str(), 65534, 65534) == 0);
    CHECK_THAT(refusal<FileError>([&] { place_behind_links(folder.file("file")); }), Contains("'file' is a link of another user"));
    write_file(folder.file("file"), "6");
    CHECK(read_file(folder.file("file")) == "6");
    CHECK(read_file(folder.file("target/kept.csv")) == "precious");
}

TEST_CASE("links are resolved as by the operating system", "[export]") {
    const TemporaryFolder folder;
    std::filesystem::create_directories(folder.file("a/b"));
    std::filesystem::create_directory_symlink("a/b", folder.file("down"));
    std::filesystem::create_directory_symlink(folder.file("down"), folder.file("whole"));
    std::filesystem::create_directory_symlink("loop", folder.file("loop"));
    std::filesystem::create_symlink("down/new.txt", folder.file("file"));
    std::filesystem::create_symlink("none/", folder.file("slash"));
    write_file(folder.file("whole/../up.txt"), "1");
    CHECK(read_file(folder.file("a/up.txt")) == "1");
    CHECK(place_of(folder.file("file")).name == "file");
    const OpenPlace behind = place_behind_links(folder.file("file"));
    CHECK(behind.name == "new.txt");
    write_new_file(behind.folder, behind.name, "file", "2");
    CHECK(read_file(folder.file("a/b/new.txt")) == "2");
    CHECK_THAT(refusal<FileError>([&] { write_file(folder.file("loop/a"), "x"); }), Contains("Too many levels of symbolic links"));
    CHECK_THAT(refusal<FileError>([&] { write_file(folder.file("a/up.txt/b"), "x"); }), Contains("Not a directory"));
    CHECK(behind.is_open_as == -1);
    CHECK(place_behind_links("/dev/stdout").is_open_as == 1);
    for (const char* name : {"none/", "file/", "a", "down", "whole", "slash"}) CHECK_THAT(refusal<FileError>([&] { place_behind_links(folder.file(name)); }), Contains("is the name of a folder; give that of a file"));
}
