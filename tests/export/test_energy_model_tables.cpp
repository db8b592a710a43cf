#include "export/energy_model_tables.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <fmt/format.h>

#include "error.h"
#include "io/hdf5_store.h"
#include "version.h"
#include "export/csv.h"
#include "export/solid_model_tables.h"
#include "mesh/embedded_lattice.h"
#include "springs/contact_patch.h"
#include "springs/contact_spring.h"
#include "springs/energy_model_terms.h"
#include "springs/energy_model_at_radius.h"
#include "springs/energy_model_kernel.h"
#include "springs/indentation_solver.h"
#include "../example.h"
#include "../mesh/disc.h"
#include "../mesh/dome.h"
#include "../springs/several_discs.h"
#include "../refusal.h"
#include "../solid_model_example.h"
#include "../tolerances.h"

using namespace tissue;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;

namespace {

TissueModel plane_model(const SpringMesh& mesh) {
    const EnergyModelTerms model_terms(mesh, energy_model_heuristic(mesh, 450, "plane-strain", 12), {"spring.surface", "cell.layer", "contact.normal.phase"});
    const Eigen::Vector3d p(0.4, -0.3, 0.5);
    TissueModel model;
    model.mesh = mesh;
    model.energy_model = {model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible()};
    const Outline outline(mesh);
    model.case_names = {"first", "second"};
    model.node_mass_kg = Eigen::VectorXd::Ones(mesh.node_count());
    model.heuristic_a = model.heuristic_b = Eigen::VectorXd::Ones(mesh.spring_count());
    model.contact_m.resize(2, 2);
    model.direction.resize(2, 2);
    model.magnitude_m = Eigen::Vector2d(0.003, 0.006);
    for (int c : {0, 1}) {
        model.contact_m.row(c) = outline.position((0.3 + 0.2 * c) * outline.length());
        model.direction.row(c) = outline.direction((0.3 + 0.2 * c) * outline.length(), 0.2);
    }
    return model;
}

/// sum A V (J - 1)^2 / 2, with J of the trilinear map's gradient at the point `at` of each cell.
double cells_energy(const SpringMesh& mesh, const SolidModelTables& t, const NodeField& u) {
    double W = 0;
    for (Eigen::Index c = 0; c < t.cells.rows(); ++c) {
        Eigen::Matrix3d before = Eigen::Matrix3d::Zero(), after = before;
        for (int k = 0; k < 8; ++k)
            for (int d = 0; d < 3; ++d) {
                double weight = (k >> d & 1) ? 1 : -1;
                for (int other : {(d + 1) % 3, (d + 2) % 3}) weight *= (k >> other & 1) ? t.at(c, other) : 1 - t.at(c, other);
                before.col(d) += weight * mesh.nodes.row(t.cells(c, k)).transpose();
                after.col(d) += weight * (mesh.nodes + u).row(t.cells(c, k)).transpose();
            }
        W += t.cell_Pa[c] * t.volume_m3[c] * std::pow(after.determinant() / before.determinant() - 1, 2) / 2;
    }
    return W;
}

}  // namespace

