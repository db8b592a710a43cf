#include "train/train_energy_model.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../mesh/embedded_block.h"
#include "error.h"
#include "mesh/free_surface.h"
#include "springs/indentation_solver.h"
#include "../mesh/disc.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const std::vector<std::string> terms = {"spring.all", "spring.surface", "spring.held.upright", "cell.layer", "contact.normal",
                                        "contact.tangent", "contact.rotation", "contact.stretch"};

struct Problem {
    SpringMesh mesh;
    EnergyModelTerms law;
    std::vector<IndentationPath> paths;
    Eigen::VectorXd truth;
};

/// A reference that is itself such an energy model, so that training can match it exactly.
Problem problem(SpringMesh mesh) {
    Problem p{mesh, EnergyModelTerms(mesh, energy_model_heuristic(mesh, 450, "plane-strain", 12), terms), {}, {}};
    p.truth.resize(p.law.size());
    for (Eigen::Index i = 0; i < p.truth.size(); ++i) p.truth[i] = 0.4 * std::sin(1.0 + 2.0 * static_cast<double>(i));
    const TissueEnergy energy = p.law.energy(mesh);
    const ContactSurface surface(mesh);
    EquilibriumSolver solver(energy, surface);
    for (double part : {0.1, 0.27, 0.36, 0.52}) {
        IndentationPath& path = p.paths.emplace_back();
        const double arc_m = part * surface.outline().length();
        path.contact_m = surface.outline().position(arc_m);
        path.name = "at " + std::to_string(part);
        const ContactPatch patch = surface.at(arc_m);
        for (double depth : {0.003, 0.006}) {
            const Eigen::Vector2d push = depth * surface.outline().direction(arc_m, 2 * part - 0.6);
            const EquilibriumState state = solver.indent(p.law.constants(p.truth), PatchSpring(patch, p.law.patch(p.truth).at(patch)), push);
            path.records.push_back({push, state.contact_force_N, state.displacement});
        }
    }
    return p;
}

}  // namespace

TEST_CASE("training recovers the energy model of its reference on a block and on a shape") {
    for (const SpringMesh& mesh : {make_lattice("grid8", 6, 6, 0.1, 0.1), edge_mesh(disc(16))}) {
        const Problem p = problem(mesh);
        EnergyModelTrainingOptions options;
        options.ridge = 0;
        options.fit = {60, 1e-9, 1e-12, 0};
        const TrainedEnergyModel trained = train_energy_model(p.mesh, p.law, p.paths, options);
        CHECK((trained.coefficients - p.truth).norm() < 1e-4);
        CHECK(trained.objective < 1e-8);
        CHECK(trained.lost.empty());
        REQUIRE(trained.starts.size() == 1);
        CHECK(trained.starts[0].gradient < 1e-5);
    }
}

TEST_CASE("training on forces alone matches them up to the ridge") {
    Problem p = problem(make_lattice("grid8", 6, 6, 0.1, 0.1));
    for (IndentationPath& path : p.paths)
        for (IndentationPath::Record& record : path.records) record.displacement.resize(0, 0);
    const TrainedEnergyModel trained = train_energy_model(p.mesh, p.law, p.paths);
    CHECK(energy_model_residual_count(p.law, p.paths, {}) == 2 * 8 + 8);
    CHECK(trained.objective < 0.05);  // of the ridge: errors of a fifth of a percent
}

TEST_CASE("the heuristic's factor is the force ratio without zero forces and is refused without any force") {
    Problem p = problem(make_lattice("grid8", 6, 6, 0.1, 0.1));
    const TissueEnergy energy = p.law.energy(p.mesh);
    const ContactSurface surface(p.mesh);
    EquilibriumSolver solver(energy, surface);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(p.law.size());
    for (IndentationPath& path : p.paths) {
        const ContactPatch patch = surface.at(surface.outline().arc_of(path.contact_m));
        for (IndentationPath::Record& record : path.records)
            record.force_N = 2.5 * solver.indent(p.law.constants(zero), PatchSpring(patch, p.law.patch(zero).at(patch)), record.push_m).contact_force_N;
    }
    CHECK(heuristic_factor(p.mesh, p.law, p.paths) == Approx(2.5).epsilon(tolerance::newton));
    p.paths[0].records[0].force_N.setZero();  // without a relative error it does not count
    CHECK(heuristic_factor(p.mesh, p.law, p.paths) == Approx(2.5).epsilon(tolerance::newton));
    for (IndentationPath& path : p.paths)
        for (IndentationPath::Record& record : path.records) record.force_N.setZero();
    CHECK_THAT(refusal<MismatchError>([&] { heuristic_factor(p.mesh, p.law, p.paths); }), Contains("no load path has a force"));
}

