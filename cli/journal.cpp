#include "journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "error.h"
#include "io/folder.h"

namespace tissue::cli {
namespace {

std::string header(int dimension) {
    std::string names;
    for (const char* what : {"contact", "displacement", "force"})
        for (int d = 0; d < dimension; ++d) names += fmt::format("{}{}_{} [{}]", names.empty() ? "" : ",", what, "xyz"[d], what[0] == 'f' ? "N" : "m");
    return names + '\n';
}

/// Why a file may not be overwritten; empty when it is empty, or a journal without rows.
std::string in_the_way(int descriptor) {
    std::ifstream in(fmt::format("/proc/self/fd/{}", descriptor));
    std::string begins(header(3).size() + 1, '\0');
    in.read(begins.data(), static_cast<std::streamsize>(begins.size()));
    begins.resize(static_cast<std::size_t>(in.gcount()));
    if (begins.empty() && in.eof()) return {};
    for (int dimension : {2, 3}) {
        const std::string first = header(dimension);
        if (begins == first) return {};
        if (begins.compare(0, first.size(), first) == 0) return "has measurements of an earlier session";
    }
    return in.bad() || begins.empty() ? "cannot be read" : "exists and is not a journal";
}

}  // namespace

Journal::Journal(const std::string& file, int dimension) : file_(file) {
    if (file.empty()) return;
    const auto refuse = [&](const std::string& why) {
        if (out_ >= 0) ::close(out_);
        throw FileError(fmt::format("{}: {}", file_, why));
    };
    const OpenPlace place = place_behind_links(file);
    // an open descriptor shares its position with other writers
    shared_ = place.is_open_as >= 0;
    out_ = shared_ ? ::fcntl(place.is_open_as, F_DUPFD_CLOEXEC, 0)
                                 : ::openat(place.folder.descriptor(), place.name.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (out_ < 0) refuse(fmt::format("cannot be written: {}", std::strerror(errno)));
    struct stat is {};
    if (!shared_ && ::fstat(out_, &is) == 0 && S_ISREG(is.st_mode)) {  // a pipe has neither rows nor an end
        if (::flock(out_, LOCK_EX | LOCK_NB) != 0) refuse(errno == EWOULDBLOCK ? "another session is writing it" : fmt::format("cannot be locked: {}", std::strerror(errno)));
        if (is.st_nlink > 1) refuse("is a file with several hard links: name another file, or remove it");
        if (const std::string why = in_the_way(out_); !why.empty()) refuse(why + ": name another file, or remove it");
        if (::ftruncate(out_, 0) != 0) refuse(fmt::format("cannot be written: {}", std::strerror(errno)));
    }
    if (!write(header(dimension))) refuse("cannot be written");
}

Journal::~Journal() {
    if (out_ >= 0) ::close(out_);
}

/// Writes the whole line or nothing, because a cut row would be read as another measurement. A file that others write
/// to is never truncated.
bool Journal::write(const std::string& line) {
    const off_t begin = ::lseek(out_, 0, SEEK_CUR);
    for (std::size_t done = 0; done < line.size();) {
        const ssize_t n = ::write(out_, line.data() + done, line.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            if (!shared_ && begin >= 0 && ::ftruncate(out_, begin) == 0) ::lseek(out_, begin, SEEK_SET);
            return false;
        }
        done += static_cast<std::size_t>(n);
    }
    return true;
}

void Journal::add(const Learner::Line& line) {
    if (out_ < 0 || !whole_) return;
    std::string row;
    for (const Point& p : {line.poke.contact_m, line.poke.push_m, line.poke.force_N})
        // the shortest text that reads back to the same double
        for (double v : p) row += fmt::format("{}{}", row.empty() ? "" : ",", v);
    whole_ = write(row + '\n');
}

void Journal::close() {
    if (out_ < 0) return;
    if (::close(std::exchange(out_, -1)) != 0) whole_ = false;
    if (!whole_) throw FileError(file_ + ": could not be written completely: measurements are missing");
}

}  // namespace tissue::cli