TEST_CASE("exported tables reproduce the strain energy of a model on a block and on a shape", "[export][law]") {
    for (const SpringMesh& mesh : {make_lattice("grid8", 6, 5, 0.1, 0.1), edge_mesh(disc(12))}) {
        const TissueModel model = plane_model(mesh);
        const EnergyModelTables t = energy_model_tables(model);
        const NodeField u = scattered(mesh, 0.003), x = mesh.nodes + u;
        Eigen::VectorXd area = Eigen::VectorXd::Zero(t.area_m2.size());
        for (std::size_t k = 0; k < t.edge_area.size(); ++k) {
            const int i = t.edge_from[k], j = t.edge_to[k];
            area[t.edge_area[k]] += (x(i, 0) * x(j, 1) - x(j, 0) * x(i, 1)) / 2;
        }
        double W = 0;
        for (Eigen::Index e = 0; e < area.size(); ++e) W += t.area_N_m[e] * t.area_m2[e] * std::pow(area[e] / t.area_m2[e] - 1, 2) / 2;
        for (int s = 0; s < mesh.spring_count(); ++s)
            W += t.spring_N_m[s] * std::pow((x.row(mesh.springs(s, 0)) - x.row(mesh.springs(s, 1))).norm() - mesh.rest_length(s), 2) / 2;
        CHECK(W == Approx(TissueEnergy(mesh, true).energy(model.energy_model->constants, u)).epsilon(tolerance::rounding));
        CHECK(std::count(t.area_kind.begin(), t.area_kind.end(), "region") == 5);
        CHECK(std::count(t.area_kind.begin(), t.area_kind.end(), "cell") == (mesh.topology == "edges" ? mesh.node_count() : 30));
    }
}

TEST_CASE("indented load cases are exported all or one by name and their forces balance", "[export][law]") {
    const TissueModel model = plane_model(make_lattice("grid8", 6, 5, 0.1, 0.1));
    const std::vector<IndentationOfCase> all = indentations_of_cases(model, ""), second = indentations_of_cases(model, "second");
    REQUIRE(all.size() == 2);
    REQUIRE(second.size() == 1);
    CHECK(second[0].load_case == 1);
    CHECK(second[0].state.displacement == all[1].state.displacement);
    CHECK(all[1].push_m.norm() == Approx(0.006));
    // the forces of supports and tool balance
    CHECK((all[0].force_N.colwise().sum()).norm() <= tolerance::newton * all[0].force_N.norm());
    CHECK_THAT(refusal<MismatchError>([&] { indentations_of_cases(model, "third"); }), Contains("'third'") && Contains("such as first"));
}

TEST_CASE("exported tables in space reproduce the strain energy and the contact energy of a model", "[export][solid]") {
    const TissueModel model = solid_example();
    const SpringMesh& mesh = model.mesh;
    const SolidModelTables t = solid_model_tables(model);
    const NodeField u = scattered(mesh, 0.002), x = mesh.nodes + u;
    double W = 0;
    for (int s = 0; s < mesh.spring_count(); ++s)
        W += t.spring_N_m[s] * std::pow((x.row(mesh.springs(s, 0)) - x.row(mesh.springs(s, 1))).norm() - mesh.rest_length(s), 2) / 2;
    W += cells_energy(mesh, t, u);
    for (Eigen::Index m = 0; m < t.support_N_m.size(); ++m) W += t.support_N_m[m] * mesh.embedding.at(mesh.fixed[static_cast<std::size_t>(m)], u).squaredNorm() / 2;
    CHECK(W == Approx(TissueEnergy(mesh, false).energy(model.energy_model->constants, u)).epsilon(tolerance::rounding));

    const ContactTable table = contact_table(model, {1});
    const ContactSpring contact(make_contact_kernel(mesh, model.energy_model->disc_radius_m)->rows_at(model.contact_m.row(1).transpose()),
                                model.energy_model->patch);
    const Eigen::Vector3d push(0.001, -0.002, -0.004);
    Eigen::VectorXd e = table.push * push;
    for (std::size_t q = 0; q < table.pull_row.size(); ++q)
        e[table.pull_row[q]] -= table.pull.row(static_cast<Eigen::Index>(q)).dot(u.row(table.pull_node[q]));
    double stored = 0, s = 0;  // energy of all rows, and of the rows of the mean
    for (Eigen::Index r = 0; r < e.size(); ++r) {
        stored += table.k_N_m[static_cast<std::size_t>(r)] * e[r] * e[r] / 2;
        if (r == 2) s = stored;
    }
    const double hardening = table.hardening(0, 0), saturation = table.hardening(0, 1), coupling = table.hardening(0, 2);
    CHECK(stored + hardening * s * s / (2 * (1 + saturation * s)) + coupling * e[0] * (e[1] * e[1] + e[2] * e[2]) / 2 ==
          Approx(contact.load(push, contact.gather(u)).energy_J).epsilon(tolerance::rounding));
    CHECK(std::count(table.kind.begin(), table.kind.end(), "normal") == 1);
    CHECK(contact_table(model, {0, 1}).hardening.row(1) == table.hardening.row(0));
}

