#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "error.h"
#include "export/files.h"
#include "io/hdf5_store.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

struct timespec modified(const std::string& file) {
    struct stat status {};
    REQUIRE(stat(file.c_str(), &status) == 0);
    return status.st_mtim;
}

ino_t inode(const std::string& file) {
    struct stat status {};
    REQUIRE(stat(file.c_str(), &status) == 0);
    return status.st_ino;
}

/// Last file and folder that were flushed, and the error that fsync returns. The fsync below replaces the C library's
/// in the whole program.
std::atomic<ino_t> forced{0}, forced_folder{0};
std::atomic<off_t> forced_bytes{0};
std::atomic<int> disk_error{0};

}  // namespace

extern "C" int fsync(int descriptor) {
    struct stat status {};
    if (::fstat(descriptor, &status) == 0 && S_ISDIR(status.st_mode)) {
        forced_folder = status.st_ino;
    } else {
        forced = status.st_ino, forced_bytes = status.st_size;
    }
    if (disk_error != 0) return errno = disk_error, -1;
    return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

TEST_CASE("a file's content is flushed to disk; a failed flush keeps the old file") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a", "old");
    write_file(file, "whole");
    CHECK(forced == inode(file));
    CHECK(forced_bytes == 5);

    disk_error = EIO;
    CHECK_THAT(refusal<FileError>([&] { write_file(file, "newer"); }), Contains(file + ": cannot write: "));
    disk_error = EINVAL;  // as for a pipe
    CHECK_NOTHROW(write_file(folder.file("b"), "x"));
    disk_error = 0;
    CHECK(read_file(file) == "whole");
    CHECK(folder.names() == std::vector<std::string>{"a", "b"});
}

TEST_CASE("the folder is flushed to disk when a file gets its name", "[files]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a");
    forced_folder = 0;
    write_file(file, "whole");
    CHECK(forced_folder == inode(std::filesystem::path(file).parent_path()));
    forced_folder = 0;
    CHECK_FALSE(write_file_if_changed(file, "whole"));
    CHECK(forced_folder == 0);
    forced_folder = 0;
    forced_folder = 0;
    write_files(folder.file("out"), {{"a.csv", "1"}});
    CHECK(forced_folder == inode(folder.file("out")));
    forced_folder = 0;
    Hdf5Writer(folder.file("b"), "cases", {"a command", 1, {}}).commit();
    CHECK(forced_folder == inode(std::filesystem::path(file).parent_path()));
}

TEST_CASE("a written file is read back byte for byte and leaves no temporary file") {
    const TemporaryFolder folder;
    const std::string odd("zero \0 and \r\n and \xff", 19), file = folder.file("a");
    write_file(file, odd);
    CHECK(read_file(file) == odd);
    write_file(file, "");
    CHECK(read_file(file).empty());
    CHECK(folder.names() == std::vector<std::string>{"a"});
}

TEST_CASE("write_file_if_changed keeps a file of equal content with its time stamp and writes other content") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a");
    CHECK(write_file_if_changed(file, "x"));
    const auto before = modified(file);
    const ino_t which = inode(file);
    CHECK_FALSE(write_file_if_changed(file, "x"));
    CHECK(modified(file).tv_sec == before.tv_sec);
    CHECK(modified(file).tv_nsec == before.tv_nsec);
    CHECK(inode(file) == which);
    CHECK(write_file_if_changed(file, "y"));
    CHECK(read_file(file) == "y");
}

TEST_CASE("write_file makes a new inode instead of changing the old file") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a", "old");
    const ino_t which = inode(file);
    write_file(file, "new");
    CHECK(inode(file) != which);
}

TEST_CASE("a file's hash depends on its content alone") {
    const TemporaryFolder folder;
    const std::string a = file_hash(folder.file("a", "tissue"));
    CHECK(a == file_hash(folder.file("b", "tissue")));
    CHECK(a != file_hash(folder.file("c", "tissue ")));
    CHECK(a.size() == 32);
    CHECK(a.find_first_not_of("0123456789abcdef") == std::string::npos);
    CHECK(file_hash(folder.file("empty", "")) == "99aa06d3014798d86001c324468d497f");  // XXH3's published value

    std::string longer(3'000'001, '\0');
    for (std::size_t k = 0; k < longer.size(); ++k) longer[k] = static_cast<char>(k * k % 251);
    CHECK(file_hash(folder.file("longer", longer)) == text_hash(longer));
}

