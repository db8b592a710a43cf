#include <catch2/catch.hpp>

#include "serve_example.h"

using namespace tissue;
using namespace tissue::serve;

TEST_CASE("the hand moves around the tissue and leaves it where it entered at the nearest side", "[serve]") {
    const Shown s;
    Draw draw(4);
    for (int k = 0; k < 300; ++k) {
        const auto& boxes = s.scene.boxes();
        const Point from = outside(boxes, Eigen::Vector2d(draw(-0.05, 0.3), draw(-0.05, 0.15)), 0.01),
                    to = outside(boxes, Eigen::Vector2d(draw(-0.05, 0.3), draw(-0.05, 0.15)), 0.01);
        CHECK_FALSE(in_tissue(s.scene, from, 0.0099));
        Point at = from;
        double length = 0;
        for (const Point& p : way_round(boxes, from, to, 0.01)) {
            for (int i = 0; i <= 50; ++i) REQUIRE_FALSE(in_tissue(s.scene, at + (p - at) * i / 50, 0.0088));
            length += (p - at).norm();
            at = p;
        }
        CHECK(at == to);
        CHECK(length < (to - from).norm() + 0.6);
    }
    Hand hand(s.scene);
    hand.follow(Eigen::Vector2d(0.09, 0.05));   // inside, near the right side; the hand starts above the middle
    for (int k = 0; k < 200; ++k) hand.step(0.016);
    CHECK((hand.at() - Eigen::Vector2d(0.09, 0.05)).norm() < 1e-12);
    hand.follow(Eigen::Vector2d(0.07, 0.03));   // the hand now follows directly
    CHECK((hand.step(0.016) - Eigen::Vector2d(0.07, 0.03)).norm() < 1e-12);
    hand.let_go();
    for (int k = 0; k < 100; ++k) hand.step(0.016);
    CHECK((hand.at() - Eigen::Vector2d(0.11, 0.05)).norm() < 1e-9);   // it leaves where it entered
    hand.follow(Eigen::Vector2d(1e300, -1e300));
    for (int k = 0; k < 1000; ++k) hand.step(0.016);
    CHECK(hand.at().norm() < 2);
}

TEST_CASE("the demo indents every place to the depth of its load cases and nowhere else", "[serve]") {
    const Shown s;
    Hand hand(s.scene);
    hand.demonstrate(-1);
    std::vector<double> deepest(9, 0);
    std::vector<int> order;
    for (int k = 0; k < 60 * 60; ++k) {
        hand.step(1.0 / 60);
        const int place = hand.place();
        REQUIRE(place >= 0);
        if (order.empty() || order.back() != place) order.push_back(place);
        const Place& p = s.scene.places()[static_cast<std::size_t>(place)];
        const Eigen::Vector2d in = hand.at() - p.contact_m;
        if (in_tissue(s.scene, hand.at())) {
            deepest[static_cast<std::size_t>(place)] = std::max(deepest[static_cast<std::size_t>(place)], in.dot(p.direction));
            CHECK(in.norm() < 0.017);
        }
    }
    CHECK(order.front() == s.scene.first_place());
    for (double depth : deepest) CHECK(depth == Approx(0.015 * 1.1).margin(0.0004));   // 0.1: stretch of the coupling
    hand.demonstrate(4);
    for (int k = 0; k < 600; ++k) {
        hand.step(1.0 / 60);
        CHECK(hand.place() == 4);
    }
    hand.let_go();
    CHECK(hand.place() == -1);
}

TEST_CASE("the demo resets relaxing tissue before every indentation and never resets elastic tissue", "[serve][memory]") {
    for (const bool relaxes : {true, false}) {
        const TemporaryFolder folder;
        write_model(folder.file("law.h5"), relaxes ? relaxing(energy_model_example()) : energy_model_example(), {"test", 1, {}});
        Stage stage({folder.file("law.h5")}, StageOptions{{}, false});
        Show show(stage, [](int, const std::string&) {});
        Simulation simulation(stage.model());
        // simulated time: one step of the show every 16 ticks
        int presses = 0, resets = 0;
        int untouched = 1000;   // ticks without contact; a bouncing contact counts once
        for (int k = 0; k < 20000; ++k) {
            if (k % 16 == 0) show.step(100 + 1e-3 * k);
            stage.channel().before(simulation);
            simulation.tick(stage.pointer().read(1e-3 * k));
            const bool first = simulation.contact().contact && untouched > 300;
            untouched = simulation.contact().contact ? 0 : untouched + 1;
            resets += simulation.record().reset;
            if (simulation.record().reset) CHECK_FALSE(in_tissue(stage.scene(), simulation.record().master_m));
            if (!first) continue;
            if (relaxes) CHECK(simulation.rested_s() > simulation.record().time_s - 0.5);
            ++presses;
        }
        INFO((relaxes ? "relaxing: " : "elastic: ") << presses << " indentations, " << resets << " resets");
        CHECK(presses >= 4);
        if (!relaxes) CHECK(resets == 0);
        else CHECK((resets >= presses && resets <= presses + 1));
    }
}

