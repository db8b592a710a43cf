#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "field.h"

namespace tissue {

struct Surface;

/// A part of space, in metres: what of a solid's surface lies in it is held, its border included. As text, in the list of a shape's held surfaces:
///   below z = 0.012    above x = -0.03    ball 0.03 0.02 0.01 radius 0.015    box 0 0 0 to 0.1 0.05 0.01
/// or as one word, as make and a shell carry it: below_z_0.012.
class HeldRegion {
   public:
    /// Nothing for the name of a surface: what does not begin with one of these four words; and what has neither blank nor = and no axis, of a ball or box no number,
    /// behind it, as box_bottom. Throws MismatchError for any other text that is no region.
    static std::optional<HeldRegion> of(const std::string& text);

    /// Below 0 inside, 0 on its border, above 0 outside; between two places it differs by no more than they lie apart [m].
    double outside_m(const Eigen::Vector3d& place_m) const { return outside_(place_m); }
    const std::string& text() const { return text_; }
    std::string word() const;

   private:
    HeldRegion(std::string text, std::function<double(const Eigen::Vector3d&)> outside) : text_(std::move(text)), outside_(std::move(outside)) {}

    std::string text_;
    std::function<double(const Eigen::Vector3d&)> outside_;
};

/// How near to a border of a region a place of this surface or solid counts as on it [m]: a millionth of its longest side, as a file's numbers are rounded.
double border_m(const NodeField& nodes);

/// Of some texts those that name surfaces, and the regions of the others. Throws FileError, which names the file, as HeldRegion::of does.
struct HeldParts {
    std::vector<std::string> names;
    std::vector<HeldRegion> regions;
};
HeldParts held_parts(const std::vector<std::string>& texts, const std::string& file);

/// Labels what of the surface lies in a region as fixed. Near its border triangles are divided to sides of a fortieth of the surface's longest side, then along the border; a corner
/// within a tenth of a side of it counts as on it. Returns whether anything is held by it. A region smaller than that fortieth may not be found.
bool hold(Surface& surface, const HeldRegion& region);

}  // namespace tissue
