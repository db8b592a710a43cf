#pragma once

#include <map>
#include <string>

namespace tissue {

/// What an export that is a folder holds: file names relative to it -> content.
using Files = std::map<std::string, std::string>;

/// Writes all of them into a folder of a drawn name, within theirs or, while that is not there, beside it, then moves them to their places, so
/// that a full disk leaves what was there as it was. Files of other names in the folder stay. Makes the folder where it is missing. Throws FileError.
void write_files(const std::string& folder, const Files& files);

}  // namespace tissue