TEST_CASE("training residuals vanish at the reference but for the ridge and derivatives agree with differences") {
    const Problem p = problem(make_lattice("grid8", 6, 6, 0.1, 0.1));
    EnergyModelTrainingOptions options;
    options.equilibrium.tolerance = 1e-12;
    const int rows = energy_model_residual_count(p.law, p.paths, {});
    const auto at = [&](const Eigen::VectorXd& coefficients, RowMatrix& J) {
        Eigen::VectorXd f(rows);
        J.resize(rows, p.law.size());
        energy_model_residuals(p.mesh, p.law, p.paths, options, coefficients, f, J);
        return f;
    };
    RowMatrix J, ignored;
    const Eigen::VectorXd f = at(p.truth, J);
    CHECK(f.head(rows - p.law.size()).norm() < 1e-6);
    CHECK((f.tail(p.law.size()) - 0.1 * p.truth).norm() <= tolerance::rounding);
    const double h = 1e-4;
    for (int t = 0; t < p.law.size(); ++t) {
        const Eigen::VectorXd e = h * Eigen::VectorXd::Unit(p.law.size(), t);
        const Eigen::VectorXd slope = (8 * (at(p.truth + e, ignored) - at(p.truth - e, ignored)) -
                                       (at(p.truth + 2 * e, ignored) - at(p.truth - 2 * e, ignored))) / (12 * h);
        CHECK((slope - J.col(t)).norm() <= tolerance::difference * J.col(t).norm());
    }
}

TEST_CASE("training does not depend on the number of threads and keeps the best of several starts") {
    const Problem p = problem(make_lattice("grid8", 6, 6, 0.1, 0.1));
    EnergyModelTrainingOptions options;
    options.starts = 3;
    const TrainedEnergyModel one = train_energy_model(p.mesh, p.law, p.paths, options);
    options.threads = 3;
    const TrainedEnergyModel three = train_energy_model(p.mesh, p.law, p.paths, options);
    CHECK(one.coefficients == three.coefficients);
    REQUIRE(one.starts.size() == 3);
    for (const FitResult& start : one.starts) CHECK(2 * start.half_square >= one.objective);

    // after one iteration a random start may be better than the start at zero
    options.fit.max_iterations = 1;
    options.seed = 0;
    TrainedEnergyModel hasty;
    do {
        ++options.seed;
        hasty = train_energy_model(p.mesh, p.law, p.paths, options);
        REQUIRE(hasty.kept < hasty.starts.size());
        for (const FitResult& start : hasty.starts) CHECK(2 * start.half_square >= hasty.objective);
    } while (hasty.kept == 0 && options.seed < 20);
    CHECK(hasty.kept > 0);
    CHECK(hasty.coefficients == hasty.starts[hasty.kept].x);
}

TEST_CASE("an indentation without equilibrium has an error of 1 and is listed with its depth") {
    Problem p = problem(make_lattice("grid8", 6, 6, 0.1, 0.1));
    p.paths.resize(1);
    p.paths[0].records.resize(1);
    p.paths[0].records[0].push_m *= 100;  // 300 mm: three times the size of the block
    EnergyModelTrainingOptions options;
    options.equilibrium.smallest_step = 0.02;
    const int rows = energy_model_residual_count(p.law, p.paths, {});
    Eigen::VectorXd f(rows);
    RowMatrix J(rows, p.law.size());
    std::vector<std::string> lost;
    energy_model_residuals(p.mesh, p.law, p.paths, options, Eigen::VectorXd::Zero(p.law.size()), f, J, &lost);
    CHECK(f.head(2).norm() == Approx(100));
    CHECK(f.segment(2, rows - 2).norm() == Approx(1 / 0.03));
    REQUIRE(lost.size() == 1);
    CHECK_THAT(lost[0], Contains("at 0.1") && Contains("300 mm: lost at"));
}

TEST_CASE("training without paths or terms is refused") {
    const Problem p = problem(make_lattice("grid8", 6, 6, 0.1, 0.1));
    CHECK_THAT(refusal<MismatchError>([&] { train_energy_model(p.mesh, p.law, {}); }), Contains("no load paths"));
    const EnergyModelTerms bare(p.mesh, energy_model_heuristic(p.mesh, 450, "plane-strain", 12), {});
    CHECK_THAT(refusal<MismatchError>([&] { train_energy_model(p.mesh, bare, p.paths); }), Contains("without terms"));
}

