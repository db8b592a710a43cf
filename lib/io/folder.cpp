#include "io/folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <deque>
#include <memory>
#include <sstream>
#include <utility>

#include "error.h"

namespace tissue {
namespace {

constexpr int most_links = 40;  // the limit of the Linux kernel

enum class Last { folder, file, file_behind_links };

void prepend(std::deque<std::string>& parts, const std::string& path) {
    std::istringstream in(path);
    std::deque<std::string> first;
    for (std::string part; std::getline(in, part, '/');)
        if (!part.empty()) first.push_back(part);
    parts.insert(parts.begin(), first.begin(), first.end());
}

/// The descriptor that an entry of /proc/self/fd stands for; -1: it is not such an entry.
int descriptor_named(int folder, const std::string& name) {
    struct stat here {}, own {};
    if (::fstat(folder, &here) != 0 || ::stat("/proc/self/fd", &own) != 0 || here.st_dev != own.st_dev || here.st_ino != own.st_ino) return -1;
    int descriptor = -1;
    std::from_chars(name.data(), name.data() + name.size(), descriptor);
    return descriptor;
}

OpenFolder begin(int from, const std::string& path) {
    return OpenFolder(::openat(from, path[0] == '/' ? "/" : ".", O_PATH | O_DIRECTORY | O_CLOEXEC));
}

/// Walks along a path, part by part, and checks every link before following it.
OpenPlace walk(int from, const std::string& path, const std::string& named, OpenFolder::Missing missing, Last end) {
    const auto fail = [&](const std::string& why) { throw FileError(fmt::format("{}: cannot write: {}", named, why)); };
    const auto is_folder = [&] { return FileError(named + ": is the name of a folder; give that of a file"); };
    if (end == Last::file_behind_links && !path.empty() && path.back() == '/') throw is_folder();
    std::deque<std::string> left;
    prepend(left, path);
    auto at = std::make_unique<OpenFolder>(begin(from, path));
    const auto arrived = [&](const std::string& name, int is_open_as = -1) { return OpenPlace{{std::move(*at), name}, is_open_as}; };
    for (int links = 0;;) {
        if (at->descriptor() < 0) fail(std::strerror(errno));
        if (left.empty()) break;
        const std::string part = left.front();
        left.pop_front();
        const bool last = left.empty() && end != Last::folder;
        if (last && end == Last::file) return arrived(part);
        const auto open_part = [&] { return std::make_unique<OpenFolder>(::openat(at->descriptor(), part.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC)); };
        auto next = open_part();
        if (next->descriptor() < 0 && errno == ENOENT) {
            if (last) return arrived(part);
            if (missing == OpenFolder::Missing::make) {
                if (::mkdirat(at->descriptor(), part.c_str(), 0777) != 0 && errno != EEXIST) fail(std::strerror(errno));
                next = open_part();
            }
        }
        struct stat status {};
        if (next->descriptor() < 0 || ::fstat(next->descriptor(), &status) != 0) fail(std::strerror(errno));
        if (!S_ISLNK(status.st_mode)) {
            if (last && S_ISDIR(status.st_mode)) throw is_folder();
            if (last) return arrived(part);
            if (!S_ISDIR(status.st_mode)) fail(std::strerror(ENOTDIR));
            at = std::move(next);
            continue;
        }
        if (status.st_uid != ::geteuid() && status.st_uid != 0) fail(fmt::format("'{}' is a link of another user, which is not followed: give the path of its target", part));
        if (const int open = descriptor_named(at->descriptor(), part); last && open >= 0) return arrived(part, open);
        if (++links > most_links) fail(std::strerror(ELOOP));
        std::string target(4096, '\0');
        const ssize_t length = ::readlinkat(next->descriptor(), "", target.data(), target.size());
        if (length <= 0) fail(std::strerror(errno));
        target.resize(static_cast<std::size_t>(length));
        if (last && target.back() == '/') throw is_folder();
        prepend(left, target);
        if (target[0] == '/') at = std::make_unique<OpenFolder>(begin(AT_FDCWD, target));
    }
    if (end != Last::folder && path.empty()) fail(std::strerror(ENOENT));
    if (end != Last::folder) throw is_folder();  // "/", or a link to it
    return arrived("");
}

}  // namespace

OpenFolder::OpenFolder(const std::string& path, const std::string& named, Missing missing) : OpenFolder(std::move(walk(AT_FDCWD, path, named, missing, Last::folder).folder)) {}

OpenFolder::OpenFolder(const OpenFolder& from, const std::string& path, const std::string& named, Missing missing)
    : OpenFolder(std::move(walk(from.descriptor(), path, named, missing, Last::folder).folder)) {}

OpenFolder::~OpenFolder() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

std::string OpenFolder::path_of(const std::string& name) const { return fmt::format("/proc/self/fd/{}/{}", descriptor_, name); }

void OpenFolder::keep_names() const noexcept {
    const int readable = ::openat(descriptor_, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (readable < 0) return;
    ::fsync(readable);
    ::close(readable);
}

FilePlace place_of(const std::string& file) { return walk(AT_FDCWD, file, file, OpenFolder::Missing::refuse, Last::file); }

OpenPlace place_behind_links(const std::string& file) { return walk(AT_FDCWD, file, file, OpenFolder::Missing::refuse, Last::file_behind_links); }

}  // namespace tissue
