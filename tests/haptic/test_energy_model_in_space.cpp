// The tick of an energy model in space: its forces, its energy in motion, and its highest frequency.
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "../mesh/embedded_block.h"
#include "../example.h"
#include "../mesh/dome.h"
#include "../refusal.h"
#include "../solid_model_example.h"
#include "error.h"
#include "tick_forces.h"
#include "haptic/dynamics.h"
#include "mesh/embedded_lattice.h"
#include "haptic/energy_model_spectrum.h"
#include "haptic/simulation.h"
#include "haptic/realtime_energy_model.h"
#include "haptic/spectrum.h"
#include "haptic/support_mass.h"
#include "mesh/free_surface.h"
#include "springs/energy_model_terms.h"
#include "springs/heuristic.h"
#include "springs/energy_model_kernel.h"
#include "springs/indentation_solver.h"
#include "springs/equilibrium_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// A block of whole cubes, and a solid whose surface cuts cubes.
std::vector<SpringMesh> meshes() { return {embedded_block(Lattice{{5, 6, 2}, {0.05, 0.06, 0.02}}), embedded_lattice(dome(6), 0.011)}; }

/// Squared angular frequencies of the free nodes, ascending [1/s2].
Eigen::VectorXd eigenvalues(const RealtimeMesh& mesh, const Eigen::MatrixXd& K) {
    std::vector<int> free;
    for (int node = 0; node < mesh.node_count(); ++node)
        for (int axis = 0; axis < 3 && !mesh.fixed(node); ++axis) free.push_back(3 * node + axis);
    Eigen::MatrixXd A = K(free, free);
    for (std::size_t i = 0; i < free.size(); ++i)
        for (std::size_t j = 0; j < free.size(); ++j)
            A(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) *= std::sqrt(mesh.inverse_mass()[free[i] / 3] * mesh.inverse_mass()[free[j] / 3]);
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

}  // namespace

TEST_CASE("in space forces and energy in the tick equal those of the trained energy model", "[solid][law]") {
    for (const SpringMesh& mesh : meshes())
        for (double size : {1e-6, 1e-3, 3e-3}) {
            const TissueModel model = solid_model_example(mesh);
            const TissueEnergy energy(mesh, *model.energy_model);
            NodeField u = scattered(mesh, size);
            energy.complete(u);
            INFO(mesh.topology << " " << size);
            check_tick_forces(model, energy, u, size < 1e-5 ? 1e-9 : 1e-12, 1e-9);  // l - L cancels in the tick's springs
        }
}

TEST_CASE("extra mass at stiff supports limits the highest frequency and keeps the slowest mode", "[solid][law][embedded][long]") {
    for (const SpringMesh& mesh : {embedded_block(Lattice{{5, 6, 2}, {0.05, 0.06, 0.02}}), embedded_lattice(dome(6), 0.011), embedded_lattice(dome(8), 0.008)}) {
        TissueModel model = solid_model_example(mesh);
        const TissueEnergy energy(mesh, *model.energy_model);
        const NodeField rest = NodeField::Zero(mesh.node_count(), 3);
        const auto tangent = [&] { return energy.tangent(model.energy_model->constants, rest); };
        Eigen::VectorXd& constants = model.energy_model->constants;
        const Eigen::VectorXd trained = constants.tail(mesh.support_count());
        constants.tail(mesh.support_count()).setZero();
        const double lattice = largest_eigenvalue(springs_of(model), tangent());
        constants.tail(mesh.support_count()) = 50 * trained;
        const double bare = largest_eigenvalue(springs_of(model), tangent()), slowest = smallest_eigenvalue(springs_of(model), tangent());
        const RealtimeMesh heavy(mesh, model.energy_model->curve, mass_with_supports(model));
        INFO(mesh.embedding.cubes.rows() << " cubes, without mass " << bare / lattice << ", with it " << largest_eigenvalue(heavy, tangent()) / lattice << ", slowest " << smallest_eigenvalue(heavy, tangent()) / slowest);
        CHECK(bare > 4 * lattice);
        // a dome has cubes with little tissue
        CHECK(largest_eigenvalue(heavy, tangent()) < (mesh.embedding.fraction.minCoeff() > 0.99 ? 1.05 : 2.1) * lattice);
        CHECK(smallest_eigenvalue(heavy, tangent()) >= 0.989 * slowest);
        CHECK(smallest_eigenvalue(heavy, tangent()) <= 1.0001 * slowest);
        CHECK(HapticModel(model, {}).meshes.front()->springs.mass() == heavy.mass());

        constants.tail(mesh.support_count()) = 0.01 * trained;  // soft supports need none
        CHECK(mass_with_supports(model) == model.node_mass_kg);
    }
}

