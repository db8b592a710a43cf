#include "train/train_study_model.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cases/measured_cases.h"
#include "cases/study_energy_model.h"
#include "error.h"
#include "eval/evaluation.h"
#include "../measured_example.h"
#include "../mutations.h"
#include "../refusal.h"
#include "springs/heuristic.h"
#include "springs/indentation_solver.h"
#include "springs/tissue_table.h"
#include "train/diagnostics_table.h"
#include "train/endings.h"
#include "train/train_sets.h"
#include "version.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// The example with an energy model and almost no ridge.
const std::string& energy_model_text() {
    static const std::string text = [] {
        const std::string& sets = example_study_text();
        return with(with(sets.substr(0, sets.find("[springs]")), "plane-stress", "plane-strain"), "kind = \"point\"",
                    "kind = \"patch\"\nhalf_width_m = 0.02") +
               R"([springs]
topology = "grid8"
stiffness = "law"
terms = ["spring.all", "spring.held", "contact.normal", "contact.tangent"]

[training]
ridge = 1e-6
seed = 11
)";
    }();
    return text;
}

Eigen::Vector4d truth() { return {-0.4, 0.3, 0.5, -0.2}; }

/// A reference that is itself such an energy model, with one path that is the mirror image of another.
Cases energy_model_cases(const Study& study) {
    const SpringMesh mesh = make_lattice("grid8", study.cells[0], study.cells[1], study.geometry.width_m, study.geometry.height_m);
    const EnergyModelTerms model_terms = study_energy_model(study, {}, mesh);
    TissueModel tissue;
    tissue.mesh = mesh;
    tissue.energy_model = {model_terms.terms(), truth(), model_terms.constants(truth()), model_terms.patch(truth()), model_terms.incompressible()};
    const IndentationSolver solver(tissue);
    const Outline outline(mesh);
    Cases cases{study.name, mesh.nodes, {}, study.loads.magnitudes_m, {}};
    for (const StudyPath& p : study.loads.paths) {
        LoadPath path;
        path.name = p.name;
        path.contact_m = p.contact_m;
        path.direction = p.direction;
        path.depth_m = study.loads.depth_m();
        for (int r = 0; r <= study.loads.records(); ++r) {
            const double s = r * study.loads.record_step_m;
            const Equilibrium state = solver.at(p.contact_m, s * p.direction);
            REQUIRE(state);
            path.records.push_back({s, state.displacement, NodeField::Zero(mesh.node_count(), 2), state.contact_force, Eigen::Vector2d(0, 0), 0, 1, 1, 0});
        }
        cases.paths.push_back(path);
    }
    cases.paths.push_back(mirrored(cases.paths[0], cases.nodes, study.geometry.width_m));
    return cases;
}

const std::string& energy_model_file() {
    static const TemporaryFolder folder;
    static const std::string file = [] {
        const Study study = example_study(energy_model_text());
        write_trained_model(folder.file("model.h5"), train_study_model(study, energy_model_cases(study), 1), {"tissuectl test", 11, {}});
        return folder.file("model.h5");
    }();
    return file;
}

/// The same energy model with three Maxwell branches.
const std::string& relaxing_file() {
    static const TemporaryFolder folder;
    static const std::string file = [] {
        TrainedModel model = read_trained_model(energy_model_file());
        Relaxation& r = model.energy_model->relaxation;
        r.tau_s = Eigen::Vector3d(0.05, 1, 10);
        r.contact_share = Eigen::Vector3d(0.30, 0.25, 0.20);
        r.share = NodeField::Constant(model.energy_model->constants.size(), 3, 0.1);
        r.share(7, 1) = 0;
        write_trained_model(folder.file("model.h5"), model, {"tissuectl test", 11, {}});
        return folder.file("model.h5");
    }();
    return file;
}

}  // namespace

