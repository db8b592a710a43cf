#include "cases/study_law.h"

namespace tissue {

Eigen::VectorXd triangle_moduli(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double modulus_N_m) {
    Eigen::VectorXd modulus = Eigen::VectorXd::Constant(mesh.simplices.rows(), modulus_N_m);
    if (study.material.regions.empty()) return modulus;
    for (Eigen::Index t = 0; t < modulus.size(); ++t) {
        const int region = shape->region[static_cast<std::size_t>(t)];
        const Study::LawParameters& own =
            region == 0 ? study.material
                        : static_cast<const Study::LawParameters&>(study.material.regions.at(static_cast<std::size_t>(region - 1)));
        modulus[t] = modulus_N_m * own.youngs_modulus_Pa() / study.material.youngs_modulus_Pa();
    }
    return modulus;
}

EnergyLaw study_law(const Study& study, const std::optional<Shape>& shape, const SpringMesh& mesh, double factor) {
    const double modulus_N_m = factor * study.modulus_N_m(), cap = study.springs.area_cap_E2;
    const std::string& formulation = study.material.formulation;
    const LawHeuristic heuristic =
        study.material.regions.empty() ? law_heuristic(mesh, modulus_N_m, formulation, cap)
                                       : law_heuristic(mesh, triangle_moduli(study, shape, mesh, modulus_N_m), formulation, cap);
    return {mesh, heuristic, study.springs.terms};
}

}  // namespace tissue
