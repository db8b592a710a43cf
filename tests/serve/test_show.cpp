#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <thread>

#include "../../cli/serve/frame.h"
#include "../../cli/serve/metrics.h"
#include "../../cli/serve/page.h"
#include "../../cli/serve/show.h"
#include "../example.h"
#include "../haptic/haptic_example.h"
#include "../refusal.h"
#include "../wait_for.h"
#include "error.h"

using namespace tissue;
using namespace tissue::serve;
using Json = nlohmann::json;

namespace {

/// The example with FE forces: 2 N/m along the push.
TissueModel with_forces() {
    TissueModel tissue = haptic_example();
    tissue.contact_force_N = 2 * tissue.magnitude_m.asDiagonal() * tissue.direction;
    return tissue;
}

struct Shown {
    TissueModel tissue = with_forces();
    HapticModel model{tissue, {}};
    Scene scene{tissue, model};
};

/// Cases of that model: at every load case FE's force, and displacements that differ from case to case and node to node.
Cases cases_of(const TissueModel& tissue) {
    Cases cases;
    cases.study = tissue.study;
    cases.nodes = tissue.mesh.nodes;
    cases.magnitudes_m = {0.010, 0.015};
    for (int c = 0; c < tissue.case_count(); ++c) {
        if (c % 2 == 0) {
            const std::string& name = tissue.case_names[static_cast<std::size_t>(c)];
            LoadPath path;
            path.name = name.substr(0, name.rfind('-'));
            path.contact_m = tissue.contact_m.row(c);
            path.direction = tissue.direction.row(c);
            path.depth_m = 0.015;
            cases.paths.push_back(path);
        }
        PathRecord record = measured_record(tissue.magnitude_m[c], tissue.contact_force_N.row(c), Eigen::Vector2d(0, 0));
        record.displacement = record.force = scattered(tissue.mesh, 0.001 * (c + 1));
        record.support_force_N.setZero();
        record.smallest_J = 1;
        cases.paths.back().records.push_back(record);
    }
    return cases;
}

bool in_tissue(const Scene& scene, const Point& p, double margin = 0) {
    for (const auto& [low, high] : scene.boxes())
        if ((p.array() > low.array() - margin).all() && (p.array() < high.array() + margin).all()) return true;
    return false;
}

/// A show of two models whose clients write down what they hear.
struct Stand {
    TemporaryFolder folder;
    std::unique_ptr<Stage> stage;
    std::map<int, std::vector<Json>> heard;
    std::unique_ptr<Show> show;
    double now_s = 100;
    explicit Stand(const std::optional<Cases>& cases = {}) {
        if (cases) write_cases(folder.file("cases.h5"), *cases, {"test", 1, {}});
        write_model(folder.file("a.h5"), with_forces(), {"test", 1, {}});
        write_model(folder.file("b.h5"), haptic_example({"grid8", "axial"}), {"test", 1, {}});
        stage = std::make_unique<Stage>(std::vector<std::string>{folder.file("a.h5"), folder.file("b.h5")}, StageOptions{{}, false});
        show = std::make_unique<Show>(*stage, [this](int client, const std::string& text) { heard[client].push_back(Json::parse(text)); });
    }
    std::string last_holder(int client) const {
        for (auto k = heard.at(client).rbegin(); k != heard.at(client).rend(); ++k)
            if ((*k)["type"] == "control") return (*k)["holder"];
        return "";
    }
    bool point(int client, double x, double y, bool down) {
        return !show->hear(client, Json{{"type", "pointer"}, {"x", x}, {"y", y}, {"down", down}}.dump(), now_s);
    }
    /// Time goes on, as fast as it can; the tick's own is not waited for.
    void pass(double seconds) {
        for (const double end = now_s + seconds; now_s < end; now_s += 0.016) show->step(now_s);
    }
};

}  // namespace

