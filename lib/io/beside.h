#pragma once

#include <string>

namespace tissue {

/// What becomes a file or a folder, made beside it under a name that is drawn: `NAME.tissue-XXXXXXXX.tmp`, never one that is there. So what
/// somebody has planted beside it, a link included, is neither followed nor taken over. Who may read and write it, the umask says.
struct Beside {
    std::string name;
    int descriptor;  ///< holds the lock that says: somebody is at work here
};

/// Also removes what a killed program has left beside: what is of such a name and of this user, and nobody holds the lock of. Throws
/// FileError, which names `place`, when nothing can be made.
Beside make_file_beside(const std::string& place);
Beside make_folder_beside(const std::string& place);

/// A file that is not there yet, in a folder that is this program's alone; its content is on the disk. Throws FileError.
void write_new_file(const std::string& file, const std::string& content);

/// Forces a folder's names onto the disk, after a rename: else a machine that loses power may come back with the old file. A failure is no error:
/// content and names are whole either way, not every disk can do it, and a folder that may not be read cannot be asked.
void keep_names(const std::string& folder) noexcept;

}  // namespace tissue
