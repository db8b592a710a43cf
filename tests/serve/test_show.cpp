#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <thread>

#include "../../cli/serve/metrics.h"
#include "../refusal.h"
#include "../wait_for.h"
#include "../solid_example.h"
#include "error.h"
#include "serve_example.h"

using namespace tissue;
using namespace tissue::serve;
using Json = nlohmann::json;

TEST_CASE("the first client with its pointer down holds the tissue until it releases it or leaves or stops sending", "[serve]") {
    Stand s;
    s.show->join(1);
    s.show->join(2);
    CHECK(s.heard[1][0]["type"] == "model");
    CHECK(s.last_holder(1) == "demo");
    CHECK(s.point(1, 0.05, 0.09, true));
    CHECK((s.last_holder(1) == "you" && s.last_holder(2) == "other"));
    CHECK(s.point(2, 0.05, 0.09, true));                          // no effect, but not refused
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
    s.pass(1);                                                    // no message for more than 2 s
    CHECK(s.last_holder(2) == "nobody");
    s.pass(4);
    CHECK(s.last_holder(2) == "demo");                            // the demo starts by itself
    CHECK(s.point(1, 0.05, 0.09, true));
    s.show->leave(1);
    CHECK(s.last_holder(2) == "nobody");
    CHECK_FALSE(s.show->hear(2, R"({"type":"demo","place":3})", s.now_s));
    CHECK(s.heard[2].back() == Json({{"type", "control"}, {"holder", "demo"}, {"holders", {"demo"}}, {"paused", false}, {"place", 3}}));
    CHECK(s.show->hear(2, R"({"type":"demo","place":99})", s.now_s)->reason == "no such place");
    CHECK(s.heard[2].back()["place"] == 3);
    CHECK(s.show->hear(2, R"({"type":"model","model":2})", s.now_s)->kind == std::string("message"));
    CHECK(s.show->hear(2, "x", s.now_s)->reason == "not JSON");
}

TEST_CASE("a pointer of the wrong dimension is refused except in the 2 s after a change of model", "[serve]") {
    Stand s;
    s.show->join(1);
    const char* in_space = R"({"type":"pointer","x":0.05,"y":0.05,"z":0.05,"down":true})";
    const auto refused = s.show->hear(1, in_space, s.now_s);
    REQUIRE(refused);
    CHECK(refused->kind == std::string("message"));
    CHECK(refused->reason == "'z' is not allowed: this model is in the plane");
    CHECK(s.last_holder(1) == "demo");
    CHECK_FALSE(s.show->hear(1, R"({"type":"model","model":1})", s.now_s));
    CHECK_FALSE(s.show->hear(1, in_space, s.now_s + 1.9));
    CHECK(s.last_holder(1) != "you");
    CHECK(s.show->hear(1, in_space, s.now_s + 2.1));
    s.stage->stop();
}

TEST_CASE("a running stage changes models at most every 0.5 s and keeps its counts and a pause", "[serve]") {
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
    CHECK(s.stage->index() == 0);   // the last request is done after 0.5 s
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
    for (const char* count : {"capped_total", "late_total", "lost_seconds_total"}) CHECK(metrics.find(std::string("\ntissue_") + count + " ") != std::string::npos);
    CHECK(metrics.find("\ntissue_model_info{name=\"example (2)\"} 1\n") != std::string::npos);
    s.stage->stop();
    CHECK(s.stage->simulation().record().device_N.allFinite());
    CHECK(s.stage->counts().faults() == 0);
    CHECK(refusal<FileError>([&] { Stage({s.folder.file("none.h5")}, {}); }).find("none.h5") != std::string::npos);
    StageOptions wrong;
    wrong.haptic.sets = "best";
    CHECK(refusal<MismatchError>([&] { Stage({s.folder.file("a.h5")}, wrong); }).find("a.h5: spring sets 'best'") != std::string::npos);
}

