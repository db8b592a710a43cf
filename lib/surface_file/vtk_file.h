#pragma once

#include <string>

namespace tissue {

/// Message for a file whose name ends in .vtp, .vtk or .vtu, in any case: it is not read, and what to do instead. Empty
/// for any other name. scripts/vtk_surface converts such a file, because VTK's readers are too large to link. These
/// functions are not in surface_file.cpp, because `tissuectl rim` is linked with it, and make solves all load paths
/// again when that program's code changes.
std::string vtk_refusal(const std::string& file);

/// Throws FileError with the message of vtk_refusal, unless it is empty.
void refuse_vtk(const std::string& file);

}  // namespace tissue