TEST_CASE("training recovers the parameters of a reference and counts mirror images once", "[law]") {
    const Study study = example_study(energy_model_text());
    const Cases cases = energy_model_cases(study);
    const TrainedModel model = train_study_model(study, cases, 2);
    REQUIRE(model.energy_model);
    CHECK((model.energy_model->coefficients - truth()).norm() < 1e-3);
    CHECK(model.books.energy_model->paths == 2);
    CHECK(model.books.energy_model->records == 4);
    CHECK(model.case_count() == 6);  // the mirror image is a load case without new data for an energy model
    CHECK(endings_of(model.books).broken.empty());

    const Evaluation evaluation = evaluate(model, cases, 0, 0, 1);
    const ContactStatistics learned = evaluation.model("learned").closed_loop();
    CHECK(learned.force.n == 6);
    CHECK(learned.force.max < 1e-4);
    CHECK(learned.shape.max < 1e-4);
    CHECK(evaluation.model("heuristic_a").closed_loop().force.median > 0.05);
    CHECK_THAT(to_markdown(evaluation), Contains("| spring.held | 0.3") && Contains("2 FE paths"));
    CHECK_THAT(to_json(evaluation, 11), Contains("\"spring.held\"") && !Contains("_hash"));
    const nlohmann::json told = nlohmann::json::parse(to_json(evaluation, 11, {"ab", "cd"}));
    CHECK((told["model_hash"] == "ab" && told["cases_hash"] == "cd" && told["trained_errors"].size() == 6));
    CHECK((told["trained_errors"][2]["name"] == model.case_names[2] && told["trained_errors"][2]["error"] == *evaluation.model("learned").cases[2].closed_loop.force));

    // In space errors are also reported by thirds of the contacts, from thin to thick. A missing answer counts, a
    // missing reference does not.
    Evaluation solid = evaluation;
    solid.energy_model->disc_radius_m = 0.007;
    DrawnContacts role{"held_out", {}, {"lost: unstable"}};
    for (int k = 12; k >= 0; --k) {
        ContactError error;
        error.shape = 0.02;
        error.force = k == 5 ? std::numeric_limits<double>::infinity() : 0.01 * k;
        role.contacts.push_back({"c", Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 0, -1), 0, 0, 0.004, k == 0 ? std::numeric_limits<double>::infinity() : 1e-3 * (62 - k), 1e-3 * (20 + k), Eigen::Vector3d(0, 0, -1), false, {error}});
    }
    solid.held_out = {{"learned"}, {role}, {}, {}};
    CHECK_THAT(to_markdown(solid), Contains("| thickness, 20.0 to 23.0 mm | 1.5 % / 2.8 % / 3.0 % | 4 of 4 | 2.0 % / 2.0 % / 2.0 % | 4 of 4 |\n") &&
                                       Contains("| thickness, 24.0 to 27.0 mm | 6.5 % / none / none | 3 of 4 |") && Contains("| thickness, 28.0 to 32.0 mm | 10.0 % / 11.8 % / 12.0 % | 5 of 5 |") &&
                                       Contains("| distance from the free surface's edge, 50.0 to 53.0 mm | 10.5 % / 11.8 % / 12.0 % | 4 of 4 |"));
    CHECK_THAT(to_json(solid, 11), Contains("\"thickness_m\": 0.02") && Contains("\"clearance_m\": null"));
    // by disc radius where there are several; a missing reference counts in N
    CHECK_THAT(to_markdown(solid), !Contains("| disc of "));
    solid.held_out.roles[0].lost_radius_m = {0.006};
    for (std::size_t k = 0; k < 13; ++k) solid.held_out.roles[0].contacts[k].radius_m = k % 2 == 1 ? 0.004 : 0.006;
    CHECK_THAT(to_markdown(solid), Contains("| disc of 4 mm | 8.0 % / none / none | 5 of 6 |") && Contains("| disc of 6 mm |") && Contains("| 7 of 8 |"));
    const nlohmann::json by_radius = nlohmann::json::parse(to_json(solid, 11))["by_radius"]["held_out"];
    CHECK((by_radius.size() == 2 && by_radius[0]["radius_m"] == 0.004 && by_radius[1]["learned"]["of"] == 8));
    // as on a block
    for (DrawnContact& contact : solid.held_out.roles[0].contacts) contact.thickness_m = 0.05 + 1e-9 * contact.clearance_m;
    CHECK_THAT(to_markdown(solid), !Contains("| thickness, ") && Contains("| distance from "));
    solid.held_out.roles[0].contacts.resize(11);
    CHECK_THAT(to_markdown(solid), !Contains("by thirds"));
}

