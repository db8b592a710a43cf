#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tissue {

/// A user's description of a tissue of their own, from which new_study() makes a study.
struct NewStudy {
    std::string shape;               ///< file: .geo, .msh, or one of surface_endings (surface_file/surface_file.h)
    std::string shape_in_study;      ///< path of this file as the study gives it, relative to the study's folder
    double unit_m = 1;               ///< unit of length of this file [m]
    bool trust_geo = false;          ///< whether gmsh may run the file, where it is a .geo
    /// Fixed parts: named curves of the file, in space named surfaces or regions of space (mesh/fixed_region.h).
    std::vector<std::string> fixed;
    /// The same parts as the study gives them, with paths relative to its folder; empty: as in `fixed`.
    std::vector<std::string> fixed_in_study;
    double bed_Pa_m = 0;             ///< in space: stiffness per area of the bed under these parts [Pa/m]; 0: rigid
    std::string preset = "liver";    ///< fem/materials/NAME.toml
    double thickness_m = 0.1;        ///< in the plane
    /// Length of the springs, in space edge of the lattice's cubes [m]; absent: derived from the size of the tissue.
    std::optional<double> size_m;
};

struct WrittenStudy {
    std::string toml;                 ///< text of the study file, every key with its unit
    bool solid;                       ///< whether the tissue is three-dimensional
    std::vector<std::string> choices;  ///< lines for the user: each chosen value, and what it was derived from
};

/// A study of an energy model for the shape. Springs, finite elements, tool and depth follow from the size of the
/// tissue.
/// Throws FileError as shape_extent.
/// Throws MismatchError for a surface with a fault; for fixed parts that are missing, unknown, or contain all or
/// nothing of the tissue, with the names that the file has; for a bed in the plane; for a tissue or springs whose size
/// is out of range; where the size is not in the file (only gmsh can compute it) and size_m is absent.
WrittenStudy new_study(const NewStudy& wanted);

}  // namespace tissue
