#include "io/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>
#include <vector>

#include "error.h"

namespace tissue {
namespace {

[[noreturn]] void fail(const std::string& file, const std::string& doing) {
    throw FileError(fmt::format("{}: cannot {}: {}", file, doing, std::strerror(errno)));
}

/// Whether `name` is still the file that is open.
bool is_open_as(int descriptor, const std::string& name) {
    struct stat ours {}, there {};
    return ::fstat(descriptor, &ours) == 0 && ::stat(name.c_str(), &there) == 0 && ours.st_ino == there.st_ino &&
           ours.st_dev == there.st_dev;
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

std::string digits(const XXH128_hash_t& hash) {
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace

NewFile::NewFile(std::string file) : file_(std::move(file)), temporary_(file_ + ".tmp") {
    using std::chrono::steady_clock;
    const auto give_up = steady_clock::now() + std::chrono::seconds(60);  // a file is written in less than one
    for (;;) {
        descriptor_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
        if (descriptor_ < 0) fail(file_, "write");
        const bool taken = ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
        if (!taken && is_open_as(descriptor_, temporary_)) break;  // else the other one has moved it into place
        ::close(descriptor_);
        if (steady_clock::now() > give_up) throw FileError(file_ + ": cannot write: another program is writing it");
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    if (::ftruncate(descriptor_, 0) == 0) return;
    const int error = errno;
    ::unlink(temporary_.c_str());
    ::close(descriptor_);
    errno = error;
    fail(file_, "write");
}

NewFile::~NewFile() {
    if (descriptor_ < 0) return;
    ::unlink(temporary_.c_str());
    ::close(descriptor_);
}

void NewFile::move_into_place() {
    // else a machine that loses power may keep the name and not what it names; EINVAL: a place that has nothing to force
    if (::fsync(descriptor_) != 0 && errno != EINVAL) fail(file_, "write");
    // a network's disk refuses data when a descriptor is closed; the last one goes with the lock
    if (const int copy = ::dup(descriptor_); copy < 0 || ::close(copy) != 0) fail(file_, "write");
    if (std::rename(temporary_.c_str(), file_.c_str()) != 0) fail(file_, "write");
    ::close(descriptor_);
    descriptor_ = -1;
}

void write_file(const std::string& file, const std::string& content) {
    NewFile beside(file);
    std::size_t done = 0;
    while (done < content.size()) {
        const ssize_t n = ::write(beside.descriptor(), content.data() + done, content.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(file, "write");
        done += static_cast<std::size_t>(n);
    }
    beside.move_into_place();
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
    std::ostringstream content;
    content << in.rdbuf();
    if (in.bad()) fail(file, "read");
    return content.str();
}

std::string file_hash(const std::string& file) {
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
