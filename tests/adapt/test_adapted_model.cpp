#include "adapt/adapted_model.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "adapt_example.h"
#include "adapt/next_measurement.h"
#include "adapt/measurements_csv.h"
#include "error.h"
#include "../example.h"
#include "../haptic/haptic_example.h"
#include "../mesh/dome.h"
#include "../solid_model_example.h"
#include "mesh/embedded_lattice.h"
#include "mesh/free_surface.h"
#include "springs/indentation_solver.h"
#include "springs/tissue_table.h"
#include "version.h"

using namespace tissue;
using Catch::Matchers::Contains;

TEST_CASE("adaptation continued from a file equals uninterrupted adaptation bit for bit", "[adapt]") {
    const TemporaryFolder folder;
    const TissueModel model = energy_model_example();
    const std::vector<ForceMeasurement> pokes = pokes_of(stiffer(model, 0.5), 12);
    for (const std::string& kind : unknown_kinds()) {
        AdaptOptions options;
        options.unknowns = kind;
        options.place_error_m = 0.001;
        const std::string base = folder.file(kind + "0.h5"), half = folder.file(kind + "1.h5");
        write_model(base, model, {"test", 0, {}});
        CHECK_FALSE(adapted_options(base));
        const std::unique_ptr<Adaptation> first = read_adaptation(base, options);
        Adaptation whole(model, options);
        for (std::size_t i = 0; i < 6; ++i) {
            first->learn(pokes[i]);
            whole.learn(pokes[i]);
        }
        first->learn(pokes[5]);  // refused and counted
        whole.learn(pokes[5]);
        write_adapted_model(half, *first, {"test", 0, {}});
        CHECK(adapted_options(half)->unknowns == kind);
        const std::unique_ptr<Adaptation> then = read_adaptation(half, AdaptOptions());
        for (std::size_t i = 6; i < 12; ++i) {
            then->learn(pokes[i]);
            whole.learn(pokes[i]);
        }
        CHECK(then->state().x == whole.state().x);
        CHECK(then->state().P == whole.state().P);
        CHECK(then->state().refused == 1);
        CHECK(then->energy_model().constants == whole.energy_model().constants);
        CHECK(then->model().heuristic_a == whole.model().heuristic_a);
        then->forget();
        CHECK(then->energy_model().constants == model.energy_model->constants);
    }
}

TEST_CASE("an adapted model is read back with adapted contacts from a file of a later format version", "[adapt]") {
    const TemporaryFolder folder;
    const TissueModel model = energy_model_example();
    const std::vector<ForceMeasurement> pokes = pokes_of(stiffer(model, 0.7), 8);
    Adaptation adaptation(model);
    for (const ForceMeasurement& poke : pokes) adaptation.learn(poke);
    const std::string file = folder.file("model.h5");
    write_adapted_model(file, adaptation, {"test", 0, {}});
    const TissueModel read = read_model(file);
    CHECK(read.energy_model->contact_log_scale == adaptation.energy_model().contact_log_scale);
    CHECK(adaptation.single_scale_in_use());
    CHECK(read_adaptation(file, {})->single_scale_in_use());
    CHECK(read_adaptation(file, {})->state().scale == adaptation.state().scale);
    CHECK(read_adaptation(file, {})->state().scale_variance == adaptation.state().scale_variance);
    CHECK(read_adaptation(file, {})->state().evidence == adaptation.state().evidence);
    CHECK(worst_error(read, pokes) == worst_error(adaptation.model(), pokes));
    CHECK(read.contact_force_N.rows() == 0);  // FE forces belong to the training tissue
    const LearnedField learned = *learned_field(file);
    CHECK(learned.pokes == 8);
    CHECK((learned.factor.array() - std::exp(adaptation.state().scale)).abs().maxCoeff() < 1e-12);
    CHECK((learned.sd.array() - std::sqrt(adaptation.state().scale_variance)).abs().maxCoeff() < 1e-12);
    CHECK(Hdf5Reader(file, "model").number_attribute("/", "format_version") == adapted_format_version);
    CHECK(adapted_format_version > time_format_version);
    // the tick has the same adapted contact
    HapticOptions options;
    options.heuristic_mesh = false;
    const HapticModel plays(read, options), was(model, options);
    ToolSpring stiff, soft;
    plays.meshes.front()->energy_model->contacts().at(25, {0.5, 0.5, 0}, {}, stiff);
    was.meshes.front()->energy_model->contacts().at(25, {0.5, 0.5, 0}, {}, soft);
    const Point push = Eigen::Vector2d(0.001, -0.003);
    const NodeColumns still = NodeColumns::Zero(model.mesh.node_count(), 2);
    CHECK(stiff.tool_force_N(push, still).norm() / soft.tool_force_N(push, still).norm() == Approx(std::exp(0.7)).epsilon(0.2));
}

