#include "eval/force_map.h"

#include <catch2/catch.hpp>

#include "error.h"
#include "springs/indentation_solver.h"
#include "../example.h"
#include "../refusal.h"
#include "../tolerances.h"

using namespace tissue;

namespace {

/// Paths of a map at these places along the middle of the example's top, with 1.1 times the forces of the given model.
Cases mapped(const TissueModel& model, const std::vector<double>& x_m) {
    const IndentationSolver solver(model);
    const Point down = Eigen::Vector3d(0, 0, -1);
    Cases cases;
    for (double x : x_m) {
        LoadPath& path = cases.paths.emplace_back();
        path.name = "map-" + std::to_string(cases.paths.size());
        path.role = "map";
        path.contact_m = Eigen::Vector3d(x, 0.05, 0.05);
        path.direction = down;
        path.depth_m = 0.003;
        const Equilibrium state = solver.at(path.contact_m, 0.003 * down);
        REQUIRE(state);
        PathRecord record;
        record.magnitude_m = 0.003;
        record.contact_force_N = 1.1 * state.contact_force;
        path.records.push_back(record);
    }
    return cases;
}

TissueModel with_nodule() {
    TissueModel model = solid_example();
    model.energy_model->disc.ground.resize(2, 4);
    model.energy_model->disc.ground << 0.045, 0.05, 0.04, 1e-6, 0.055, 0.05, 0.04, 1e-6;
    model.energy_model->patch.log_N_m(0, ContactParameters::ground_factor) = 0.5;
    return model;
}

}  // namespace

TEST_CASE("a force map has FE and model forces; contrast is force over the nodule over the farthest forces", "[solid]") {
    const TissueModel model = with_nodule();
    const Cases cases = mapped(model, {0.02, 0.035, 0.05, 0.08});
    const ForceMap map = force_map(model, cases, 2);
    REQUIRE(map.places.size() == 4);
    CHECK(map.depth_m == 0.003);
    for (const ForceMap::Place& p : map.places) CHECK(p.fe_N == Approx(1.1 * p.learned_N.value()).epsilon(tolerance::solve));
    REQUIRE(map.contrast);
    CHECK(map.contrast->over_m[0] == 0.05);
    CHECK(map.contrast->far_m.size() == 2);
    CHECK(map.contrast->fe == Approx(map.places[2].fe_N / ((map.places[0].fe_N + map.places[3].fe_N) / 2)).epsilon(tolerance::rounding));
    CHECK(map.contrast->learned.value() == Approx(map.contrast->fe).epsilon(tolerance::solve));
    CHECK(map.contrast->fe > 1);
    CHECK_FALSE(force_map(solid_example(), cases, 1).contrast);  // no nodule
}

TEST_CASE("places of a map without FE reference are listed and left out; cases without a map have none", "[solid]") {
    const TissueModel model = with_nodule();
    Cases cases = mapped(model, {0.02, 0.05, 0.08});
    cases.paths[0].lost = "lost at 2 mm";
    const ForceMap map = force_map(model, cases, 1);
    CHECK(map.places.size() == 2);
    CHECK(map.lost == std::vector<std::string>{"map-1: lost at 2 mm"});
    CHECK(map.contrast->far_m.size() == 1);
    CHECK(n_of_N(map.error(), "places") == "2 of 3 places, 1 without a reference");
    CHECK(map.error().max == Approx(0.1 / 1.1).epsilon(tolerance::solve));
    ForceMap missing = map;
    missing.places[1].learned_N.reset();
    CHECK(std::isinf(missing.error().median));
    CHECK(missing.error().missing == 1);
    for (LoadPath& path : cases.paths) path.role = "held_out";
    CHECK(force_map(model, cases, 1).empty());
    TissueModel sets = model;
    sets.energy_model.reset();
    CHECK(force_map(sets, cases, 1).empty());
    cases.paths[1].role = "map";
    CHECK_THROWS_AS(force_map(sets, cases, 1), MismatchError);
}