TEST_CASE("the demo resets a mesh that has not returned to rest before the next indentation", "[serve][long]") {
    for (const bool away : {true, false}) {
        const TemporaryFolder folder;
        write_model(folder.file("law.h5"), energy_model_example(), {"test", 1, {}});
        Stage stage({folder.file("law.h5")}, StageOptions{{}, false});
        Show show(stage, [](int, const std::string&) {});
        // the demo indents the first; the show gets the states of the second
        Simulation simulation(stage.model()), seen(stage.model());
        // ends 10 mm below the top, far from rest as an inverted mesh would be
        for (int k = 0; k < 1500; ++k) seen.tick(sample_at(0.05, 0.12 - (away ? 2e-5 : 0) * k));
        int resets = 0, presses = 0;
        for (int k = 0; k < 20000; ++k) {
            if (k % 16 == 0) show.step(100 + 1e-3 * k);
            stage.channel().before(simulation);
            const bool before = simulation.contact().contact;
            simulation.tick(stage.pointer().read(1e-3 * k));
            stage.channel().after(seen, {});
            resets += simulation.record().reset;
            if (simulation.record().reset) CHECK_FALSE(in_tissue(stage.scene(), simulation.record().master_m));
            presses += simulation.contact().contact && !before;
        }
        INFO((away ? "away: " : "at rest: ") << presses << " indentations, " << resets << " resets");
        CHECK(presses >= 4);
        CHECK((away ? resets >= 4 : resets == 0));
    }
}

TEST_CASE("in the plane the tool enters perpendicular to the nearest side although the device lags the hand", "[serve]") {
    const TemporaryFolder folder;
    write_model(folder.file("law.h5"), energy_model_example(), {"test", 1, {}});
    Stage stage({folder.file("law.h5")}, StageOptions{{}, false});
    Show show(stage, [](int, const std::string&) {});
    show.join(1);
    Simulation simulation(stage.model());
    int k = 0;
    const auto pass = [&](double seconds, const auto& look) {
        for (const int end = k + static_cast<int>(1e3 * seconds); k < end; ++k) {
            if (k % 16 == 0) show.step(100 + 1e-3 * k);
            simulation.tick(stage.pointer().read(1e-3 * k));
            look(simulation.record().master_m);
        }
    };
    Draw draw(12);
    for (int press = 0; press < 12; ++press) {
        const double in = draw(0.004, 0.009), along = draw(0.02, 0.08);
        const int side = press % 3;   // left, right, top
        const Point wanted = side == 0 ? Eigen::Vector2d(in, along) : side == 1 ? Eigen::Vector2d(0.1 - in, along) : Eigen::Vector2d(along, 0.1 - in);
        double off = -1;
        const auto point = [&](bool down) {
            show.hear(1, nlohmann::json{{"type", "pointer"}, {"x", wanted[0]}, {"y", wanted[1]}, {"down", down}}.dump(), 100 + 1e-3 * k);
        };
        for (int word = 0; word < 5; ++word) {   // a page repeats its message twice a second while the hand rests
            point(true);
            pass(0.5, [&](const Point& at) {
                if (in_tissue(stage.scene(), at)) off = std::max(off, std::abs(side == 2 ? at[0] - along : at[1] - along));
            });
        }
        INFO("indentation " << press << " at " << wanted.transpose());
        CHECK(off >= 0);
        CHECK(off < 2e-4);
        CHECK((simulation.record().master_m - wanted).norm() < 1e-4);
        point(false);
        pass(1, [](const Point&) {});
    }
}

TEST_CASE("a hand dragged along the side of a plane mesh first waits outside and is inside within 1 s", "[serve]") {
    const Shown s;
    for (const double speed_m_s : {0.02, 0.03, 0.1, 0.3}) {
        Hand hand(s.scene);
        double there_s = -1;
        for (int k = 0; k < 120 && there_s < 0; ++k) {   // back and forth between x = 20 mm and 80 mm
            const double way = std::fmod(speed_m_s * k / 60, 0.12);
            const Point wanted = Eigen::Vector2d(0.02 + (way < 0.06 ? way : 0.12 - way), 0.094);
            hand.follow(wanted);
            hand.step(1.0 / 60);
            if (in_tissue(s.scene, hand.at()) && (hand.at() - wanted).norm() < 1e-12) there_s = k / 60.0;
        }
        INFO("dragged at " << speed_m_s << " m/s");
        CHECK(there_s > 0.15);   // it first waits outside
        CHECK(there_s < 1);
    }
}

TEST_CASE("the demo resets model and target tissue together: equal tissues have equal forces at rest within 2 per cent", "[serve][adapt][memory]") {
    const TemporaryFolder folder;
    write_model(folder.file("law.h5"), relaxing(energy_model_example()), {"test", 1, {}});
    StageOptions options;
    options.realtime = false;
    options.hidden = folder.file("law.h5");
    Stage stage({folder.file("law.h5")}, options);
    Show show(stage, [](int, const std::string&) {});
    Simulation simulation(stage.model());
    int felt = 0, resets = 0;
    int still = 0;
    double worst = 0;
    Point before_m = Point::Zero(2);
    for (int k = 0; k < 20000; ++k) {
        if (k % 16 == 0) show.step(100 + 1e-3 * k);
        if (k == 9990) show.hear(1, R"({"type":"reset"})", 100 + 1e-3 * k);
        stage.channel().before(simulation);
        const DeviceSample sample = stage.devices().front()->read(1e-3 * k);
        simulation.tick(sample);
        resets += simulation.record().reset;
        const Eigen::Vector2d own_N = -simulation.record().coupling_N, felt_N = stage.model().options.map.force_to_tissue(sample.measured_N).head(2);
        still = simulation.record().mesh < 0 || (simulation.record().master_m - before_m).norm() > 1e-5 ? 0 : still + 1;
        before_m = simulation.record().master_m;
        if (still < 200) continue;  // a new contact oscillates, and the two integrate with different steps
        ++felt;
        worst = std::max(worst, (felt_N - own_N).norm() / own_N.norm());
    }
    CHECK(felt > 1000);
    CHECK(resets >= 3);
    CHECK(worst < 0.02);
}
