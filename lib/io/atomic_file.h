#pragma once

#include <istream>
#include <string>

#include "io/beside.h"

namespace tissue {

/// A file in the making: a temporary one beside it, of a drawn name (io/beside.h), until it is moved into place. Of programs
/// that make the same file at once the last one's stays; what a killed one left is removed. A link of the file's name, hard or symbolic, is
/// replaced, and what it leads to stays as it is. Throws FileError when it cannot be written, or is a device or a pipe.
class NewFile {
   public:
    explicit NewFile(std::string file);
    ~NewFile();  ///< removes the temporary one, unless it was moved
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    int descriptor() const { return beside_.descriptor; }  ///< of the temporary file, which is empty at first

    /// The file appears, whole, and its content is on the disk before its name, which is there, too, as far as the disk can. Throws FileError, and
    /// leaves nothing beside.
    void move_into_place();

   private:
    std::string file_;
    Beside beside_;
};

/// Writes beside and renames: `file` appears whole or not at all, and keeps its old content on failure.
/// Throws FileError when it cannot be written.
void write_file(const std::string& file, const std::string& content);

/// As write_file, but leaves a file that already says the same untouched, so that make sees no change.
/// Returns whether it wrote.
bool write_file_if_changed(const std::string& file, const std::string& content);

/// The whole content of a text, or what a pipe gives until it ends. Throws FileError when it cannot be read, is a device, or has more than 256 MiB.
std::string read_file(const std::string& file);

/// The same of what comes in; named: in messages.
std::string read_all(std::istream& in, const std::string& named);

/// Fingerprint of a text, 32 hexadecimal digits (XXH3).
std::string text_hash(const std::string& content);

/// A file's fingerprint, that of its content as text_hash has it, of any size. Throws FileError, of a pipe, too, which would have given its content away.
std::string file_hash(const std::string& file);

}  // namespace tissue