TEST_CASE("each exported load case is indented by its own disc", "[export][solid]") {
    const TissueModel model = several_discs();
    const std::vector<IndentationOfCase> cases = indentations_of_cases(model, "");
    REQUIRE(cases.size() == 1);
    const Point contact_m = model.contact_m.row(0).transpose();
    const EnergyModel small = energy_model_at_radius(*model.energy_model, 0.004);
    CHECK(cases[0].state.contact_force == IndentationSolver(model.mesh, small).at(contact_m, cases[0].push_m).contact_force);
    CHECK(cases[0].state.contact_force != IndentationSolver(model).at(contact_m, cases[0].push_m).contact_force);
    const ContactSpring contact(make_contact_kernel(model.mesh, small)->rows_at(contact_m), small.patch);
    const ContactTable table = contact_table(model, {0});
    CHECK(Eigen::Map<const Eigen::VectorXd>(table.k_N_m.data(), static_cast<Eigen::Index>(table.k_N_m.size())) == contact.k_N_m);
    CHECK(table.hardening(0, 0) == contact.hardening_1_J);
    TissueModel wide = model;
    wide.case_radius_m.setConstant(0.05);
    CHECK_THAT(refusal<MismatchError>([&] { contact_table(wide, {0}); }), Contains("radius 50 mm"));
    TissueModel apart = model;  // its surface is moved away from its lattice
    apart.mesh.nodes.topRows(apart.mesh.embedding.node_count()).col(2).array() += 0.05;
    apart.contact_m.col(2).array() += 0.05;
    CHECK(contact_table(apart, {0}).load_case.empty());

    const Files files = csv_files(model, cases);
    CHECK_THAT(files.at("presses.csv"), StartsWith("case,contact_x_m,contact_y_m,contact_z_m,radius_m,push_x_m") && Contains(",0.02,0.004,"));
    const auto lines = [&](const std::string& with) {
        const std::string& text = files.at("correction.csv");
        Eigen::Index n = 0;
        for (std::size_t at = text.find(with); at != std::string::npos; at = text.find(with, at + 1)) ++n;
        return n;
    };
    CHECK(lines("\n0.007,") == model.mesh.facets.rows() * 10);  // the model's own radius, once
    CHECK(lines("\n0.004,") == lines("\n0.007,"));
    CHECK(lines("\n0.01,") == lines("\n0.007,"));
}

TEST_CASE("adapted contacts of a model in space are exported", "[export][solid]") {
    TissueModel model = solid_example();
    CHECK(csv_files(model, indentations_of_cases(model, "")).count("surface.csv") == 0);
    model.energy_model->contact_log_scale = Eigen::VectorXd::LinSpaced(model.mesh.node_count(), 0, 0.25);
    CHECK_THAT(csv_files(model, indentations_of_cases(model, "")).at("surface.csv"), StartsWith("node,contact_log_scale\n0,0\n") && EndsWith(fmt::format("{},0.25\n", model.mesh.node_count() - 1)));
}

TEST_CASE("a model whose contact hardens in compression alone has its own format version and is read back", "[export][solid]") {
    const TemporaryFolder folder;
    TissueModel model = solid_example();
    CHECK(contact_table(model, {1}).hardening(0, 3) == 0);
    model.energy_model->terms.back() = "contact.compression";
    model.energy_model->patch.curve = ContactCurve::compression;
    write_model(folder.file("model.h5"), model, {"tissuectl test", 0, {}});
    CHECK(Hdf5Reader(folder.file("model.h5"), "model").number_attribute("/", "format_version") == pulled_format_version);
    CHECK(read_model(folder.file("model.h5")).energy_model->patch.curve == ContactCurve::compression);
    CHECK(contact_table(model, {1}).hardening(0, 3) == 1);
}

