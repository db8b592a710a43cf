#pragma once

#include <optional>

#include "mesh/shape.h"
#include "springs/energy_model_terms.h"
#include "springs/relaxation.h"
#include "study/study.h"

namespace tissue {

/// E2 of each triangle of the study's mesh [N/m], in space E of each tetrahedron [Pa] (T). It is modulus_N_m (in space
/// a modulus in Pa) in the base material, and in proportion to E in regions.
Eigen::VectorXd triangle_moduli(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double modulus_N_m);

/// E of each spring or cell in space [Pa] (P): the mean of E over evenly spread points, 4 along a spring and 64 in a
/// cell.
/// pieces: nodes of the springs or cells, one row each (P x K). With regions, points outside the tissue are left out;
/// where all are outside, E is that of the tissue at the facet nearest to the piece's centre.
/// Throws StudyError for a region, or a nodule from a surface file, that contains no point of any cell.
Eigen::VectorXd solid_moduli(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, const Cells& pieces);

/// Points of an even grid that lie in the study's nodule (G x 4): place [m], and volume of its part times
/// log(E / E of the base material) [m3]. The grid has 8 points across the nodule's bounding box, or up to 64 for a thin
/// nodule, so that there are at least 50 in it where possible.
/// Throws StudyError for a nodule that is too thin to contain any.
NodeField nodule_points(const Study& study);

/// The same for the named regions of a solid shape, with four points a tetrahedron (G x 4).
NodeField region_points(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh);

/// Part of each spring or cell that lies in an inclusion, by the points of solid_moduli (P). pieces: as there.
Eigen::VectorXd fraction_inside(const SpringMesh& mesh, const Cells& pieces, const Inclusion& inclusion);

/// The study's energy model before training: its terms on its mesh, with the heuristic constants of its material. E2 is
/// multiplied by `factor`; where the material is only an estimate, heuristic_factor (train/train_energy_model.h) computes it.
/// Throws MismatchError for terms that the mesh cannot have, for a shape with more regions than the study names, and
/// for a shape made without the study's beds; StudyError as solid_moduli.
EnergyModelTerms study_energy_model(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double factor = 1);

/// Relaxation of an energy model of the study's terms on its mesh. The relative modulus of a constant in each Maxwell
/// branch is the mean over the materials in which its element lies, weighted by their stiffness; that of the contact is
/// the base material's. Supports do not relax. Empty where the material does not relax, or where relative moduli are
/// fitted to measured histories.
Relaxation study_relaxation(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, const EnergyModelTerms& model_terms);

}  // namespace tissue
