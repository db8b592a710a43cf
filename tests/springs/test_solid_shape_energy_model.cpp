#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "error.h"
#include "mesh/solid_block.h"
#include "mesh/embedded_lattice.h"
#include "mesh/cells.h"
#include "springs/disc_contact.h"
#include "springs/disc_rows.h"
#include "springs/energy_model_terms.h"
#include "springs/heuristic.h"
#include "springs/indentation_solver.h"
#include "../mesh/dome.h"
#include "../tolerances.h"

using namespace tissue;
using Approx = Catch::Detail::Approx;
using Catch::Matchers::Contains;

namespace {

EnergyModelTerms energy_model_on(const SpringMesh& mesh, const std::vector<std::string>& terms) {
    return {mesh, solid_heuristic(mesh, Eigen::VectorXd::Constant(mesh.spring_count(), 4524), Eigen::VectorXd::Constant(cell_count(mesh), 4524), 4524, 12, 0.007), terms};
}

}  // namespace

TEST_CASE("springs of a cut lattice have shear modulus E/3 and its cells 0.95 of their cap as bulk modulus", "[solid_shape]") {
    const SpringMesh mesh = embedded_lattice(dome(12), 0.011);
    const Eigen::Index S = mesh.spring_count(), C = cell_count(mesh);
    const EnergyModelTerms model_terms = energy_model_on(mesh, {"spring.all"});
    Eigen::VectorXd constants = model_terms.constants(Eigen::VectorXd::Zero(1)), springs = constants, cells = constants;
    springs.tail(C + mesh.support_count()).setZero();
    cells.head(S).setZero();
    cells.tail(mesh.support_count()).setZero();
    const TissueEnergy energy = model_terms.energy(mesh);
    CHECK(energy.constant_count() == S + C + mesh.support_count());
    const double e = 1e-5, V = mesh.embedding.fraction.sum() * std::pow(0.011, 3);
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3;
        NodeField slide = NodeField::Zero(mesh.node_count(), 3), stretch = slide;
        slide.col(a) = 2 * e * mesh.nodes.col(b);
        stretch.col(a) = e * mesh.nodes.col(a);
        stretch.col(b) = -e * mesh.nodes.col(b);
        CHECK(energy.energy(springs, slide) / (2 * e * e * V) == Approx(4524.0 / 3).epsilon(1e-3));
        CHECK(energy.energy(springs, stretch) / (2 * e * e * V) == Approx(4524.0 / 3).epsilon(1e-3));
    }
    CHECK(energy.energy(cells, e * mesh.nodes) == Approx(0.95 * 12 * 4524 * 9 * e * e * V / 2).epsilon(1e-4));
    CHECK(energy.smallest_ratio(0.1 * mesh.nodes) == Approx(1.331).epsilon(1e-9));
    NodeField mirror = NodeField::Zero(mesh.node_count(), 3);
    mirror.col(2) = -2 * mesh.nodes.col(2);
    CHECK(energy.smallest_ratio(mirror) == Approx(-1).epsilon(1e-9));
}

TEST_CASE("location terms are accepted on an embedded solid except wall and surface and held terms", "[solid_shape]") {
    const SpringMesh mesh = embedded_lattice(dome(6), 0.011);
    for (const char* term : {"spring.all", "cell.all", "spring.layer", "cell.layer", "spring.along",
                             "spring.across.layer", "spring.upright", "spring.top", "cell.bottom", "spring.z", "cell.z2", "spring.x2", "spring.face", "spring.body", "spring.vertical", "contact.normal.curved", "support.all"})
        CHECK_NOTHROW(energy_model_on(mesh, {term}));
    // lattice nodes are neither on the surface nor fixed
    for (const char* term : {"spring.wall", "cell.wall", "spring.surface", "cell.surface", "spring.held"})
        CHECK_THROWS_WITH(energy_model_on(mesh, {term}), Contains("is not possible here; allowed: all, layer, top, bottom, nodule, x2"));
    CHECK_THROWS_WITH(energy_model_on(mesh, {"contact.normal.phase"}), Contains("optionally followed by one of .curved, .ground, .edge"));
}