TEST_CASE("the factor of a term in the report is the ratio of constants to heuristic below the cap", "[law]") {
    std::string text = energy_model_text();
    const std::size_t from = text.find("terms = ["), to = text.find("]", from);
    const Study study = example_study(text.replace(from, to + 1 - from, "terms = [\"cell.all\"]"));
    const Cases cases = energy_model_cases(example_study(energy_model_text()));
    TrainedModel model = train_study_model(study, cases, 1);
    const EnergyModelTerms model_terms = study_energy_model(study, {}, model.mesh);
    model.energy_model->coefficients = Eigen::VectorXd::Constant(1, -4.069);
    model.energy_model->constants = model_terms.constants(model.energy_model->coefficients);
    const Eigen::Index cell = model.mesh.spring_count(), last = cell + 15;  // of 4 x 4 cells
    const double p = model.energy_model->coefficients[0], factor = model.energy_model->constants[cell] / model.books.energy_model->untrained_constants[cell];
    CHECK(factor == Approx(0.258).epsilon(0.01));  // exp(p) is 0.0171
    CHECK(model.energy_model->constants[last] / model.books.energy_model->untrained_constants[last] == Approx(factor));
    CHECK_THAT(to_markdown(evaluate(model, cases, 0, 0, 1)), Contains(fmt::format("| cell.all | {:.3f} | {:.3g} |", p, factor)));

    TrainedModel stress = model;  // the distance of its cells from the cap at the start is not known
    stress.energy_model->incompressible = false;
    Evaluation e = evaluate(model, cases, 0, 0, 1);
    e.energy_model = stress.energy_model;
    CHECK_THAT(to_markdown(e), Contains(fmt::format("| cell.all | {:.3f} | none |", p)));
}