TEST_CASE("a force on a node of an embedded solid does the same work on its lattice", "[solid][embedded]") {
    const TissueModel model = solid_model_example(embedded_lattice(dome(6), 0.011));
    const Embedding& embedding = model.mesh.embedding;
    const int K = embedding.node_count();
    NodeColumns u = scattered(model.mesh, 1e-3), f = NodeColumns::Zero(model.mesh.node_count(), 3);
    embedding.interpolate(u);
    const Eigen::Vector3d force{1, -2, 3};
    for (int node : {0, 7, K - 1}) {
        f.setZero();
        const double work = force.dot(u.row(node));
        embedding.spread(node, force, f);
        CHECK((f.bottomRows(f.rows() - K).array() * u.bottomRows(f.rows() - K).array()).sum() == Approx(work).epsilon(1e-12));
    }
}

TEST_CASE("trained curvature range and correction of a contact apply in evaluation and in the tick and after reading a file", "[solid][embedded][long]") {
    TissueModel free = solid_model_example(embedded_lattice(dome(6), 0.011));
    free.energy_model->patch.log_N_m.col(ContactParameters::curved_factor).head<4>().setConstant(1.5);
    const SpringMesh& mesh = free.mesh;
    const FreeSurface surface(mesh);
    const auto facet = static_cast<int>(std::find_if(surface.free_of().begin(), surface.free_of().end(), [](Eigen::Index number) { return number > 20; }) - surface.free_of().begin());
    REQUIRE(facet < mesh.facets.rows());
    const Eigen::Vector3d weight = Eigen::Vector3d::Constant(1.0 / 3);
    const FreeSurface::Place at = surface.place(surface.free_of()[static_cast<std::size_t>(facet)], weight);
    const double curved = make_contact_kernel(mesh, *free.energy_model)->rows_at(at.point_m).factors[ContactParameters::curved_factor];
    TissueModel model = free;
    model.energy_model->disc.curved_range = {curved - 0.6, curved - 0.4};
    model.energy_model->disc.correction.value.setConstant(mesh.facets.rows(), 10, -0.3);
    const TemporaryFolder folder;
    free.heuristic_b = model.heuristic_b = model.heuristic_a;
    for (TissueModel* m : {&free, &model}) {
        m->contact_m = at.point_m.transpose();
        m->direction = at.inward.transpose();
    }
    write_model(folder.file("model.h5"), model, {"tissuectl test", 0, {}});
    const TissueModel back = read_model(folder.file("model.h5"));

    const Point push = 0.002 * at.inward;
    const double soft_N = IndentationSolver(model).at(at.point_m, push).contact_force.norm();
    CHECK(soft_N < 0.9 * IndentationSolver(free).at(at.point_m, push).contact_force.norm());
    CHECK(IndentationSolver(back).at(at.point_m, push).contact_force.norm() == soft_N);

    const RealtimeMesh springs = springs_of(model);
    const RealtimeEnergyModel energy_model(model, springs);
    ToolSpring tool;
    energy_model.contacts().at(facet, weight, {}, tool);
    const ContactSpring trained(make_contact_kernel(mesh, *model.energy_model)->rows_at(at.point_m), model.energy_model->patch);
    const NodeColumns rest = NodeColumns::Zero(mesh.node_count(), 3);
    CHECK(tool.energy_J(push, rest) == Approx(trained.load(push, Eigen::VectorXd::Zero(trained.rows.pull.cols())).energy_J).epsilon(1e-9));
    const ContactSpring unclamped(make_contact_kernel(mesh, *free.energy_model)->rows_at(at.point_m), free.energy_model->patch);
    CHECK(unclamped.k_N_m[0] == Approx(trained.k_N_m[0] * std::exp(1.5 * 0.4 + 0.3)));

    CHECK(HapticModel(model, {}).fingerprint == HapticModel(back, {}).fingerprint);
    CHECK(HapticModel(model, {}).fingerprint != HapticModel(free, {}).fingerprint);
}