TEST_CASE("cases of one contact and direction are one place, with its curve from rest", "[serve]") {
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

    const TissueModel without = haptic_example();   // of an earlier program
    const HapticModel model(without, {});
    CHECK(Json::parse(Scene(without, model).message({"a"}, 0))["places"][0]["curve"].empty());
}

TEST_CASE("the nearest place is the one at the contact whose push is most like ours, with FE's force at its depth", "[serve]") {
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
    CHECK(std::isnan(at(0.06, 0.1, {0, -0.02}).force_N));   // deeper than FE was asked
    CHECK(std::isnan(at(0.06, 0.1, {0, 0.001}).force_N));   // pulled

    TickSummary summary;
    summary.ticks = 42;
    summary.clients = 3;
    const std::string bytes = FrameCoder().encode(make_frame(state, s.scene, top, summary));
    REQUIRE(bytes.size() == 256 + 2 * 2 * 121 * 4);
    double head[32];
    std::memcpy(head, bytes.data(), sizeof head);
    CHECK((head[1] == 42 && head[13] == 0 && head[22] == 1 && head[26] == 3));
    CHECK(head[23] == top.force_N);
    float node[2];
    std::memcpy(node, bytes.data() + 256 + 4 * 2 * 120, sizeof node);
    CHECK((node[0] == Approx(0.1) && node[1] == Approx(0.1)));
}

TEST_CASE("on its way the hand goes round the tissue; to a point inside it comes from the nearest side", "[serve]") {
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
    hand.follow(Eigen::Vector2d(0.09, 0.05));   // inside, near the right side; the hand is above the middle
    for (int k = 0; k < 200; ++k) hand.step(0.016);
    CHECK((hand.at() - Eigen::Vector2d(0.09, 0.05)).norm() < 1e-12);
    hand.follow(Eigen::Vector2d(0.07, 0.03));   // now it is led
    CHECK((hand.step(0.016) - Eigen::Vector2d(0.07, 0.03)).norm() < 1e-12);
    hand.let_go();
    for (int k = 0; k < 100; ++k) hand.step(0.016);
    CHECK((hand.at() - Eigen::Vector2d(0.11, 0.05)).norm() < 1e-9);   // out where it came in
    hand.follow(Eigen::Vector2d(1e300, -1e300));
    for (int k = 0; k < 1000; ++k) hand.step(0.016);
    CHECK(hand.at().norm() < 2);
}

TEST_CASE("the demo presses every place of a tour as deep as its cases, and only there", "[serve]") {
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
    for (double depth : deepest) CHECK(depth == Approx(0.015 * 1.1).margin(0.0004));
    hand.demonstrate(4);
    for (int k = 0; k < 600; ++k) {
        hand.step(1.0 / 60);
        CHECK(hand.place() == 4);
    }
    hand.let_go();
    CHECK(hand.place() == -1);
}

TEST_CASE("the demo finds tissue that relaxes at rest at every press, and leaves other tissue as it is", "[serve][memory]") {
    for (const bool relaxes : {true, false}) {
        const TemporaryFolder folder;
        write_model(folder.file("law.h5"), relaxes ? relaxing(law_example()) : law_example(), {"test", 1, {}});
        Stage stage({folder.file("law.h5")}, StageOptions{{}, false});
        Show show(stage, [](int, const std::string&) {});
        Simulation simulation(stage.model());
        // both in simulated time: a step of the show every 16 ticks
        int presses = 0, resets = 0;
        int untouched = 1000;   // ticks; a contact may bounce
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
        INFO((relaxes ? "relaxing: " : "elastic: ") << presses << " presses, " << resets << " resets");
        CHECK(presses >= 4);
        if (!relaxes) CHECK(resets == 0);
        else CHECK((resets >= presses && resets <= presses + 1));
    }
}

