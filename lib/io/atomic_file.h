#pragma once

#include <string>

namespace tissue {

/// Writes beside and renames: `file` appears whole or not at all, and keeps its old content on failure.
/// Throws FileError when it cannot be written.
void write_file(const std::string& file, const std::string& content);

/// As write_file, but leaves a file that already says the same untouched, so that make sees no change.
/// Returns whether it wrote.
bool write_file_if_changed(const std::string& file, const std::string& content);

/// The whole content. Throws FileError when it cannot be read.
std::string read_file(const std::string& file);

/// Moves a finished temporary over its final name, or removes it and throws FileError.
void move_into_place(const std::string& temporary, const std::string& file);

/// Fingerprint of a text, 32 hexadecimal digits (XXH3).
std::string text_hash(const std::string& content);

/// A file's fingerprint, 32 hexadecimal digits (XXH3). Throws FileError.
std::string file_hash(const std::string& file);

}  // namespace tissue
