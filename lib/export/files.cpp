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

/// A temporary folder beside another. Its destructor removes it with everything left in it.
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
    std::map<std::string, std::vector<std::pair<std::string, const std::string*>>> within;  // folder -> its files
    for (const auto& [name, content] : files) {
        const fs::path path(name);  // names come from files of unknown origin
        if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
            throw FileError(folder + ": the name '" + name + "' leads out of this folder");
        within[path.parent_path().string()].emplace_back(path.filename().string(), &content);
    }
    fs::path place(folder);
    if (!place.has_filename()) place = place.parent_path();  // "out/"
    std::error_code error;
    const bool is_there = fs::is_directory(place, error);
    if (!is_there && fs::exists(place, error)) throw FileError(folder + ": is a file; give a folder");
    const OpenFolder parent(is_there ? place.string() : place.parent_path().string(), folder, Missing::make);
    // an existing folder gets the temporary one inside: it may be on another disk, and its parent may not be writable
    const OwnFolder own(is_there ? (place / "export").string() : place.string());
    const OpenFolder beside(own.folder, own.name, folder);
    for (const auto& [path, all] : within) {
        const OpenFolder from(beside, path, folder, Missing::make);
        for (const auto& [name, content] : all) write_new_file(from, name, (place / path / name).string(), *content);
    }
    const OpenFolder to(place.string(), folder, Missing::make);
    // make all folders before any file is replaced
    for (const auto& one : within) OpenFolder(to, one.first, folder, Missing::make);
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
