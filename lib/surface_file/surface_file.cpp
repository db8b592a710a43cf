#include "surface_file/surface_file.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "error.h"
#include "io/atomic_file.h"
#include "surface_file/facets.h"
#include "surface_file/text_lines.h"

namespace tissue {
namespace {

using namespace surface_file;

struct Kind {
    std::string_view ending;
    Facets (*read)(const std::string& file, std::string_view content);
};
constexpr std::array<Kind, 5> kinds{{{".stl", read_stl}, {".obj", read_obj}, {".ply", read_ply}, {".off", read_off}, {".glb", read_glb}}};

const Kind* kind_of(const std::string& file) {
    for (const Kind& kind : kinds)
        if (file.size() > kind.ending.size() && is_word(std::string_view(file).substr(file.size() - kind.ending.size()), kind.ending)) return &kind;
    return nullptr;
}

}  // namespace

bool is_surface_file(const std::string& file) { return kind_of(file) != nullptr; }

MshFile read_surface_file(const std::string& file) {
    const Kind* kind = kind_of(file);
    if (kind == nullptr) throw FileError(fmt::format("{}: is not a surface file; its name must end in {}", file, surface_endings));
    return kind->read(file, read_file(file)).mesh();
}

MshFile read_surface_or_msh(const std::string& file, const std::string& named) { return is_surface_file(file) ? read_surface_file(file) : read_msh(file, true, named); }

MshFile read_other_surface(const std::string& file) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error)) throw FileError("there is no file " + file);
    return read_surface_or_msh(file, file);
}

}  // namespace tissue
