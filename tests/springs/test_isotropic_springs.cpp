#include "springs/isotropic_springs.h"

#include <catch2/catch.hpp>
#include <random>

#include "../mesh/embedded_block.h"
#include "../mesh/dome.h"
#include "mesh/embedded_lattice.h"
#include "mesh/topology.h"
#include "springs/energy_model_terms.h"
#include "springs/heuristic.h"
#include "springs/tissue_energy.h"

using namespace tissue;

namespace {

constexpr double E = 4524;

/// Smallest and largest W / (V mu (tr^2 / 2 + strain : strain)) over affine displacements of all kinds. W: energy of
/// the springs of an untrained energy model, without cells.
std::array<double, 2> stiffness_range(const SpringMesh& mesh) {
    const bool solid = mesh.is_solid();
    const Eigen::Index cells = mesh_cells(mesh).rows();
    const EnergyModelHeuristic heuristic = solid ? solid_heuristic(mesh, Eigen::VectorXd::Constant(mesh.spring_count(), E), Eigen::VectorXd::Constant(cells, E), E, 12, 0.007) : energy_model_heuristic(mesh, E, "plane-stress", 12);
    const EnergyModelTerms model_terms(mesh, heuristic, {"spring.all"});
    Eigen::VectorXd constants = model_terms.constants(Eigen::VectorXd::Zero(1));
    constants.tail(constants.size() - mesh.spring_count()).setZero();
    const TissueEnergy energy = model_terms.energy(mesh);
    const NodeField rest = NodeField::Zero(mesh.node_count(), mesh.dimension());
    const Eigen::SparseMatrix<double> K = energy.tangent(constants, rest);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> draw(-1, 1);
    std::array<double, 2> range{1e9, -1e9};
    for (int k = 0; k < 50; ++k) {
        PointMatrix strain = PointMatrix::Zero(mesh.dimension(), mesh.dimension());
        for (Eigen::Index i = 0; i < strain.rows(); ++i)
            for (Eigen::Index j = 0; j <= i; ++j) strain(i, j) = strain(j, i) = draw(random);
        // shear along the axes
        if (k == 0) strain.setZero(), strain(0, strain.cols() - 1) = strain(strain.rows() - 1, 0) = 1;
        // shear at 45 degrees
        if (k == 1) strain.setZero(), strain(0, 0) = 1, strain(strain.rows() - 1, strain.cols() - 1) = -1;
        const NodeField u = mesh.nodes * strain;
        Eigen::VectorXd flat(u.size());
        for (Eigen::Index n = 0; n < u.rows(); ++n) flat.segment(n * u.cols(), u.cols()) = u.row(n).transpose();
        const double V = mesh.node_measure.sum(), isotropic = V * E / 3 * (std::pow(strain.trace(), 2) / 2 + strain.squaredNorm()), has = flat.dot(K * flat) / 2;
        range[0] = std::min(range[0], has / isotropic), range[1] = std::max(range[1], has / isotropic);
    }
    return range;
}

}  // namespace

TEST_CASE("untrained springs on a lattice are isotropic with shear modulus E/3 to 1e-12", "[isotropic]") {
    for (const std::vector<double>& cell_mm : {std::vector<double>{10, 10, 10}, {10, 10}, {6, 10}, {10, 6}})
        for (const int n : {2, 4}) {
            std::vector<int> cells(cell_mm.size(), n);
            std::vector<double> size;
            for (const double mm : cell_mm) size.push_back(1e-3 * mm * n);
            const SpringMesh mesh = cell_mm.size() == 3 ? embedded_block(Lattice{cells, size}) : make_lattice("grid8", Lattice{cells, size});
            const auto [least, most] = stiffness_range(mesh);
            INFO(cell_mm[0] << " x " << cell_mm[1] << ", " << n << " cells");
            CHECK(std::abs(least - 1) < 1e-12);
            CHECK(std::abs(most - 1) < 1e-12);
        }
}

TEST_CASE("direction moments of a cube's springs are isotropic up to the sixth order", "[isotropic]") {
    const SpringMesh mesh = embedded_block(Lattice{{2, 2, 2}, {0.02, 0.02, 0.02}});
    const Eigen::VectorXd measure = isotropic_measure(mesh);
    double sum = 0, x2 = 0, x4 = 0, x6 = 0, x2y2 = 0, x4y2 = 0, x2y2z2 = 0;
    for (int s = 0; s < mesh.spring_count(); ++s) {
        const Eigen::Array3d n2 = (mesh.nodes.row(mesh.springs(s, 0)) - mesh.nodes.row(mesh.springs(s, 1))).transpose().normalized().array().square();
        sum += measure[s];
        x2 += measure[s] * n2[0];
        x4 += measure[s] * n2[0] * n2[0];
        x6 += measure[s] * std::pow(n2[0], 3);
        x2y2 += measure[s] * n2[0] * n2[1];
        x4y2 += measure[s] * n2[0] * n2[0] * n2[1];
        x2y2z2 += measure[s] * n2.prod();
    }
    const std::array<double, 6> is = {x2 / sum, x4 / sum, x6 / sum, x2y2 / sum, x4y2 / sum, x2y2z2 / sum}, all = {1 / 3.0, 1 / 5.0, 1 / 7.0, 1 / 15.0, 1 / 35.0, 1 / 105.0};
    for (std::size_t k = 0; k < is.size(); ++k) CHECK(is[k] == Approx(all[k]).epsilon(1e-12));
}

TEST_CASE("isotropic shares of squares are 1/2 and 1; too oblong cells have none; measure (7) is unchanged", "[isotropic]") {
    const RectangleShares square = *isotropic_shares({0.01, 0.01});
    CHECK(square.along_x == Approx(0.5));
    CHECK(square.along_y == Approx(0.5));
    CHECK(square.diagonal == Approx(1));
    CHECK_FALSE(isotropic_shares({0.01, 0.018}));
    // the measure of (7) itself is unchanged
    const SpringMesh mesh = embedded_block(Lattice{{2, 2, 2}, {0.02, 0.02, 0.02}});
    CHECK(mesh.incident_measure.maxCoeff() == Approx(1e-6));
    CHECK(isotropic_measure(mesh).sum() == Approx(mesh.incident_measure.sum()).epsilon(1e-12));
    const SpringMesh plane = make_lattice("grid8", 4, 4, 0.1, 0.1);
    CHECK(isotropic_measure(plane) == plane.incident_measure);
    const SpringMesh edges = make_lattice("grid4", 4, 4, 0.1, 0.12);
    CHECK(isotropic_measure(edges) == edges.incident_measure);
}

TEST_CASE("untrained springs in an embedded lattice are isotropic with cubes cut by the surface", "[isotropic][embedded]") {
    const SpringMesh mesh = embedded_lattice(dome(8), 0.0073);
    const auto [least, most] = stiffness_range(mesh);
    // without the lower limit of node_measure
    const double cubes_m3 = std::pow(0.0073, 3) * mesh.embedding.fraction.sum();
    CHECK(most - least < 1e-12);
    CHECK(most == Approx(cubes_m3 / mesh.node_measure.sum()).epsilon(1e-12));
}