/// A slab of 80 x 80 x 20 mm in boxes of 10 mm, with its nodes moved by `move`, in a lattice of 10 mm.
template <class Move>
SpringMesh slab(const Move& move) {
    Shape shape = solid_block(Lattice{{8, 8, 2}, {0.08, 0.08, 0.02}});
    for (Eigen::Index i = 0; i < shape.nodes.rows(); ++i) shape.nodes.row(i) = move(Eigen::Vector3d(shape.nodes.row(i).transpose())).transpose();
    return embedded_lattice(shape, 0.01);
}

TEST_CASE("a disc's curvature factor is R / radius on a cap, negative in a valley and 0 on a saddle", "[solid_shape]") {
    const double R = 0.007, radius_m = 0.1;
    const auto bent = [&](double along_x, double along_y) {
        const SpringMesh mesh = slab([&](Eigen::Vector3d x) {
            x[2] -= x[2] / 0.02 * (along_x * std::pow(x[0] - 0.04, 2) + along_y * std::pow(x[1] - 0.04, 2)) / (2 * radius_m);
            return x;
        });
        return DiscContact(mesh, R).rows_at(Eigen::Vector3d(0.04, 0.04, 0.02)).factors[ContactParameters::curved_factor];
    };
    CHECK(bent(0, 0) == Approx(0).margin(1e-12));
    CHECK(bent(1, 1) == Approx(R / radius_m).epsilon(0.02));
    CHECK(bent(-1, -1) == Approx(-R / radius_m).epsilon(0.02));
    CHECK(bent(1, 0) == Approx(R / radius_m / 2).epsilon(0.02));
    CHECK(bent(1, -1) == Approx(0).margin(0.02 * R / radius_m));
}

TEST_CASE("a softening contact falls to half its stiffness; softening terms exclude hardening terms", "[solid_shape]") {
    const SpringMesh mesh = embedded_lattice(dome(6), 0.011);
    const EnergyModelTerms model_terms = energy_model_on(mesh, {"contact.softening"});
    const ContactRows rows = DiscContact(mesh, 0.007).rows_at(Eigen::Vector3d(0, 0, 0.05));
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(3 * rows.nodes.size());
    ContactRows mean = rows;  // without the imprint, which does not soften
    mean.push.conservativeResize(3, 3);
    mean.pull.conservativeResize(3, rows.pull.cols());
    mean.share.conservativeResize(3);
    mean.parameter_row.resize(3);
    const auto stiffness = [&](double depth_m, double coefficient) {
        ContactSpring spring(mean, model_terms.patch(Eigen::VectorXd::Constant(1, coefficient)));
        spring.coupling_N_m2 = 0;
        return spring.load(rows.push.row(0).transpose() * depth_m, rest).tool_force_N.norm() / depth_m;
    };
    const double k = stiffness(1e-9, 0);
    const Eigen::VectorXd start = start_of_disc(4524, 0.007, mesh.embedding.spacing_m).array().exp();
    CHECK(k == Approx(start[0]).epsilon(1e-6));
    CHECK(stiffness(1, 0) == Approx(k / 2).epsilon(0.01));
    const double v = start[ContactParameters::hardening_row], s = k * 25e-6 / 2;
    CHECK(stiffness(5e-3, 0) == Approx(k * (1 + v * s + v * v * s * s / 2) / std::pow(1 + v * s, 2)).epsilon(1e-9));
    CHECK(stiffness(5e-3, 1) < stiffness(5e-3, 0));
    for (const char* term : {"contact.hardening", "contact.saturation", "contact.hardening.curved"}) {
        CHECK_THROWS_WITH(energy_model_on(mesh, {"contact.softening", term}), Contains("use `hardening` with `saturation`, or `softening`"));
        CHECK_THROWS_WITH(energy_model_on(mesh, {term, "contact.softening.curved"}), Contains("use `hardening` with `saturation`, or `softening`"));
    }
}