TEST_CASE("a softening contact is read back from model.h5", "[export][solid]") {
    const TemporaryFolder folder;
    TissueModel model = solid_example();
    model.energy_model->terms.back() = "contact.softening";
    model.energy_model->patch.curve = ContactCurve::softens;
    write_model(folder.file("model.h5"), model, {"tissuectl test", 0, {}});
    CHECK(read_model(folder.file("model.h5")).energy_model->patch.curve == ContactCurve::softens);
    CHECK(contact_table(model, {1}).hardening(0, 0) == -contact_table(model, {1}).hardening(0, 1));
}

TEST_CASE("inclusion points of a model in space are read back from model.h5", "[export][solid]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    TissueModel model = solid_example();
    const auto back = [&] {
        write_model(file, model, {"tissuectl test", 0, {}});
        return read_model(file);
    };
    CHECK(back().energy_model->disc.ground.rows() == 0);
    model.energy_model->disc.ground = NodeField::Constant(3, 4, 0.02);
    model.energy_model->disc.ground(1, 3) = 1e-7;
    model.energy_model->patch.log_N_m(0, ContactParameters::ground_factor) = 0.5;
    CHECK(back().energy_model->disc.ground == model.energy_model->disc.ground);
    CHECK(IndentationSolver(back()).at(model.contact_m.row(1).transpose(), 0.002 * model.direction.row(1).transpose()).contact_force ==
          IndentationSolver(model).at(model.contact_m.row(1).transpose(), 0.002 * model.direction.row(1).transpose()).contact_force);
    const double stiffness = contact_table(model, {1}).k_N_m[0];
    model.energy_model->disc.ground.resize(0, 4);
    CHECK(stiffness > contact_table(model, {1}).k_N_m[0]);
    model.energy_model->disc.ground = NodeField::Constant(3, 4, 2e3);  // outside any tissue
    CHECK_THAT(refusal<FileError>(back), Contains("model.h5: /law/ground"));
}

TEST_CASE("exported load cases in space have no arc length and their forces balance the supports", "[export][solid]") {
    const TissueModel model = solid_example();
    const std::vector<IndentationOfCase> cases = indentations_of_cases(model, "");
    const SolidModelTables t = solid_model_tables(model);
    REQUIRE(cases.size() == 2);
    for (const IndentationOfCase& c : cases) {
        REQUIRE(c.state);
        CHECK_FALSE(c.arc_m);
        CHECK(c.push_m.norm() == Approx(model.magnitude_m[c.load_case]));
        Eigen::Vector3d held_N = Eigen::Vector3d::Zero();
        for (Eigen::Index m = 0; m < t.support_N_m.size(); ++m) held_N += t.support_N_m[m] * model.mesh.embedding.at(model.mesh.fixed[static_cast<std::size_t>(m)], c.state.displacement);
        CHECK((c.force_N.colwise().sum().transpose() - held_N).norm() <= 1e-9 * c.force_N.norm());
    }
}

