#include "surface_file/vtk_file.h"

#include <fmt/format.h>

#include <string_view>

#include "error.h"
#include "surface_file/text_lines.h"

namespace tissue {

std::string vtk_refusal(const std::string& file) {
    constexpr std::size_t length = 4;  // length of an ending
    if (file.size() <= length) return "";
    const std::string_view ending = std::string_view(file).substr(file.size() - length);
    const std::string stem = file.substr(0, file.size() - length);
    if (surface_file::is_word(ending, ".vtp") || surface_file::is_word(ending, ".vtk"))
        return fmt::format("{0}: is a VTK surface; convert it first: scripts/vtk_surface {0} {1}.obj", file, stem);
    if (surface_file::is_word(ending, ".vtu"))
        return fmt::format("{0}: is an unstructured grid: save its surface as {1}.vtp (ParaView: Extract Surface) and convert that: scripts/vtk_surface {1}.vtp {1}.obj; or give its tetrahedra as a .msh", file, stem);
    return "";
}

void refuse_vtk(const std::string& file) {
    if (const std::string why = vtk_refusal(file); !why.empty()) throw FileError(why);
}

}  // namespace tissue