TEST_CASE("implicit derivatives of an indented dome agree with finite differences", "[solid_shape][long]") {
    const SpringMesh mesh = embedded_lattice(dome(8), 0.011);
    const EnergyModelTerms model_terms = energy_model_on(mesh, {"spring.all", "cell.layer", "spring.along.layer", "contact.normal", "contact.imprint_normal", "contact.softening", "contact.normal.curved",
                                       "contact.tangent.curved", "contact.softening.curved", "support.all"});
    const TissueEnergy energy = model_terms.energy(mesh);
    const DiscContact kernel(mesh, 0.007, {{}, {-9, 9}, {NodeField::Constant(mesh.facets.rows(), 3, 0.4)}});
    EquilibriumSolver solver(energy, kernel);
    const Eigen::VectorXd p = Eigen::VectorXd::LinSpaced(model_terms.size(), -0.2, 0.2);
    const Eigen::Vector3d at = FreeSurface(mesh).nearest(Eigen::Vector3d(0.02, 0.013, 0.05)).point_m, push(-2e-3, 1e-3, -3e-3);
    const auto pressed = [&](const Eigen::VectorXd& q) { return solver.indent(model_terms.constants(q), ContactSpring(kernel.rows_at(at), model_terms.patch(q)), push); };
    const EquilibriumState state = pressed(p);
    REQUIRE(state.status == SolverStatus::converged);
    CHECK(state.contact_force_N.dot(push) > 0);
    const EquilibriumDerivative by = solver.derivative(model_terms.constants_by(p), model_terms.stiffness_by(p, kernel.rows_at(at).factors, kernel.rows_at(at).log_scale));
    for (Eigen::Index t = 0; t < p.size(); ++t) {
        Eigen::VectorXd low = p, high = p;
        low[t] -= 1e-4;
        high[t] += 1e-4;
        const EquilibriumState a = pressed(low), b = pressed(high);
        CHECK((by.contact_force.col(t) - Eigen::VectorXd((b.contact_force_N - a.contact_force_N) / 2e-4)).norm() < 1e-5 * state.contact_force_N.norm());
        const NodeField moved = (b.displacement - a.displacement) / 2e-4;
        CHECK((by.displacement.col(t) - as_vector(moved)).norm() < 1e-5 * state.displacement.norm());
    }
}

TEST_CASE("supports hold an embedded solid without cells; two blocks far apart make no connected lattice", "[embedded]") {
    const SpringMesh mesh = embedded_lattice(dome(8), 0.011);
    const EnergyModelTerms model_terms = energy_model_on(mesh, {"spring.all"});
    const Eigen::VectorXd untrained = model_terms.constants(Eigen::VectorXd::Zero(1)), uniform = springs_alone(mesh, untrained, uniform_stiffness(mesh, 5));
    CHECK(uniform.head(mesh.spring_count()).maxCoeff() == 5);
    CHECK(uniform.head(mesh.spring_count()).minCoeff() == 2.5);  // diagonals
    CHECK(uniform.segment(mesh.spring_count(), cell_count(mesh)).isZero(0));
    REQUIRE(mesh.support_count() > 10);
    CHECK(uniform.tail(mesh.support_count()) == untrained.tail(mesh.support_count()));
    const TissueEnergy energy = model_terms.energy(mesh);
    const DiscContact kernel(mesh, 0.007);
    EquilibriumSolver solver(energy, kernel);
    const Point top = FreeSurface(mesh).nearest(Eigen::Vector3d(0, 0, 0.05)).point_m;
    const EquilibriumState state = solver.indent(uniform, ContactSpring(kernel.rows_at(top), model_terms.patch(Eigen::VectorXd::Zero(1))), Eigen::Vector3d(0, 0, -0.004));
    REQUIRE(state.status == SolverStatus::converged);
    for (int node : mesh.fixed) CHECK(state.displacement.row(node).norm() < 1e-4);

    const auto two_blocks = [](double gap_m) {
        Shape one = solid_block(Lattice{{2, 2, 2}, {0.02, 0.02, 0.02}}), both = one;
        const auto n = static_cast<int>(one.nodes.rows());
        both.nodes.conservativeResize(2 * n, 3);
        both.nodes.bottomRows(n) = one.nodes.rowwise() + Eigen::RowVector3d(0.02 + gap_m, 0, 0);
        both.simplices.conservativeResize(2 * one.simplices.rows(), 4);
        both.simplices.bottomRows(one.simplices.rows()) = one.simplices.array() + n;
        for (const auto& f : one.fixed_facets) both.fixed_facets.push_back({f[0] + n, f[1] + n, f[2] + n});
        return both;
    };
    CHECK_NOTHROW(embedded_lattice(two_blocks(0.001), 0.006));
    CHECK_THROWS_WITH(embedded_lattice(two_blocks(0.02), 0.006), Contains("is not connected"));
}
