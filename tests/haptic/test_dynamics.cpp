#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "../refusal.h"
#include "error.h"
#include "haptic/band_cholesky.h"
#include "haptic/dynamics.h"
#include "haptic/spectrum.h"
#include "haptic_example.h"
#include "springs/spring_law.h"

using Catch::Matchers::Contains;
using namespace tissue;

namespace {

NodeColumns scattered_columns(const RealtimeMesh& mesh, double size) {
    NodeColumns u(mesh.node_count(), 2);
    for (Eigen::Index i = 0; i < u.size(); ++i) u.data()[i] = size * std::sin(12.9898 * static_cast<double>(i + 1) + 78.2);
    return u;
}

NodeColumns with_fixed_at_rest(const RealtimeMesh& mesh, NodeColumns u) {
    for (int n = 0; n < mesh.node_count(); ++n)
        if (mesh.fixed(n)) u.row(n).setZero();
    return u;
}

double kinetic(const RealtimeMesh& mesh, const MeshState& s) {
    return 0.5 * (mesh.mass().asDiagonal() * s.velocity.cwiseAbs2()).sum();
}

double total(const RealtimeMesh& mesh, const MeshState& s) {
    return kinetic(mesh, s) + mesh.potential_energy(s.theta, s.displacement);
}

/// A lattice of cells x cells, its spring law and a set that is not symmetric.
struct Small {
    explicit Small(const std::string& law, const std::string& topology = "grid8", int cells = 3)
        : model(haptic_example({topology, law, cells})), mesh(model.mesh, law, model.node_mass_kg),
          theta(model.trained[0].theta.row(3).transpose()), slots(mesh.to_slots(theta)) {}
    TissueModel model;
    RealtimeMesh mesh;
    Eigen::VectorXd theta, slots;
};

/// Runs for `seconds` from the same initial state and returns u.
NodeColumns run(const std::string& kind, const Small& s, double dt, double seconds, double damping = 0) {
    const auto dynamics = make_dynamics(kind, s.mesh, {dt, damping});
    MeshState state(s.mesh, s.slots);
    state.displacement = with_fixed_at_rest(s.mesh, scattered_columns(s.mesh, 1e-3));
    const auto steps = static_cast<long>(std::lround(seconds / dt));
    for (long k = 0; k < steps; ++k) dynamics->step(state, {});
    return state.displacement;
}

}  // namespace

TEST_CASE("the force of the realtime mesh equals that of the spring law for ordered and shuffled nodes", "[dynamics]") {
    for (const std::string& law : spring_laws().names())
        for (int shuffled : {0, 1}) {
            TissueModel model = haptic_example({"grid8", law, 6});
            if (shuffled) {  // shuffled node numbers: every spring is loose
                const int N = model.mesh.node_count();
                std::vector<int> to(static_cast<std::size_t>(N));
                for (int n = 0; n < N; ++n) to[static_cast<std::size_t>(n)] = (n * 19) % N;
                SpringMesh mesh = model.mesh;
                for (int n = 0; n < N; ++n) mesh.nodes.row(to[static_cast<std::size_t>(n)]) = model.mesh.nodes.row(n);
                for (int s = 0; s < mesh.spring_count(); ++s)
                    for (int e : {0, 1}) mesh.springs(s, e) = to[static_cast<std::size_t>(model.mesh.springs(s, e))];
                for (int& n : mesh.facets.reshaped()) n = to[static_cast<std::size_t>(n)];
                for (int& n : mesh.fixed) n = to[static_cast<std::size_t>(n)];
                model.mesh = mesh;
            }
            const RealtimeMesh mesh(model.mesh, law, model.node_mass_kg);
            const Eigen::VectorXd theta = model.trained[0].theta.row(5).transpose();
            NodeField u(mesh.node_count(), 2);
            u = scattered_columns(mesh, 4e-3);
            const Eigen::VectorXd expected = make_spring_law(law)->force_matrix(model.mesh, u) * theta;
            NodeColumns f(mesh.node_count(), 2);
            mesh.force(mesh.to_slots(theta), u, f);
            const NodeField rows = f;
            CHECK((as_vector(rows) - expected).norm() < 1e-13 * expected.norm());
        }
}

