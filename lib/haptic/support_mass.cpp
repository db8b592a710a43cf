#include "haptic/support_mass.h"

#include <cmath>

#include "haptic/realtime_mesh.h"
#include "haptic/spectrum.h"
#include "springs/tissue_energy.h"

namespace tissue {
namespace {

/// Mass at each node with which no support oscillates faster than the squared angular frequency omega2 [kg] (N).
Eigen::VectorXd asked_mass(const SpringMesh& mesh, const Eigen::VectorXd& support_N_m, double omega2) {
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.node_count());
    for (Eigen::Index m = 0; m < support_N_m.size(); ++m) {
        const int supported = mesh.fixed[static_cast<std::size_t>(m)];
        const auto weight = mesh.embedding.weight.row(supported).array();
        const double n = static_cast<double>((weight != 0).count());
        for (int k = 0; k < 8; ++k) mass[mesh.embedding.corner(supported, k)] += n * support_N_m[m] * weight[k] * weight[k] / omega2;
    }
    return mass;
}

/// Stiffness of each node with all others fixed, along its softest axis [N/m] (N).
Eigen::VectorXd own_stiffness(const Eigen::SparseMatrix<double>& tangent, int nodes) {
    const Eigen::VectorXd diagonal = tangent.diagonal();
    return Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic>>(diagonal.data(), 3, nodes).colwise().minCoeff().transpose();
}

}  // namespace

Eigen::VectorXd mass_with_supports(const TissueModel& model) {
    const SpringMesh& mesh = model.mesh;
    const Eigen::Index supports = mesh.support_count();
    if (supports == 0) return model.node_mass_kg;
    const EnergyModel& energy_model = *model.energy_model;
    const TissueEnergy energy(mesh, energy_model);
    const NodeField rest = NodeField::Zero(mesh.node_count(), mesh.dimension());
    Eigen::VectorXd free = energy_model.constants;
    free.tail(supports).setZero();
    const Eigen::SparseMatrix<double> supported = energy.tangent(energy_model.constants, rest), lattice = energy.tangent(free, rest);
    const RealtimeMesh springs(mesh, energy_model.curve, model.node_mass_kg);
    const double omega2 = largest_eigenvalue(springs, lattice);
    constexpr double little = 1.05 * 1.05;
    if (!(largest_eigenvalue(springs, supported) > little * omega2)) return model.node_mass_kg;
    const SlowestMode slowest_mode(springs, supported);
    const double slowest = slowest_mode.of(model.node_mass_kg);
    if (!(slowest > 0)) return model.node_mass_kg;

    const Eigen::VectorXd asked = asked_mass(mesh, energy_model.constants.tail(supports), omega2);
    const Eigen::VectorXd stiffness = own_stiffness(lattice, mesh.node_count());
    constexpr double enough = 0.99;  // ratio of squared frequencies: half a per cent of the frequency
    for (double most = 1500; most >= 1; most /= 1.5) {
        const Eigen::VectorXd mass = model.node_mass_kg + asked.cwiseMin(most / omega2 * stiffness);
        if (slowest_mode.of(mass) >= enough * slowest) return mass;
    }
    return model.node_mass_kg;
}

}  // namespace tissue
