#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "../../cli/serve/show.h"
#include "../example.h"
#include "../haptic/haptic_example.h"
#include "../wait_for.h"

using namespace tissue;
using namespace tissue::serve;
using Json = nlohmann::json;

namespace {

/// A frame in space with two meshes of `nodes` nodes each, at random positions in a cube of 0.1 m.
Frame some_frame(Draw& draw, int nodes) {
    Frame frame;
    frame.dimension = 3;
    frame.head.assign(40, 0);
    frame.nodes_m.assign(2, std::vector<float>(static_cast<std::size_t>(3 * nodes)));
    for (auto& mesh : frame.nodes_m)
        for (float& x : mesh) x = static_cast<float>(draw(0, 0.1));
    return frame;
}

/// Decodes frames as cli/view/state.js does, and counts the nodes in each.
struct Reader {
    std::vector<std::vector<float>> nodes;
    std::vector<std::size_t> carried;
    void read(const std::string& bytes) {
        double head[40];
        REQUIRE(bytes.size() >= sizeof head);
        std::memcpy(head, bytes.data(), sizeof head);
        carried = {static_cast<std::size_t>(head[38]), static_cast<std::size_t>(head[39])};
        std::size_t at = sizeof head;
        for (std::size_t m = 0; m < 2; ++m) {
            REQUIRE(bytes.size() >= at + 16 * carried[m]);
            for (std::size_t k = 0; k < carried[m]; ++k) {
                std::uint32_t node;
                std::memcpy(&node, bytes.data() + at + 4 * k, 4);
                if (nodes[m].size() < 3 * (node + 1)) nodes[m].resize(3 * (node + 1));
                std::memcpy(&nodes[m][3 * node], bytes.data() + at + 4 * carried[m] + 12 * k, 12);
            }
            at += 16 * carried[m];
        }
        CHECK(bytes.size() == at);
    }
    Reader() : nodes(2) {}
};

const std::vector<Hand::Box> two_boxes = {{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.1, 0.08, 0.05)},
                                          {Eigen::Vector3d(0.15, 0, 0), Eigen::Vector3d(0.25, 0.08, 0.05)}};

bool in_boxes(const Point& p, double margin) {
    for (const auto& [low, high] : two_boxes)
        if ((p.array() > low.array() - margin).all() && (p.array() < high.array() + margin).all()) return true;
    return false;
}

/// The solid example with FE forces, 100 N per metre of tool displacement, and FE displacements at every load case.
struct Solid {
    TissueModel tissue;
    std::vector<NodeField> fe_m;
    std::unique_ptr<HapticModel> model;
    std::unique_ptr<Scene> scene;
    Solid() : tissue(solid_example()) {
        tissue.contact_force_N = 100 * tissue.magnitude_m.asDiagonal() * tissue.direction;
        for (int c = 0; c < tissue.case_count(); ++c) fe_m.push_back(scattered(tissue.mesh, 1e-3 * (c + 1)));
        model = std::make_unique<HapticModel>(tissue, HapticOptions{});
        scene = std::make_unique<Scene>(tissue, *model, fe_m);
    }
};

}  // namespace

TEST_CASE("in space the first state has every node and later states only nodes that moved by more than 1 um", "[serve]") {
    Draw draw(15);
    Frame frame = some_frame(draw, 400);
    FrameCoder coder;
    Reader page;
    page.read(coder.encode(frame));
    CHECK(page.carried == std::vector<std::size_t>{400, 400});
    CHECK(page.nodes == frame.nodes_m);
    page.read(coder.encode(frame));
    CHECK(page.carried == std::vector<std::size_t>{0, 0});

    frame.nodes_m[0][3 * 7] = 0.05F;
    page.read(coder.encode(frame));
    page.nodes[0][3 * 7] = 0;
    frame.nodes_m[0][3 * 7] += 0.9e-6F;
    page.read(coder.encode(frame));
    CHECK(page.carried == std::vector<std::size_t>{0, 0});
    frame.nodes_m[0][3 * 7] += 0.9e-6F;   // in total more than 1 um from its position on the page
    frame.nodes_m[1][3 * 9 + 2] = std::numeric_limits<float>::quiet_NaN();
    page.read(coder.encode(frame));
    CHECK(page.carried == std::vector<std::size_t>{1, 1});
    CHECK(page.nodes[0][3 * 7] == frame.nodes_m[0][3 * 7]);
    CHECK(std::isnan(page.nodes[1][3 * 9 + 2]));

    coder.forget();
    page.read(coder.encode(frame));
    CHECK(page.carried == std::vector<std::size_t>{400, 400});
    const Frame other = some_frame(draw, 300);   // of another model, without a call of forget()
    Reader again;
    again.read(coder.encode(other));
    CHECK(again.nodes == other.nodes_m);
}