TEST_CASE("in space spring forces in the tick equal those of the spring law for any order of lattice nodes", "[solid][dynamics]") {
    const SpringMesh lattice = embedded_block(Lattice{{5, 6, 2}, {0.05, 0.06, 0.02}});
    for (const bool shuffled : {false, true}) {
        SpringMesh mesh = lattice;
        const int N = mesh.node_count(), own = mesh.embedding.node_count();
        if (shuffled) {
            std::vector<int> order(static_cast<std::size_t>(N));
            std::iota(order.begin(), order.end(), 0);
            std::mt19937 random(7);
            for (int n = N - 1; n > own; --n) std::swap(order[static_cast<std::size_t>(n)], order[static_cast<std::size_t>(own) + random() % static_cast<unsigned>(n + 1 - own)]);
            const auto to = [&](int node) { return order[static_cast<std::size_t>(node)]; };
            for (int n = 0; n < N; ++n) mesh.nodes.row(to(n)) = lattice.nodes.row(n);
            for (int& n : mesh.springs.reshaped()) n = to(n);
            for (int& n : mesh.embedding.cubes.reshaped()) n = to(n);
            for (int& n : mesh.embedding.corner.reshaped()) n = to(n);
        }
        Eigen::VectorXd masses = Eigen::VectorXd::Ones(N);
        masses.head(own).setZero();
        const SpringCurve curve = shuffled ? SpringCurve() : SpringCurve::mooney_rivlin(0.3, 3);
        const RealtimeMesh springs(mesh, curve, masses);
        CHECK(springs.bands().size() >= 13);  // one per direction
        for (const RealtimeMesh::Band& band : springs.bands()) CHECK(band.alike);
        Eigen::VectorXd theta = mesh.incident_measure * 1e6;
        for (Eigen::Index s = 0; s < theta.size(); ++s) theta[s] *= 1 + 0.3 * std::sin(1.7 * static_cast<double>(s));
        const NodeField u = scattered(mesh, 4e-3);  // some springs are so short that their curve is linear
        const auto law = make_turning_law(curve);
        const Eigen::VectorXd expected = law->force_matrix(mesh, u) * theta;
        NodeColumns f = NodeColumns::Zero(N, 3), u_by_row = NodeColumns::Zero(springs.rows().count(), 3), f_by_row = u_by_row;
        springs.rows().scatter(u, u_by_row);
        springs.force(springs.to_slots(theta), u_by_row, f_by_row);
        springs.rows().gather(f_by_row, f);
        const NodeField rows = f;
        CHECK((as_vector(rows) - expected).norm() < 1e-13 * expected.norm());

        const SparseMatrix K = law->stiffness(mesh, theta, NodeField::Zero(N, 3));
        CHECK((springs.stiffness_at_rest(springs.to_slots(theta)) - K).norm() < 1e-13 * K.norm());
        const Eigen::VectorXd exact = eigenvalues(springs, K);
        // bound by isotropic springs
        CHECK(largest_eigenvalue(springs, springs.to_slots(theta)) >= exact[exact.size() - 1]);
    }
}