TEST_CASE("files above 256 MiB and devices are refused for reading") {
    const TemporaryFolder folder;
    const std::string large = folder.file("large", "");
    REQUIRE(truncate(large.c_str(), (256L << 20) + 1) == 0);  // a sparse file
    CHECK_THAT(refusal<FileError>([&] { read_file(large); }), Contains("large: has 268435457 bytes; at most 268435456 are read"));
    CHECK_THAT(refusal<FileError>([] { read_file("/dev/zero"); }), Contains("/dev/zero: is a device, not a file"));
    CHECK_THAT(refusal<FileError>([] { file_hash("/dev/zero"); }), Contains("/dev/zero: is a device, not a file"));
}

TEST_CASE("a failed read or write is reported with the file's name and leaves no temporary file") {
    const TemporaryFolder folder;
    CHECK_THAT(refusal<FileError>([&] { write_file(folder.file("none/a"), "x"); }),
               Contains("none/a") && Contains("No such file"));
    CHECK_THAT(refusal<FileError>([&] { read_file(folder.file("none")); }), Contains("none") && Contains("No such file"));
    CHECK_THAT(refusal<FileError>([&] { read_file(folder.file("")); }), Contains("folder"));
    CHECK_THROWS_AS(file_hash(folder.file("none")), FileError);
    CHECK(folder.names().empty());
}

TEST_CASE("a file that cannot get its final name leaves no temporary file") {
    const TemporaryFolder folder;
    REQUIRE(mkdir(folder.file("a").c_str(), 0755) == 0);
    CHECK_THAT(refusal<FileError>([&] { write_file(folder.file("a"), "x"); }), Contains("/a"));
    CHECK(folder.names() == std::vector<std::string>{"a"});
}

TEST_CASE("several writers of one file leave whole content at all times and no temporary file") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a", std::string(100000, '0'));
    std::atomic<int> refused{0};
    std::vector<std::thread> writers;
    for (const char letter : {'1', '2', '3', '4'})
        writers.emplace_back([&, letter] {
            for (int k = 0; k < 50; ++k) try {
                    write_file(file, std::string(100000 + static_cast<std::size_t>(letter), letter));
                } catch (const FileError&) {
                    ++refused;
                }
        });
    int mixed = 0;
    for (int k = 0; k < 200; ++k) {
        const std::string seen = read_file(file);
        mixed += seen.size() < 100000 || seen.find_first_not_of(seen[0]) != std::string::npos;
    }
    for (std::thread& writer : writers) writer.join();
    CHECK(mixed == 0);
    CHECK(refused == 0);
    CHECK(folder.names() == std::vector<std::string>{"a"});
}

TEST_CASE("a writer removes temporary files of killed writers and keeps those in use") {
    const TemporaryFolder folder;
    folder.file("a.tissue-0123abcd.tmp", "of a killed one");
    folder.file("a.tmp", "of the user's own");
    folder.file("a.20251125.tmp", "of the user's own, with a date");
    folder.file("ba.tissue-0123abcd.tmp", "of another file");
    {
        NewFile other(folder.file("a"));
        write_file(folder.file("a"), "short");
        CHECK(read_file(folder.file("a")) == "short");
        CHECK(folder.names().size() == 5);
        other.move_into_place();
        CHECK(read_file(folder.file("a")).empty());
    }
    CHECK(folder.names() == std::vector<std::string>{"a", "a.20251125.tmp", "a.tmp", "ba.tissue-0123abcd.tmp"});
}

TEST_CASE("a user's folder with a temporary name stays; temporary folders of killed programs are removed", "[files]") {
    const TemporaryFolder folder;
    write_files(folder.file("a.tissue-0123abcd.tmp"), {{"chapters/one.txt", "of the user's own"}});
    write_files(folder.file("a.tissue-89abcdef.tmp"), {{"a.tissue-89abcdef.tmp", ""}, {"half.csv", "of a killed one"}});
    write_file(folder.file("a"), "short");
    // empty, of a program killed just after making it
    std::filesystem::create_directory(folder.file("a.tissue-00000000.tmp"));
    write_file(folder.file("a"), "shorter");
    CHECK(folder.names() == std::vector<std::string>{"a", "a.tissue-0123abcd.tmp"});
    CHECK(read_file(folder.file("a.tissue-0123abcd.tmp/chapters/one.txt")) == "of the user's own");
}

