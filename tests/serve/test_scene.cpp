#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "../../cli/serve/frame.h"
#include "serve_example.h"

using namespace tissue;
using namespace tissue::serve;
using Json = nlohmann::json;

TEST_CASE("load cases of one contact and direction form one place with a force curve from rest", "[serve]") {
    const Shown s;
    REQUIRE(s.scene.places().size() == 9);
    const Place& top = s.scene.places()[1];
    CHECK(top.name == "top");
    CHECK(top.depth_m == 0.015);
    REQUIRE(top.curve.size() == 3);
    CHECK(top.curve[0] == std::pair(0.0, 0.0));
    CHECK(top.curve[2].second == Approx(0.03));
    CHECK((top.inward - Eigen::Vector2d(0, -1)).norm() < 1e-12);
    CHECK(s.scene.first_place() == 1);

    const Json j = Json::parse(s.scene.message({"a", "b"}, 1));
    for (const char* key : {"type", "study", "models", "model", "dt_s", "force_max_N", "force_scale", "dynamics", "low_m", "high_m", "meshes", "places", "demo"})
        CHECK(j.count(key) == 1);
    CHECK(j["meshes"].size() == 2);
    CHECK(j["meshes"][1]["nodes_m"][0][0].get<double>() == Approx(0.15));
    CHECK(j["meshes"][0]["springs"].size() == 220);
    CHECK(j["meshes"][0]["stiffness_N_m"][5].get<double>() == Approx(s.tissue.trained[0].theta.col(5).mean()));
    CHECK(j["high_m"][0].get<double>() == Approx(0.25));
    CHECK(j["places"][1]["curve"].size() == 3);

    const TissueModel without = haptic_example();   // without FE forces, as files of earlier programs
    const HapticModel model(without, {});
    CHECK(Json::parse(Scene(without, model).message({"a"}, 0))["places"][0]["curve"].empty());
}

TEST_CASE("the nearest place has the nearest contact and most similar direction; its FE force is at the present depth", "[serve]") {
    const Shown s;
    Simulation simulation(s.model);
    StateChannel channel(s.model, 1);
    channel.after(simulation, {});
    REQUIRE(channel.fetch());
    TickState state = channel.state();
    CHECK(s.scene.near(state).place == -1);
    const std::vector<int>& outline = s.model.meshes[0]->springs.outline();
    const auto at = [&](double x, double y, const Eigen::Vector2d& push) {
        state.record.mesh = 0;
        for (std::size_t b = 0; b < outline.size(); ++b)
            if ((s.model.meshes[0]->springs.rest().row(outline[b]) - Eigen::RowVector2d(x, y)).norm() < 1e-9) state.record.facet = static_cast<int>(b);
        state.record.weight = {1, 0, 0};
        state.contact_displacement_m[0] = push;
        return s.scene.near(state);
    };
    const Near corner = at(0, 0.1, {0.004, -0.005});
    CHECK(s.scene.places()[static_cast<std::size_t>(corner.place)].name == "tl-diagonal");
    CHECK(corner.distance_m < 1e-12);
    CHECK(corner.force_N == Approx(2 * 0.009 / std::sqrt(2)));
    CHECK(s.scene.places()[static_cast<std::size_t>(at(0, 0.1, {0.001, -0.009}).place)].name == "tl-down");
    const Near top = at(0.06, 0.1, {0, -0.012});
    CHECK(s.scene.places()[static_cast<std::size_t>(top.place)].name == "top");
    CHECK(top.distance_m == Approx(0.01));
    CHECK(top.force_N == Approx(0.024));
    CHECK(std::isnan(at(0.06, 0.1, {0, -0.02}).force_N));   // deeper than the FE reference
    CHECK(std::isnan(at(0.06, 0.1, {0, 0.001}).force_N));   // pulled outwards

    TickSummary summary;
    summary.ticks = 42;
    summary.clients = 3;
    state.record.status = TickStatus::folded;
    const std::string bytes = FrameCoder().encode(make_frame(state, s.scene, top, summary));
    REQUIRE(bytes.size() == 256 + 2 * 2 * 121 * 4);
    double head[32];
    std::memcpy(head, bytes.data(), sizeof head);
    CHECK((head[1] == 42 && head[13] == 0 && head[22] == 1 && head[26] == 3));
    CHECK(head[23] == top.force_N);
    CHECK((head[25] == 0 && head[28] == 3));
    float node[2];
    std::memcpy(node, bytes.data() + 256 + 4 * 2 * 120, sizeof node);
    CHECK((node[0] == Approx(0.1) && node[1] == Approx(0.1)));
}