TEST_CASE("training in space recovers the model from forces and surface displacements for any number of threads", "[solid][long]") {
    const SpringMesh mesh = embedded_block(Lattice{{5, 5, 3}, {0.05, 0.05, 0.03}});
    const double E = 4500, radius_m = 0.007;
    const EnergyModelHeuristic heuristic = solid_heuristic(mesh, Eigen::VectorXd::Constant(mesh.spring_count(), E),
                                                   Eigen::VectorXd::Constant(mesh_cells(mesh).rows(), E), E, 12, radius_m);
    const EnergyModelTerms model_terms(mesh, heuristic, {"spring.all", "contact.normal", "contact.tangent", "contact.hardening", "skin.normal", "skin.tangent", "skin.heave", "skin.radial"});
    const Eigen::VectorXd truth = (Eigen::VectorXd(8) << -0.3, 0.2, -0.2, 0.5, 0.3, -0.4, 0.2, 0.1).finished();
    const IndentationSolver solver(mesh, {model_terms.terms(), truth, model_terms.constants(truth), model_terms.patch(truth), false, radius_m});
    std::vector<IndentationPath> paths;
    for (const Eigen::Vector3d& direction : {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.5, 0, -1)})
        for (double x : {0.021, 0.03}) {
            IndentationPath& path = paths.emplace_back();
            path.name = "at " + std::to_string(x);
            path.contact_m = Eigen::Vector3d(x, 0.026, 0.03);
            for (double depth : {0.003, 0.007}) {
                const Eigen::Vector3d push = depth * direction.normalized();
                const Equilibrium state = solver.at(path.contact_m, push);
                REQUIRE(state);
                path.records.push_back({push, state.contact_force, solver.displayed(path.contact_m, push, state.displacement)});
            }
        }
    EnergyModelTrainingOptions options;
    options.ridge = 0;
    options.disc_radius_m = radius_m;
    options.compared = compared_nodes(mesh);
    options.fit = {60, 1e-9, 1e-12, 0};
    CHECK(energy_model_residual_count(model_terms, paths, options) == 8 * (3 + 3 * static_cast<int>(options.compared.size())) + 8);
    const TrainedEnergyModel trained = train_energy_model(mesh, model_terms, paths, options);
    CHECK((trained.coefficients - truth).norm() < 1e-4);
    CHECK(trained.objective < 1e-8);
    CHECK(trained.lost.empty());
    options.threads = 3;
    CHECK(train_energy_model(mesh, model_terms, paths, options).coefficients == trained.coefficients);

    // started from equilibria of other parameters, the residuals are those of a start from rest
    const int rows = energy_model_residual_count(model_terms, paths, options);
    PathEquilibria rests;
    Eigen::VectorXd cold(rows), warm(rows);
    RowMatrix J(rows, model_terms.size());
    energy_model_residuals(mesh, model_terms, paths, options, Eigen::VectorXd::Zero(8), warm, J, nullptr, &rests);
    energy_model_residuals(mesh, model_terms, paths, options, truth, warm, J, nullptr, &rests);
    energy_model_residuals(mesh, model_terms, paths, options, truth, cold, J);
    CHECK((warm - cold).norm() < 1e-6);

    // their derivative agrees with differences, also of the displacements with skin
    options.equilibrium.tolerance = 1e-12;
    RowMatrix ignored(rows, model_terms.size());
    const auto at = [&](const Eigen::VectorXd& p) {
        energy_model_residuals(mesh, model_terms, paths, options, p, cold, ignored);
        return cold;
    };
    const Eigen::VectorXd near = 0.5 * truth;
    energy_model_residuals(mesh, model_terms, paths, options, near, warm, J);
    for (int t = 0; t < model_terms.size(); ++t) {
        const Eigen::VectorXd e = 1e-3 * Eigen::VectorXd::Unit(model_terms.size(), t);
        const Eigen::VectorXd once = at(near + e) - at(near - e), twice = at(near + 2 * e) - at(near - 2 * e);
        CHECK(((8 * once - twice) / 12e-3 - J.col(t)).norm() <= tolerance::difference * J.col(t).norm());
    }
}