TEST_CASE("the first to put the pointer down holds the tissue until it lets go, leaves or falls silent", "[serve]") {
    Stand s;
    s.show->join(1);
    s.show->join(2);
    CHECK(s.heard[1][0]["type"] == "model");
    CHECK(s.last_holder(1) == "demo");
    CHECK(s.point(1, 0.05, 0.09, true));
    CHECK((s.last_holder(1) == "you" && s.last_holder(2) == "other"));
    CHECK(s.point(2, 0.05, 0.09, true));                          // in vain, but no offence
    CHECK_FALSE(s.show->hear(2, R"({"type":"pause","on":true})", s.now_s));
    CHECK_FALSE(s.show->hear(2, R"({"type":"demo","place":0})", s.now_s));
    CHECK_FALSE(s.show->hear(2, R"({"type":"model","model":1})", s.now_s));
    CHECK((s.last_holder(1) == "you" && !s.show->paused() && s.stage->index() == 0));
    CHECK(s.point(2, 0, 0, false));
    CHECK(s.last_holder(1) == "you");
    CHECK(s.point(1, 0, 0, false));
    CHECK(s.last_holder(2) == "nobody");
    CHECK(s.point(2, 0.05, 0.09, true));
    CHECK((s.last_holder(1) == "other" && s.last_holder(2) == "you"));
    s.pass(1.5);
    CHECK(s.last_holder(2) == "you");
    s.pass(1);                                                    // silent for two seconds
    CHECK(s.last_holder(2) == "nobody");
    s.pass(4);
    CHECK(s.last_holder(2) == "demo");                            // it begins by itself
    CHECK(s.point(1, 0.05, 0.09, true));
    s.show->leave(1);
    CHECK(s.last_holder(2) == "nobody");
    CHECK_FALSE(s.show->hear(2, R"({"type":"demo","place":3})", s.now_s));
    CHECK(s.heard[2].back() == Json({{"type", "control"}, {"holder", "demo"}, {"paused", false}, {"place", 3}}));
    CHECK_FALSE(s.show->hear(2, R"({"type":"demo","place":99})", s.now_s));   // of another model: the first place
    CHECK(s.heard[2].back()["place"] == 1);
    CHECK(s.show->hear(2, R"({"type":"model","model":2})", s.now_s)->kind == std::string("message"));
    CHECK(s.show->hear(2, "x", s.now_s)->reason == "not JSON");
}

TEST_CASE("a pointer of another dimension is refused, but not while it may have crossed the news of another model", "[serve]") {
    Stand s;
    s.show->join(1);
    const char* in_space = R"({"type":"pointer","x":0.05,"y":0.05,"z":0.05,"down":true})";
    const auto refused = s.show->hear(1, in_space, s.now_s);
    REQUIRE(refused);
    CHECK(refused->kind == std::string("message"));
    CHECK(refused->reason == "'z' is of models in space, and this one is in the plane");
    CHECK(s.last_holder(1) == "demo");
    CHECK_FALSE(s.show->hear(1, R"({"type":"model","model":1})", s.now_s));
    CHECK_FALSE(s.show->hear(1, in_space, s.now_s + 1.9));
    CHECK(s.last_holder(1) != "you");
    CHECK(s.show->hear(1, in_space, s.now_s + 2.1));
    s.stage->stop();
}