TEST_CASE("random motion and dropped states leave every node position on a page within 1 um", "[serve]") {
    Draw draw(16);
    Frame frame = some_frame(draw, 120);
    FrameCoder coders[2];
    Reader pages[2];
    std::size_t told = 0;
    for (int k = 0; k < 400; ++k) {
        for (auto& mesh : frame.nodes_m)
            for (float& x : mesh)
                if (draw.below(3) == 0) x += static_cast<float>(draw(-4e-7, 6e-7));
        for (int p = 0; p < 2; ++p) {
            if (p == 1 && k > 0 && draw.below(3) > 0) continue;   // this page misses states
            pages[p].read(coders[p].encode(frame));
            told += pages[p].carried[0];
            for (std::size_t m = 0; m < 2; ++m)
                for (std::size_t n = 0; n < frame.nodes_m[m].size(); n += 3) {
                    double off = 0;
                    for (std::size_t a = 0; a < 3; ++a) off += std::pow(static_cast<double>(frame.nodes_m[m][n + a]) - pages[p].nodes[m][n + a], 2);
                    REQUIRE(std::sqrt(off) < 1.02e-6);
                }
        }
    }
    CHECK(told > 240);
    CHECK(told < 120 * 200);   // far fewer than all nodes in each state
}

TEST_CASE("in the plane every state has every node", "[serve]") {
    Frame frame;
    frame.head.assign(32, 1.5);
    frame.nodes_m = {{1, 2, 3, 4}, {5, 6, 7, 8}};
    FrameCoder coder;
    const std::string first = coder.encode(frame);
    CHECK(first.size() == 32 * 8 + 8 * 4);
    CHECK(coder.encode(frame) == first);
    float last;
    std::memcpy(&last, first.data() + first.size() - 4, 4);
    CHECK(last == 8);
}

TEST_CASE("in space the path between two points outside the tissue goes over or beside it but never below", "[serve]") {
    Draw draw(5);
    const auto somewhere = [&] { return outside(two_boxes, Eigen::Vector3d(draw(-0.1, 0.35), draw(-0.1, 0.18), draw(0, 0.15)), 0.01); };
    for (int k = 0; k < 300; ++k) {
        const Point from = somewhere(), to = somewhere();
        REQUIRE_FALSE(in_boxes(from, 0.0099));
        REQUIRE(from[2] >= 0);
        Point at = from;
        for (const Point& p : way_round(two_boxes, from, to, 0.01)) {
            for (int i = 0; i <= 50; ++i) {
                const Point on_way = at + (p - at) * i / 50;
                REQUIRE_FALSE(in_boxes(on_way, 0.0088));
                REQUIRE(on_way[2] >= 0);
            }
            at = p;
        }
        CHECK(at == to);
    }
    const Point low = outside(two_boxes, Eigen::Vector3d(0.05, 0.04, 0.001), 0.01);   // nearest to the fixed side
    CHECK(low[2] > 0);
    CHECK_FALSE(in_boxes(low, 0.0099));
}

TEST_CASE("the near message of a solid has three displacement components per node", "[serve]") {
    NodeField u(2, 3);
    u << 0.00123456789, -0.002, 1e-9, 0, 0, -0.005;
    CHECK(Json::parse(near_message(0, 0, {{0.01, u}}))["outline"] == Json::parse("[[0.01, [[0.0012346, -0.002, 0.0], [0.0, 0.0, -0.005]]]]"));
}

