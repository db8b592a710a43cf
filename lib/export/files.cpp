#include "export/files.h"

#include <unistd.h>

#include <filesystem>
#include <set>

#include "error.h"
#include "io/beside.h"

namespace tissue {
namespace {

/// A folder beside another, which goes with all that is still in it.
struct OwnFolder : Beside {
    explicit OwnFolder(const std::string& place) : Beside(make_folder_beside(place)) {}
    ~OwnFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(name, ignored);
        ::close(descriptor);
    }
    OwnFolder(const OwnFolder&) = delete;
    OwnFolder& operator=(const OwnFolder&) = delete;
};

}  // namespace

void write_files(const std::string& folder, const Files& files) {
    namespace fs = std::filesystem;
    const fs::path place(folder);
    try {
        if (fs::exists(place) && !fs::is_directory(place)) throw FileError(folder + ": is a file, wanted a folder");
        if (place.has_parent_path()) fs::create_directories(place.has_filename() ? place.parent_path() : place.parent_path().parent_path());
        // where the folder is there, within it: it may be another disk's, and its parent may be nobody's to write to
        const OwnFolder made(fs::is_directory(place) ? (place / "export").string() : folder);
        const fs::path beside(made.name);
        for (const auto& [name, content] : files) {
            // names come out of files that anyone may have written
            if (const std::string first = fs::path(name).lexically_normal().begin()->string();
                first == ".." || first == "/")
                throw FileError(folder + ": the name '" + name + "' leads out of it");
            fs::create_directories((beside / name).parent_path());
            write_new_file((beside / name).string(), content);
        }
        for (const auto& file : files) fs::create_directories((place / file.first).parent_path());  // all, before one is replaced
        for (const auto& file : files) fs::rename(beside / file.first, place / file.first);
        std::set<fs::path> folders{fs::absolute(place).parent_path()};
        for (const auto& file : files) folders.insert((place / file.first).parent_path());
        for (const fs::path& one : folders) keep_names(one.string());
    } catch (const fs::filesystem_error& e) {
        throw FileError(folder + ": cannot write: " + e.code().message());
    }
}

}  // namespace tissue
