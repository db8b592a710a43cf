#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "../../cli/serve/frame.h"
#include "../../cli/serve/hand.h"
#include "../../cli/serve/messages.h"
#include "../haptic/haptic_example.h"

using namespace tissue;
using namespace tissue::serve;
using Json = nlohmann::json;

namespace {

/// A state in space of two meshes of so many nodes, all of them somewhere in a cube of 0.1 m.
Frame some_frame(Draw& draw, int nodes) {
    Frame frame;
    frame.dimension = 3;
    frame.head.assign(40, 0);
    frame.nodes_m.assign(2, std::vector<float>(static_cast<std::size_t>(3 * nodes)));
    for (auto& mesh : frame.nodes_m)
        for (float& x : mesh) x = static_cast<float>(draw(0, 0.1));
    return frame;
}

/// What a page makes of frames, as cli/view/state.js does; counts how many nodes each carried.
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

}  // namespace

TEST_CASE("in space a page's first state has every node, and each after it those that moved by more than 1 um", "[serve]") {
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
    frame.nodes_m[0][3 * 7] += 0.9e-6F;   // together more than 1 um from where the page has it
    frame.nodes_m[1][3 * 9 + 2] = std::numeric_limits<float>::quiet_NaN();
    page.read(coder.encode(frame));
    CHECK(page.carried == std::vector<std::size_t>{1, 1});
    CHECK(page.nodes[0][3 * 7] == frame.nodes_m[0][3 * 7]);
    CHECK(std::isnan(page.nodes[1][3 * 9 + 2]));

    coder.forget();
    page.read(coder.encode(frame));
    CHECK(page.carried == std::vector<std::size_t>{400, 400});
    const Frame other = some_frame(draw, 300);   // of another model, should anybody forget to say so
    Reader again;
    again.read(coder.encode(other));
    CHECK(again.nodes == other.nodes_m);
}

TEST_CASE("however nodes wander and whichever states are left out, a page has none of them wrong by more than 1 um", "[serve]") {
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
            if (p == 1 && k > 0 && draw.below(3) > 0) continue;   // this one is slow
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
    CHECK(told < 120 * 200);   // far from all of them each time
}

TEST_CASE("in the plane every state has every node, for whoever reads it", "[serve]") {
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

TEST_CASE("in space the way from place to place goes over the tissue or beside it, never under it", "[serve]") {
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
    const Point low = outside(two_boxes, Eigen::Vector3d(0.05, 0.04, 0.001), 0.01);   // nearest to the held side
    CHECK(low[2] > 0);
    CHECK_FALSE(in_boxes(low, 0.0099));
}

TEST_CASE("FE's displacement in space is told with three numbers a node", "[serve]") {
    NodeField u(2, 3);
    u << 0.00123456789, -0.002, 1e-9, 0, 0, -0.005;
    CHECK(Json::parse(near_message(0, 0, {{0.01, u}}))["outline"] == Json::parse("[[0.01, [[0.0012346, -0.002, 0.0], [0.0, 0.0, -0.005]]]]"));
}
