#include "io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include "error.h"

namespace tissue {
namespace {

[[noreturn]] void fail(const std::string& file, const std::string& doing) {
    throw FileError(fmt::format("{}: cannot {}: {}", file, doing, std::strerror(errno)));
}

constexpr std::uintmax_t largest_text = 256 << 20;

std::ifstream opened(const std::string& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) throw FileError(file + ": is a folder, not a file");
    if (std::filesystem::is_character_file(file, error)) throw FileError(file + ": is a device, not a file");
    std::ifstream in(file, std::ios::binary);
    if (!in) fail(file, "read");
    return in;
}

void write_all(int descriptor, const std::string& file, const std::string& content) {
    std::size_t done = 0;
    while (done < content.size()) {
        const ssize_t n = ::write(descriptor, content.data() + done, content.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(file, "write");
        done += static_cast<std::size_t>(n);
    }
}

/// Flushes the written content to disk.
void keep(int descriptor, const std::string& file) {
    // without this a power failure may leave the name without its content; EINVAL: the file cannot be flushed
    if (::fsync(descriptor) != 0 && errno != EINVAL) fail(file, "write");
    // a network disk reports refused data when a descriptor is closed
    if (const int copy = ::dup(descriptor); copy < 0 || ::close(copy) != 0) fail(file, "write");
}

Beside beside(const std::string& file) {
    // a new file would replace a device, a pipe, or the link /dev/stdout, which root is allowed to do
    struct stat there {};
    const bool special = ::stat(file.c_str(), &there) == 0 && !S_ISREG(there.st_mode) && !S_ISDIR(there.st_mode);
    if (special || file.rfind("/dev/std", 0) == 0 || file.rfind("/dev/fd/", 0) == 0) throw FileError(file + ": is a device or a pipe; give a file");
    if (!file.empty() && file.back() == '/') throw FileError(file + ": is the name of a folder; give that of a file");
    return make_file_beside(file);
}

std::string digits(const XXH128_hash_t& hash) {
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace

NewFile::NewFile(std::string file) : file_(std::move(file)), beside_(beside(file_)) {}

NewFile::~NewFile() {
    if (beside_.descriptor < 0) return;
    ::unlinkat(beside_.folder.descriptor(), beside_.name.c_str(), 0);
    ::close(beside_.descriptor);
}

void NewFile::move_into_place() {
    keep(beside_.descriptor, file_);
    const int folder = beside_.folder.descriptor();
    if (::renameat(folder, beside_.name.c_str(), folder, beside_.place.c_str()) != 0) fail(file_, "write");
    ::close(std::exchange(beside_.descriptor, -1));
    beside_.folder.keep_names();
}

void write_file(const std::string& file, const std::string& content) {
    NewFile beside(file);
    write_all(beside.descriptor(), file, content);
    beside.move_into_place();
}

void write_new_file(const OpenFolder& folder, const std::string& name, const std::string& named, const std::string& content) {
    const int descriptor = ::openat(folder.descriptor(), name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor < 0) fail(named, "write");
    const std::unique_ptr<const int, void (*)(const int*)> closed(&descriptor, [](const int* d) { ::close(*d); });
    write_all(descriptor, named, content);
    keep(descriptor, named);
}

bool write_file_if_changed(const std::string& file, const std::string& content) {
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error) && read_file(file) == content) return false;
    write_file(file, content);
    return true;
}

std::string read_file(const std::string& file) {
    std::ifstream in = opened(file);
    std::error_code error;
    if (const auto size = std::filesystem::file_size(file, error); !error && size > largest_text)
        throw FileError(fmt::format("{}: has {} bytes; at most {} are read", file, size, largest_text));
    errno = 0;
    return read_all(in, file);
}

std::string read_all(std::istream& in, const std::string& named) {
    std::string content;
    std::vector<char> piece(1 << 16);
    while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())) || in.gcount() > 0) {
        content.append(piece.data(), static_cast<std::size_t>(in.gcount()));
        if (content.size() > largest_text) throw FileError(fmt::format("{}: has more than {} bytes; this is the most that is read", named, largest_text));
    }
    if (in.bad()) fail(named, "read");
    return content;
}

std::string file_hash(const std::string& file) {
    std::error_code error;
    if (std::filesystem::is_fifo(file, error)) throw FileError(file + ": is a pipe; give a file, because it is read twice");
    std::ifstream in = opened(file);
    const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), XXH3_freeState);
    XXH3_128bits_reset(state.get());
    std::vector<char> piece(1 << 20);
    while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())) || in.gcount() > 0)
        XXH3_128bits_update(state.get(), piece.data(), static_cast<std::size_t>(in.gcount()));
    if (in.bad()) fail(file, "read");
    return digits(XXH3_128bits_digest(state.get()));
}

std::string text_hash(const std::string& content) {
    return digits(XXH3_128bits(content.data(), content.size()));
}

}  // namespace tissue
