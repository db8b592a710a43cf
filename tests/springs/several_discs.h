#pragma once

#include "../mesh/embedded_block.h"
#include "../solid_model_example.h"

namespace tissue {

/// An energy model of a 7 mm disc with size terms for discs of 4 to 10 mm, and one load case of the smallest disc.
inline TissueModel several_discs() {
    TissueModel model = solid_model_example(embedded_block(Lattice{{5, 6, 2}, {0.05, 0.06, 0.02}}));
    EnergyModel& energy_model = *model.energy_model;
    energy_model.terms = {"spring.all", "contact.normal.size", "contact.hardening.size"};
    energy_model.coefficients = Eigen::Vector3d(0, 0.3, 1.5);
    energy_model.disc.correction.value = NodeField::Constant(model.mesh.facets.rows(), 10, 0.02);
    energy_model.sizes.radii_m = with_means({0.004, 0.007, 0.010});
    energy_model.sizes.spacing_m = model.mesh.embedding.spacing_m;
    for (double x : {-0.05, 0.03, 0.02, 0.01, 0.06}) energy_model.sizes.correction.push_back({NodeField::Constant(model.mesh.facets.rows(), 10, x)});
    model.heuristic_b = model.heuristic_a;
    model.case_radius_m = Eigen::VectorXd::Constant(1, 0.004);
    model.contact_m = Eigen::RowVector3d(0.021, 0.033, 0.02);
    model.direction = Eigen::RowVector3d(0, 0, -1);
    return model;
}

}  // namespace tissue