TEST_CASE("spring force is the derivative of spring energy and spring stiffness is the derivative of spring force", "[dynamics]") {
    for (const std::string& law : spring_laws().names()) {
        const Small s(law);
        const NodeColumns u = scattered_columns(s.mesh, 5e-3), du = scattered_columns(s.mesh, 1.0).reverse();
        NodeColumns f(u), plus(u), minus(u);
        s.mesh.force(s.slots, u, f);
        const double h = 1e-7;
        const double slope = (s.mesh.potential_energy(s.slots, u + h * du) - s.mesh.potential_energy(s.slots, u - h * du)) / (2 * h);
        CHECK(slope == Approx(f.cwiseProduct(du).sum()).epsilon(1e-6));
        s.mesh.force(s.slots, u + h * du, plus);
        s.mesh.force(s.slots, u - h * du, minus);
        NodeColumns Kdu = NodeColumns::Zero(u.rows(), 2);
        for (int slot : s.mesh.slot_of_spring()) {
            const Eigen::Vector2i e = s.mesh.nodes_of_slot(slot);
            const Eigen::Vector2d k = s.slots[slot] * s.mesh.unit_stiffness(slot, u, false) * (du.row(e[0]) - du.row(e[1])).transpose();
            Kdu.row(e[0]) += k.transpose();
            Kdu.row(e[1]) -= k.transpose();
        }
        CHECK(((plus - minus) / (2 * h) - Kdu).norm() < 1e-6 * Kdu.norm());
    }
}

TEST_CASE("banded Cholesky agrees with a dense solver and refuses an indefinite matrix", "[dynamics]") {
    for (const std::string law : {"isotropic", "axial"}) {
        const Small s(law, "grid8", 5);
        const FreeNumbering numbering(s.mesh);
        BandCholesky A(numbering.order, numbering.half_bandwidth);
        add_stiffness(s.mesh, numbering, s.slots, NodeColumns::Zero(s.mesh.node_count(), 2), 1, false, A);
        Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(numbering.order, numbering.order);
        for (int c = 0; c < numbering.order; ++c)
            for (int r = c; r < std::min(numbering.order, c + numbering.half_bandwidth + 1); ++r)
                dense(r, c) = dense(c, r) = A.at(r, c);
        const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(numbering.order, -1, 2);
        Eigen::VectorXd x = b;
        REQUIRE(A.factor());
        A.solve(x.data());
        CHECK((x - dense.ldlt().solve(b)).norm() < 1e-10 * x.norm());
    }
    BandCholesky indefinite(2, 1);
    indefinite.at(0, 0) = 1;
    indefinite.at(1, 0) = 2;
    indefinite.at(1, 1) = 1;
    CHECK_FALSE(indefinite.factor());
}

