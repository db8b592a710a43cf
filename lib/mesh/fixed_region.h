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

/// A region of space. The part of a solid's surface in the region, border included, is fixed. A study's list of fixed
/// surfaces has regions as text, with lengths in metres:
///   below z = 0.012    above x = -0.03    ball 0.03 0.02 0.01 radius 0.015
///   box 0 0 0 to 0.1 0.05 0.01            within 0.003 of spine.stl
/// make and shells need one word: below_z_0.012. `within` is a distance from the facets of another surface, on either
/// side. The file of that surface has the shape's unit of length.
class FixedRegion {
   public:
    /// A function that reads the surface of a file.
    using Reader = std::function<MshFile(const std::string& file)>;

    /// Parses the text of a region. read: for the file of `within`; unit_m: unit of length of that file [m].
    /// Result: nothing if the text is the name of a surface. A name does not begin with one of the five words above; or
    /// it has neither blanks nor '=', and its second part is no axis (below, above) or no number (ball, box, within).
    /// An example is box_bottom.
    /// Throws MismatchError for any other text that is not a region, and for `within` without a reader. Does not catch
    /// exceptions of the reader.
    static std::optional<FixedRegion> of(const std::string& text, const Reader& read = {}, double unit_m = 1);

    /// Distance as written (above 0) and file of a `within` region.
    struct Within {
        std::string distance_m, file;
        std::string word() const { return "within_" + distance_m + "_of_" + file; }
    };
    /// Parses a `within` region without reading its file; nothing for any other text.
    static std::optional<Within> within(const std::string& text);

    /// Below 0 inside, 0 on the border, above 0 outside [m]. Values at two points differ by at most their distance.
    double outside_m(const Eigen::Vector3d& place_m) const { return outside_(place_m); }
    /// Smallest width of the region [m]; infinite for a half space (below, above). Of `within`: twice its distance.
    double narrowest_m() const { return narrowest_m_; }
    const std::string& text() const { return text_; }
    const std::string& word() const { return word_; }

   private:
    FixedRegion(std::string text, std::string word, double narrowest_m, std::function<double(const Eigen::Vector3d&)> outside)
        : text_(std::move(text)), word_(std::move(word)), narrowest_m_(narrowest_m), outside_(std::move(outside)) {}

    std::string text_, word_;
    double narrowest_m_;
    std::function<double(const Eigen::Vector3d&)> outside_;
};

/// Distance from a region's border within which a point counts as on the border [m]: 1e-6 of the longest side of the
/// nodes' bounding box, because files have rounded coordinates.
double border_m(const NodeField& nodes);

/// A study's list of fixed parts, split into names of surfaces and regions.
struct FixedParts {
    std::vector<std::string> names;
    std::vector<FixedRegion> regions;
    std::vector<int> bed_of_name, bed_of_region;  ///< elastic bed of each, from 1; 0: none
};
/// Splits a list of texts. file: named in messages; read, unit_m: as for FixedRegion::of; beds: bed of each text, or
/// empty if none has one. Throws FileError where FixedRegion::of throws MismatchError, and if beds has another length
/// than texts.
FixedParts fixed_parts(const std::vector<std::string>& texts, const std::string& file, const FixedRegion::Reader& read, double unit_m, const std::vector<int>& beds = {});

/// Labels the part of a surface that lies in a region and is not fixed yet. Let L be the longest side of the surface's
/// bounding box. Triangles are divided along the region's border. A corner within L/400 of the point where a side meets
/// the border counts as on the border. Near the border of a ball, a box or a `within` region triangles are refined
/// first, to sides of L/40 or a third of the region's smallest width, whichever is less.
/// label: of the triangles that become fixed. Result: whether any triangle lies in the region, fixed before or not.
/// Throws MismatchError for a region narrower than L/130, and if the refinement adds more than 500,000 triangles.
bool hold(Surface& surface, const FixedRegion& region, int label = 1);

}  // namespace tissue
