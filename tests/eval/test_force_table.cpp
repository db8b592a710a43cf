#include "eval/force_table.h"

#include <catch2/catch.hpp>

#include "../tolerances.h"

using namespace tissue;

namespace {

/// Forces that are linear in arc length, angle and depth, at three places on the top, three angles each, two depths
/// each.
struct Example {
    SpringMesh mesh = make_lattice("grid8", 10, 10, 0.1, 0.1);
    Outline outline{mesh};
    std::vector<double> arcs = {0.15, 0.16, 0.18}, angles = {-0.4, 0.0, 0.3}, depths = {0.004, 0.01};
    std::vector<LoadPath> paths;
    std::vector<LoadCase> loads;

    static Eigen::Vector2d force(double arc, double angle, double depth) {
        return {1 + 20 * arc + 3 * angle + 500 * depth, 2 - 10 * arc + angle - 100 * depth};
    }
    Example() {
        for (double arc : arcs)
            for (double angle : angles) {
                LoadPath path;
                path.contact_m = outline.position(arc);
                path.direction = outline.direction(arc, angle);
                for (double depth : depths) {
                    path.records.push_back({depth, {}, {}, force(arc, angle, depth), Eigen::Vector2d(0, 0), 0, 1, 1, 0});
                }
                paths.push_back(path);
            }
        for (const LoadPath& path : paths)
            for (const PathRecord& record : path.records) loads.push_back({"", &path, &record});
        std::swap(loads.front(), loads[7]);  // in any order
    }
    Eigen::Vector2d push(double arc, double angle) const { return outline.direction(arc, angle); }
};

}  // namespace

TEST_CASE("a force table has the FE forces at solved places and is linear between them") {
    const Example e;
    const ForceTable table(e.outline, table_pushes(e.loads));
    for (double arc : {0.15, 0.152, 0.16, 0.171, 0.18})
        for (double angle : {-0.4, -0.35, -0.1, 0.22, 0.3})
            for (double depth : {0.004, 0.0045, 0.0093, 0.01}) {
                const ForceTable::Entry entry = table.at(arc, e.push(arc, angle), depth);
                CHECK_FALSE(entry.extrapolated);
                CHECK((entry.force_N - Example::force(arc, angle, depth)).norm() < tolerance::solve);
            }
}

TEST_CASE("below the smallest depth the force of a table is proportional to depth without extrapolation") {
    const Example e;
    const ForceTable::Entry entry = ForceTable(e.outline, table_pushes(e.loads)).at(0.16, e.push(0.16, 0.0), 0.001);
    CHECK_FALSE(entry.extrapolated);
    CHECK((entry.force_N - 0.25 * Example::force(0.16, 0, 0.004)).norm() < tolerance::solve);
}

TEST_CASE("outside the solved range a force table returns the nearest force and marks extrapolation") {
    const Example e;
    const ForceTable table(e.outline, table_pushes(e.loads));
    const auto nearest = [&](double arc, double angle, double depth, const Eigen::Vector2d& wanted) {
        const ForceTable::Entry entry = table.at(arc, e.push(arc, angle), depth);
        CHECK(entry.extrapolated);
        CHECK((entry.force_N - wanted).norm() < tolerance::solve);
    };
    nearest(0.14, 0, 0.004, Example::force(0.15, 0, 0.004));
    nearest(0.15, 1.2, 0.004, Example::force(0.15, 0.3, 0.004));
    nearest(0.15, -1.2, 0.004, Example::force(0.15, -0.4, 0.004));
    nearest(0.15, 0, 0.02, Example::force(0.15, 0, 0.01));
}

TEST_CASE("a plane force table adds mirror images except of indentations that mirror themselves") {
    TissueModel block;
    Example e;
    block.mesh = e.mesh;
    const std::vector<TablePush> both = table_pushes(e.loads, symmetries_of(block));
    CHECK(e.loads.size() == 18);
    CHECK(both.size() == 36 - 2);  // the normal indentation in the middle of the top is its own image, at both depths
    const ForceTable table(e.outline, both);
    const Eigen::Vector2d there = Example::force(0.18, 0.3, 0.01);
    const ForceTable::Entry image = table.at(e.outline.length() - 0.18 - 0, e.push(e.outline.length() - 0.18, -0.3), 0.01);
    CHECK_FALSE(image.extrapolated);
    CHECK((image.force_N - Eigen::Vector2d(-there.x(), there.y())).norm() < tolerance::solve);
}
