#include "springs/set_grid.h"

#include <catch2/catch.hpp>

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

}  // namespace

TEST_CASE("at a trained contact the nearest spring set is the one of that contact") {
    const SetGrid grid(example().model);
    for (int c = 0; c < 18; ++c) {
        const Eigen::Vector2d contact = example().model.contact_m.row(c), push = example().model.direction.row(c);
        const double arc = grid.outline().arc_of(contact);
        CHECK(grid.nearest(arc, push, example().model.magnitude_m[c]) == c);
    }
}

TEST_CASE("the nearest spring set is chosen by arc length first; then by angle; then by depth") {
    const SetGrid grid(example().model);
    const auto nearest = [&](double arc, double angle, double depth) {
        return grid.nearest(arc, grid.outline().direction(arc, angle), depth);
    };
    CHECK(nearest(0.162, 0.2, 0.009) == 1 * 6 + 2 * 2 + 1);   // 0.16, 0.3, 10 mm
    CHECK(nearest(0.154, -0.3, 0.005) == 0 * 6 + 0 * 2 + 0);  // 0.15, -0.4, 4 mm
    CHECK(nearest(0.12, -0.1, 0.05) == 0 * 6 + 1 * 2 + 1);    // outside the range of all sets
}