TEST_CASE("training on forces recovers the constants of a model three times stiffer than the assumed material", "[law][measured][long]") {
    const Study study = measured_study();
    const SpringMesh mesh = measured_mesh();
    constexpr double stiffer = 3;  // than the material of the study
    const EnergyModelTerms model_terms = study_energy_model(study, {}, mesh, stiffer);
    Eigen::VectorXd p(7);
    p << -0.2, 0.3, 0.4, 0.5, -0.3, 0.6, -0.4;
    TissueModel tissue;
    tissue.mesh = mesh;
    tissue.energy_model = {model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible()};
    const IndentationSolver solver(tissue);
    const Outline outline(mesh);
    MeasuredTable table{"data.csv", "made up", {}};
    for (double arc = 0.013; arc < outline.length() - 0.01; arc += 0.0137)
        for (double angle : {-0.6, 0.0, 0.6})
            for (double depth : {0.003, 0.008}) {
                const Eigen::Vector2d push = depth * outline.direction(arc, angle);
                const Equilibrium state = solver.at(outline.position(arc), push);
                REQUIRE(state);
                table.rows.push_back({static_cast<int>(table.rows.size()) + 2, outline.position(arc), push, state.contact_force, "", ""});
            }
    const Cases cases = measured_cases(study, table);
    const TrainedModel model = train_study_model(study, cases, 2);
    CHECK(model.books.energy_model->factor == Approx(stiffer).epsilon(0.3));  // relative to the untrained heuristic
    CHECK(((model.energy_model->constants - tissue.energy_model->constants).array() / tissue.energy_model->constants.array()).abs().maxCoeff() < 1e-3);
    CHECK((model.energy_model->patch.log_N_m - tissue.energy_model->patch.log_N_m).cwiseAbs().maxCoeff() < 1e-3);

    const Evaluation evaluation = evaluate(model, cases, 0, 0, 1);
    const DrawnContacts* held_out = evaluation.held_out.role("held_out");
    REQUIRE(held_out);
    CHECK(held_out->statistics(0).force.max < 1e-4);
    CHECK(evaluation.model("heuristic_a").closed_loop().force.median > 0.01);  // the start differs from the reference
    CHECK_THAT(to_markdown(evaluation), Contains("measured paths") && Contains("times the study's E2, fitted to the forces") && !Contains("shape"));
    // no displacements were measured
    CHECK_THAT(to_json(evaluation, 11), Contains("\"factor\"") && !Contains("shape"));

    // Tissue at rest: the instantaneous model is the long-term one times 1 / (1 - sum g), with g given or fitted.
    const auto relaxing = [&](const std::string& viscosity) {
        std::string text = with(measured_study_text(), "[material]\n", "[material]\nmoduli = \"long-term\"\nviscosity = " + viscosity + "\n");
        return example_study(with(text, "seed = 8\n", "seed = 8\nhistories = \"h.csv\"\n"));
    };
    // measurements at rest are compared with the long-term model
    const auto fits_its_readings = [&](const TrainedModel& trained) {
        const Evaluation at_rest = evaluate(trained, cases, 0, 0, 1);
        CHECK(at_rest.held_out.role("held_out")->statistics(0).force.max < 1e-4);
        CHECK(at_rest.model("learned").closed_loop().force.max < 1e-4);
        CHECK_THAT(to_markdown(at_rest), Contains("The measurements are of tissue at rest"));
    };
    const TrainedModel grown = train_study_model(relaxing("[{ g = 0.2, tau_s = 0.5 }, { g = 0.3, tau_s = 5 }]"), cases, 2);
    fits_its_readings(grown);
    const TemporaryFolder folder;
    write_trained_model(folder.file("model.h5"), grown, {"tissuectl test", 11, {}});
    fits_its_readings(read_trained_model(folder.file("model.h5")));
    const EnergyModel given = *grown.energy_model;
    CHECK((given.constants - 2 * model.energy_model->constants).norm() < 1e-9 * given.constants.norm());
    CHECK(given.relaxation.contact_share == Eigen::Vector2d(0.2, 0.3));
    Cases in_time = cases;
    History h;
    h.name = "ramp", h.role = "train";
    h.contact_m = outline.position(0.05);
    h.direction = outline.direction(0.05, 0);
    h.time_s = Eigen::VectorXd::LinSpaced(81, 0, 16);
    h.push_m = NodeField::Zero(81, 2);
    h.contact.assign(81, 1);
    NodeField now = NodeField::Zero(81, 2);
    for (Eigen::Index n = 1; n < 81; ++n) {
        h.push_m.row(n) = std::min(0.006, 0.015 * h.time_s[n]) * h.direction.transpose();
        now.row(n) = 2 * solver.at(h.contact_m, h.push_m.row(n).transpose()).contact_force.transpose();
    }
    h.force_N = relaxed(h.time_s, now, Eigen::Vector2d(0.5, 5), Eigen::Vector2d(0.2, 0.3));
    in_time.histories = {h};
    const TrainedModel fitted = train_study_model(relaxing("[{ tau_s = 0.5 }, { tau_s = 5 }, { tau_s = 50 }]"), in_time, 2);
    fits_its_readings(fitted);
    CHECK(fitted.energy_model->relaxation.branches() == 2);  // one branch is not needed
    CHECK((fitted.energy_model->relaxation.contact_share - Eigen::Vector2d(0.2, 0.3)).norm() < 1e-3);
    CHECK((fitted.energy_model->constants - given.constants).norm() < 2e-3 * given.constants.norm());
    CHECK(fitted.books.energy_model->shares->histories == 1);
    CHECK(fitted.books.energy_model->shares->status == "converged");
    in_time.histories.front().role = "held_out";
    CHECK_THAT(to_markdown(evaluate(fitted, in_time, 0, 0, 1)), Contains("Maxwell branches fitted to 1 measured histories, converged") && Contains("compared with the measured force, noise included") && !Contains("prony"));

    // measurements before relaxation are compared with the instantaneous model, whatever its branches
    const Study at_once = example_study(with(with(measured_study_text(), "[material]\n", "[material]\nmoduli = \"instantaneous\"\nviscosity = [{ g = 0.5, tau_s = 1 }]\n"),
                                             "seed = 8\n", "seed = 8\nhistories = \"h.csv\"\n"));
    const Evaluation quick = evaluate(train_study_model(at_once, cases, 2), cases, 0, 0, 1);
    CHECK(quick.held_out.role("held_out")->statistics(0).force.max < 1e-4);
    CHECK_THAT(to_markdown(quick), !Contains("of tissue at rest"));

    Study sets = example_study();
    CHECK_THAT(refusal<MismatchError>([&] { train_sets(sets, cases, 1); }), Contains("measured") && Contains("'" + sets.name + "' has spring sets"));
    TrainedModel earlier = model;  // spring sets, which earlier programs trained on such cases
    earlier.energy_model.reset();
    CHECK_THAT(refusal<MismatchError>([&] { evaluate(earlier, cases, 0, 0, 1); }), Contains("measured") && Contains("sets"));
}

