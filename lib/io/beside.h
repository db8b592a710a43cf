#pragma once

#include <string>

#include "io/folder.h"

namespace tissue {

/// What becomes a file or a folder, made beside it under a name that is drawn: `NAME.tissue-XXXXXXXX.tmp`, never one that is there. So what
/// somebody has planted beside it, a link included, is neither followed nor taken over. Who may read and write it, the umask says.
struct Beside {
    OpenFolder folder;
    std::string place;  ///< the name there that it is to get
    std::string name;   ///< the name there that it has
    int descriptor;     ///< holds the lock that says: somebody is at work here
};

/// Also removes what a killed program has left beside: what is of such a name and of this user, and nobody holds the lock of. Throws
/// FileError, which names `place`, when nothing can be made.
Beside make_file_beside(const std::string& place);
/// In the folder is a file of its own drawn name, by which a later program knows it for left over; a folder that lacks this file and is not empty stays.
Beside make_folder_beside(const std::string& place);
/// With all that is still in it, whatever has its name by now.
void remove_folder(const Beside& made);

/// A file that is not there yet; its content is on the disk. Throws FileError, which begins with `named`.
void write_new_file(const OpenFolder& folder, const std::string& name, const std::string& named, const std::string& content);

}  // namespace tissue
