#include "train/endings.h"

#include <catch2/catch.hpp>

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

using Words = std::vector<std::string>;

SetDiagnostics sets_of(const std::string& optimizer, const Words& status, double gap = 0) {
    SetDiagnostics t;
    t.optimizer = optimizer;
    t.status = status;
    t.gap = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(status.size()), gap);
    return t;
}

const ProblemRecord posed{"force", {"posed", "posed"}, "posed"};

OptimumCertificate proof(const Words& status) {
    OptimumCertificate optimum;
    optimum.status = status;
    return optimum;
}

}  // namespace

TEST_CASE("a training with all parts converged reports no endings", "[endings]") {
    const Endings e = endings_of(posed, {sets_of("spsa", {"converged", "converged"})}, proof({"converged", "converged"}));
    CHECK(e.broken.empty());
    CHECK(e.other.empty());
}

TEST_CASE("stop criteria and exhausted restarts are reported but not as broken", "[endings]") {
    const Endings e = endings_of(posed,
                                 {sets_of("spsa", {"iterations_done", "target_met"}, 1),
                                  sets_of("spsa-2008", {"restarts_exhausted", "time_out"}, 1)},
                                 proof({"converged", "converged"}));
    CHECK(e.broken.empty());
    CHECK(e.other == Words{"spsa: of 2 sets 1 iterations_done, 1 target_met",
                           "spsa-2008: of 2 sets 1 restarts_exhausted, 1 time_out"});
}

TEST_CASE("a stalled set is reported as broken only if far from the certified optimum", "[endings]") {
    const OptimumCertificate optimum = proof({"converged", "converged"});
    const Endings near = endings_of(posed, {sets_of("spsa", {"stalled", "converged"}, 1e-4)}, optimum);
    CHECK(near.broken.empty());
    CHECK(near.other == Words{"spsa: of 2 sets 1 stalled"});
    for (double gap : {1e-2, std::nan("")}) {
        const Endings far = endings_of(posed, {sets_of("spsa", {"stalled", "converged"}, gap)}, optimum);
        CHECK(far.broken == Words{"spsa: of 2 sets 1 stalled"});
        CHECK(far.other.empty());
    }
}

TEST_CASE("unconverged problem and common set and certified optimum and exact solve are reported as broken", "[endings]") {
    const Endings e = endings_of({"contact", {"floppy", "posed"}, "singular"}, {sets_of("exact", {"converged", "stalled"}, 1)},
                                 proof({"converged", "stalled"}));
    CHECK(e.broken == Words{"objective contact: of 2 sets 1 floppy", "objective contact: the single set for all cases singular",
                            "certified optimum: of 2 sets 1 stalled", "exact: of 2 sets 1 stalled"});
}

TEST_CASE("a model of an earlier program without statuses reports nothing as broken", "[endings]") {
    CHECK(endings_of({}, {sets_of("exact", {"converged", "converged"})}, {}).broken.empty());
}
