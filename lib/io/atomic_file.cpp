#include "io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "error.h"

namespace tissue {
namespace {

[[noreturn]] void fail(const std::string& file, const std::string& doing) {
    throw FileError(fmt::format("{}: cannot {}: {}", file, doing, std::strerror(errno)));
}

}  // namespace

void move_into_place(const std::string& temporary, const std::string& file) {
    if (std::rename(temporary.c_str(), file.c_str()) == 0) return;
    const int error = errno;
    ::unlink(temporary.c_str());
    errno = error;
    fail(file, "write");
}

void write_file(const std::string& file, const std::string& content) {
    const std::string temporary = file + ".tmp";
    const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (fd < 0) fail(file, "write");
    std::size_t done = 0;
    while (done < content.size()) {
        const ssize_t n = ::write(fd, content.data() + done, content.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) break;
        done += static_cast<std::size_t>(n);
    }
    int error = done < content.size() ? errno : 0;
    if (::close(fd) != 0 && error == 0) error = errno;
    if (error != 0) {
        ::unlink(temporary.c_str());
        errno = error;
        fail(file, "write");
    }
    move_into_place(temporary, file);
}

bool write_file_if_changed(const std::string& file, const std::string& content) {
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error) && read_file(file) == content) return false;
    write_file(file, content);
    return true;
}

std::string read_file(const std::string& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) throw FileError(file + ": is a folder, not a file");
    std::ifstream in(file, std::ios::binary);
    if (!in) fail(file, "read");
    std::ostringstream content;
    content << in.rdbuf();
    if (in.bad()) fail(file, "read");
    return content.str();
}

std::string file_hash(const std::string& file) {
    return text_hash(read_file(file));
}

std::string text_hash(const std::string& content) {
    const XXH128_hash_t hash = XXH3_128bits(content.data(), content.size());
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace tissue