TEST_CASE("adaptation datasets that are missing or of the wrong size are refused", "[adapt]") {
    const TemporaryFolder folder;
    Adaptation adaptation(energy_model_example());
    adaptation.learn(pokes_of(energy_model_example(), 1)[0]);
    for (const DatasetRule& rule : adaptation_table()) {
        if (rule.optional) continue;
        const std::string file = folder.file("model.h5");
        write_adapted_model(file, adaptation, {"test", 0, {}});
        replace_dataset(file, rule.name);
        CHECK_THROWS_WITH(read_adaptation(file, {}), Contains(rule.name));
        write_adapted_model(file, adaptation, {"test", 0, {}});
        replace_dataset(file, rule.name, {1});
        CHECK_THROWS_AS(read_adaptation(file, {}), FileError);
    }
}

TEST_CASE("the next measurement is proposed where it reduces the posterior variance most", "[adapt]") {
    const TissueModel model = energy_model_example();
    AdaptOptions alone;
    alone.rival = false;
    Adaptation adaptation(model, alone);
    const std::vector<Push> pushes = pushes_over(adaptation.surface(), model.mesh, 0.005, 0.01);
    CHECK(pushes.size() > 20);
    for (const Push& push : pushes) {
        CHECK(adaptation.surface().nearest(push.contact_m).distance_m < 1e-12);
        CHECK(push.push_m.norm() == Approx(0.005));
    }
    for (double depth : {-0.005, 0.0, std::nan(""), std::numeric_limits<double>::infinity()})
        CHECK_THROWS_AS(pushes_over(adaptation.surface(), model.mesh, depth, 0.01), MismatchError);
    // all measurements on the left: the best next one lies on the right
    for (const ForceMeasurement& poke : pokes_of(model, 30))
        if (poke.contact_m[0] < 0.05) adaptation.learn(poke);
    const std::vector<MeasurementGain> worth = rank_measurements(adaptation, pushes, pushes);
    REQUIRE(worth.size() == pushes.size());
    CHECK(pushes[worth.front().push].contact_m[0] > 0.05);
    for (std::size_t i = 1; i < worth.size(); ++i) CHECK(worth[i - 1].gain >= worth[i].gain);
    // the gain is the part of the variance that a measurement there removes
    const auto variance = [&] {
        double sum = 0;
        for (const Push& push : pushes) sum += adaptation.covariance(adaptation.expect(push.contact_m, push.push_m), false).trace();
        return sum;
    };
    const double before = variance();
    const Push& best = pushes[worth.front().push];
    const Expected expected = adaptation.expect(best.contact_m, best.push_m);
    REQUIRE(adaptation.learn({best.contact_m, best.push_m, expected.force_N}).status == UpdateStatus::learned);
    CHECK(1 - variance() / before == Approx(worth.front().gain).epsilon(0.02));
}

TEST_CASE("a proposed measurement has the standard deviation of the expected force while one scale is in use", "[adapt]") {
    const TissueModel model = energy_model_example();
    Adaptation adaptation(model);
    for (const ForceMeasurement& poke : pokes_of(stiffer(model, 0.5), 3)) adaptation.learn(poke);
    REQUIRE(adaptation.single_scale_in_use());
    const std::vector<Push> pushes = pushes_over(adaptation.surface(), model.mesh, 0.005, 0.02);
    for (const MeasurementGain& worth : rank_measurements(adaptation, pushes, pushes)) {
        const Push& push = pushes[worth.push];
        CHECK(worth.sd_before == Approx(std::sqrt(adaptation.covariance(adaptation.expect(push.contact_m, push.push_m), false).trace() / 2)));
        CHECK(worth.sd_before < 0.1);  // a field would still have its prior's, where nothing was measured
    }
}