TEST_CASE("models change on the running stage, counts go on, and a pause lasts", "[serve]") {
    Stand s;
    CHECK(s.stage->names() == std::vector<std::string>{"example", "example (2)"});
    s.stage->start(nullptr);
    s.show->join(1);
    const auto wait = [&](const auto& wanted) {
        return wait_for([&] {
            s.now_s += 0.001;
            s.show->step(s.now_s);
            return wanted();
        });
    };
    CHECK(wait([&] { return s.stage->counts().ticks > 200; }));
    CHECK_FALSE(s.show->frame().nodes_m.empty());
    CHECK_FALSE(s.show->hear(1, R"({"type":"pause","on":true})", s.now_s));
    CHECK(s.heard[1].back()["paused"] == true);
    CHECK_FALSE(s.show->hear(1, R"({"type":"model","model":1})", s.now_s));
    CHECK(s.stage->index() == 1);
    CHECK(s.stage->model().meshes[0]->springs.spring_count() == 420);
    CHECK(s.show->paused());
    const double turned_s = s.now_s;
    for (int model : {0, 1, 0}) CHECK_FALSE(s.show->hear(1, R"({"type":"model","model":)" + std::to_string(model) + "}", turned_s));
    s.show->step(s.now_s = turned_s + 0.49);
    CHECK(s.stage->index() == 1);   // too soon after the last change
    s.show->step(s.now_s = turned_s + 0.51);
    CHECK(s.stage->index() == 0);   // what was asked for last comes when it may
    CHECK_FALSE(s.show->hear(1, R"({"type":"model","model":1})", s.now_s));
    s.show->step(s.now_s += 0.51);
    CHECK(s.stage->index() == 1);
    CHECK(s.show->paused());
    const long long then = s.stage->counts().ticks;
    CHECK(then > 200);
    CHECK_FALSE(s.show->hear(1, R"({"type":"pause","on":false})", s.now_s));
    CHECK(wait([&] { return s.stage->counts().ticks > then + 100; }));
    CHECK_FALSE(s.show->hear(1, R"({"type":"reset"})", s.now_s));
    s.show->leave(1);
    int models = 0;
    for (const Json& j : s.heard[1]) models += j["type"] == "model";
    CHECK(models == 4);

    Traffic traffic;
    traffic.refused["origin"] = 2;
    const std::string metrics = metrics_text(*s.show, traffic);
    CHECK(metrics.find("\ntissue_refused_total{reason=\"origin\"} 2\n") != std::string::npos);
    CHECK(metrics.find("\ntissue_model_info{name=\"example (2)\"} 1\n") != std::string::npos);
    s.stage->stop();
    CHECK(s.stage->simulation().record().device_N.allFinite());
    CHECK(s.stage->counts().faults() == 0);
    CHECK(refusal<FileError>([&] { Stage({s.folder.file("none.h5")}, {}); }).find("none.h5") != std::string::npos);
    StageOptions wrong;
    wrong.haptic.sets = "best";
    CHECK(refusal<MismatchError>([&] { Stage({s.folder.file("a.h5")}, wrong); }).find("a.h5: spring sets 'best'") != std::string::npos);
}

TEST_CASE("FE's surface in the model's folder is told with the nearest place, once, and is cases.h5's at every case", "[serve]") {
    const TissueModel tissue = with_forces();
    const Cases cases = cases_of(tissue);
    Stand s(cases);
    CHECK(s.stage->warnings().empty());
    s.show->join(1);
    s.stage->start(nullptr);
    const auto nears = [&] {
        std::vector<Json> all;
        for (const Json& j : s.heard[1])
            if (j["type"] == "near") all.push_back(j);
        return all;
    };
    REQUIRE(wait_for([&] {   // the demo goes round the places
        s.now_s += 0.004;
        s.show->step(s.now_s);
        return nears().size() > 4 && nears().back()["place"] >= 0;
    }));
    const auto& outline = s.stage->model().meshes[0]->springs.outline();
    int before = -2, told = 0;
    for (const Json& near : nears()) {
        const int place = near["place"];
        CHECK(place != before);   // not once a frame
        before = place;
        const Json& rows = near["outline"];
        REQUIRE(rows.size() == (place < 0 ? 0 : 3));
        for (std::size_t k = 0; k < rows.size(); ++k) {
            CHECK(rows[k][0] == (k == 0 ? 0.0 : k == 1 ? 0.010 : 0.015));
            REQUIRE(rows[k][1].size() == outline.size());
            for (std::size_t b = 0; b < outline.size(); ++b)
                for (int d = 0; d < 2; ++d) {
                    const auto& records = cases.paths[static_cast<std::size_t>(place)].records;
                    const double u = k == 0 ? 0 : records[k - 1].displacement(outline[b], d);
                    CHECK(rows[k][1][b][static_cast<std::size_t>(d)].get<double>() == Approx(u).margin(0.51e-7).epsilon(0));
                }
        }
        told += place >= 0;
    }
    CHECK(told > 0);
    s.show->join(2);   // who comes later is told too
    Json last;
    for (const Json& j : s.heard[2])
        if (j["type"] == "near") last = j;
    CHECK(last == nears().back());
}