TEST_CASE("training in space recovers the size terms of a disc from contacts of several radii", "[solid][long]") {
    const SpringMesh mesh = embedded_block(Lattice{{5, 5, 3}, {0.05, 0.05, 0.03}});
    const double E = 4500, own_m = 0.007;
    const EnergyModelHeuristic heuristic = solid_heuristic(mesh, Eigen::VectorXd::Constant(mesh.spring_count(), E), Eigen::VectorXd::Constant(mesh_cells(mesh).rows(), E), E, 12, own_m);
    const EnergyModelTerms model_terms(mesh, heuristic, {"contact.normal", "contact.normal.size", "contact.hardening.size"});
    const Eigen::VectorXd truth = Eigen::Vector3d(0.2, 0.4, 0.6);
    EnergyModel known{model_terms.terms(), truth, model_terms.constants(truth), model_terms.patch(truth), false, own_m};
    known.sizes = {with_means({0.005, own_m, 0.010}), mesh.embedding.spacing_m};
    const IndentationSolver solver(mesh, known);
    std::vector<IndentationPath> paths;
    for (double radius_m : {0.0, 0.005, 0.010}) {
        IndentationPath& path = paths.emplace_back();
        path.name = "radius " + std::to_string(radius_m);
        path.contact_m = Eigen::Vector3d(0.024, 0.026, 0.03);
        path.radius_m = radius_m;
        for (double depth : {0.003, 0.006}) {
            const Point push = depth * Eigen::Vector3d(0.2, 0, -1).normalized();
            const Equilibrium state = solver.of(radius_m).at(path.contact_m, push);
            REQUIRE(state);
            path.records.push_back({push, state.contact_force, {}});
        }
    }
    EnergyModelTrainingOptions options;
    options.ridge = 0;
    options.disc_radius_m = own_m;
    options.sizes = known.sizes;
    options.fit = {60, 1e-9, 1e-12, 0};
    const TrainedEnergyModel trained = train_energy_model(mesh, model_terms, paths, options);
    CHECK((trained.coefficients - truth).norm() < 1e-4);
    CHECK(trained.lost.empty());
}

TEST_CASE("training keeps every equilibrium of its start even where losing one lowers the objective") {
    const SpringMesh mesh = make_lattice("grid8", 6, 6, 0.1, 0.1);
    const EnergyModelTerms model_terms(mesh, energy_model_heuristic(mesh, 450, "plane-strain", 12), {"spring.all", "spring.surface", "contact.normal", "contact.tangent"});
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(model_terms.size());
    const IndentationSolver solver(mesh, {model_terms.terms(), zero, model_terms.constants(zero), model_terms.patch(zero), model_terms.incompressible()});
    const Outline outline(mesh);
    std::vector<IndentationPath> paths;
    for (double part : {0.1, 0.27, 0.36, 0.52}) {
        IndentationPath& path = paths.emplace_back();
        path.contact_m = outline.position(part * outline.length());
        const Eigen::Vector2d push = 0.008 * outline.direction(part * outline.length(), 2 * part - 0.6);
        const Equilibrium state = solver.at(path.contact_m, push);
        REQUIRE(state);
        path.records.push_back({push, 0.2 * state.contact_force, {}});  // tissue a fifth as stiff
    }
    EnergyModelTrainingOptions options;
    options.ridge = 0.01;
    options.equilibrium.max_newton = 4;  // few iterations in long steps, so that equilibria are soon missed
    options.equilibrium.load_step = 2;
    options.equilibrium.smallest_step = 0.3;
    const int rows = energy_model_residual_count(model_terms, paths, options);
    std::vector<char> gone;
    const FitFunction residuals = [&](const Eigen::VectorXd& p, Eigen::Ref<Eigen::VectorXd> f, Eigen::Ref<RowMatrix> J) {
        energy_model_residuals(mesh, model_terms, paths, options, p, f, J, nullptr, nullptr, &gone);
    };
    const auto lost_at = [&](const Eigen::VectorXd& p) {
        Eigen::VectorXd f(rows);
        RowMatrix J(rows, model_terms.size());
        residuals(p, f, J);
        return std::count(gone.begin(), gone.end(), 1);
    };
    REQUIRE(lost_at(zero) == 0);
    const FitResult careless = nonlinear_fit(residuals, rows, zero, options.fit);
    CHECK(lost_at(careless.x) > 0);  // a fit without this rule loses equilibria
    const TrainedEnergyModel trained = train_energy_model(mesh, model_terms, paths, options);
    CHECK(trained.lost.empty());
    CHECK(trained.starts[0].lost == 0);
    CHECK(trained.objective < 0.1 * 2 * careless.half_square);
}
