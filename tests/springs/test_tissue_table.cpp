#include "springs/tissue_table.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "error.h"
#include "../example.h"
#include "../format_version.h"
#include "../mesh/dome.h"
#include "../mutations.h"
#include "../refusal.h"
#include "../solid_model_example.h"
#include "haptic/simulation.h"
#include "mesh/embedded_lattice.h"
#include "mesh/free_surface.h"
#include "train/diagnostics_table.h"
#include "version.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

/// A complete model.h5, written once.
const std::string& example_model_file() {
    static const TemporaryFolder folder;
    static const std::string file = [] {
        const Study study = example_study();
        const Eigen::VectorXd theta = example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1));
        write_trained_model(folder.file("model.h5"), example_model(study, example_cases(study, theta), theta),
                            {"tissuectl test", 11, {}});
        return folder.file("model.h5");
    }();
    return file;
}

/// Simulates 50 ticks with the model. It is refused in one line, or every force is finite.
void play(const TissueModel& tissue) {
    try {
        const HapticModel model(tissue, {});
        Simulation simulation(model);
        for (int k = 0; k < 50; ++k) {
            DeviceSample sample;
            sample.position_m << 0.05, 0.102 - 1e-4 * k, 0;
            CHECK(simulation.tick(sample).allFinite());
        }
    } catch (const Error& e) {
        CHECK(std::string(e.what()).find('\n') == std::string::npos);
    }
}

}  // namespace

TEST_CASE("every dataset of a model.h5 has one rule and every rule has a dataset") {
    const auto tissue = datasets_of(example_model_file(), tissue_table()), sets = datasets_of(example_model_file(), sets_table()),
               books = datasets_of(example_model_file(), books_table());
    CHECK(tissue.size() + sets.size() + books.size() == Hdf5Reader(example_model_file(), "model").datasets().size());
    for (const auto& [table, found] : {std::pair(&tissue_table(), &tissue), std::pair(&sets_table(), &sets), std::pair(&books_table(), &books)})
        for (const DatasetRule& rule : *table)
            CHECK(std::any_of(found->begin(), found->end(), [&](const auto& f) { return f.second == &rule; }));
}

TEST_CASE("a model with any one dataset changed is refused in one line or gives finite forces") {
    int refused = 0;
    for (const DatasetTable* table : {&tissue_table(), &sets_table()})
        refused += refused_mutations(example_model_file(), *table, [](const std::string& file) { play(read_model(file)); });
    CHECK(refused > 100);
}

TEST_CASE("training records with any one dataset made invalid are refused in one line") {
    CHECK(refused_mutations(example_model_file(), books_table(), [](const std::string& file) { read_trained_model(file); }) > 100);
}

TEST_CASE("a clockwise boundary and one that differs from the outline are refused by name") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5"), &whole = example_model_file();
    const auto said = [&](const std::string& dataset, const std::vector<double>& values) {
        std::filesystem::copy_file(whole, file, std::filesystem::copy_options::overwrite_existing);
        replace_dataset(file, dataset, values);
        try {
            read_model(file);
        } catch (const FileError& e) {
            return std::string(e.what());
        }
        return std::string("read");
    };
    const Eigen::VectorXd boundary = Hdf5Reader(whole, "model").vector("/mesh/boundary"), back = boundary.reverse();
    CHECK(said("/mesh/boundary", {boundary.begin(), boundary.end()}) == "read");
    CHECK_THAT(said("/mesh/boundary", {back.begin(), back.end()}), Contains("/mesh/boundary: is clockwise"));
    std::vector<double> cut(boundary.begin(), boundary.end());
    cut.erase(cut.begin() + 3);
    CHECK_THAT(said("/mesh/boundary", cut), Contains("/mesh/boundary: is not the outline"));
    CHECK_THAT(said("/mesh/fixed", {0, 4}), Contains("/mesh/fixed: "));
    CHECK_THAT(said("/one_set", {1, 2, 3}), Contains("/one_set: is 3, must be S = 72"));
}