TEST_CASE("without cases.h5 there is no FE surface and no word of it; a foreign or damaged one is not used, and one line says so",
          "[serve]") {
    const TissueModel tissue = with_forces();
    const auto no_outline = [](const Stand& s) {
        for (const Place& place : s.stage->scene().places())
            if (!place.outlines.empty()) return false;
        return true;
    };
    const Stand without;
    CHECK((no_outline(without) && without.stage->warnings().empty()));

    const auto refused = [&](const Cases& cases, const std::string& why) {
        const Stand s(cases);
        const std::vector<std::string>& said = s.stage->warnings();
        INFO(why);
        REQUIRE_FALSE(said.empty());
        CHECK(no_outline(s));
        CHECK(said[0] == s.folder.file("cases.h5") + " is not used: it does not belong to " + s.folder.file("a.h5") + ": " + why);
    };
    Cases study = cases_of(tissue), nodes = study, missing = study, force = study, contact = study, depth = study;
    study.study = "other";
    refused(study, "it is of the study 'other'");
    nodes.nodes(7, 0) += 1e-6;
    refused(nodes, "it has other nodes");
    missing.paths[1].name = "above";
    refused(missing, "it has no load case 'top-10mm'");
    force.paths[2].records[1].contact_force_N *= 1.001;
    refused(force, "its load case 'right-15mm' is another");
    contact.paths[0].contact_m.y() += 1e-6;
    refused(contact, "its load case 'left-10mm' is another");

    depth.magnitudes_m[0] *= 1 + 1e-7;   // to six digits the same name
    for (LoadPath& path : depth.paths) path.records[0].magnitude_m = depth.magnitudes_m[0];
    refused(depth, "its load case 'left-10mm' is another");

    const TemporaryFolder folder;
    folder.file("cases.h5", "no HDF5");
    const FeCases damaged = read_fe_cases(folder.file("model.h5"), tissue);
    CHECK(damaged.displacement_m.empty());
    CHECK(damaged.warning.find("cases.h5 is not used: ") != std::string::npos);
    CHECK(damaged.warning.find('\n') == std::string::npos);

    Cases measured = cases_of(tissue);   // of a hand: true, and silent about the inside
    measured.measurement = Measurement{};
    measured.measurement->noise_source = "unknown";
    write_cases(folder.file("cases.h5"), measured, {"test", 1, {}});
    const FeCases hand = read_fe_cases(folder.file("model.h5"), tissue);
    CHECK((hand.displacement_m.empty() && hand.warning.empty()));
}

TEST_CASE("the page is in the program, whole, and asks for nothing from elsewhere", "[serve]") {
    CHECK(page_file("/page.css"));
    CHECK(page_file("/page.js"));
    for (const PageFile& file : page_files()) {
        INFO(file.path);
        CHECK(file.text.size() > 200);
        CHECK(page_file(file.path)->text == file.text);
        if (file.path != "/three.module.js") CHECK(file.text.find("https://") == std::string_view::npos);
        const std::string_view from = " from \"./";   // every module that another one needs is there
        for (std::size_t at = 0; (at = file.text.find(from, at)) != std::string_view::npos;) {
            at += from.size() - 1;
            const std::string needed(file.text.substr(at, file.text.find('"', at) - at));
            INFO(needed);
            CHECK(page_file(needed));
        }
    }
    CHECK(page_file("/")->text.find("</html>") != std::string_view::npos);
    CHECK(page_file("/")->text.find("<script>") == std::string_view::npos);   // the policy allows files alone
    CHECK_FALSE(page_file("/index.html/.."));
    CHECK_FALSE(page_file(""));
}