TEST_CASE("the model message of a solid has only its surface nodes with their facets and places with their normals", "[serve]") {
    const Solid s;
    const SpringMesh& mesh = s.tissue.mesh;
    REQUIRE(s.scene->shown().size() == 75 - 9);   // 5 x 5 x 3 nodes, of which 3 x 3 x 1 lie inside
    const Json j = Json::parse(s.scene->message({"solid"}, 0));
    CHECK((j["dimension"] == 3 && j["node_count"] == mesh.node_count() && j["spring_count"] == mesh.spring_count() && j["tool"] == Json::array({{{"shape", "disc"}, {"radius_m", 0.012}}})));
    const Json& learned = j["meshes"][0];
    CHECK((learned.count("springs") == 0 && learned["nodes_m"].size() == 66 && learned["fixed"].size() == 25));
    REQUIRE(learned["facets"].size() == static_cast<std::size_t>(mesh.facets.rows()));
    double volume = 0;   // divergence theorem for x / 3 over facets with outward normals
    for (const Json& facet : learned["facets"]) {
        Eigen::Vector3d corner[3];
        for (std::size_t k = 0; k < 3; ++k)
            for (int a = 0; a < 3; ++a) corner[k][a] = learned["nodes_m"][facet[k].get<std::size_t>()][static_cast<std::size_t>(a)];
        volume += corner[0].dot(corner[1].cross(corner[2])) / 6;
    }
    CHECK(volume == Approx(0.1 * 0.1 * 0.05));
    for (const Json& k : learned["fixed"]) CHECK(learned["nodes_m"][k.get<std::size_t>()][2] == 0.0);
    REQUIRE(j["places"].size() == 2);
    CHECK(j["places"][1]["inward"] == Json::parse("[-0.0, -0.0, -1.0]"));
    CHECK(j["places"][1]["curve"].size() == 2);
    CHECK(j["demo"] == 0);
    const FeOutline& deep = s.scene->places()[1].outlines.back();
    REQUIRE(deep.displacement_m.rows() == 66);
    for (std::size_t k = 0; k < 66; ++k)
        CHECK(deep.displacement_m.row(static_cast<Eigen::Index>(k)) == s.fe_m[1].row(s.scene->shown()[k]));
}

TEST_CASE("a carried surface is encoded as vertex positions and facets and the nodes and weights of each vertex", "[serve]") {
    Solid s;
    CHECK((s.scene->carried().empty() && !Json::parse(s.scene->message({"solid"}, 0)).contains("surface")));
    CarriedSurface surface = own_surface(s.tissue.mesh);
    surface.node.row(3) = s.tissue.mesh.facets.row(7);
    surface.weight.row(3) << 0.5, 0.25, 0.25;
    s.scene->carry(surface);
    const Json j = Json::parse(s.scene->message({"solid"}, 0));
    CHECK(j["surface"] == true);
    const std::string& bytes = s.scene->carried();
    const std::size_t V = 66, F = static_cast<std::size_t>(surface.facets.rows());
    REQUIRE(bytes.size() == 8 + 12 * (3 * V + F));
    const auto word = [&](std::size_t at) { std::uint32_t x = 0; std::memcpy(&x, bytes.data() + 4 * at, 4); return static_cast<std::size_t>(x); };
    const auto real = [&](std::size_t at) { float x = 0; std::memcpy(&x, bytes.data() + 4 * at, 4); return x; };
    CHECK((word(0) == V && word(1) == F));
    const std::size_t rest = 2, facets = rest + 3 * V, node = facets + 3 * F, weight = node + 3 * V;
    const Json& learned = j["meshes"][0];
    for (std::size_t v = 0; v < V; ++v)
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(real(rest + 3 * v + k) == static_cast<float>(learned["nodes_m"][v][k].get<double>()));
            CHECK(word(node + 3 * v + k) == (v == 3 ? learned["facets"][7][k].get<std::size_t>() : v));
            CHECK(real(weight + 3 * v + k) == (v == 3 ? (k == 0 ? 0.5F : 0.25F) : k == 0 ? 1.0F : 0.0F));
        }
    for (std::size_t f = 0; f < F; ++f)
        for (std::size_t k = 0; k < 3; ++k) CHECK(word(facets + 3 * f + k) == learned["facets"][f][k].get<std::size_t>());
}