TEST_CASE("the scene of an energy model has springs and places with FE forces and no spring set", "[serve]") {
    TissueModel tissue = energy_model_example();
    tissue.contact_force_N = 100 * tissue.magnitude_m.asDiagonal() * tissue.direction;
    const HapticModel model(tissue, {});
    const Scene scene(tissue, model);
    const Json message = Json::parse(scene.message({"law"}, 0));
    CHECK(message["law"] == true);
    CHECK(message["places"].size() == 5);
    CHECK(message["meshes"][0]["stiffness_N_m"][7].get<double>() == Approx(tissue.energy_model->constants[7]));

    // in an indentation by the demo, the FE force is that at the tool's depth
    Simulation simulation(model);
    StateChannel channel(model, 1);
    Hand hand(scene);
    hand.demonstrate(scene.first_place());
    int compared = 0;
    for (int k = 0; k < 6000; ++k) {
        const Eigen::Vector2d at = hand.step(1e-3);
        simulation.tick(sample_at(at.x(), at.y()));
        channel.after(simulation, {});
        REQUIRE(channel.fetch());
        const Near near = scene.near(channel.state());
        if (near.place < 0) continue;
        CHECK(channel.state().record.set == -1);
        const double depth = channel.state().record.contact_displacement_m.dot(scene.places()[static_cast<std::size_t>(near.place)].direction);
        if (!std::isfinite(near.force_N)) continue;  // deeper than the FE reference
        ++compared;
        CHECK(near.force_N == Approx(100 * depth).margin(1e-9));
    }
    CHECK(compared > 500);
}

TEST_CASE("the model message of a relaxing energy model has the relaxation of its contact; others have none", "[serve]") {
    const auto told = [](const TissueModel& tissue) {
        const HapticModel model(tissue, {});
        return Json::parse(Scene(tissue, model).message({"a"}, 0));
    };
    TissueModel tissue = relaxing(energy_model_example());
    tissue.energy_model->relaxation.share *= 0.5;   // the message has the contact's moduli, not these
    const Json relaxation = told(tissue)["relaxation"];
    CHECK(relaxation == Json({{"tau_s", {0.05, 1.0, 10.0}}, {"share", {0.30, 0.25, 0.20}}}));
    CHECK(told(energy_model_example()).count("relaxation") == 0);
    CHECK(told(with_forces()).count("relaxation") == 0);
}

TEST_CASE("a state has the time of the last reset and 0 before the first", "[serve]") {
    const TissueModel tissue = relaxing(energy_model_example());
    const HapticModel model(tissue, {});
    const Scene scene(tissue, model);
    Simulation simulation(model);
    StateChannel channel(model, 1);
    const auto rested_s = [&](int ticks) {
        for (int k = 0; k < ticks; ++k) {
            REQUIRE(channel.before(simulation));
            simulation.tick(sample_at(0.05, 0.2));
            channel.after(simulation, {});
        }
        REQUIRE(channel.fetch());
        return make_frame(channel.state(), scene, scene.near(channel.state()), {}).head[27];
    };
    CHECK(rested_s(5) == 0);
    channel.reset();
    CHECK(rested_s(7) == Approx(5 * model.options.dt_s));
    CHECK(rested_s(7) == Approx(5 * model.options.dt_s));
}
