#include <catch2/catch.hpp>
#include <cmath>

#include "../refusal.h"
#include "error.h"
#include "haptic/selector.h"
#include "haptic_example.h"
#include "springs/equilibrium.h"

using namespace tissue;

namespace {

Selector make(const TissueModel& model, SelectorOptions::Mode mode, SelectorOptions::By by = SelectorOptions::By::displacement) {
    return Selector(model, model.trained[0].theta, {mode, by});
}

/// Segment and weight of a place on the outline.
std::pair<int, double> place(const SpringMesh& mesh, const Eigen::Vector2d& x) {
    const SurfacePoint p = locate_on_surface(mesh, x);
    const auto b = std::find(mesh.boundary.begin(), mesh.boundary.end(), p.node[0]) - mesh.boundary.begin();
    return {static_cast<int>(b), p.weight[1]};
}

}  // namespace

TEST_CASE("every load case is served by its own set, nearest or blended", "[selector]") {
    const TissueModel model = haptic_example();
    for (auto mode : {SelectorOptions::Mode::nearest, SelectorOptions::Mode::blended}) {
        const Selector selector = make(model, mode);
        for (int c = 0; c < model.case_count(); ++c) {
            const auto [segment, w] = place(model.mesh, model.contact_m.row(c));
            const SetWeights sets = selector.select(segment, w, model.magnitude_m[c] * model.direction.row(c));
            double own = 0;
            for (int k = 0; k < sets.count; ++k)
                if (sets.set[static_cast<std::size_t>(k)] == c) own += sets.weight[static_cast<std::size_t>(k)];
            CHECK(own == Approx(1).margin(1e-5));
        }
    }
}

TEST_CASE("automatic blends where every place knows several pushes, and else takes the nearest set", "[selector]") {
    using Mode = SelectorOptions::Mode;
    TissueModel model = haptic_example();  // one push at each midpoint, as the paper has it
    CHECK(make(model, Mode::automatic).options().mode == Mode::nearest);
    std::vector<int> corners;
    for (int c = 0; c < model.case_count(); ++c)
        if (model.case_names[static_cast<std::size_t>(c)].rfind("t", 0) == 0 && model.contact_m(c, 0) != 0.05) corners.push_back(c);
    REQUIRE(corners.size() == 12);
    TissueModel dense = model;
    dense.case_names.clear();
    for (int c : corners) dense.case_names.push_back(model.case_names[static_cast<std::size_t>(c)]);
    dense.contact_m = model.contact_m(corners, Eigen::all).eval();
    dense.direction = model.direction(corners, Eigen::all).eval();
    dense.magnitude_m = model.magnitude_m(corners).eval();
    dense.trained[0].theta = model.trained[0].theta(corners, Eigen::all).eval();
    CHECK(make(dense, Mode::automatic).options().mode == Mode::blended);
    CHECK(make(dense, Mode::nearest).options().mode == Mode::nearest);
}

TEST_CASE("nearest: position before angle before magnitude", "[selector]") {
    const TissueModel model = haptic_example();
    const Selector selector = make(model, SelectorOptions::Mode::nearest);
    const auto [segment, w] = place(model.mesh, {0.02, 0.1});  // between top-left corner and the top's middle
    const SetWeights steep = selector.select(segment, w, {0.0001, -0.0112});
    CHECK(model.case_names[static_cast<std::size_t>(steep.set[0])] == "tl-down-10mm");
    const SetWeights deep = selector.select(segment, w, {0.0101, -0.0099});
    CHECK(model.case_names[static_cast<std::size_t>(deep.set[0])] == "tl-diagonal-15mm");
    CHECK(deep.count == 1);
}

TEST_CASE("shares lie in [0, 1] and make 1 anywhere, and blended ones change continuously", "[selector]") {
    const TissueModel model = haptic_example();
    Draw draw(3);
    for (auto mode : {SelectorOptions::Mode::nearest, SelectorOptions::Mode::blended})
        for (auto by : {SelectorOptions::By::displacement, SelectorOptions::By::force}) {
            const Selector selector = make(model, mode, by);
            const double size = by == SelectorOptions::By::force ? 0.005 : 0.02;
            double roughest = 0;
            for (int k = 0; k < 20000; ++k) {
                const int segment = draw.below(static_cast<int>(model.mesh.boundary.size()));
                const double w = draw(0, 1), angle = draw(-3.2, 3.2), r = draw(0, size);
                const SetWeights sets = selector.select(segment, w, {r * std::cos(angle), r * std::sin(angle)});
                double sum = 0;
                for (int i = 0; i < sets.count; ++i) {
                    const double share = sets.weight[static_cast<std::size_t>(i)];
                    REQUIRE((share >= 0 && share <= 1));
                    sum += share;
                }
                REQUIRE(sum == Approx(1).epsilon(1e-12));
                REQUIRE((sets.count >= 1 && sets.count <= 8));
            }
            if (mode == SelectorOptions::Mode::nearest || by == SelectorOptions::By::force) continue;
            // a push into the top, swept in depth: theta moves in proportion to the step
            const auto [segment, w] = place(model.mesh, {0.031, 0.1});
            Eigen::VectorXd last;
            for (double depth = 0; depth < 0.02; depth += 1e-5) {
                const Eigen::VectorXd theta = blend(model.trained[0].theta, selector.select(segment, w, {0.2 * depth, -depth}));
                if (last.size() > 0) roughest = std::max(roughest, (theta - last).norm() / theta.norm());
                last = theta;
            }
            CHECK(roughest < 0.01);
        }
}

TEST_CASE("by force, a set serves where the force is the one that it gives at its own case", "[selector]") {
    const TissueModel model = haptic_example();
    const Selector selector = make(model, SelectorOptions::Mode::nearest, SelectorOptions::By::force);
    for (int c = 0; c < 6; ++c) {  // straight pushes: force along the push by symmetry of the isotropic law
        const Eigen::Vector2d position = model.contact_m.row(c);
        const auto rest = solve_equilibrium(model.mesh, *make_spring_law(model.law), model.trained[0].theta.row(c).transpose(),
                                            locate_on_surface(model.mesh, position), model.magnitude_m[c] * model.direction.row(c));
        REQUIRE(rest);
        const auto [segment, w] = place(model.mesh, position);
        CHECK(selector.select(segment, w, rest.contact_force).set[0] == c);
    }
}

TEST_CASE("a model without sets, or by force without an equilibrium, is refused", "[selector]") {
    TissueModel empty = haptic_example();
    empty.case_names.clear();
    refusal<MismatchError>([&] { make(empty, SelectorOptions::Mode::nearest); });
    const TissueModel floppy = haptic_example({"grid4", "axial"});
    CHECK(refusal<MismatchError>([&] { make(floppy, SelectorOptions::Mode::nearest, SelectorOptions::By::force); })
              .find("zero-energy") != std::string::npos);
}