TEST_CASE("the model message has the nodule in the trained mesh and the inner nodes that carry it", "[serve]") {
    Solid s;
    CHECK_FALSE(Json::parse(s.scene->message({"solid"}, 0)).contains("nodule"));
    s.tissue.nodule = nodule_surface(Inclusion(Eigen::Vector3d(0.052, 0.05, 0.026), 0.01));
    const Scene scene(s.tissue, *s.model, s.fe_m);
    CHECK((scene.shown().size() > 66 && std::is_sorted(scene.shown().begin(), scene.shown().end())));
    const Json j = Json::parse(scene.message({"solid"}, 0)), &nodule = j["nodule"], &nodes = j["meshes"][0]["nodes_m"];
    REQUIRE((nodule["points_m"].size() == 162 && nodule["facets"].size() == 320 && nodule["nodes"].size() == 162));
    CHECK(nodes.size() == scene.shown().size());
    for (std::size_t v = 0; v < 162; ++v)   // each point is the weighted mean of its four nodes
        for (std::size_t a = 0; a < 3; ++a) {
            double at = 0;
            for (std::size_t k = 0; k < 4; ++k) at += nodule["weights"][v][k].get<double>() * nodes[nodule["nodes"][v][k].get<std::size_t>()][a].get<double>();
            CHECK(at == Approx(nodule["points_m"][v][a].get<double>()).margin(1e-12));
            CHECK(at == Approx(s.tissue.nodule.points(static_cast<Eigen::Index>(v), static_cast<Eigen::Index>(a)) + s.model->meshes[0]->place_m[static_cast<Eigen::Index>(a)]).margin(1e-12));
        }
    CHECK(scene.places()[0].outlines.back().displacement_m.rows() == static_cast<Eigen::Index>(nodes.size()));
}

TEST_CASE("a state in space has three components of every vector and the surface nodes of each mesh", "[serve]") {
    const Solid s;
    Simulation simulation(*s.model);
    StateChannel channel(*s.model, 1);
    channel.after(simulation, {});
    REQUIRE(channel.fetch());
    TickState state = channel.state();
    state.record.mesh = 0;
    state.record.facet = 0;
    state.record.weight = {0.2, 0.3, 0.5};
    state.record.master_m = Eigen::Vector3d(1, 2, 3);
    state.proxy_m = Eigen::Vector3d(4, 5, 6);
    state.record.coupling_N = Eigen::Vector3d(-7, -8, -9);
    state.record.device_N = {10, 11, 12};
    state.contact_displacement_m[0] = Eigen::Vector3d(0.1, 0.2, 0.3);
    if (state.contact_displacement_m.size() > 1) state.contact_displacement_m[1] = Eigen::Vector3d(0.4, 0.5, 0.6);
    const Frame frame = make_frame(state, *s.scene, s.scene->near(state), {});
    const std::vector<double>& h = frame.head;
    REQUIRE(h.size() == 40);
    const auto at = [&](std::size_t xy, std::size_t z) { return std::vector<double>{h[xy], h[xy + 1], h[z]}; };
    CHECK(at(9, 32) == std::vector<double>{1, 2, 3});
    CHECK(at(11, 33) == std::vector<double>{4, 5, 6});
    CHECK(at(14, 34) == std::vector<double>{0.1, 0.2, 0.3});
    if (state.contact_displacement_m.size() > 1) CHECK(at(16, 35) == std::vector<double>{0.4, 0.5, 0.6});
    CHECK(at(18, 36) == std::vector<double>{7, 8, 9});
    CHECK(at(20, 37) == std::vector<double>{10, 11, 12});
    const Point contact = s.model->meshes[0]->springs.rest_place(0, state.record.weight);
    CHECK(at(29, 31) == std::vector<double>(contact.begin(), contact.end()));
    state.record.mesh = -1;
    const std::vector<double> untouched = make_frame(state, *s.scene, s.scene->near(state), {}).head;
    CHECK((untouched[29] == 0 && untouched[30] == 0 && untouched[31] == 0));
    REQUIRE(frame.nodes_m.size() == s.model->meshes.size());
    for (std::size_t m = 0; m < frame.nodes_m.size(); ++m) {
        const Point& place = s.model->meshes[m]->place_m;
        REQUIRE(frame.nodes_m[m].size() == 3 * 66);
        for (std::size_t k = 0; k < 66; ++k)
            for (int a = 0; a < 3; ++a)
                CHECK(frame.nodes_m[m][3 * k + static_cast<std::size_t>(a)] ==
                      Approx(place[a] + s.tissue.mesh.nodes(s.scene->shown()[k], a)).margin(1e-8));
    }
}