TEST_CASE("in space undamped steps of an energy model keep energy within a band without drift", "[solid][law][long]") {
    for (const SpringMesh& mesh : meshes()) {
        const TissueModel model = solid_model_example(mesh);
        const RealtimeMesh springs = springs_of(model);
        const RealtimeEnergyModel energy_model(model, springs);
        const double fastest = std::sqrt(largest_eigenvalue(springs, TissueEnergy(mesh, *model.energy_model).tangent(model.energy_model->constants, NodeField::Zero(mesh.node_count(), 3))));
        const int substeps = energy_model_substeps(fastest * fastest, 1e-3);
        const auto dynamics = make_dynamics("symplectic", springs, {1e-3 / substeps, 0, &energy_model});
        MeshState state(springs, Eigen::VectorXd::Zero(springs.slot_count()));
        state.velocity = scattered(mesh, 0.1);
        for (int node : mesh.fixed) state.velocity.row(node).setZero();
        const auto total = [&] { return (springs.mass().asDiagonal() * state.velocity.cwiseAbs2()).sum() / 2 + energy_model.energy(state.displacement); };
        const double start = total();
        std::vector<double> mean(4, 0);
        for (std::size_t part = 0; part < mean.size(); ++part)
            for (int k = 0; k < 2000; ++k) {
                ContactLoad free;
                dynamics->advance(state, free, 1e-3 / substeps, substeps, substeps);
                const double now = total();
                REQUIRE(now > 0.5 * start);
                REQUIRE(now < 1.5 * start);
                mean[part] += now / 2000;
            }
        INFO(mesh.topology << ": " << substeps << " substeps, energy over the first " << mean[1] / mean[0] << " " << mean[2] / mean[0] << " " << mean[3] / mean[0]);
        CHECK(mean[3] == Approx(mean[0]).epsilon(0.01));
        CHECK(state.displacement.norm() > 1e-4);
    }
}