TEST_CASE("a law has a scene too: its springs, its places and what FE says there, and no spring sets", "[serve]") {
    TissueModel tissue = law_example();
    tissue.contact_force_N = 100 * tissue.magnitude_m.asDiagonal() * tissue.direction;
    const HapticModel model(tissue, {});
    const Scene scene(tissue, model);
    const Json message = Json::parse(scene.message({"law"}, 0));
    CHECK(message["law"] == true);
    CHECK(message["places"].size() == 5);
    CHECK(message["meshes"][0]["stiffness_N_m"][7].get<double>() == Approx(tissue.energy_law->constants[7]));

    // the demo's own press: FE's force is told at the tool's depth
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
        if (!std::isfinite(near.force_N)) continue;  // deeper than FE went
        ++compared;
        CHECK(near.force_N == Approx(100 * depth).margin(1e-9));
    }
    CHECK(compared > 500);
}

TEST_CASE("a law that relaxes says how the force under its tool does; other models say nothing of it", "[serve]") {
    const auto told = [](const TissueModel& tissue) {
        const HapticModel model(tissue, {});
        return Json::parse(Scene(tissue, model).message({"a"}, 0));
    };
    TissueModel tissue = relaxing(law_example());
    tissue.energy_law->relaxation.share *= 0.5;   // what is told is the contact's
    const Json relaxation = told(tissue)["relaxation"];
    CHECK(relaxation == Json({{"tau_s", {0.05, 1.0, 10.0}}, {"share", {0.30, 0.25, 0.20}}}));
    CHECK(told(law_example()).count("relaxation") == 0);
    CHECK(told(with_forces()).count("relaxation") == 0);
}

TEST_CASE("a state says when the tissue was last put to rest: at the beginning, or when someone asked for it", "[serve]") {
    const TissueModel tissue = relaxing(law_example());
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

TEST_CASE("a model that learns while it plays: everyone hears what became of each reading, and those who come later what is known", "[serve][adapt]") {
    const TemporaryFolder folder;
    TissueModel hidden = law_example();
    for (double& constant : hidden.energy_law->constants) constant *= 1.5;
    hidden.energy_law->patch.log_N_m.array() += std::log(1.5);
    write_model(folder.file("law.h5"), law_example(), {"test", 1, {}});
    write_model(folder.file("hidden.h5"), hidden, {"test", 1, {}});
    write_model(folder.file("sets.h5"), haptic_example(), {"test", 1, {}});
    StageOptions options;
    options.realtime = false;
    options.hidden = folder.file("hidden.h5");
    CHECK_THROWS_AS(Stage({folder.file("law.h5"), folder.file("law.h5")}, options), MismatchError);
    CHECK_THROWS_AS(Stage({folder.file("sets.h5")}, options), MismatchError);
    Stage stage({folder.file("law.h5")}, options);
    CHECK(stage.scene().learns());
    std::map<int, std::vector<Json>> heard;
    Show show(stage, [&](int client, const std::string& text) {
        const Json j = Json::parse(text);
        if (j["type"] == "learned") heard[client].push_back(j);
        if (j["type"] == "model") CHECK(j["learns"] == true);
    });
    show.join(1);
    show.step(100);
    REQUIRE(heard[1].size() == 1);
    CHECK(heard[1][0]["learned"]["pokes"] == 0);
    CHECK_FALSE(heard[1][0].contains("reading"));
    CHECK(heard[1][0]["next"]["push_m"].size() == 2);
    stage.start(nullptr);
    const auto began = std::chrono::steady_clock::now();
    const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(); };
    while (heard[1].size() < 3 && seconds() < 60) {
        show.step(100 + seconds());
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    stage.stop();
    REQUIRE(heard[1].size() >= 3);
    const Json& last = heard[1].back();
    CHECK(last["reading"]["status"] == "learned");
    const auto factor = last["learned"]["factor"].get<std::vector<double>>();
    double mean = 0;
    for (double f : factor) mean += f / static_cast<double>(factor.size());
    CHECK(mean > 1.2);
    show.join(2);
    REQUIRE(heard[2].size() == 1);
    CHECK(heard[2][0] == last);
}
