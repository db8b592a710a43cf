#include "export/files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <vector>

#include "error.h"
#include "io/beside.h"

namespace tissue {
namespace {

/// A folder beside another, which goes with all that is still in it.
struct OwnFolder : Beside {
    explicit OwnFolder(const std::string& beside) : Beside(make_folder_beside(beside)) {}
    ~OwnFolder() {
        remove_folder(*this);
        ::close(descriptor);
    }
    OwnFolder(const OwnFolder&) = delete;
    OwnFolder& operator=(const OwnFolder&) = delete;
};

}  // namespace

void write_files(const std::string& folder, const Files& files) {
    namespace fs = std::filesystem;
    using Missing = OpenFolder::Missing;
    std::map<std::string, std::vector<std::pair<std::string, const std::string*>>> within;  // of each folder, what is in it
    for (const auto& [name, content] : files) {
        const fs::path path(name);  // names come out of files that anyone may have written
        if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
            throw FileError(folder + ": the name '" + name + "' leads out of it");
        within[path.parent_path().string()].emplace_back(path.filename().string(), &content);
    }
    fs::path place(folder);
    if (!place.has_filename()) place = place.parent_path();  // "out/"
    std::error_code error;
    const bool is_there = fs::is_directory(place, error);
    if (!is_there && fs::exists(place, error)) throw FileError(folder + ": is a file, wanted a folder");
    const OpenFolder parent(is_there ? place.string() : place.parent_path().string(), folder, Missing::make);
    // where the folder is there, within it: it may be another disk's, and its parent may be nobody's to write to
    const OwnFolder own(is_there ? (place / "export").string() : place.string());
    const OpenFolder beside(own.folder, own.name, folder);
    for (const auto& [path, all] : within) {
        const OpenFolder from(beside, path, folder, Missing::make);
        for (const auto& [name, content] : all) write_new_file(from, name, (place / path / name).string(), *content);
    }
    const OpenFolder to(place.string(), folder, Missing::make);
    for (const auto& one : within) OpenFolder(to, one.first, folder, Missing::make);  // all, before a file is replaced
    for (const auto& [path, all] : within) {
        const OpenFolder from(beside, path, folder), into(to, path, folder);
        for (const auto& [name, content] : all)
            if (::renameat(from.descriptor(), name.c_str(), into.descriptor(), name.c_str()) != 0)
                throw FileError(fmt::format("{}: cannot write: {}", folder, std::strerror(errno)));
        into.keep_names();
    }
    own.folder.keep_names();
    to.keep_names();
}

}  // namespace tissue
