#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "field.h"
#include "mesh/held_region.h"
#include "mesh/msh_file.h"

namespace tissue {

/// The surface of a closed solid: triangles that close in a volume, whatever the file was that they came from.
struct Surface {
    static constexpr int fixed_label = 1, free_label = 2, disc_label = 3;  ///< as fem/solve_solid.edp knows them
    static constexpr int first_bed_label = 21, last_bed_label = 60;        ///< what is held and lies on an elastic bed of its own
    static bool is_held(int label) { return label == fixed_label || (label >= first_bed_label && label <= last_bed_label); }

    NodeField nodes;         ///< [m] (N x 3)
    Cells triangles;         ///< normals point out (T x 3)
    std::vector<int> label;  ///< of each triangle

    Eigen::Vector3d corner(Eigen::Index triangle, int i) const { return nodes.row(triangles(triangle, i)).transpose(); }
};

constexpr double crease_cosine = 0.766;  ///< of 40 degrees: where neighbours turn by more there is an edge to be kept

/// The surface of a mesh of tetrahedra, or, where it has none, its triangles, turned so that they point out. `fixed` are
/// names of physical surfaces; where no surface has a name, its parts between edges that turn by more than 40 degrees
/// are "surface-1", "surface-2", ... from the largest on. `fixed` may also have regions (mesh/held_region.h), along whose border triangles are divided; `read` reads the other surface of
/// one that is `within` it. beds: of each of `fixed` the elastic bed that it lies on, from 1, by which it is labelled (held_label); 0: none. Where two parts share a triangle, the first of `fixed`
/// has it, names before regions. unit_m [m] is the mesh's unit of length.
/// Throws FileError with file, place and cause: no triangles, one without area, a surface that does not close or that
/// meets itself, more than one piece, a hole through it, no group of a name (with those there are), a fixed group that is
/// not on the surface or is all of it, nothing that is held, a bed whose parts others hold already.
Surface make_surface(const MshFile& mesh, const std::vector<std::string>& fixed, double unit_m, const HeldRegion::Reader& read = {}, const std::vector<int>& beds = {});

/// Label of what lies on a bed, from 1; 0: of what does not move.
constexpr int held_label(int bed) { return bed > 0 ? Surface::first_bed_label + bed - 1 : Surface::fixed_label; }

/// What to_msh calls held triangles of a label: "fixed", "bed-1", ...
std::string held_name(int label);

/// Volume and its centroid, of a closed surface; the volume is below 0 where normals point inwards.
struct Enclosed {
    double volume_m3;
    Eigen::Vector3d centre_m;
};
Enclosed enclosed_by(const Surface& surface);

double held_area_m2(const Surface& surface);

/// Throws MismatchError where a connected held part has lost a tenth or more of its area when its surface was divided anew.
void check_held_area(const Surface& before, const Surface& divided);

/// The same without what is held, all of it free.
Surface closed_surface(const MshFile& mesh, double unit_m);

/// As MSH 2.2 in metres: triangles "fixed" 1, "free" 2, "disc" 3, and on beds "bed-1" 21, ...; those of an inclusion's surface inside it are gmsh's surface 4, in no physical group.
std::string to_msh(const Surface& surface, const Surface* inclusion = nullptr);

/// 4 sqrt(3) area / sum of squared sides: 1 of the regular triangle, 0 of a flat one.
double triangle_quality(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace tissue
