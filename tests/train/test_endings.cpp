#include "train/endings.h"

#include <catch2/catch.hpp>

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

using Words = std::vector<std::string>;

TrainingBook sets_of(const std::string& optimizer, const Words& status, double gap = 0) {
    TrainingBook t;
    t.optimizer = optimizer;
    t.status = status;
    t.gap = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(status.size()), gap);
    return t;
}

const ProblemRecord posed{"force", {"posed", "posed"}, "posed"};

OptimumProof proof(const Words& status) {
    OptimumProof optimum;
    optimum.status = status;
    return optimum;
}

}  // namespace

TEST_CASE("a training whose every part converged has nothing to say", "[endings]") {
    const Endings e = endings_of(posed, {sets_of("spsa", {"converged", "converged"})}, proof({"converged", "converged"}));
    CHECK(e.broken.empty());
    CHECK(e.other.empty());
}

TEST_CASE("stop criteria and the paper's restarts are ends of their own, not broken promises", "[endings]") {
    const Endings e = endings_of(posed,
                                 {sets_of("spsa", {"iterations_done", "target_met"}, 1),
                                  sets_of("spsa-2008", {"restarts_exhausted", "time_out"}, 1)},
                                 proof({"converged", "converged"}));
    CHECK(e.broken.empty());
    CHECK(e.other == Words{"spsa: of 2 sets 1 iterations_done, 1 target_met",
                           "spsa-2008: of 2 sets 1 restarts_exhausted, 1 time_out"});
}

TEST_CASE("a set that stalled is fine near the certified optimum and broken far from it", "[endings]") {
    const OptimumProof optimum = proof({"converged", "converged"});
    const Endings near = endings_of(posed, {sets_of("spsa", {"stalled", "converged"}, 1e-4)}, optimum);
    CHECK(near.broken.empty());
    CHECK(near.other == Words{"spsa: of 2 sets 1 stalled"});
    for (double gap : {1e-2, std::nan("")}) {
        const Endings far = endings_of(posed, {sets_of("spsa", {"stalled", "converged"}, gap)}, optimum);
        CHECK(far.broken == Words{"spsa: of 2 sets 1 stalled"});
        CHECK(far.other.empty());
    }
}

TEST_CASE("what promises convergence and did not reach it is broken: problem, one set, certified optimum", "[endings]") {
    const Endings e = endings_of({"contact", {"floppy", "posed"}, "singular"}, {sets_of("exact", {"converged", "stalled"}, 1)},
                                 proof({"converged", "stalled"}));
    CHECK(e.broken == Words{"objective contact: of 2 sets 1 floppy", "objective contact: the one set for all cases singular",
                            "certified optimum: of 2 sets 1 stalled", "exact: of 2 sets 1 stalled"});
}

TEST_CASE("a model of an earlier program says nothing of its optimum, and nothing is said of it", "[endings]") {
    CHECK(endings_of({}, {sets_of("exact", {"converged", "converged"})}, {}).broken.empty());
}
