#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "field.h"
#include "mesh/msh_file.h"

namespace tissue {

struct Surface;

/// A part of space, in metres: what of a solid's surface lies in it is held, its border included. As text, in the list of a shape's held surfaces:
///   below z = 0.012    above x = -0.03    ball 0.03 0.02 0.01 radius 0.015    box 0 0 0 to 0.1 0.05 0.01    within 0.003 of spine.stl
/// or as one word, as make and a shell carry it: below_z_0.012. `within` counts the distance from another surface's facets, on either side; that file has the shape's unit of length.
class HeldRegion {
   public:
    /// Reads the surface of a file.
    using Reader = std::function<MshFile(const std::string& file)>;

    /// Nothing for a surface's name: a text that does not begin with one of these five words; or one without blanks and '=' whose second part is no axis (below, above)
    /// or no number (ball, box, within), such as box_bottom. Throws MismatchError for any other text that is no region, and for `within` without a reader; what the reader throws.
    static std::optional<HeldRegion> of(const std::string& text, const Reader& read = {}, double unit_m = 1);

    /// The distance, as it is written and above 0, and the file of a text that is such a region; else nothing. Reads no file.
    struct Within {
        std::string distance_m, file;
        std::string word() const { return "within_" + distance_m + "_of_" + file; }
    };
    static std::optional<Within> within(const std::string& text);

    /// Below 0 inside, 0 on its border, above 0 outside; between two places it differs by no more than they lie apart [m].
    double outside_m(const Eigen::Vector3d& place_m) const { return outside_(place_m); }
    /// Its shortest way across [m]; infinite of a half space, whose border is a plane.
    double narrowest_m() const { return narrowest_m_; }
    const std::string& text() const { return text_; }
    const std::string& word() const { return word_; }

   private:
    HeldRegion(std::string text, std::string word, double narrowest_m, std::function<double(const Eigen::Vector3d&)> outside)
        : text_(std::move(text)), word_(std::move(word)), narrowest_m_(narrowest_m), outside_(std::move(outside)) {}

    std::string text_, word_;
    double narrowest_m_;
    std::function<double(const Eigen::Vector3d&)> outside_;
};

/// How near to a border of a region a place of this surface or solid counts as on it [m]: a millionth of its longest side, as a file's numbers are rounded.
double border_m(const NodeField& nodes);

/// Of some texts those that name surfaces, and the regions of the others. Throws FileError, which names the file, where HeldRegion::of throws MismatchError.
struct HeldParts {
    std::vector<std::string> names;
    std::vector<HeldRegion> regions;
    std::vector<int> bed_of_name, bed_of_region;  ///< the elastic bed that each lies on, from 1; 0: none
};
/// beds: of each text its bed; empty: none has one.
HeldParts held_parts(const std::vector<std::string>& texts, const std::string& file, const HeldRegion::Reader& read, double unit_m, const std::vector<int>& beds = {});

/// Labels what of the surface lies in a region and is not held yet, to a 400th of the surface's longest side: triangles are divided along the border, and a corner that near to where an edge meets it
/// counts as on it. Near the border of a ball or box triangles are divided before, to sides of a fortieth of that longest side, or a third of the region's narrowest. Returns whether anything
/// is held by it. Throws MismatchError for a region narrower than a 130th, and where that would make more than half a million triangles more.
bool hold(Surface& surface, const HeldRegion& region, int label = 1);

}  // namespace tissue