TEST_CASE("an energy model is read back unchanged from a file of a later format version", "[law]") {
    const Study study = example_study(energy_model_text());
    const TrainedModel a = train_study_model(study, energy_model_cases(study), 1), b = read_trained_model(energy_model_file());
    REQUIRE(b.energy_model);
    CHECK(b.energy_model->terms == a.energy_model->terms);
    CHECK(b.energy_model->coefficients == a.energy_model->coefficients);
    CHECK(b.energy_model->constants == a.energy_model->constants);
    CHECK(b.energy_model->patch.log_N_m == a.energy_model->patch.log_N_m);
    CHECK(b.energy_model->incompressible);
    CHECK(b.books.energy_model->status == a.books.energy_model->status);
    CHECK(b.books.energy_model->objective == a.books.energy_model->objective);
    CHECK(b.books.energy_model->gradient == a.books.energy_model->gradient);
    CHECK(b.books.energy_model->kept == 0);
    CHECK(Hdf5Reader(energy_model_file(), "model").number_attribute("/", "format_version") == energy_model_format_version);
    CHECK(energy_model_format_version > format_version);
}

TEST_CASE("a relaxing energy model is read back unchanged from a file of a later format version", "[law][memory]") {
    const EnergyModel energy_model = *read_model(relaxing_file()).energy_model;
    CHECK(energy_model.relaxation.tau_s == Eigen::Vector3d(0.05, 1, 10));
    CHECK(energy_model.relaxation.share.rows() == energy_model.constants.size());
    CHECK(energy_model.relaxation.share(7, 1) == 0);
    CHECK(energy_model.relaxation.share(7, 2) == 0.1);
    CHECK(energy_model.relaxation.contact_share == Eigen::Vector3d(0.30, 0.25, 0.20));
    CHECK(read_model(energy_model_file()).energy_model->relaxation.empty());
    CHECK(Hdf5Reader(relaxing_file(), "model").number_attribute("/", "format_version") == time_format_version);
    CHECK(time_format_version > solid_format_version);

    TrainedModel model = read_trained_model(relaxing_file());
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& what) {
        write_trained_model(folder.file("m.h5"), model, {"tissuectl test", 11, {}});
        CHECK_THAT(refusal<FileError>([&] { read_model(folder.file("m.h5")); }), Contains(what));
        model = read_trained_model(relaxing_file());
    };
    model.energy_model->relaxation.share(3, 0) = 0.9;
    refused("/law/share: sum to 1 or more");
    model.energy_model->relaxation.contact_share[0] = 0.6;
    refused("/law/contact_share: sum to 1 or more");
    model.energy_model->relaxation.tau_s = Eigen::Vector3d(1, 0.05, 10);
    refused("/law/relaxation_time");
}

