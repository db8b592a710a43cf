#pragma once

#include <string>

#include "io/folder.h"

namespace tissue {

/// A temporary file or folder, made beside its target under a new random name `NAME.tissue-XXXXXXXX.tmp`. So an
/// existing file or link of another user is neither followed nor taken over. The umask sets its permissions.
struct Beside {
    OpenFolder folder;
    std::string place;  ///< name of the target in the folder
    std::string name;   ///< present name in the folder
    int descriptor;     ///< holds a lock while the temporary file or folder is in use
};

/// A temporary file beside `place`. First removes those left by killed programs: of such a name, of this user, and
/// without a lock. Throws FileError, which names `place`, when nothing can be made.
Beside make_file_beside(const std::string& place);
/// A temporary folder beside `place`. It contains a file with the folder's own name, by which a later program
/// recognises it as left over. A folder without this file is removed only if it is empty.
Beside make_folder_beside(const std::string& place);
/// Removes the folder with everything left in it, and its name if that still belongs to an empty folder.
void remove_folder(const Beside& made);

/// Writes a new file and flushes it to disk. Throws FileError, which begins with `named`, also where the file exists.
void write_new_file(const OpenFolder& folder, const std::string& name, const std::string& named, const std::string& content);

}  // namespace tissue