TEST_CASE("in space the spectrum of an energy model is that of its tangents at rest and indented by its disc", "[solid][law][long]") {
    const TissueModel model = solid_example();
    const SpringMesh& mesh = model.mesh;
    const RealtimeMesh springs = springs_of(model);
    const EnergyModelSpectrum spectrum = energy_model_spectrum(model, springs);
    const EnergyModel& energy_model = *model.energy_model;
    const TissueEnergy energy(mesh, energy_model);
    const Eigen::VectorXd rest = eigenvalues(springs, energy.tangent(energy_model.constants, NodeField::Zero(mesh.node_count(), 3)));
    CHECK(spectrum.smallest == Approx(rest[0]).epsilon(1e-6));
    CHECK(spectrum.largest > 1.005 * rest[rest.size() - 1]);

    // Indentations at other places, as deep as the deepest load case.
    const auto kernel = make_contact_kernel(mesh, energy_model.disc_radius_m, energy_model.disc);
    const FreeSurface surface(mesh);
    EquilibriumSolver solver(energy, *kernel);
    const auto largest_under = [&](const ContactSpring& contact, const EquilibriumState& state) {
        Eigen::MatrixXd K = energy.tangent(energy_model.constants, state.displacement);
        const Eigen::MatrixXd own = contact.tangent(state.push_m, contact.gather(state.displacement));
        for (std::size_t i = 0; i < contact.rows.nodes.size(); ++i)
            for (std::size_t j = 0; j < contact.rows.nodes.size(); ++j)
                K.block<3, 3>(3 * contact.rows.nodes[i], 3 * contact.rows.nodes[j]) += own.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j));
        return eigenvalues(springs, K).maxCoeff();
    };
    double stiffest = 0;
    for (const Point& point : surface.points(2)) {
        const FreeSurface::Place place = surface.nearest(point);
        const ContactSpring contact(kernel->rows_at(place.point_m), energy_model.patch);
        const EquilibriumState state = solver.indent(energy_model.constants, contact, model.magnitude_m.maxCoeff() * place.inward);
        if (state.status != SolverStatus::no_equilibrium) stiffest = std::max(stiffest, largest_under(contact, state));
    }
    INFO("rest " << std::sqrt(rest[rest.size() - 1]) << ", indented " << std::sqrt(stiffest) << ", computed " << std::sqrt(spectrum.largest));
    CHECK(stiffest > 1.01 * rest[rest.size() - 1]);
    CHECK(spectrum.largest > 0.985 * stiffest);
    CHECK(spectrum.largest < 1.01 * stiffest);

    TissueModel hard = model;  // a contact far stiffer than the tissue
    hard.energy_model->patch.log_N_m.col(0).head<4>().array() += 5;
    CHECK(energy_model_spectrum(hard, springs).largest > 1.5 * rest[rest.size() - 1]);

    // A contact that softens under indentation is stiffest at first touch.
    TissueModel soft = hard;
    soft.energy_model->patch.log_N_m.col(0).head<2>().array() += 1;
    soft.energy_model->patch.curve = ContactCurve::softens;
    soft.energy_model->patch.log_N_m(ContactParameters::hardening_row, 0) = 12;
    double first_touch = 0;
    EquilibriumState untouched;
    untouched.displacement = NodeField::Zero(mesh.node_count(), 3);
    untouched.push_m = Point::Zero(3);
    for (const Point& point : surface.points(2)) first_touch = std::max(first_touch, largest_under(ContactSpring(kernel->rows_at(surface.nearest(point).point_m), soft.energy_model->patch), untouched));
    CHECK(energy_model_spectrum(soft, springs).largest > 0.985 * first_touch);

    // Indentations without equilibrium count as far as they came.
    TissueModel lost = model;
    lost.magnitude_m *= 200;
    const FreeSurface::Place first = surface.nearest(surface.points(2)[0]);
    const EquilibriumState as_far = solver.indent(energy_model.constants, ContactSpring(kernel->rows_at(first.point_m), energy_model.patch), lost.magnitude_m.maxCoeff() * first.inward);
    REQUIRE(as_far.status == SolverStatus::no_equilibrium);
    INFO(energy_model_spectrum(lost, springs).static_N_m << ' ' << as_far.contact_force_N.norm() / as_far.push_m.norm());
    CHECK(energy_model_spectrum(lost, springs).static_N_m > 0.5 * as_far.contact_force_N.norm() / as_far.push_m.norm());
}

TEST_CASE("in space springs that do not turn and steps that do not fit and unordered cubes are refused", "[solid][law]") {
    const TissueModel model = solid_model_example(meshes().front());
    for (const char* law : {"axial", "isotropic"})
        CHECK_THAT(refusal<MismatchError>([&] { RealtimeMesh(model.mesh, law, model.node_mass_kg); }), Contains("geometric"));
    const TissueModel embedded = solid_model_example(embedded_lattice(dome(6), 0.011));
    const RealtimeMesh its = springs_of(embedded);
    CHECK_THAT(refusal<MismatchError>([&] { make_dynamics("symplectic", its, {1e-3, 0, nullptr}); }), Contains("needs an energy model"));
    const RealtimeMesh springs = springs_of(model);
    for (const char* name : {"implicit", "paper"})
        CHECK_THAT(refusal<MismatchError>([&] { const RealtimeEnergyModel law(model, springs); make_dynamics(name, springs, {1e-3, 1, &law}); }), Contains(name));

    TissueModel other = model;
    other.mesh.embedding.cubes.row(3).swap(other.mesh.embedding.cubes.row(4));
    const RealtimeMesh elsewhere = springs_of(other);
    CHECK_THAT(refusal<MismatchError>([&] { RealtimeEnergyModel(other, elsewhere); }), Contains("cube 4 is not in order after the one before"));
}
