#pragma once

#include <map>
#include <string>

namespace tissue {

/// The files of an export that is a folder: name relative to the folder -> content.
using Files = std::map<std::string, std::string>;

/// Writes all files into a temporary folder with a random name, then moves them to their places, so that a full disk
/// leaves the previous files unchanged. The temporary folder is inside `folder`, or beside it if `folder` does not
/// exist yet. Makes `folder` where it is missing; files of other names in it stay. Throws FileError, also for a name
/// that leads out of the folder.
void write_files(const std::string& folder, const Files& files);

}  // namespace tissue
