#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/msh_file.h"

namespace tissue::surface_file {

/// Facets before their corners are points of a mesh, as a reader finds them in its file. Throws FileError of that file.
class Facets {
   public:
    explicit Facets(const std::string& file) : file_(file) {}

    /// What is added from here on is of a new group; they are numbered from 1. An empty name is none.
    void begin_group(const std::string& name);
    /// What is added from here on is of this group.
    void go_on_with(int group) { now_ = group; }
    void add(const std::array<MshFile::Point, 3>& corners);
    /// A plane facet of three corners or more, which is divided. of_points: where they stand in `points`, checked here.
    /// line: where it stands, for messages; 0 where the file has no lines.
    void add(const std::vector<MshFile::Point>& points, const std::vector<long long>& of_points, long line = 0);
    MshFile mesh() const;

   private:
    void add_triangle(const std::array<MshFile::Point, 3>& corners, long line);
    [[noreturn]] void refuse(const std::string& why, long line) const;

    const std::string& file_;
    std::vector<std::array<MshFile::Point, 3>> corners_;
    std::vector<int> group_;          // of each, from 1
    std::vector<std::string> names_;  // of the groups
    int now_ = 0;
    long given_ = 0;           // facets of the file
    std::size_t divided_ = 0;  // corners to the third, of those that were divided
};

constexpr double largest_coordinate = 1e12;  ///< as read_msh has it
constexpr std::size_t most_facets = 1'000'000, most_corners = 255;

/// A text without the three bytes with which UTF-8 may mark itself.
std::string_view without_mark(std::string_view text);

/// content: the file's. Each begins a group.
Facets read_stl(const std::string& file, std::string_view content);
Facets read_obj(const std::string& file, std::string_view content);
Facets read_off(const std::string& file, std::string_view content);
Facets read_ply(const std::string& file, std::string_view content);
Facets read_glb(const std::string& file, std::string_view content);

}  // namespace tissue::surface_file
