#include "export/files.h"

#include <filesystem>

#include "error.h"
#include "io/atomic_file.h"

namespace tissue {

void write_files(const std::string& folder, const Files& files) {
    namespace fs = std::filesystem;
    const fs::path place(folder),
        beside(place.has_filename() ? folder + ".tmp" : place.parent_path().string() + ".tmp");
    try {
        if (fs::exists(place) && !fs::is_directory(place)) throw FileError(folder + ": is a file, wanted a folder");
        fs::remove_all(beside);
        for (const auto& [name, content] : files) {
            // names come out of files that anyone may have written
            if (const std::string first = fs::path(name).lexically_normal().begin()->string();
                first == ".." || first == "/")
                throw FileError(folder + ": the name '" + name + "' leads out of it");
            fs::create_directories((beside / name).parent_path());
            write_file((beside / name).string(), content);
        }
        for (const auto& [name, content] : files) {
            fs::create_directories((place / name).parent_path());
            fs::rename(beside / name, place / name);
        }
        fs::remove_all(beside);
    } catch (const fs::filesystem_error& e) {
        std::error_code ignored;
        fs::remove_all(beside, ignored);
        throw FileError(folder + ": cannot write: " + e.code().message());
    } catch (...) {
        std::error_code ignored;
        fs::remove_all(beside, ignored);
        throw;
    }
}

}  // namespace tissue