TEST_CASE("two clients lead one tool each and a state has the numbers of both tools", "[serve][two]") {
    const bool solid = GENERATE(false, true);
    const TemporaryFolder folder;
    const std::string file = folder.file("law.h5");
    write_model(file, solid ? solid_example() : energy_model_example(), {"test", 1, {}});
    StageOptions options;
    options.realtime = false;
    options.haptic.tools = 2;
    options.haptic.heuristic_mesh = false;
    Stage stage({file}, options);
    std::map<int, Json> control, model;
    Show show(stage, [&](int client, const std::string& text) {
        const Json j = Json::parse(text);
        if (j["type"] == "control") control[client] = j;
        if (j["type"] == "model") model[client] = j;
    });
    const Point low = stage.model().low_m, high = stage.model().high_m;
    const auto at = [&](double share, double deep_m) {
        Point p = (low + high) / 2;
        p[0] = low[0] + share * (high - low)[0];
        p[p.size() - 1] = high[p.size() - 1] - deep_m;
        return p;
    };
    double now_s = 100;
    const auto point = [&](int client, int tool, const Point& p, bool down) {
        Json said = {{"type", "pointer"}, {"x", p[0]}, {"y", p[1]}, {"down", down}, {"tool", tool}};
        if (solid) said["z"] = p[2];
        return show.hear(client, said.dump(), now_s);
    };
    show.join(1);
    show.join(2);
    CHECK(model[1]["tools"] == 2);
    CHECK(control[1]["holders"] == Json({"demo", "nobody"}));
    const Point left = at(0.3, 0.004), right = at(0.7, 0.004);
    CHECK_FALSE(point(2, 1, right, true));  // ends the demo of the first tool
    CHECK(control[2]["holders"] == Json({"nobody", "you"}));
    CHECK((control[2]["holder"] == "you" && control[1]["holder"] == "other"));
    CHECK_FALSE(point(1, 1, left, true));  // the other client holds it
    CHECK(control[1]["holders"] == Json({"nobody", "other"}));
    CHECK_FALSE(point(1, 0, left, true));
    CHECK(control[1]["holders"] == Json({"you", "other"}));
    CHECK(point(1, 2, left, true)->reason == "no such tool");
    CHECK_FALSE(show.hear(2, R"({"type":"pause","on":true})", now_s));
    CHECK_FALSE(show.paused());

    stage.start(nullptr);
    const std::size_t own = solid ? 40 : 32;
    const auto wait = [&](const auto& wanted) {
        return wait_for([&] {
            now_s += 0.002;
            point(1, 0, left, true);
            if (control[2]["holders"][1] == "you") point(2, 1, right, true);
            show.step(now_s);
            return !show.frame().head.empty() && wanted(show.frame().head);
        });
    };
    CHECK(wait([&](const auto& head) { return head[13] == 0 && head[own] == 0 && std::abs(head[solid ? 36 : 19]) > 1e-3; }));
    const double come_m = 2e-3;
    CHECK(wait([&](const auto& head) { return std::abs(head[9] - left[0]) < come_m && std::abs(head[own + 2] - right[0]) < come_m; }));
    const std::vector<double> head = show.frame().head;
    CHECK(head.size() == own + (solid ? 20 : 14));
    CHECK(head[own + 1] == 0);
    const auto vector = [&](std::size_t k) {
        Point p(solid ? 3 : 2);
        p[0] = head[own + k], p[1] = head[own + k + 1];
        if (solid) p[2] = head[own + 14 + (k - 2) / 2];
        return p;
    };
    CHECK(vector(8)[low.size() - 1] < 0);  // the force on the tissue points down
    CHECK((vector(8) + vector(10)).norm() < 1e-6);
    CHECK(vector(6)[low.size() - 1] < 0);
    CHECK((vector(4) - vector(2)).norm() < 0.01);
    const double beside_m = 5e-3;  // largest lateral distance of the contact at rest from the tool
    CHECK((vector(12) - vector(2)).head(low.size() - 1).norm() < beside_m);
    CHECK_FALSE(point(2, 1, right, false));
    CHECK(control[1]["holders"] == Json({"you", "nobody"}));
    CHECK(wait([&](const auto& now) { return now[own] == -1 && now[13] == 0; }));
    stage.stop();
    CHECK(stage.counts().faults() == 0);
    CHECK(stage.counts().clamped == stage.simulation().safety(0).counters().clamped + stage.simulation().safety(1).counters().clamped);
    // after a change to a model of the other dimension the pointers of both tools have that dimension
    const std::string other = folder.file("other.h5");
    write_model(other, solid ? energy_model_example() : solid_example(), {"test", 1, {}});
    Stage pair({file, other}, options);
    Show turned(pair, [](int, const std::string&) {});
    turned.join(1);
    turned.step(100);
    CHECK_FALSE(turned.hear(1, R"({"type":"model","model":1})", 101));
    CHECK(pair.index() == 1);
    for (double time_s = 101; time_s < 102; time_s += 0.016) turned.step(time_s);
    for (int tool : {0, 1}) CHECK(pair.simulation().options(tool).map.to_tissue(pair.pointer(tool).read(1).position_m).size() == (solid ? 2 : 3));
    pair.stop();
    options.hidden = file;
    CHECK(refusal<MismatchError>([&] { Stage({file}, options); }).find("--tools") == 0);
}

TEST_CASE("an option of spring sets is accepted if one model has sets and refused for energy models alone", "[serve]") {
    const TemporaryFolder folder;
    write_model(folder.file("law.h5"), energy_model_example(), {"test", 1, {}});
    write_model(folder.file("sets.h5"), haptic_example(), {"test", 1, {}});
    StageOptions options;
    options.haptic.innovation = 0.1;
    CHECK_NOTHROW(Stage({folder.file("sets.h5"), folder.file("law.h5")}, options));
    CHECK(refusal<MismatchError>([&] { Stage({folder.file("law.h5")}, options); }).find("law.h5: innovation") != std::string::npos);
}

TEST_CASE("a model that adapts sends the results of its measurements; a client that joins later gets the newest", "[serve][adapt][long]") {
    const TemporaryFolder folder;
    TissueModel hidden = energy_model_example();
    for (double& constant : hidden.energy_model->constants) constant *= 1.5;
    hidden.energy_model->patch.log_N_m.array() += std::log(1.5);
    write_model(folder.file("law.h5"), energy_model_example(), {"test", 1, {}});
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
    const bool learned = wait_for([&] {
        show.step(100 + seconds());
        return heard[1].size() >= 3;
    });
    stage.stop();
    REQUIRE(learned);
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
