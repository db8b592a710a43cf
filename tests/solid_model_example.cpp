#include "solid_model_example.h"

#include <cmath>

#include "mesh/topology.h"
#include "springs/energy_model_terms.h"
#include "springs/heuristic.h"
#include "springs/tissue_energy.h"

namespace tissue {

TissueModel solid_model_example(const SpringMesh& mesh) {
    constexpr double modulus_Pa = 4524, radius_m = 0.007;
    TissueModel m;
    m.study = "space";
    m.law = "geometric";
    m.mesh = mesh;
    m.modulus_N_m = modulus_Pa;
    m.node_mass_kg = node_masses(mesh, 1000, 1);
    m.heuristic_a = heuristic_stiffness(mesh, modulus_Pa);
    const Eigen::Index cells = cell_count(mesh);
    const EnergyModelTerms model_terms(mesh, solid_heuristic(mesh, Eigen::VectorXd::Constant(mesh.spring_count(), modulus_Pa), Eigen::VectorXd::Constant(cells, modulus_Pa), modulus_Pa, 12, radius_m),
                        {"spring.all"});
    const Eigen::VectorXd p = Eigen::VectorXd::Zero(1);
    m.energy_model = {model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible(), radius_m};
    m.energy_model->curve = SpringCurve::mooney_rivlin(0.3, 3);
    for (Eigen::Index e = 0; e < m.energy_model->constants.size(); ++e)
        m.energy_model->constants[e] *= 1 + 0.3 * std::sin(1.7 * static_cast<double>(e));
    m.case_names = {"deepest"};
    m.magnitude_m = Eigen::VectorXd::Constant(1, 0.006);
    return m;
}

}  // namespace tissue
