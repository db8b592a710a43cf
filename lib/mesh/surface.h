#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "field.h"
#include "mesh/fixed_region.h"
#include "mesh/msh_file.h"

namespace tissue {

/// The surface of a solid: triangles that enclose a volume.
struct Surface {
    static constexpr int fixed_label = 1, free_label = 2, disc_label = 3;  ///< as in fem/solve_solid.edp
    static constexpr int first_bed_label = 21, last_bed_label = 60;        ///< fixed parts on elastic beds 1 to 40
    /// Whether a label is of a fixed part, on an elastic bed or not.
    static bool is_fixed(int label) { return label == fixed_label || (label >= first_bed_label && label <= last_bed_label); }

    NodeField nodes;         ///< [m] (N x 3)
    Cells triangles;         ///< node numbers, normals point out (T x 3)
    std::vector<int> label;  ///< of each triangle

    /// Position of a triangle's corner i [m].
    Eigen::Vector3d corner(Eigen::Index triangle, int i) const { return nodes.row(triangles(triangle, i)).transpose(); }
};

/// cos 40 degrees. Neighbouring triangles that turn by more have an edge (crease) between them.
constexpr double crease_cosine = 0.766;

/// The surface of a mesh's tetrahedra, or its triangles if it has no tetrahedra. Triangles are turned so that their
/// normals point out. Fixed parts are labelled (fixed_label_of).
/// fixed: names of physical surfaces. If no surface has a name, the parts between edges that turn by more than 40
/// degrees are "surface-1", "surface-2", ..., the largest first. `fixed` may also have regions of space
/// (mesh/fixed_region.h); triangles are divided along their borders. If two parts share a triangle, the first of `fixed`
/// gets it, names before regions. unit_m: the mesh's unit of length [m]. read: reads the file of a `within` region.
/// beds: elastic bed of each of `fixed`, from 1; 0 or an empty list: none.
/// Throws FileError with file, place and cause: no triangles; one without area; a surface that does not close or that
/// meets itself; more than one piece; a hole through it; no group of a name (with the names there are); a fixed group
/// that is not on the surface or is all of it; nothing fixed; a region without a triangle; a bed whose triangles other
/// parts have.
Surface make_surface(const MshFile& mesh, const std::vector<std::string>& fixed, double unit_m, const FixedRegion::Reader& read = {}, const std::vector<int>& beds = {});

/// Label of the triangles on an elastic bed, from 1. 0: label of rigidly fixed triangles.
constexpr int fixed_label_of(int bed) { return bed > 0 ? Surface::first_bed_label + bed - 1 : Surface::fixed_label; }

/// Name of a fixed label in to_msh: "fixed", "bed-1", ...
std::string fixed_name(int label);

/// Volume enclosed by a closed surface, and its centroid. The volume is below 0 if the normals point inwards.
struct Enclosed {
    double volume_m3;
    Eigen::Vector3d centre_m;
};
Enclosed enclosed_by(const Surface& surface);

/// Area of the fixed triangles [m^2].
double fixed_area_m2(const Surface& surface);

/// Throws MismatchError if remeshing took more than a tenth of the area of a connected fixed part. before, divided: the
/// surface before and after remeshing.
void check_fixed_area(const Surface& before, const Surface& divided);

/// As make_surface, but without fixed parts: all triangles are free.
Surface closed_surface(const MshFile& mesh, double unit_m);

/// A surface as text in MSH 2.2, in metres: triangles "fixed" 1, "free" 2, "disc" 3 and, on elastic beds, "bed-1" 21
/// and so on. The triangles of an inclusion's surface, if given, are gmsh's surface 4 and in no physical group.
std::string to_msh(const Surface& surface, const Surface* inclusion = nullptr);

/// Quality of a triangle: 4 sqrt(3) area / sum of squared sides; 1 if equilateral, 0 if flat.
double triangle_quality(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace tissue
