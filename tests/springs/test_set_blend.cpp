#include "springs/set_blend.h"

#include <catch2/catch.hpp>
#include <numeric>

#include "../example.h"
#include "../tolerances.h"

using namespace tissue;

namespace {

/// Sets at three positions on the top, three angles each, two depths each; set number = position * 6 + angle * 2 + depth.
struct Example {
    TissueModel model;
    std::vector<double> arc = {0.15, 0.16, 0.18}, angle = {-0.4, 0.0, 0.3}, depth = {0.004, 0.01};
};

const Example& example() {
    static const Example e = [] {
        Example x;
        x.model.mesh = make_lattice("grid8", 10, 10, 0.1, 0.1);
        const Outline outline(x.model.mesh);
        const Eigen::Index C = 18;
        x.model.contact_m.resize(C, 2);
        x.model.direction.resize(C, 2);
        x.model.magnitude_m.resize(C);
        Eigen::Index c = 0;
        for (double arc : x.arc)
            for (double angle : x.angle)
                for (double depth : x.depth) {
                    x.model.case_names.push_back("set" + std::to_string(c));
                    x.model.contact_m.row(c) = outline.position(arc);
                    x.model.direction.row(c) = outline.direction(arc, angle);
                    x.model.magnitude_m[c++] = depth;
                }
        return x;
    }();
    return e;
}

double total(const SetWeights& w) {
    return std::accumulate(w.weight.begin(), w.weight.begin() + w.count, 0.0);
}

/// The weighted mean of a number that each set has: what a blend makes of a field of them.
double mean(const SetWeights& w, const std::vector<double>& value) {
    double sum = 0;
    for (int i = 0; i < w.count; ++i)
        sum += w.weight[static_cast<std::size_t>(i)] * value[static_cast<std::size_t>(w.set[static_cast<std::size_t>(i)])];
    return sum;
}

}  // namespace

TEST_CASE("at a trained contact its own set serves alone") {
    const SetGrid grid(example().model);
    for (int c = 0; c < 18; ++c) {
        const Eigen::Vector2d contact = example().model.contact_m.row(c), push = example().model.direction.row(c);
        const double arc = grid.outline().arc_of(contact);
        for (const SetWeights& w : {grid.blended(arc, push, example().model.magnitude_m[c]),
                                    grid.nearest(arc, push, example().model.magnitude_m[c])}) {
            CHECK(total(w) == Approx(1).epsilon(tolerance::rounding));
            for (int i = 0; i < w.count; ++i)
                if (w.set[static_cast<std::size_t>(i)] != c)
                    CHECK(w.weight[static_cast<std::size_t>(i)] < 1e-6);  // arcs and angles come back rounded
        }
    }
}

TEST_CASE("weights are never negative, sum to one, and are linear in position, angle and depth") {
    const SetGrid grid(example().model);
    std::vector<double> arcs, angles, depths;
    for (double arc : example().arc)
        for (double angle : example().angle)
            for (double depth : example().depth) {
                arcs.push_back(arc);
                angles.push_back(angle);
                depths.push_back(depth);
            }
    for (double arc : {0.152, 0.16, 0.171})
        for (double angle : {-0.35, -0.1, 0.22})
            for (double depth : {0.0045, 0.0093}) {
                const SetWeights w = grid.blended(arc, grid.outline().direction(arc, angle), depth);
                CHECK_FALSE(w.extrapolated);
                CHECK(total(w) == Approx(1).epsilon(tolerance::rounding));
                for (int i = 0; i < w.count; ++i) CHECK(w.weight[static_cast<std::size_t>(i)] >= 0);
                CHECK(mean(w, arcs) == Approx(arc).epsilon(tolerance::solve));
                CHECK(mean(w, angles) == Approx(angle).epsilon(tolerance::solve));
                CHECK(mean(w, depths) == Approx(depth).epsilon(tolerance::solve));
            }
}

TEST_CASE("outside what was trained the nearest sets serve, and say so; above the smallest depth it serves") {
    const SetGrid grid(example().model);
    const auto push = [&](double arc, double angle) { return grid.outline().direction(arc, angle); };
    CHECK(grid.blended(0.1, push(0.1, 0), 0.005).extrapolated);
    CHECK(grid.blended(0.155, push(0.155, 1.2), 0.005).extrapolated);
    CHECK(grid.blended(0.155, push(0.155, 0), 0.02).extrapolated);
    const SetWeights shallow = grid.blended(0.15, push(0.15, 0.0), 0.001);
    for (int i = 0; i < shallow.count; ++i)
        if (shallow.weight[static_cast<std::size_t>(i)] > 1e-6)
            CHECK(example().model.magnitude_m[shallow.set[static_cast<std::size_t>(i)]] == 0.004);
}

TEST_CASE("the nearest set is one set") {
    const SetGrid grid(example().model);
    const SetWeights w = grid.nearest(0.162, grid.outline().direction(0.162, 0.2), 0.009);
    REQUIRE(w.count == 1);
    CHECK(w.weight[0] == 1);
    CHECK(w.set[0] == 1 * 6 + 2 * 2 + 1);  // 0.16, 0.3, 10 mm
}

TEST_CASE("a blend is the weighted mean of its sets, and of equal sets the set") {
    NodeField theta(2, 3);
    theta << 1, 2, 3, 5, 6, 7;
    SetWeights w;
    w.count = 2;
    w.set = {0, 1};
    w.weight = {0.25, 0.75};
    CHECK((blend(theta, w) - Eigen::Vector3d(4, 5, 6)).norm() < tolerance::rounding);
    theta.row(1) = theta.row(0);
    CHECK((blend(theta, w) - Eigen::Vector3d(1, 2, 3)).norm() < tolerance::rounding);
}
