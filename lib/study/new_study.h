#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tissue {

/// What a person says of a tissue of their own; everything else a new study chooses.
struct NewStudy {
    std::string shape;               ///< file: .geo, .msh, or one of surface_endings (surface_file/surface_file.h)
    std::string shape_in_study;      ///< the same as the study is to name it, from its own folder
    double unit_m = 1;               ///< of that file
    bool trust_geo = false;          ///< whether gmsh may run it, where it is a .geo
    std::vector<std::string> held;   ///< its named curves, in space surfaces or regions (mesh/held_region.h), that are held
    std::vector<std::string> held_in_study;  ///< the same as the study is to name them, from its own folder; none: as they are
    double bed_Pa_m = 0;             ///< in space, stiffness per area of the bed that these lie on [Pa/m]; 0: rigid
    std::string preset = "liver";    ///< fem/materials/NAME.toml
    double thickness_m = 0.1;        ///< in the plane
    std::optional<double> size_m;    ///< of the springs, in space of their cubes; absent: a part of the tissue's size
};

struct WrittenStudy {
    std::string toml;                 ///< every key with its unit
    bool solid;                       ///< of a tissue in space
    std::vector<std::string> choices;  ///< lines for a person: what was chosen, and from what
};

/// A study of an energy model for the shape: springs, finite elements, tool and depth from the size of the tissue.
/// Throws FileError as shape_extent; MismatchError where nothing or something unknown is held, with the names there are, where the size is
/// that of no tissue, and where gmsh alone knows it and size_m is absent.
WrittenStudy new_study(const NewStudy& wanted);

}  // namespace tissue