TEST_CASE("exported tables of an embedded lattice reproduce the energy of springs and cells and supports", "[export][solid_shape]") {
    const TissueModel model = solid_model_example(embedded_lattice(dome(4), 0.011));
    const SpringMesh& mesh = model.mesh;
    const SolidModelTables t = solid_model_tables(model);
    NodeField u = scattered(mesh, 0.002);
    mesh.embedding.interpolate(u);
    const NodeField x = mesh.nodes + u;
    double W = cells_energy(mesh, t, u);
    for (int s = 0; s < mesh.spring_count(); ++s)
        W += t.spring_N_m[s] * model.energy_model->curve.energy(mesh.rest_length(s), (x.row(mesh.springs(s, 0)) - x.row(mesh.springs(s, 1))).norm() - mesh.rest_length(s));
    CHECK((t.at - NodeField::Constant(t.at.rows(), 3, 0.5)).cwiseAbs().maxCoeff() > 0.1);  // cut cubes
    REQUIRE(t.support_N_m.size() == mesh.support_count());
    const double without = W;
    for (int m = 0; m < mesh.support_count(); ++m) W += t.support_N_m[m] * u.row(mesh.fixed[static_cast<std::size_t>(m)]).squaredNorm() / 2;
    CHECK(W > 1.001 * without);
    CHECK(W == Approx(TissueEnergy(mesh, *model.energy_model).energy(model.energy_model->constants, u)).epsilon(tolerance::rounding));
}

TEST_CASE("exported tables of an adapted model reproduce its contact stiffness", "[export][law]") {
    const SpringMesh mesh = make_lattice("grid8", 6, 5, 0.1, 0.1);
    TissueModel model = plane_model(mesh);
    const Files before = csv_files(model, indentations_of_cases(model, "first"));
    model.energy_model->contact_log_scale = Eigen::VectorXd::LinSpaced(mesh.node_count(), -0.4, 0.7);
    CHECK(csv_files(model, indentations_of_cases(model, "first")).at("surface.csv") != before.at("surface.csv"));

    // contact stiffness computed from the tables as results/FORMATS.md describes
    const EnergyModelTables t = energy_model_tables(model);
    const ContactSurface surface(mesh);
    const auto kernel = make_contact_kernel(mesh, *model.energy_model);
    const auto& scaled = dynamic_cast<const ContactSurface&>(*kernel);
    const ContactParameters& patch = model.energy_model->patch;
    for (const double part : {0.0, 0.3, 0.71}) {
        const double arc = part * t.surface_arc_m.back();
        const ContactPatch plain = surface.at(arc);
        double log_scale = 0;
        for (int i = 0; i < ContactPatch::size; ++i) {
            const auto n = std::clamp(static_cast<int>(std::floor(plain.place)) + i - 1, 0, static_cast<int>(t.surface_node.size()) - 1);
            log_scale += plain.weight[i] * t.surface_log_scale[static_cast<std::size_t>(n)];
        }
        CHECK(patch.at(scaled.at(arc)).normal == Approx(patch.at(plain).normal * std::exp(log_scale)).epsilon(tolerance::rounding));
    }
}

TEST_CASE("exported tables have Maxwell branches of a relaxing model and none of an elastic one", "[export][law]") {
    const SpringMesh mesh = make_lattice("grid8", 6, 5, 0.1, 0.1);
    TissueModel model = plane_model(mesh);
    CHECK(csv_files(model, indentations_of_cases(model, "first")).count("branches.csv") == 0);
    NodeField share(model.energy_model->constants.size(), 2);
    share.col(0).setConstant(0.25);
    share.col(1).setLinSpaced(0, 0.5);
    model.energy_model->relaxation = {Eigen::Vector2d(0.125, 2), share, Eigen::Vector2d(0.25, 0.0625)};
    const Files files = csv_files(model, indentations_of_cases(model, "first"));
    CHECK(files.at("branches.csv") == "branch,relaxation_time_s,contact_share\n0,0.125,0.25\n1,2,0.0625\n");
    const std::string& shares = files.at("shares.csv");
    CHECK(shares.substr(0, shares.find('\n', 25)) == "constant,share_0,share_1\n0,0.25,0");
    CHECK(std::count(shares.begin(), shares.end(), '\n') == 1 + model.energy_model->constants.size());
    CHECK_THAT(shares, Contains(std::to_string(model.energy_model->constants.size() - 1) + ",0.25,0.5\n"));
}
