#include "springs/tissue_model.h"

#include <catch2/catch.hpp>

#include "error.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const Provenance provenance{"tissuectl test", 11, {}};

const Eigen::VectorXd& theta() {
    static const Eigen::VectorXd theta = example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1));
    return theta;
}

const Cases& example_cases_once() {
    static const Cases cases = example_cases(example_study(), theta());
    return cases;
}

const TrainedModel& example() {
    static const TrainedModel model = example_model(example_study(), example_cases_once(), theta());
    return model;
}

}  // namespace

TEST_CASE("a model is read back from HDF5 bit by bit") {
    const TemporaryFolder folder;
    write_model(folder.file("model.h5"), example(), provenance);
    const TissueModel &a = example(), b = read_model(folder.file("model.h5"));
    CHECK(b.study == a.study);
    CHECK(b.law == a.law);
    CHECK(b.mesh.topology == a.mesh.topology);
    CHECK(b.mesh.nodes == a.mesh.nodes);
    CHECK(b.mesh.springs == a.mesh.springs);
    CHECK(b.mesh.simplices == a.mesh.simplices);
    CHECK(b.mesh.loop() == a.mesh.loop());
    CHECK(b.mesh.fixed == a.mesh.fixed);
    CHECK(b.mesh.incident_measure == a.mesh.incident_measure);
    CHECK(b.mesh.node_measure == a.mesh.node_measure);
    CHECK(b.modulus_N_m == a.modulus_N_m);
    CHECK(b.node_mass_kg == a.node_mass_kg);
    CHECK(b.heuristic_a == a.heuristic_a);
    CHECK(b.heuristic_b == a.heuristic_b);
    CHECK(b.case_names == a.case_names);
    CHECK(b.contact_m == a.contact_m);
    CHECK(b.direction == a.direction);
    CHECK(b.magnitude_m == a.magnitude_m);
    CHECK(b.contact_force_N == a.contact_force_N);
    CHECK(b.one_set == a.one_set);
    CHECK(b.optimum == a.optimum);
    REQUIRE(b.trained.size() == a.trained.size());
    for (std::size_t t = 0; t < a.trained.size(); ++t) {
        CHECK(b.trained[t].optimizer == a.trained[t].optimizer);
        CHECK(b.trained[t].theta == a.trained[t].theta);
    }
}

TEST_CASE("every dataset of model.h5 has units and a description: stiffness in N/m, loss in N, mass in kg") {
    const TemporaryFolder folder;
    write_trained_model(folder.file("model.h5"), example(), provenance);
    const Hdf5Reader in(folder.file("model.h5"), "model");
    CHECK(in.describe().size() > 20);  // describe refuses a dataset without units or description
    for (const auto& [name, units] : std::vector<std::pair<std::string, std::string>>{{"/mesh/nodes", "m"},
                                                                                      {"/node_mass", "kg"},
                                                                                      {"/heuristic_a", "N/m"},
                                                                                      {"/trained/spsa/theta", "N/m"},
                                                                                      {"/trained/spsa/loss", "N"},
                                                                                      {"/cases/magnitude", "m"},
                                                                                      {"/cases/contact_force", "N"},
                                                                                      {"/cases/node_weight", "1"}}) {
        CHECK(in.text_attribute(name, "units") == units);
        CHECK_FALSE(in.text_attribute(name, "description").empty());
    }
}

TEST_CASE("a model contains the contact forces of its load cases; a model without them is read too") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    write_model(file, example(), provenance);
    const std::vector<LoadCase> loads = load_cases(example_cases_once());
    const TissueModel model = read_model(file);
    REQUIRE(model.contact_force_N.rows() == model.case_count());
    for (Eigen::Index c = 0; c < model.case_count(); ++c)
        CHECK(model.contact_force_N.row(c).transpose() == loads[static_cast<std::size_t>(c)].record->contact_force_N);
    CHECK(model.contact_force_N.norm() > 0);

    replace_dataset(file, "/cases/contact_force");
    CHECK(read_model(file).contact_force_N.rows() == 0);
    write_model(file, read_model(file), provenance);
    CHECK(read_model(file).contact_force_N.rows() == 0);
    write_model(file, example(), provenance);
    replace_dataset(file, "/cases/contact_force", {1, 2, 3});
    CHECK_THAT(refusal<FileError>([&] { read_model(file); }), Contains("/cases/contact_force"));
}

TEST_CASE("a model without a required dataset is refused with file and dataset") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    for (const std::string name : {"/mesh/springs", "/node_mass", "/heuristic_a", "/cases/names", "/trained/spsa/theta",
                                   "/optimizers"}) {
        write_model(file, example(), provenance);
        replace_dataset(file, name);
        CHECK_THAT(refusal<FileError>([&] { read_model(file); }), Contains("model.h5: " + name) && Contains("missing"));
    }
}

TEST_CASE("a model with a dataset of the wrong size is refused with file and dataset") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    for (const std::string name :
         {"/mesh/node_area", "/mesh/incident_area", "/node_mass", "/heuristic_a", "/heuristic_b", "/cases/magnitude",
          "/trained/spsa/loss", "/trained/spsa/rel_loss", "/trained/spsa/iterations", "/trained/spsa/restarts",
          "/trained/spsa/curve_iteration"}) {
        write_trained_model(file, example(), provenance);
        replace_dataset(file, name, {1, 2, 3});
        // any number of points of a curve is possible: the losses at these points then have the wrong size
        const std::string refused = name == "/trained/spsa/curve_iteration" ? "/trained/spsa/curve_loss" : name;
        CHECK_THAT(refusal<FileError>([&] { read_trained_model(file); }), Contains("model.h5: " + refused + ": is ") && Contains(", must be "));
    }
}

TEST_CASE("a model with a tool displacement above the size of its tissue is refused") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    TissueModel model = example();
    const double longest_m = model.mesh.size_m();
    model.magnitude_m[0] = longest_m;
    write_model(file, model, provenance);
    CHECK(read_model(file).magnitude_m[0] == longest_m);
    model.magnitude_m[0] = 83;
    write_model(file, model, provenance);
    CHECK_THAT(refusal<FileError>([&] { read_model(file); }), Contains("model.h5: /cases/magnitude") && Contains("8.3e+04 mm"));
}

TEST_CASE("a model with a node number out of range is refused") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    for (const auto& [name, bad] : std::vector<std::pair<std::string, double>>{
             {"/mesh/boundary", 25.0}, {"/mesh/boundary", -1.0}, {"/mesh/fixed", 1e6}}) {
        write_model(file, example(), provenance);
        replace_dataset(file, name, {0, 1, bad});
        CHECK_THAT(refusal<FileError>([&] { read_model(file); }), Contains("model.h5: " + name));
    }
}

TEST_CASE("a missing model file and a file of cases are refused") {
    const TemporaryFolder folder;
    CHECK_THROWS_AS(read_model(folder.file("none.h5")), FileError);
    {
        Hdf5Writer out(folder.file("cases.h5"), "cases", provenance);
        out.commit();
    }
    CHECK_THAT(refusal<FileError>([&] { read_model(folder.file("cases.h5")); }), Contains("'cases'"));
    CHECK_THROWS_AS(write_model(folder.file("none/model.h5"), example(), provenance), FileError);
}
