#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tissue {

struct Surface;

/// A part of space [m]: what of a solid's surface lies in it is held. As text, in the list of a shape's held surfaces:
///   below z = 0.012    above x = -0.03    ball 0.03 0.02 0.01 radius 0.015    box 0 0 0 to 0.1 0.05 0.01
/// or as one word, with _ for blanks and nothing for =: below_z_0.012.
class HeldRegion {
   public:
    /// Nothing where the text does not begin with one of these words and a blank or _: then it names a surface. Throws MismatchError for one that
    /// does and goes on otherwise.
    static std::optional<HeldRegion> of(const std::string& text);

    /// Below 0 inside, 0 on its border, above 0 outside; continuous [m].
    double outside_m(const Eigen::Vector3d& place_m) const { return outside_(place_m); }
    const std::string& word() const { return word_; }

   private:
    HeldRegion(std::string word, std::function<double(const Eigen::Vector3d&)> outside) : word_(std::move(word)), outside_(std::move(outside)) {}

    std::string word_;
    std::function<double(const Eigen::Vector3d&)> outside_;
};

/// Of some texts those that name surfaces, and the regions of the others.
struct HeldParts {
    std::vector<std::string> names;
    std::vector<HeldRegion> regions;
};
HeldParts held_parts(const std::vector<std::string>& texts);

/// Labels what of the surface lies in a region as fixed. Triangles on its border are divided along it; a corner within a tenth of a side of the border counts as
/// on it. Returns whether anything is held by it. What is smaller than the triangles is not found.
bool hold(Surface& surface, const HeldRegion& region);

}  // namespace tissue