TEST_CASE("measurements are read line by line and an invalid line is reported with its place", "[adapt]") {
    const std::string header = "contact_x [mm],contact_y [mm],displacement_x [mm],displacement_y [mm],force_x [mN],force_y [N]\n";
    std::istringstream in("# a robot\n" + header + "10,100,0,-5,20,-1.5\n10,100,0,-5,nan,-1.5\n\n10,100,0\n10,\xe4,0,-5,20,-1\n\"10,100,0,-5,20,-1\n20,100,0,-4,0,-1\n");
    MeasurementLines lines(in, "pipe", 2);
    const auto first = lines.next();
    REQUIRE(first);
    CHECK(first->fault.empty());
    CHECK(first->line == 3);
    CHECK(first->poke.contact_m.isApprox(Eigen::Vector2d(0.01, 0.1)));
    CHECK(first->poke.force_N.isApprox(Eigen::Vector2d(0.02, -1.5)));
    CHECK_THAT(lines.next()->fault, Contains("pipe:4: column 'force_x' is 'nan'"));
    CHECK_THAT(lines.next()->fault, Contains("pipe:6: has 3 fields, the header 6 columns"));
    CHECK_THAT(lines.next()->fault, Contains("pipe:7: byte 4 (0xe4) is not UTF-8"));
    CHECK_THAT(lines.next()->fault, Contains("pipe:8: has a quote that does not enclose a whole field"));
    CHECK(lines.next()->fault.empty());
    CHECK_FALSE(lines.next());
    std::istringstream wrong("contact_x [inch]\n1\n");
    MeasurementLines none(wrong, "pipe", 2);
    CHECK_THROWS_WITH(none.next(), Contains("pipe:1") && Contains("'inch'"));
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(read_measurements(folder.file("a.csv", header + "1,2\n"), 2), Contains("a.csv:2"));
    CHECK_THROWS_WITH(read_measurements(folder.file("b.csv", header), 2), Contains("has no rows"));
    CHECK_THROWS_WITH(read_measurements(folder.file("c.csv", header + "1,2,3,4,5,6\n"), 3), Contains("'contact_z' is missing"));
}

TEST_CASE("the adapted field of an embedded lattice is also given at the nodes of the solid", "[adapt][embedded]") {
    TissueModel model = solid_model_example(embedded_lattice(dome(6), 0.011));
    AdaptOptions options;
    options.unknowns = "field";
    options.rival = false;
    Adaptation adaptation(model, options);
    const Point top = FreeSurface(model.mesh).nearest(Eigen::Vector3d(0.01, 0, 0.05)).point_m, push = Eigen::Vector3d(0, 0, -0.004);
    const Equilibrium rest = IndentationSolver(model).at(top, push);
    REQUIRE(rest);
    adaptation.learn({top, push, 1.3 * rest.contact_force});
    const LearnedField learned = *learned_field(adaptation);
    const Embedding& embedding = model.mesh.embedding;
    const int K = embedding.node_count(), N = model.mesh.node_count();
    REQUIRE(adaptation.unknowns().size() == N - K);
    REQUIRE(learned.factor.size() == N);
    REQUIRE(learned.sd.size() == N);
    CHECK(learned.factor.maxCoeff() > 1.02);
    for (int node : {0, 11, K - 1}) {
        double log_factor = 0, most = 0;
        for (int k = 0; k < 8; ++k) {
            const int corner = embedding.corner(node, k);
            log_factor += embedding.weight(node, k) * std::log(learned.factor[corner]);
            most += std::abs(embedding.weight(node, k)) * learned.sd[corner];
        }
        CHECK(std::log(learned.factor[node]) == Approx(log_factor).margin(1e-12));
        CHECK(learned.sd[node] > 0);
        CHECK(learned.sd[node] <= most * (1 + 1e-9));
    }
    CHECK(learned.sd[K + 3] == Approx(std::sqrt(adaptation.state().P(3, 3))));
}