TEST_CASE("an unknown spring law and a modulus that is not positive and finite are refused") {
    const TemporaryFolder folder;
    TissueModel model = read_model(example_model_file());
    const auto said = [&] {
        write_model(folder.file("model.h5"), model, {"tissuectl test", 11, {}});
        try {
            read_model(folder.file("model.h5"));
        } catch (const FileError& e) {
            return std::string(e.what());
        }
        return std::string("read");
    };
    model.law = "elastic";
    CHECK_THAT(said(), Contains("model.h5: /: attribute 'law'"));
    model.law = "axial";
    CHECK(said() == "read");
    for (const double modulus : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
        model.modulus_N_m = modulus;
        CHECK_THAT(said(), Contains("modulus_N_m"));
    }
}

TEST_CASE("a model in an embedded lattice is read back unchanged; inconsistent datasets are refused by name", "[embedded]") {
    const TemporaryFolder folder;
    const std::string whole = folder.file("whole.h5"), file = folder.file("model.h5");
    TissueModel model = solid_model_example(embedded_lattice(dome(6), 0.011));
    model.heuristic_b = model.heuristic_a;
    model.contact_m = FreeSurface(model.mesh).nearest(Eigen::Vector3d(0, 0, 0.05)).point_m.transpose();
    model.direction = Eigen::RowVector3d(0, 0, -1);
    write_model(whole, model, {"tissuectl test", 11, {}});
    CHECK(Hdf5Reader(whole, "model").number_attribute("/", "format_version") == curve_format_version);
    const TissueModel back = read_model(whole);
    const Embedding &was = model.mesh.embedding, &is = back.mesh.embedding;
    CHECK(is.cubes == was.cubes);
    CHECK(is.corner == was.corner);
    CHECK(is.weight == was.weight);
    CHECK(is.fraction == was.fraction);
    CHECK(is.centroid == was.centroid);
    CHECK(is.spacing_m == was.spacing_m);
    CHECK(back.energy_model->constants == model.energy_model->constants);

    // curve of the springs
    model.energy_model->curve = SpringCurve::mooney_rivlin(0.31, 3, 0.7, 1.2);
    write_model(file, model, {"tissuectl test", 11, {}});
    CHECK(read_model(file).energy_model->curve == model.energy_model->curve);
    CHECK_FALSE(read_model(file).energy_model->curve == SpringCurve::mooney_rivlin(0.31, 3));
    const std::vector<std::pair<std::string, double>> wrong = {{"c2_share", 1.5}, {"c2_share", std::nan("")}, {"straight_below", 0}, {"straight_below", 1}, {"straight_above", 0.9}, {"straight_above", 1e9}};
    for (const auto& [name, value] : wrong) {
        write_model(file, model, {"tissuectl test", 11, {}});
        set_attribute(file, "/law", name, value);
        CHECK_THAT(refusal<FileError>([&] { read_model(file); }), Contains("/law") && Contains(name));
    }
    write_model(file, model, {"tissuectl test", 11, {}});
    set_attribute(file, "/law", "c2_share", 1);
    set_attribute(file, "/law", "straight_above", 2);
    CHECK_THAT(refusal<FileError>([&] { read_model(file); }), Contains("soften above 2"));
    model.energy_model->curve = SpringCurve();
    write_model(file, model, {"tissuectl test", 11, {}});
    CHECK(read_model(file).energy_model->curve.hookean());
    CHECK(Hdf5Reader(file, "model").number_attribute("/", "format_version") == embedded_format_version);

    const auto said = [&](const auto& change) {
        TissueModel changed = model;
        change(changed.mesh.embedding, changed.node_mass_kg, changed.mesh);
        write_model(file, changed, {"tissuectl test", 11, {}});
        return refusal<FileError>([&] { read_model(file); });
    };
    const auto said_of = [&](const NodeField& correction, double least, double most) {
        TissueModel changed = model;
        changed.energy_model->disc.correction.value = correction;
        changed.energy_model->disc.curved_range = {least, most};
        write_model(file, changed, {"tissuectl test", 11, {}});
        return refusal<FileError>([&] { read_model(file); });
    };
    const auto facets = model.mesh.facets.rows();
    CHECK_THAT(said_of(NodeField::Zero(facets, 6), 2, 1.5), Contains("/law/curved_range: must be [smallest, largest]"));
    TissueModel of_one_place = model;
    of_one_place.energy_model->disc = {{}, {0.2, 0.2}, {NodeField::Random(facets, 6)}};
    write_model(file, of_one_place, {"tissuectl test", 11, {}});
    CHECK(read_model(file).energy_model->disc.curved_range == of_one_place.energy_model->disc.curved_range);
    CHECK(read_model(file).energy_model->disc.correction.value == of_one_place.energy_model->disc.correction.value);
    CHECK_THAT(said_of(NodeField::Zero(facets - 1, 6), 0, 1), Contains(fmt::format("/law/lattice_correction: has {} rows, must have one for each of {} facets", facets - 1, facets)));
    CHECK_THAT(said_of(NodeField::Zero(facets, 7), 0, 1), Contains("/law/lattice_correction: has 7 columns, must have (p + 1)(p + 2) / 2"));
    using Mass = Eigen::VectorXd;
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.fraction[0] = 1.5; }), Contains("/mesh/lattice/fraction: is above 1"));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.fraction[0] = 0; }), Contains("/mesh/lattice/fraction: "));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.spacing_m /= 1000; }), Contains("/mesh/lattice/cubes: cubes of 0.011 mm are in a box of"));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.spacing_m *= 1.5; }), Contains("/mesh/lattice/cubes: corner "));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.centroid(0, 0) = 2; }), Contains("/mesh/lattice/centroid: is above 1"));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.weight(0, 0) = 7; }), Contains("/mesh/lattice/weight: does not sum to 1"));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.cubes(0, 0) = 0; }), Contains("/mesh/lattice/cubes: names node 0, which is the solid's own"));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.corner(0, 0) = 1; }), Contains("/mesh/lattice/corner: names node 1, which is the solid's own"));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e.corner(0, 0) = 1000000; }), Contains("/mesh/lattice/corner"));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { for (int k = 0; k < 8; k += 2) std::swap(e.cubes(0, k), e.cubes(0, k + 1)); }), Contains("/mesh/lattice/cubes: cell 0 is inverted"));
    CHECK_THAT(said([](Embedding&, Mass& mass, SpringMesh&) { mass[0] = 1; }), Contains("/node_mass: of node 0 is 1; it must be 0 for an embedded"));
    CHECK_THAT(said([](Embedding&, Mass& mass, SpringMesh&) { mass[mass.size() - 1] = 0; }), Contains("/node_mass: of node "));
    CHECK_THAT(said([](Embedding&, Mass&, SpringMesh& mesh) { mesh.node_measure[mesh.node_count() - 1] = 0; }), Contains("/mesh/node_volume: of node "));
    CHECK_THAT(said([](Embedding&, Mass&, SpringMesh& mesh) { mesh.fixed.push_back(mesh.node_count() - 1); }), Contains("/mesh/fixed: names node "));
    CHECK_THAT(said([](Embedding&, Mass&, SpringMesh& mesh) { mesh.topology = "edges"; }), Contains("do not belong together"));
    CHECK_THAT(said([](Embedding& e, Mass&, SpringMesh&) { e = {}; }), Contains("do not belong together"));
    CHECK_THAT(said([](Embedding&, Mass&, SpringMesh& mesh) { mesh.topology = "edges3"; }), Contains("attribute 'topology' is 'edges3', which is not known; train the study again"));
    // a lattice node without a cube
    CHECK_THAT(said([](Embedding&, Mass& mass, SpringMesh& mesh) {
                   const Eigen::Index N = mesh.node_count();
                   mesh.nodes.conservativeResize(N + 1, 3);
                   mesh.nodes.row(N) << 500, 500, 500;
                   for (Eigen::VectorXd* of : {&mass, &mesh.node_measure}) {
                       of->conservativeResize(N + 1);
                       (*of)[N] = 1;
                   }
               }),
               Contains("/mesh/lattice/cubes: do not use node "));
}
