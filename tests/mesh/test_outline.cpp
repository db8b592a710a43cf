#include "mesh/outline.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "error.h"
#include "../tolerances.h"

using namespace tissue;

namespace {

const double pi = std::acos(-1.0);

Outline block() {
    return Outline(make_lattice("grid4", 4, 3, 0.2, 0.1));
}

}  // namespace

TEST_CASE("the outline of a block runs over its sides and top from bottom right to bottom left") {
    CHECK(block().length() == Approx(0.1 + 0.2 + 0.1).epsilon(tolerance::rounding));
    const auto near = [](const Eigen::Vector2d& a, double x, double y) { return (a - Eigen::Vector2d(x, y)).norm() < 1e-14; };
    CHECK(near(block().position(0), 0.2, 0));
    CHECK(near(block().position(0.05), 0.2, 0.05));
    CHECK(near(block().position(0.1), 0.2, 0.1));
    CHECK(near(block().position(0.25), 0.05, 0.1));
    CHECK(near(block().position(0.4), 0, 0));
    CHECK(near(block().position(-1), 0.2, 0));
    CHECK(near(block().position(9), 0, 0));
}

TEST_CASE("the corners of a block of one cell are all of its free nodes") {
    const SpringMesh mesh = make_lattice("grid8", 1, 1, 0.1, 0.1);
    CHECK(Outline(mesh).corners() == std::vector<double>{0.1, 0.2});
}

TEST_CASE("arc_of is the inverse of position along the outline") {
    for (double arc = 0; arc <= 0.4; arc += 0.013)
        CHECK(block().arc_of(block().position(arc)) == Approx(arc).margin(tolerance::rounding));
}

TEST_CASE("the inward normal points into the tissue; at a corner it bisects both sides' normals") {
    CHECK((block().inward_normal(0.05) - Eigen::Vector2d(-1, 0)).norm() < tolerance::rounding);
    CHECK((block().inward_normal(0.2) - Eigen::Vector2d(0, -1)).norm() < tolerance::rounding);
    CHECK((block().inward_normal(0.37) - Eigen::Vector2d(1, 0)).norm() < tolerance::rounding);
    const Eigen::Vector2d corner = block().inward_normal(0.1);
    CHECK((corner - Eigen::Vector2d(-1, -1) / std::sqrt(2)).norm() < tolerance::rounding);
}

TEST_CASE("angle is the inverse of direction; angles are counter-clockwise from the inward normal") {
    for (double arc : {0.03, 0.1, 0.22})
        for (double angle : {-1.2, 0.0, 0.3}) {
            const Eigen::Vector2d push = block().direction(arc, angle);
            CHECK(push.norm() == Approx(1).epsilon(tolerance::rounding));
            CHECK(block().angle(arc, push) == Approx(angle).margin(tolerance::rounding));
        }
    CHECK((block().direction(0.2, pi / 2) - Eigen::Vector2d(1, 0)).norm() < tolerance::rounding);
}

TEST_CASE("an outline is refused for a mesh without a free surface or with two") {
    SpringMesh mesh = make_lattice("grid4", 4, 3, 0.2, 0.1);
    SpringMesh held = mesh;
    held.fixed.clear();
    for (int i = 0; i < held.node_count(); ++i) held.fixed.push_back(i);
    CHECK_THROWS_AS(Outline(held), MismatchError);
    for (int i = mesh.node_count() - 5; i < mesh.node_count(); ++i) mesh.fixed.push_back(i);  // the top as well
    CHECK_THROWS_AS(Outline(mesh), MismatchError);
}
