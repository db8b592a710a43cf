#include "io/beside.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <utility>

#include "error.h"

namespace tissue {
namespace {

enum class Kind { file, folder };

constexpr std::string_view before_digits = ".tissue-", ending = ".tmp";
constexpr std::size_t drawn_digits = 8;

/// Whether `name` is still the open file; a link is not.
bool is_open_as(int descriptor, const OpenFolder& folder, const std::string& name) {
    struct stat ours {}, there {};
    return ::fstat(descriptor, &ours) == 0 && ::fstatat(folder.descriptor(), name.c_str(), &there, AT_SYMLINK_NOFOLLOW) == 0 &&
           ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
}

bool locked(int descriptor, int how) { return ::flock(descriptor, how | LOCK_NB) == 0; }

/// Whether `name` is a random name made for a target named `last`. Names with a date, or of other programs, are not.
bool drawn_for(const std::string& last, const std::string& name) {
    const std::size_t digits = last.size() + before_digits.size(), end = digits + drawn_digits;
    return name.size() == end + ending.size() && name.compare(0, last.size(), last) == 0 && name.compare(last.size(), before_digits.size(), before_digits) == 0 &&
           name.find_first_not_of("0123456789abcdef", digits) == end && name.compare(end, ending.size(), ending) == 0;
}

/// Removes the content of an open folder, and then its name. Another user may have given that name to something else
/// meanwhile: only an empty folder is removed.
void remove_open_folder(int descriptor, const OpenFolder& folder, const std::string& name) {
    std::error_code error, ignored;
    for (std::filesystem::directory_iterator entry(fmt::format("/proc/self/fd/{}/", descriptor), error), end; !error && entry != end; entry.increment(error))
        if (entry->path().filename() != name) std::filesystem::remove_all(entry->path(), ignored);
    ::unlinkat(descriptor, name.c_str(), 0);  // last: by this file a later program recognises the folder
    ::unlinkat(folder.descriptor(), name.c_str(), AT_REMOVEDIR);
}

/// Whether this program made the folder: it then contains a file with the folder's name. Another user can rename a
/// folder of this user, but cannot put a file into it.
bool made_here(int descriptor, const std::string& name) {
    struct stat mark {};
    return ::fstatat(descriptor, name.c_str(), &mark, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(mark.st_mode) && mark.st_uid == ::geteuid();
}

bool mark(int descriptor, const std::string& name) {
    const int file = ::openat(descriptor, name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    return file >= 0 && ::close(file) == 0;
}

/// Removes what killed programs left: files, and folders made by this program, of this user and without a lock.
void remove_left_over(const FilePlace& place) {
    std::error_code error;
    for (std::filesystem::directory_iterator entry(place.folder.path_of(""), error), end; !error && entry != end; entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (!drawn_for(place.name, name)) continue;
        const int descriptor = ::openat(place.folder.descriptor(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (descriptor < 0) continue;
        struct stat status {};
        if (::fstat(descriptor, &status) == 0 && status.st_uid == ::geteuid() && locked(descriptor, LOCK_EX) && is_open_as(descriptor, place.folder, name)) {
            if (S_ISREG(status.st_mode)) ::unlinkat(place.folder.descriptor(), name.c_str(), 0);
            if (S_ISDIR(status.st_mode) && made_here(descriptor, name)) remove_open_folder(descriptor, place.folder, name);
            // removes only an empty folder
            if (S_ISDIR(status.st_mode)) ::unlinkat(place.folder.descriptor(), name.c_str(), AT_REMOVEDIR);
        }
        ::close(descriptor);
    }
}

std::string drawn_name(const std::string& last, const std::string& named) {
    std::uint32_t drawn = 0;
    if (::getrandom(&drawn, sizeof drawn, 0) != sizeof drawn) throw FileError(named + ": cannot write: the system returns no random numbers");
    return fmt::format("{}{}{:08x}{}", last, before_digits, drawn, ending);
}

/// Descriptor of a new file or folder, or -1. errno then is the cause; with EEXIST another name may work. The umask
/// sets the permissions.
int make(const OpenFolder& folder, const std::string& name, Kind kind) {
    if (kind == Kind::file) return ::openat(folder.descriptor(), name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (::mkdirat(folder.descriptor(), name.c_str(), 0777) != 0) return -1;
    const int descriptor = ::openat(folder.descriptor(), name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor < 0 && errno == ENOENT) errno = EEXIST;  // made, and removed again by another program as left over
    return descriptor;
}

Beside make_beside(const std::string& named, Kind kind) {
    FilePlace place = place_of(named);
    remove_left_over(place);
    for (int tries = 0; tries < 100; ++tries) {  // another program may make the same name, or remove it as left over
        const std::string name = drawn_name(place.name, named);
        const int descriptor = make(place.folder, name, kind);
        if (descriptor < 0 && errno == EEXIST) continue;
        if (descriptor < 0) throw FileError(fmt::format("{}: cannot write: {}", named, std::strerror(errno)));
        // a shared lock: the file gets its final name a moment before it is closed, and HDF5 opens no file with an
        // exclusive lock; some network disks do not support locks
        const bool ours = locked(descriptor, LOCK_SH) || errno != EWOULDBLOCK;
        const bool is_here = ours && is_open_as(descriptor, place.folder, name);
        if (is_here && (kind == Kind::file || mark(descriptor, name))) return {std::move(place.folder), place.name, name, descriptor};
        const int cause = errno;
        ::close(descriptor);
        if (kind == Kind::folder) ::unlinkat(place.folder.descriptor(), name.c_str(), AT_REMOVEDIR);
        if (is_here) throw FileError(fmt::format("{}: cannot write: {}", named, std::strerror(cause)));
    }
    throw FileError(named + ": cannot write: no free name for a temporary file in its folder");
}

}  // namespace

Beside make_file_beside(const std::string& place) { return make_beside(place, Kind::file); }

Beside make_folder_beside(const std::string& place) { return make_beside(place, Kind::folder); }

void remove_folder(const Beside& made) { remove_open_folder(made.descriptor, made.folder, made.name); }

}  // namespace tissue
