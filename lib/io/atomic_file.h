#pragma once

#include <istream>
#include <string>

#include "io/beside.h"

namespace tissue {

/// A new file under construction: a temporary file with a random name beside its target (io/beside.h), until it is
/// moved into place. If several programs make the same file at once, the last one's stays. Temporary files of killed
/// programs are removed. If the file's name is a link, hard or symbolic, the link is replaced and its target stays
/// unchanged. Throws FileError when the file cannot be written, or is a device or a pipe.
class NewFile {
   public:
    explicit NewFile(std::string file);
    ~NewFile();  ///< removes the temporary file, unless it was moved
    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    int descriptor() const { return beside_.descriptor; }  ///< of the temporary file, which is empty at first

    /// Moves the whole file to its name. The content is flushed to disk first, and the name afterwards if the disk
    /// supports it. Throws FileError; the destructor then removes the temporary file.
    void move_into_place();

   private:
    std::string file_;
    Beside beside_;
};

/// Writes a temporary file and renames it: `file` appears whole or not at all, and keeps its old content on failure.
/// Throws FileError when it cannot be written.
void write_file(const std::string& file, const std::string& content);

/// As write_file, but does not touch a file that already has this content, so that make sees no change. Returns whether
/// it wrote.
bool write_file_if_changed(const std::string& file, const std::string& content);

/// The whole content of a file, or what a pipe delivers until it ends. Throws FileError when it cannot be read, is a
/// device, or has more than 256 MiB.
std::string read_file(const std::string& file);

/// The whole content of a stream, with the same limit. named: its name in messages.
std::string read_all(std::istream& in, const std::string& named);

/// Hash of a text, 32 hexadecimal digits (XXH3, 128 bits).
std::string text_hash(const std::string& content);

/// Hash of a file of any size, equal to text_hash of its content. Throws FileError, also for a pipe, because reading it
/// would consume its content.
std::string file_hash(const std::string& file);

}  // namespace tissue