TEST_CASE("read_model gives the constants of an energy model and no spring sets", "[law]") {
    const TissueModel model = read_model(energy_model_file());
    REQUIRE(model.energy_model);
    CHECK(model.energy_model->constants == read_trained_model(energy_model_file()).energy_model->constants);
    CHECK(model.trained.empty());
}

/// A model that relaxes and is adapted, with all datasets of an energy model.
const std::string& whole_file() {
    static const TemporaryFolder folder;
    static const std::string file = [] {
        TrainedModel model = read_trained_model(relaxing_file());
        model.energy_model->contact_log_scale = Eigen::VectorXd::Constant(model.mesh.node_count(), 0.2);
        model.books.energy_model->shares = {3, 1e-12, 0.04, 1.5, "converged"};
        write_trained_model(folder.file("model.h5"), model, {"tissuectl test", 11, {}});
        return folder.file("model.h5");
    }();
    return file;
}

TEST_CASE("every dataset of an energy model has a rule and alterations are refused in one line", "[law]") {
    int refused = 0;
    for (const DatasetTable* table : {&energy_model_table(), &energy_model_diagnostics_table()}) {
        CHECK(datasets_of(whole_file(), *table).size() == table->size());
        refused += refused_mutations(whole_file(), *table, [](const std::string& file) { read_trained_model(file); });
    }
    CHECK(refused > 40);
    const EnergyModelDiagnostics::Shares shares = *read_trained_model(whole_file()).books.energy_model->shares;
    CHECK(shares.histories == 3);
    CHECK(shares.misfit == 0.04);
    CHECK(shares.grown == 1.5);
    CHECK(shares.status == "converged");
    CHECK_FALSE(read_trained_model(relaxing_file()).books.energy_model->shares);
}

TEST_CASE("a fit that misses its tolerances or an equilibrium is reported as broken", "[law][endings]") {
    EnergyModelDiagnostics diagnostics = *read_trained_model(energy_model_file()).books.energy_model;
    CHECK(endings_of(diagnostics).broken.empty());
    diagnostics.lost = {"left at 8 mm: lost at 5 mm"};
    CHECK_THAT(endings_of(diagnostics).broken.at(0), Contains("of 4 load cases 1"));
    diagnostics.lost.clear();
    for (const char* word : {"no_progress", "held_back", "iterations_done"}) {
        diagnostics.status = {word};
        CHECK_THAT(endings_of(diagnostics).broken.at(0), Contains(word));
    }
}

TEST_CASE("training spring sets in a study with an energy model is refused and the reverse", "[law]") {
    const Study law = example_study(energy_model_text()), sets = example_study();
    CHECK_THAT(refusal<MismatchError>([&] { train_sets(law, energy_model_cases(law), 1); }), Contains("has an energy model"));
    CHECK_THAT(refusal<MismatchError>([&] { train_study_model(sets, energy_model_cases(law), 1); }), Contains("has spring sets"));
}

TEST_CASE("an energy model whose number of constants does not match its mesh is refused", "[law]") {
    const TemporaryFolder folder;
    TrainedModel model = read_trained_model(energy_model_file());
    model.energy_model->constants.conservativeResize(model.energy_model->constants.size() - 1);
    write_trained_model(folder.file("model.h5"), model, {"tissuectl test", 11, {}});
    CHECK_THAT(refusal<FileError>([&] { read_trained_model(folder.file("model.h5")); }), Contains("/law/constants"));
}