TEST_CASE("remove_folder empties the folder that was made and not another one that has its name now", "[files]") {
    const TemporaryFolder folder;
    const Beside made = make_folder_beside(folder.file("a"));
    const OpenFolder within(made.folder, made.name, "a");
    write_new_file(within, "half.csv", "half.csv", "of the program");
    CHECK(folder.names() == std::vector<std::string>{made.name});
    std::filesystem::rename(folder.file(made.name), folder.file("elsewhere"));
    write_files(folder.file(made.name), {{"thesis.tex", "of the user's own"}});
    remove_folder(made);
    ::close(made.descriptor);
    CHECK(read_file(folder.file(made.name + "/thesis.tex")) == "of the user's own");
    CHECK(std::filesystem::is_empty(folder.file("elsewhere")));
}

TEST_CASE("a temporary file in use permits a shared lock as of HDF5 and no exclusive lock") {
    const TemporaryFolder folder;
    NewFile writer(folder.file("a"));
    REQUIRE(folder.names().size() == 1);
    const int reader = ::open(folder.file(folder.names()[0]).c_str(), O_RDONLY | O_CLOEXEC);
    REQUIRE(reader >= 0);
    CHECK(::flock(reader, LOCK_SH | LOCK_NB) == 0);  // the lock that HDF5 requests without waiting
    CHECK(::flock(reader, LOCK_EX | LOCK_NB) != 0);
    ::close(reader);
}

TEST_CASE("a symbolic link at a temporary name is not followed and its target is unchanged") {
    const TemporaryFolder folder;
    const std::string own = folder.file("own", "precious");
    for (const char* planted : {"a.tmp", "a.tissue-0123abcd.tmp"}) REQUIRE(symlink(own.c_str(), folder.file(planted).c_str()) == 0);
    write_file(folder.file("a"), "a foreign content");
    CHECK(read_file(own) == "precious");
    CHECK(read_file(folder.file("a")) == "a foreign content");
    CHECK(std::filesystem::is_symlink(folder.file("a.tmp")));
    { const Hdf5Writer store(folder.file("a"), "model", {}); }
    CHECK(read_file(own) == "precious");
}

TEST_CASE("a result that is a symbolic or hard link is replaced and its target is unchanged") {
    const TemporaryFolder folder;
    const std::string own = folder.file("own", "precious"), linked = folder.file("linked"), also = folder.file("also");
    REQUIRE(symlink(own.c_str(), linked.c_str()) == 0);
    REQUIRE(link(own.c_str(), also.c_str()) == 0);
    for (const std::string& file : {linked, also}) {
        write_file(file, "new");
        CHECK(read_file(file) == "new");
        CHECK_FALSE(std::filesystem::is_symlink(file));
    }
    CHECK(read_file(own) == "precious");
}

TEST_CASE("writing to a device or a pipe is refused and leaves it unchanged") {
    const TemporaryFolder folder;
    const std::string pipe = folder.file("pipe"), led = folder.file("led");
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    REQUIRE(symlink("/dev/null", led.c_str()) == 0);
    for (const std::string& file : {pipe, led, std::string("/dev/stdout")})
        CHECK_THAT(refusal<FileError>([&] { write_file(file, "x"); }), Contains(file + ": is a device or a pipe; give a file"));
    CHECK(std::filesystem::is_fifo(pipe));
    CHECK(std::filesystem::is_symlink(led));
    CHECK(folder.names() == std::vector<std::string>{"led", "pipe"});
}

TEST_CASE("the permissions of a new file follow the umask") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a");
    const mode_t before = umask(0);
    for (const auto& [mask, wanted] : {std::pair<mode_t, mode_t>{002, 0664}, {022, 0644}, {077, 0600}}) {
        umask(mask);
        write_file(file, "x");
        struct stat status {};
        REQUIRE(stat(file.c_str(), &status) == 0);
        CHECK((status.st_mode & 0777) == wanted);
    }
    umask(before);
}
