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

TEST_CASE("an export, a file and a journal go through no link of another user's, and through the user's own", "[export]") {
    const TemporaryFolder folder;
    write_files(folder.file("target"), {{"kept.csv", "precious"}});
    for (const char* name : {"own", "planted"}) std::filesystem::create_directory_symlink("target", folder.file(name));
    write_files(folder.file("own"), {{"a.csv", "1"}, {"sub/b.csv", "2"}});
    write_file(folder.file("own/sub/c.csv"), "3");
    CHECK(read_file(folder.file("target/a.csv")) == "1");
    CHECK(read_file(folder.file("target/sub/c.csv")) == "3");
    if (::lchown(folder.file("planted").c_str(), 65534, 65534) != 0) return;  // not root: no link is another user's
    const std::string why = "'planted' is a link of another user, which is not followed: give the path that it leads to";
    CHECK_THAT(refusal<FileError>([&] { write_files(folder.file("planted"), {{"a.csv", "4"}}); }), Contains(why));
    CHECK_THAT(refusal<FileError>([&] { write_files(folder.file("planted/new"), {{"a.csv", "4"}}); }), Contains(why));
    CHECK_THAT(refusal<FileError>([&] { write_file(folder.file("planted/a.csv"), "4"); }), Contains(why));
    CHECK_THAT(refusal<FileError>([&] { place_behind_links(folder.file("planted/a.csv")); }), Contains(why));
    CHECK(read_file(folder.file("target/a.csv")) == "1");
    // within a folder that is written into, too
    std::filesystem::create_directory_symlink("../target", folder.file("target/inner"));
    REQUIRE(::lchown(folder.file("target/inner").c_str(), 65534, 65534) == 0);
    CHECK_THAT(refusal<FileError>([&] { write_files(folder.file("target"), {{"a.csv", "5"}, {"inner/b.csv", "5"}}); }), Contains("'inner' is a link of another user"));
    CHECK(read_file(folder.file("target/a.csv")) == "1");
    // a file that a link is replaced by is no way through it
    std::filesystem::create_symlink("target/kept.csv", folder.file("file"));
    REQUIRE(::lchown(folder.file("file").c_str(), 65534, 65534) == 0);
    CHECK_THAT(refusal<FileError>([&] { place_behind_links(folder.file("file")); }), Contains("'file' is a link of another user"));
    write_file(folder.file("file"), "6");
    CHECK(read_file(folder.file("file")) == "6");
    CHECK(read_file(folder.file("target/kept.csv")) == "precious");
}

TEST_CASE("where links lead is found as the system finds it", "[export]") {
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
    for (const char* name : {"none/", "file/", "a", "down", "whole", "slash"}) CHECK_THAT(refusal<FileError>([&] { place_behind_links(folder.file(name)); }), Contains("is a folder's name, wanted a file's"));
}