TEST_CASE("the extreme eigenvalues of a spring mesh match those of a dense eigenvalue solver", "[dynamics]") {
    for (const std::string law : {"isotropic", "axial"}) {
        const Small s(law, "grid8", 4);
        const SparseMatrix K = make_spring_law(law)->stiffness(s.model.mesh, s.theta, NodeField::Zero(s.mesh.node_count(), 2));
        std::vector<int> free;
        for (int n = 0; n < s.mesh.node_count(); ++n)
            for (int d : {0, 1})
                if (!s.mesh.fixed(n)) free.push_back(2 * n + d);
        Eigen::MatrixXd scaled(free.size(), free.size());
        for (std::size_t i = 0; i < free.size(); ++i)
            for (std::size_t j = 0; j < free.size(); ++j)
                scaled(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
                    K.coeff(free[i], free[j]) / std::sqrt(s.mesh.mass()[free[i] / 2] * s.mesh.mass()[free[j] / 2]);
        const Eigen::VectorXd exact = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues();
        const double largest = largest_eigenvalue(s.mesh, s.slots);
        CHECK(largest >= exact.maxCoeff() * (1 - 1e-9));
        CHECK(largest <= exact.maxCoeff() * 1.02);
        CHECK(smallest_eigenvalue(s.mesh, s.slots) == Approx(exact.minCoeff()).epsilon(1e-4));
    }
    const Small singular("axial", "grid4");
    CHECK(smallest_eigenvalue(singular.mesh, singular.slots) == 0);
}

TEST_CASE("symplectic and implicit steps are of first order in dt", "[dynamics]") {
    for (const std::string& law : spring_laws().names())
        for (const std::string kind : {"symplectic", "implicit"}) {
            const Small s(law);
            const double seconds = 0.016;
            const NodeColumns exact = run("symplectic", s, 1e-7, seconds, 2.0);
            const double coarse = (run(kind, s, 2e-5, seconds, 2.0) - exact).norm();
            const double fine = (run(kind, s, 1e-5, seconds, 2.0) - exact).norm();
            CHECK(std::log2(coarse / fine) == Approx(1).margin(0.1));
        }
}

TEST_CASE("symplectic steps keep energy within a band and implicit steps reduce it and the paper's step diverges", "[dynamics]") {
    const Small s("isotropic", "grid4", 10);
    const auto energies = [&](const std::string& kind, int steps) {
        const auto dynamics = make_dynamics(kind, s.mesh, {1e-3, 0});
        MeshState state(s.mesh, s.slots);
        state.displacement = with_fixed_at_rest(s.mesh, scattered_columns(s.mesh, 1e-3));
        std::vector<double> e = {total(s.mesh, state)};
        for (int k = 0; k < steps; ++k) {
            dynamics->step(state, {});
            e.push_back(total(s.mesh, state));
        }
        return e;
    };
    REQUIRE(std::sqrt(largest_eigenvalue(s.mesh, s.slots)) * 1e-3 < 1);
    const std::vector<double> symplectic = energies("symplectic", 20000), implicit = energies("implicit", 2000),
                              paper = energies("paper", 400);
    for (double e : symplectic) REQUIRE(e < 2.5 * symplectic[0]);
    CHECK(symplectic.back() > 0.4 * symplectic[0]);
    for (std::size_t k = 1; k < implicit.size(); ++k) REQUIRE(implicit[k] <= implicit[k - 1] * (1 + 1e-12));
    CHECK(paper[100] > 100 * paper[0]);
    CHECK(paper[400] > 1e6 * paper[100]);
}

TEST_CASE("the time integration and its number of steps follow from the largest eigenvalue", "[dynamics]") {
    CHECK(stable_dynamics(1.79e3 * 1.79e3, 1e-3) == "symplectic");
    CHECK(stable_dynamics(1.81e3 * 1.81e3, 1e-3) == "implicit");
    CHECK(energy_model_substeps(0, 1e-3) == 1);
    CHECK(energy_model_substeps(1.99e3 * 1.99e3, 1e-3) == 3);
    CHECK(energy_model_substeps(2.01e3 * 2.01e3, 1e-3) == 4);
    CHECK(energy_model_contact_damping_s(1e6, 1e-3, 2) == contact_damping_s(1e-3, 2));
    CHECK(energy_model_contact_damping_s(36e6, 1e-3, 9) == Approx(1.75e-3 / 9));  // (omega h)^2 = 4 / 9
    for (const double much : {1e9 * 1e9, std::numeric_limits<double>::infinity(), std::nan("")})
        CHECK_THAT(refusal<MismatchError>([&] { energy_model_substeps(much, 1e-3); }), Contains("at most 1000"));
    // The limit is omega dt = 2: a mesh just above it diverges, one just below it does not.
    Small s("isotropic", "grid4", 10);
    const double omega = std::sqrt(largest_eigenvalue(s.mesh, s.slots));
    for (double product : {1.98, 2.03}) {
        const NodeColumns u = run("symplectic", s, product / omega, 3000 * product / omega);
        CHECK((u.norm() < 1) == (product < 2));
    }
}

TEST_CASE("the implicit step of 1 ms is stable for springs 1000 times stiffer and comes to rest", "[dynamics]") {
    for (const std::string& law : spring_laws().names()) {
        Small s(law, "grid8", 10);
        s.slots *= 1000;
        const auto dynamics = make_dynamics("implicit", s.mesh, {1e-3, 1});
        MeshState state(s.mesh, s.slots);
        const int node = s.mesh.outline()[25];
        ContactLoad load{{node, node}, {1, 0}, 1e5, s.mesh.rest().row(node).transpose() + Eigen::Vector2d(0.002, -0.01), Eigen::Vector2d(0, 0)};
        Eigen::Vector2d force = Eigen::Vector2d::Zero(), before = force;
        for (int k = 0; k < 4000; ++k) {
            before = force;
            force = dynamics->step(state, load);
            REQUIRE(state.displacement.allFinite());
            REQUIRE(state.displacement.norm() < 1);
        }
        CHECK((force - before).norm() < 1e-6 * force.norm());
        CHECK((load.proxy(s.mesh, state.displacement) - load.master_m).norm() < 0.2 * 0.01);
    }
}

TEST_CASE("implicit and symplectic coupling agree within 0.1 % at steps of 1 us", "[dynamics]") {
    for (const std::string law : {"isotropic", "axial"}) {
        const Small s(law);
        const std::vector<int>& outline = s.mesh.outline();
        const ContactLoad load{{outline[5], outline[6]}, {0.3, 0.7}, 5, {0.05, 0.08}, Eigen::Vector2d(1e-3, 2e-3)};
        MeshState a(s.mesh, s.slots), b = a;
        const auto one = make_dynamics("symplectic", s.mesh, {1e-6, 1}), two = make_dynamics("implicit", s.mesh, {1e-6, 1});
        Eigen::Vector2d fa = Eigen::Vector2d::Zero(), fb = fa;
        for (int k = 0; k < 5000; ++k) {
            fa = one->step(a, load);
            fb = two->step(b, load);
        }
        CHECK((a.displacement - b.displacement).norm() < 1e-3 * a.displacement.norm());
        CHECK((fa - fb).norm() < 1e-3 * fa.norm());
    }
}

TEST_CASE("the tool's force on the end nodes has the resultant and moment and power of -f at the proxy", "[dynamics][contact]") {
    const Small s("axial");
    const std::vector<int>& outline = s.mesh.outline();
    for (double w : {0.0, 0.2, 0.5, 1.0}) {
        // From rest, the momentum of the nodes after one step is dt times the forces on them.
        const auto dynamics = make_dynamics("symplectic", s.mesh, {1e-3, 0});
        MeshState state(s.mesh, s.slots);
        const ContactLoad load{{outline[4], outline[5]}, {1 - w, w}, 3, {0.07, 0.05}, Eigen::Vector2d(0, 0)};
        const Eigen::Vector2d proxy = load.proxy(s.mesh, state.displacement);
        const Eigen::Vector2d f = 3 * (proxy - load.master_m);  // on the hand
        const Eigen::Vector2d returned = dynamics->step(state, load);
        CHECK((returned + f).norm() < 1e-15);
        const NodeColumns nodal = s.mesh.mass().asDiagonal() * state.velocity / 1e-3;
        CHECK((nodal.colwise().sum().transpose() + f).norm() < 1e-14);
        const auto moment = [](const Eigen::Vector2d& x, const Eigen::Vector2d& force) { return x.x() * force.y() - x.y() * force.x(); };
        double moments = 0, power = 0;
        NodeColumns v = scattered_columns(s.mesh, 0.1);
        for (int n = 0; n < s.mesh.node_count(); ++n) {
            moments += moment(s.mesh.rest().row(n), nodal.row(n));
            power += nodal.row(n).dot(v.row(n));
        }
        CHECK(moments == Approx(-moment(proxy, f)).margin(1e-15));
        CHECK(power == Approx(-f.dot((1 - w) * v.row(outline[4]) + w * v.row(outline[5]))).margin(1e-15));
    }
}

TEST_CASE("the implicit step balances momentum at its end with the force that it returns", "[dynamics][contact]") {
    for (const std::string law : {"isotropic", "axial"}) {
        const Small s(law);
        const double dt = 1e-3, damping = 3;
        const std::vector<int>& outline = s.mesh.outline();
        const ContactLoad load{{outline[5], outline[6]}, {0.3, 0.7}, 50, {0.05, 0.08}, Eigen::Vector2d(1e-3, 2e-3)};
        const auto dynamics = make_dynamics("implicit", s.mesh, {dt, damping});
        MeshState state(s.mesh, s.slots);
        state.displacement = with_fixed_at_rest(s.mesh, scattered_columns(s.mesh, 1e-3));
        for (int k = 0; k < 5; ++k) {
            const NodeColumns before = state.velocity;
            state.theta *= 1.2;  // as the moving average changes it
            state.theta_changed = true;
            const Eigen::Vector2d f = dynamics->step(state, load);
            CHECK((f - load.given_N - 50 * (load.master_m - load.proxy(s.mesh, state.displacement))).norm() < 1e-12);
            NodeColumns residual(s.mesh.node_count(), 2);
            s.mesh.force(state.theta, state.displacement, residual);
            residual += s.mesh.mass().asDiagonal() * ((state.velocity - before) / dt + damping * state.velocity);
            for (int end : {0, 1}) residual.row(load.node[end]) -= load.weight[end] * f.transpose();
            CHECK(with_fixed_at_rest(s.mesh, residual).norm() < 1e-12);
        }
    }
}

TEST_CASE("an invalid step or mass or spring law and a mesh too large to factor are refused", "[dynamics]") {
    const Small s("axial");
    CHECK(refusal<MismatchError>([&] { make_dynamics("leapfrog", s.mesh, {}); }).find("paper, symplectic, implicit") != std::string::npos);
    refusal<MismatchError>([&] { make_dynamics("paper", s.mesh, {0, 0}); });
    refusal<MismatchError>([&] { RealtimeMesh(s.model.mesh, "axial", Eigen::VectorXd::Zero(s.mesh.node_count())); });
    refusal<MismatchError>([&] { RealtimeMesh(s.model.mesh, "elastic", s.model.node_mass_kg); });
    refusal<MismatchError>([&] { s.mesh.to_slots(Eigen::VectorXd::Ones(3)); });
    const TissueModel large = haptic_example({"grid8", "axial", 240});
    const RealtimeMesh mesh(large.mesh, "axial", large.node_mass_kg);
    CHECK(refusal<MismatchError>([&] { make_dynamics("implicit", mesh, {}); }).find("too large") != std::string::npos);
}
