#pragma once

#include <string>

namespace tissue {

/// Why a file whose name ends in .vtp, .vtk or .vtu, in capitals or not, is not read, with what to do; empty for any other name.
/// scripts/vtk_surface converts such a file: VTK's readers are too large to be linked.
/// Apart from surface_file.cpp, which `tissuectl rim` is linked with: make solves load paths anew when that program's code changes.
std::string vtk_refusal(const std::string& file);

/// Throws FileError with vtk_refusal, where there is one.
void refuse_vtk(const std::string& file);

}  // namespace tissue
