#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <random>

#include "springs/spring_law.h"

using namespace tissue;

namespace {

/// Smallest eigenvalue of K without the fixed nodes [N/m].
double smallest_eigenvalue(const SpringMesh& mesh, const Eigen::VectorXd& theta) {
    const Eigen::MatrixXd K(
        make_spring_law("axial")->stiffness(mesh, theta, NodeField::Zero(mesh.node_count(), mesh.dimension())));
    std::vector<int> free;
    for (int i = 0; i < K.rows(); ++i)
        if (!std::binary_search(mesh.fixed.begin(), mesh.fixed.end(), i / mesh.dimension())) free.push_back(i);
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K(free, free), Eigen::EigenvaluesOnly).eigenvalues()[0];
}

}  // namespace

TEST_CASE("axial grid8: the lower bound on theta keeps K positive definite for random sets and their means") {
    // K is linear in theta with positive semidefinite coefficients, so theta >= floor gives K(theta) >= floor K(1)
    const SpringMesh mesh = make_lattice("grid8", 6, 6, 0.1, 0.1);
    const double floor = 0.05, ceiling = 40;
    const double bound = floor * smallest_eigenvalue(mesh, Eigen::VectorXd::Ones(mesh.spring_count()));
    REQUIRE(bound > 0);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> exponent(std::log(floor), std::log(ceiling)), part(0, 1);
    NodeField sets(8, mesh.spring_count());
    for (double& k : sets.reshaped()) k = part(random) < 0.5 ? floor : std::exp(exponent(random));
    for (Eigen::Index s = 0; s < sets.rows(); ++s) CHECK(smallest_eigenvalue(mesh, sets.row(s)) >= 0.999999 * bound);
    for (int trial = 0; trial < 10; ++trial) {
        Eigen::VectorXd weights(8);
        for (double& w : weights) w = part(random);
        CHECK(smallest_eigenvalue(mesh, sets.transpose() * weights / weights.sum()) >= 0.999999 * bound);
    }
}
