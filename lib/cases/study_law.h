#pragma once

#include <optional>

#include "mesh/shape.h"
#include "springs/energy_law.h"
#include "springs/relaxation.h"
#include "study/study.h"

namespace tissue {

/// E2 of each triangle of the study's mesh [N/m], in space E of each tetrahedron [Pa] (T): modulus_N_m of the base material, and where a region has a material
/// of its own, in proportion to its E.
Eigen::VectorXd triangle_moduli(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double modulus_N_m);

/// E of each row of springs or cells in space [Pa]: its mean over points spread evenly, 4 along a spring and 64 in a cell, of the base material, the nodule or the
/// shape's regions. Of a piece that reaches out of the tissue, in a cube that the surface cuts, points inside alone count; where there are none, the tissue nearest to
/// its middle. Throws StudyError for a region, or a nodule of a surface's file, that no cell has a point in.
Eigen::VectorXd solid_moduli(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, const Cells& pieces);

/// The study's nodule as points that fill it evenly, 8 or more across the box about it (G x 4): place [m], volume times log(E / E_block) [m3].
/// Throws StudyError for one that is too thin to have any.
NodeField nodule_points(const Study& study);

/// The study's regions of a solid shape likewise, four points a tetrahedron.
NodeField region_points(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh);

/// Part of each row's pieces that lies in an inclusion, by the points of solid_moduli.
Eigen::VectorXd fraction_inside(const SpringMesh& mesh, const Cells& pieces, const Inclusion& inclusion);

/// The study's terms on its mesh, over the heuristic of its material, E2 taken `factor` times as large (train_law.h's
/// heuristic_factor, where the material is a guess). Throws MismatchError for terms that are not possible there, and for a shape with more regions than the study names; as solid_moduli.
EnergyLaw study_law(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double factor = 1);

/// How the study's tissue relaxes, for a law of its terms on its mesh: a constant's share of a branch is the mean of what its element lies
/// in, each part as stiff as it is, from the material's own; the contact's is the base material's. Empty where nothing relaxes.
Relaxation study_relaxation(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, const EnergyLaw& law);

}  // namespace tissue
