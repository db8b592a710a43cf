#pragma once

#include <vector>

#include "cases/load_path.h"
#include "springs/tissue_model.h"

namespace tissue {

/// A mirror image or quarter turn that leaves the tissue as it is: x goes to centre + turn (x - centre), a direction or a force to turn x.
struct Symmetry {
    Eigen::MatrixXd turn;  ///< (D x D), orthogonal
    Point centre_m;        ///< (D)
};

/// Those of a model's tissue, the identity not among them. A block in the plane has the image in x; in space those in x, in y and in
/// both, and where it is as long as it is wide these with x and y exchanged: eight images with the push itself. Where it holds other material, those that leave it as it is. Others have none.
std::vector<Symmetry> symmetries_of(const TissueModel& model);

/// A push whose force FE has said: what a table of forces is made of.
struct TablePush {
    Point contact_m, direction, force_N;
    double depth_m;
};

/// The load cases, and what they say of their images, but where one is among the load cases or images already: images of a push in the middle
/// coincide. A push that is among the load cases again and again has the images of each.
/// A push of another disc than disc_radius_m stands as the push of that one in proportion: a half space asks (R / a)^2 times the force of a disc R / a times as large, R / a times as deep.
std::vector<TablePush> table_pushes(const std::vector<LoadCase>& loads, const std::vector<Symmetry>& symmetries = {}, double disc_radius_m = 0);

}  // namespace tissue