TEST_CASE("a factor of the heuristic that is no positive number is refused", "[law]") {
    const TemporaryFolder folder;
    TrainedModel model = read_trained_model(energy_model_file());
    CHECK(model.books.energy_model->factor == 1);  // with an FE reference the material is known
    for (double factor : {0.0, -1.0, std::nan("")}) {
        model.books.energy_model->factor = factor;
        write_trained_model(folder.file("model.h5"), model, {"tissuectl test", 11, {}});
        CHECK_THAT(refusal<FileError>([&] { read_trained_model(folder.file("model.h5")); }), Contains("'factor'"));
    }
}

TEST_CASE("training without any FE solution is refused with place and depth and cause of three paths", "[law]") {
    const Study study = example_study(energy_model_text());
    Cases cases = energy_model_cases(study);
    const LoadPath one = cases.paths[0];
    cases.paths.clear();
    for (int i = 0; i < 5; ++i) {
        LoadPath& path = cases.paths.emplace_back(one);
        path.name = "p" + std::to_string(i);
        path.lost = "no equilibrium beyond 0.5 mm; the contact and more";
        path.records.resize(1);  // at rest
    }
    const std::string third = fmt::format("p2 at ({:.4g}, {:.4g}) mm, 8 mm deep: no equilibrium beyond 0.5 mm;", 1e3 * one.contact_m.x(), 1e3 * one.contact_m.y());
    for (const std::string& why : {refusal<MismatchError>([&] { train_study_model(study, cases, 1); }), refusal<MismatchError>([&] { train_sets(example_study(), cases, 1); })}) {
        CHECK_THAT(why, Contains("study 'example': none of its 5 training paths has an FE reference") && Contains(third) && Contains("and 2 more"));
        CHECK_THAT(why, !Contains("p3") && !Contains("and more"));
    }
    cases.paths.clear();
    CHECK_THAT(refusal<MismatchError>([&] { train_study_model(study, cases, 1); }), Contains("no training path"));
}

TEST_CASE("a baseline without any answer is missing in every table and the evaluation continues", "[law]") {
    const Study study = example_study(energy_model_text());
    Cases cases = energy_model_cases(study);
    TrainedModel model = read_trained_model(energy_model_file());
    // axial springs alone have shear modes of zero energy; the cells of the model stabilise them
    const SpringMesh axes = make_lattice("grid4", study.cells[0], study.cells[1], study.geometry.width_m, study.geometry.height_m);
    const EnergyModelTerms model_terms(axes, energy_model_heuristic(axes, 450, "plane-strain", 12), {"spring.all"});
    const Eigen::VectorXd p = Eigen::VectorXd::Zero(1);
    model.mesh = axes;
    model.law = "axial";
    model.heuristic_a = model.heuristic_b = heuristic_stiffness(axes, 450);
    model.energy_model = EnergyModel{model_terms.terms(), p, model_terms.constants(p), model_terms.patch(p), model_terms.incompressible()};
    model.books.energy_model->untrained_constants = model_terms.constants(p);
    model.books.energy_model->untrained_patch = model_terms.patch(p);
    const Evaluation e = evaluate(model, cases, 0, 0, 1);
    CHECK(e.uniform_chosen_on == "modulus");
    CHECK(e.uniform_N_m == model.modulus_N_m);
    CHECK(e.model("uniform").closed_loop().force.missing == 6);
    CHECK(std::isinf(e.model("uniform").closed_loop().force.median));
    CHECK(e.model("learned").closed_loop().force.n > 0);
    CHECK_THAT(to_markdown(e), Contains("| uniform | none | 0 of 6 |") && Contains("the study's modulus"));
}
