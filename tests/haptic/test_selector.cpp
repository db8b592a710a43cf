#include <catch2/catch.hpp>
#include <cmath>

#include "../refusal.h"
#include "error.h"
#include "haptic/selector.h"
#include "haptic_example.h"
#include "springs/equilibrium.h"

using namespace tissue;

namespace {

Selector make(const TissueModel& model, SelectBy by = SelectBy::displacement) {
    return Selector(model, model.trained[0].theta, by);
}

/// Segment and weight of a place on the outline.
std::pair<int, double> place(const SpringMesh& mesh, const Eigen::Vector2d& x) {
    const SurfacePoint p = locate_on_surface(mesh, x);
    const std::vector<int> loop = mesh.loop();
    const auto b = std::find(loop.begin(), loop.end(), p.node[0]) - loop.begin();
    return {static_cast<int>(b), p.weight[1]};
}

}  // namespace

TEST_CASE("every load case selects its own spring set", "[selector]") {
    const TissueModel model = haptic_example();
    const Selector selector = make(model);
    for (int c = 0; c < model.case_count(); ++c) {
        const auto [segment, w] = place(model.mesh, model.contact_m.row(c));
        CHECK(selector.select(segment, w, model.magnitude_m[c] * model.direction.row(c)) == c);
    }
}

TEST_CASE("the nearest set is chosen by position before angle before magnitude", "[selector]") {
    const TissueModel model = haptic_example();
    const Selector selector = make(model);
    const auto [segment, w] = place(model.mesh, {0.02, 0.1});  // between the top-left corner and the middle of the top
    const int steep = selector.select(segment, w, {0.0001, -0.0112}), deep = selector.select(segment, w, {0.0101, -0.0099});
    CHECK(model.case_names[static_cast<std::size_t>(steep)] == "tl-down-10mm");
    CHECK(model.case_names[static_cast<std::size_t>(deep)] == "tl-diagonal-15mm");
}

TEST_CASE("any tool displacement or force anywhere selects an existing set", "[selector]") {
    const TissueModel model = haptic_example();
    Draw draw(3);
    for (auto by : {SelectBy::displacement, SelectBy::force}) {
        const Selector selector = make(model, by);
        const double size = by == SelectBy::force ? 0.005 : 0.02;
        for (int k = 0; k < 20000; ++k) {
            const int segment = draw.below(static_cast<int>(model.mesh.loop().size()));
            const double w = draw(0, 1), angle = draw(-3.2, 3.2), r = k % 100 ? draw(0, size) : 0;
            const int set = selector.select(segment, w, {r * std::cos(angle), r * std::sin(angle)});
            REQUIRE((set >= 0 && set < model.case_count()));
        }
    }
}

TEST_CASE("selection by force finds the set of a straight load case by its equilibrium force", "[selector]") {
    const TissueModel model = haptic_example();
    const Selector selector = make(model, SelectBy::force);
    // Straight indentations: the force is along the displacement by symmetry of the isotropic law.
    for (int c = 0; c < 6; ++c) {
        const Eigen::Vector2d position = model.contact_m.row(c);
        const auto rest = solve_equilibrium(model.mesh, *make_spring_law(model.law), model.trained[0].theta.row(c).transpose(),
                                            locate_on_surface(model.mesh, position), model.magnitude_m[c] * model.direction.row(c));
        REQUIRE(rest);
        const auto [segment, w] = place(model.mesh, position);
        CHECK(selector.select(segment, w, rest.contact_force) == c);
    }
}

TEST_CASE("selection without sets or by force without an equilibrium is refused", "[selector]") {
    TissueModel empty = haptic_example();
    empty.case_names.clear();
    refusal<MismatchError>([&] { make(empty); });
    const TissueModel singular = haptic_example({"grid4", "axial"});
    CHECK(refusal<MismatchError>([&] { make(singular, SelectBy::force); })
              .find("zero-energy") != std::string::npos);
}
