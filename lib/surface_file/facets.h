#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/msh_file.h"

namespace tissue::surface_file {

/// Collects the facets that a reader finds in a file, and makes a mesh of them. Its functions throw FileError with the
/// file's name.
class Facets {
   public:
    explicit Facets(const std::string& file) : file_(file) {}

    /// Starts a new group, to which the next facets belong. Groups are numbered from 1. An empty name: the group has no
    /// name.
    void begin_group(const std::string& name);
    /// The next facets belong to this group.
    void go_on_with(int group) { now_ = group; }
    /// Adds a triangle. A group must have been started before.
    void add(const std::array<MshFile::Point, 3>& corners);
    /// Adds a facet of 3 to most_corners corners, divided into triangles. of_points: indices of the corners in
    /// `points`, checked here. line: number of the facet's line, for messages; 0 if the file has no lines.
    void add(const std::vector<MshFile::Point>& points, const std::vector<long long>& of_points, long line = 0);
    /// The mesh: coincident corners merged, groups as read_surface_file describes.
    MshFile mesh() const;

   private:
    void add_triangle(const std::array<MshFile::Point, 3>& corners, long line);
    [[noreturn]] void refuse(const std::string& why, long line) const;

    const std::string& file_;
    std::vector<std::array<MshFile::Point, 3>> corners_;
    std::vector<int> group_;          // group of each facet, from 1
    std::vector<std::string> names_;  // names of the groups
    int now_ = 0;                     // current group
    long given_ = 0;                  // number of facets in the file so far
    std::size_t divided_ = 0;         // sum of the divided facets' corners^3
};

constexpr double largest_coordinate = 1e12;  ///< as in read_msh; in the file's unit
constexpr std::size_t most_facets = 1'000'000, most_corners = 255;

/// A text without the byte order mark of UTF-8, if it begins with one.
std::string_view without_mark(std::string_view text);

/// Readers, one a file format. file: name for messages; content: bytes of the file.
Facets read_stl(const std::string& file, std::string_view content);
Facets read_obj(const std::string& file, std::string_view content);
Facets read_off(const std::string& file, std::string_view content);
Facets read_ply(const std::string& file, std::string_view content);
Facets read_glb(const std::string& file, std::string_view content);

}  // namespace tissue::surface_file