TEST_CASE("in space the hand approaches along the surface normal and follows the client and leaves to the outside", "[serve]") {
    const Solid s;
    Draw draw(6);
    for (int k = 0; k < 60; ++k) {
        Hand hand(*s.scene);
        const bool side = k % 2 == 1;   // the top, or the side at x = 0
        const Eigen::Vector3d contact = side ? Eigen::Vector3d(0, draw(0.01, 0.09), draw(0.01, 0.04)) : Eigen::Vector3d(draw(0.01, 0.09), draw(0.01, 0.09), 0.05),
                              inward = side ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(0, 0, -1);
        double depth = 0;
        bool touched = false;
        for (int t = 0; t < 400; ++t) {
            hand.follow(contact + depth * inward);
            const Point at = hand.step(0.016);
            const double in = (at - contact).dot(inward);
            const double aside = ((at - contact) - in * inward).norm();
            if (at[0] > -0.0088 && at[0] < 0.1088 && at[1] > -0.0088 && at[1] < 0.1088 && at[2] < 0.0588) REQUIRE(aside < 1e-9);
            if (std::abs(in) > 0.001 && !touched) continue;
            touched |= aside < 1e-9;
            if (touched) depth = std::min(0.006, depth + 0.0005);
        }
        REQUIRE(touched);
        CHECK((hand.at() - (contact + 0.006 * inward)).norm() < 1e-12);
        hand.follow(contact + 0.004 * inward + Eigen::Vector3d(0, 0.001, 0));   // the hand now follows directly
        CHECK((hand.step(0.016) - (contact + 0.004 * inward + Eigen::Vector3d(0, 0.001, 0))).norm() < 1e-12);
        hand.let_go();
        for (int t = 0; t < 100; ++t) hand.step(0.016);
        CHECK((hand.at() - contact).dot(inward) < -0.0099);
        hand.follow(Eigen::Vector3d(0.3, -0.2, -1e300));   // never below the support
        for (int t = 0; t < 1000; ++t) REQUIRE(hand.step(0.016)[2] >= 0);
    }
    Hand hand(*s.scene);   // the demo indents a place to the depth of its load case, in its direction
    hand.demonstrate(1);
    double deepest = 0;
    const Place& place = s.scene->places()[1];
    for (int t = 0; t < 600; ++t) deepest = std::max(deepest, (hand.step(0.016) - place.contact_m).dot(place.direction));
    CHECK(deepest == Approx(0.005).margin(0.0004));
}

TEST_CASE("in space a pointer without z is refused and one with z holds the tissue", "[serve]") {
    const TemporaryFolder folder;
    write_model(folder.file("solid.h5"), Solid().tissue, {"test", 1, {}});
    write_model(folder.file("plane.h5"), haptic_example(), {"test", 1, {}});
    Stage stage({folder.file("solid.h5"), folder.file("plane.h5")}, {{}, false});
    std::string heard;
    Show show(stage, [&](int, const std::string& text) { heard = text; });
    show.join(1);
    const auto refused = show.hear(1, R"({"type":"pointer","x":0.05,"y":0.05,"down":true})", 10);
    REQUIRE(refused);
    CHECK(refused->reason == "'z' is missing: this model is in space");
    CHECK_FALSE(show.hear(1, R"({"type":"pointer","x":0.05,"y":0.05,"z":0.05,"down":true})", 10));
    CHECK(Json::parse(heard)["holder"] == "you");
    stage.start(nullptr);
    CHECK_FALSE(show.hear(1, R"({"type":"model","model":1})", 11));   // pointer and ticks are in the plane from here on
    CHECK_FALSE(show.hear(1, R"({"type":"pointer","x":0.05,"y":0.05,"down":true})", 14));
    CHECK(wait_for([&, now = 14.0]() mutable { return show.step(now += 0.016) && show.frame().dimension == 2; }));
    CHECK_FALSE(show.hear(1, R"({"type":"model","model":0})", 15));
    CHECK(wait_for([&, now = 15.0]() mutable { return show.step(now += 0.016) && show.frame().dimension == 3; }));
    stage.stop();
    CHECK(stage.counts().faults() == 0);
}
