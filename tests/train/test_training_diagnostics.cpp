#include "train/training_diagnostics.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "error.h"
#include "../example.h"
#include "../refusal.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

const Provenance provenance{"tissuectl test", 11, {}};

const TrainedModel& example() {
    static const TrainedModel model = [] {
        const Study study = example_study();
        const Eigen::VectorXd theta = example_theta(make_lattice("grid8", 4, 4, 0.1, 0.1));
        return example_model(study, example_cases(study, theta), theta);
    }();
    return model;
}

}  // namespace

TEST_CASE("training records are read back bit for bit from model.h5 with the model") {
    const TemporaryFolder folder;
    write_trained_model(folder.file("model.h5"), example(), provenance);
    const TrainedModel read = read_trained_model(folder.file("model.h5"));
    CHECK(read.one_set == example().one_set);
    CHECK(read.trained[0].theta == example().trained[0].theta);
    const TrainingDiagnostics &a = example().books, &b = read.books;
    CHECK(b.seed == a.seed);
    CHECK(b.node_weight == a.node_weight);
    CHECK(b.optimum.loss_N == a.optimum.loss_N);
    CHECK(b.optimum.rel_loss == a.optimum.rel_loss);
    CHECK(b.optimum.lower_bound_N == a.optimum.lower_bound_N);
    CHECK(b.optimum.kkt_residual == a.optimum.kkt_residual);
    CHECK(b.optimum.seconds == a.optimum.seconds);
    REQUIRE(b.trained.size() == a.trained.size());
    for (std::size_t t = 0; t < a.trained.size(); ++t) {
        const SetDiagnostics &x = a.trained[t], &y = b.trained[t];
        CHECK(y.optimizer == x.optimizer);
        CHECK(y.loss_N == x.loss_N);
        CHECK(y.rel_loss == x.rel_loss);
        CHECK(y.gap == x.gap);
        CHECK(y.iterations == x.iterations);
        CHECK(y.evaluations == x.evaluations);
        CHECK(y.restarts == x.restarts);
        CHECK(y.status == x.status);
        CHECK(y.curve_iteration == x.curve_iteration);
        CHECK(y.seconds == x.seconds);
        REQUIRE(y.curve_loss_N.rows() == x.curve_loss_N.rows());
        REQUIRE(y.curve_loss_N.cols() == x.curve_loss_N.cols());
        for (Eigen::Index i = 0; i < x.curve_loss_N.size(); ++i) {  // NaN once a set has stopped
            const double before = x.curve_loss_N.data()[i], after = y.curve_loss_N.data()[i];
            CHECK(((std::isnan(before) && std::isnan(after)) || before == after));
        }
    }
}

TEST_CASE("a model without training records is readable as a model but not as a trained model") {
    const TemporaryFolder folder;
    const std::string file = folder.file("model.h5");
    write_model(file, example(), provenance);
    CHECK(read_model(file).trained[0].theta == example().trained[0].theta);
    CHECK_THAT(refusal<FileError>([&] { read_trained_model(file); }), Contains("model.h5: /") && Contains("missing"));
}
