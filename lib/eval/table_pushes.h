#pragma once

#include <vector>

#include "cases/load_path.h"
#include "springs/tissue_model.h"

namespace tissue {

/// A reflection or quarter rotation that maps the tissue onto itself: place x -> centre + turn (x - centre), direction
/// or force x -> turn x.
struct Symmetry {
    Eigen::MatrixXd turn;  ///< (D x D), orthogonal
    Point centre_m;        ///< (D)
};

/// Symmetries of a model's tissue, without the identity. A block in the plane has the reflection in x. A block in space
/// has the reflections in x, in y and in both; with a square base also these combined with an exchange of x and y,
/// eight images with the identity. With an inclusion only those remain that map it onto itself. Other shapes have none.
std::vector<Symmetry> symmetries_of(const TissueModel& model);

/// FE force of one indentation: an entry of a force table.
struct TablePush {
    Point contact_m, direction, force_N;  ///< (D); direction: unit vector
    double depth_m;
};

/// The load cases and their images under the symmetries. An image that is among the load cases or images already is
/// left out; for example images of an indentation at the centre coincide. Each repetition of a repeated load case gets
/// its own images.
/// disc_radius_m: radius a of the table's disc [m]. A load case of another disc R is scaled to it: on a half space a
/// disc R / a times as large, indented R / a times as deep, needs (R / a)^2 times the force.
std::vector<TablePush> table_pushes(const std::vector<LoadCase>& loads, const std::vector<Symmetry>& symmetries = {}, double disc_radius_m = 0);

}  // namespace tissue
