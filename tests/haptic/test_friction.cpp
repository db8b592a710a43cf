#include "haptic/friction.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "../example.h"
#include "../mesh/disc.h"
#include "../refusal.h"
#include "error.h"
#include "haptic_example.h"
#include "mesh/outline.h"

using namespace tissue;

namespace {

HapticOptions with_friction(double stick, std::optional<double> slip = {}) {
    HapticOptions o;
    o.friction = {stick, slip};
    o.safety.passivity = false;
    o.heuristic_mesh = false;
    return o;
}

/// Indents the middle of the top by this depth, then drags along the first axis at 10 mm/s.
struct Drag {
    Drag(const TissueModel& tissue, const HapticOptions& options, double depth_m = 0.004) : model(tissue, options), s(model), depth(depth_m) {
        at = model.rest.dimension() == 3 ? Eigen::Vector3d(0.04, 0.05, 0.05) : Eigen::Vector3d(0.04, 0.1, 0);
        up = model.rest.dimension() == 3 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
        for (int k = 0; k <= 500; ++k) s.tick(sample_at(at + up * (0.002 - (depth + 0.002) * std::min(1.0, k / 300.0))));
        for (int k = 0; k < 1000; ++k) s.tick(sample_at(at - depth * up));
    }
    void by(double way_m) {
        const int ticks = std::max(1, static_cast<int>(std::abs(way_m) / 1e-5));
        for (int k = 1; k <= ticks; ++k) {
            at.x() += way_m / ticks;
            s.tick(sample_at(at - depth * up));
        }
    }
    double normal_N() const { return model.rest.dimension() == 3 ? s.record().coupling_N[2] : s.record().coupling_N[1]; }
    double drag_N() const { return -s.record().coupling_N[0]; }
    Point place_m() const { return model.meshes[0]->springs.rest_place(s.contact().where.facet, s.contact().where.weight); }

    HapticModel model;
    Simulation s;
    double depth;
    Eigen::Vector3d at, up;
};

std::vector<TissueModel> tissues() { return {energy_model_example(), solid_example(), haptic_example({"grid8", "axial"})}; }

}  // namespace

TEST_CASE("the drag force of a sliding tool is mu times its normal force", "[friction][long]") {
    for (const TissueModel& tissue : tissues())
        for (double mu : {0.1, 0.3}) {
            Drag drag(tissue, with_friction(mu));
            const Point from = drag.place_m();
            drag.by(0.008);
            double ratio = 0;
            for (int k = 0; k < 40; ++k) {
                drag.by(1e-4);
                ratio += drag.drag_N() / drag.normal_N() / 40;
            }
            INFO(tissue.study << " mu " << mu << ": " << ratio << ", dissipated " << drag.s.friction().dissipated_J() << " J");
            // an indented outline has kinks at its nodes
            CHECK(ratio == Approx(mu).epsilon(tissue.energy_model ? 0.03 : 0.2));
            CHECK((drag.place_m() - from)[0] > 0.003);
            CHECK(drag.s.friction().dissipated_J() > 0);
        }
}

TEST_CASE("a contact on spring sets slides by at most half a spacing in one tick", "[friction]") {
    const HapticModel model(haptic_example({"grid8", "axial"}), {});
    const std::unique_ptr<MovingSurface> surface = make_moving_surface(model.rest);
    Friction friction({0.3, 0.3});
    SurfacePlace where = surface->nearest(Eigen::Vector2d(0.02, 0.1));
    const Point from = where.position_m, tool = from + Eigen::Vector2d(1, -0.001);
    friction.slide(model.surface, model.meshes[0]->springs, *surface, 100, tool, where);
    CHECK(friction.slipping());
    CHECK((where.position_m - from).norm() == Approx(0.5 * model.surface.spacing_m()).epsilon(1e-6));
}

TEST_CASE("a contact inside the friction cone sticks and one with infinite friction always sticks", "[friction]") {
    for (const TissueModel& tissue : tissues())
        for (double mu : {0.8, std::numeric_limits<double>::infinity()}) {
            Drag drag(tissue, with_friction(mu));
            const Point from = drag.place_m();
            const double way_m = std::isinf(mu) ? 0.006 : 0.0005, dissipated_J = drag.s.friction().dissipated_J();
            drag.by(way_m);
            CHECK(drag.place_m() == from);
            CHECK_FALSE(drag.s.record().slipping);
            drag.by(-way_m);
            CHECK(drag.place_m() == from);
            CHECK(drag.s.friction().dissipated_J() == dissipated_J);
        }
}

TEST_CASE("a contact begins to slip at the static coefficient of friction", "[friction]") {
    for (const TissueModel& tissue : {energy_model_example(), solid_example()}) {
        Drag drag(tissue, with_friction(0.4, 0.2));
        double most = 0, last = 0;
        for (int k = 0; k < 100; ++k) {
            drag.by(1e-4);
            last = drag.drag_N() / drag.normal_N();
            most = std::max(most, last);
        }
        INFO(tissue.study << " most " << most << ", last " << last);
        CHECK(most == Approx(0.4).epsilon(0.1));
        CHECK(last < 0.42);
        CHECK(drag.s.friction().dissipated_J() > 0);
    }
}

TEST_CASE("cyclic drags with friction cost the hand energy and at most three times the dissipated energy", "[friction]") {
    for (const TissueModel& tissue : {energy_model_example(), solid_example()}) {
        Drag drag(tissue, with_friction(0.2));
        drag.by(0.004);
        const double before = drag.s.safety().counters().energy_given_J;
        for (int loop = 0; loop < 3; ++loop) {
            drag.by(0.008);
            drag.by(-0.008);
        }
        const double given = drag.s.safety().counters().energy_given_J - before;
        INFO(tissue.study << " given " << given << ", dissipated " << drag.s.friction().dissipated_J());
        CHECK(given < 0);
        CHECK(-given < 3 * drag.s.friction().dissipated_J());
    }
}

TEST_CASE("a tool slides along a curved surface past nodes without sticking", "[friction]") {
    TissueModel tissue = energy_model_example(edge_mesh(disc(24)));
    const HapticModel model(tissue, with_friction(0.1));
    Simulation s(model);
    const Outline outline(tissue.mesh);
    const double from = 0.3 * outline.length(), way = 0.3 * outline.length();
    const auto go = [&](double arc, double depth) {
        const Eigen::Vector2d at = outline.position(arc) + depth * outline.inward_normal(arc);
        s.tick(sample_at(at.x(), at.y()));
    };
    for (int k = 0; k <= 500; ++k) go(from, -0.002 + 0.005 * k / 500);
    REQUIRE(s.contact().pressing);
    long stood = 0, longest = 0;
    for (int k = 1; k <= 4000; ++k) {
        const Point before = model.meshes[0]->springs.rest_place(s.contact().where.facet, s.contact().where.weight);
        go(from + way * k / 4000, 0.003);
        REQUIRE(s.contact().contact);
        const Point now = model.meshes[0]->springs.rest_place(s.contact().where.facet, s.contact().where.weight);
        stood = (now - before).norm() > 0 ? 0 : stood + 1;
        if (k > 1500) longest = std::max(longest, stood);
    }
    const Point end = model.meshes[0]->springs.rest_place(s.contact().where.facet, s.contact().where.weight);
    INFO("stuck for " << longest << " ticks at most");
    CHECK(longest < 200);
    CHECK((end - outline.position(from + way)).norm() < 0.01);
}

TEST_CASE("a sliding contact on tissue that relaxes keeps the state of its Maxwell branches on both meshes", "[friction]") {
    Drag drag(relaxing(solid_example()), with_friction(0.3));
    const HapticMesh& mesh = *drag.model.meshes[0];
    SurfacePlace where = drag.s.contact().where;
    Point touched_m = drag.place_m();
    const Point from_m = touched_m, push_m = Eigen::Vector3d(0, 0, -0.004);
    const NodeColumns& u = drag.s.state(0).displacement;
    ToolSpring tool;
    mesh.energy_model->contacts().at(where.facet, where.weight, {}, tool);
    ToolMemory memory = mesh.energy_model->tool_memory(1e-3);
    ToolMemory beside = memory;
    for (int k = 0; k < 50; ++k) {
        tool.remember(push_m, u, memory);
        tool.remember(0.5 * push_m, u, beside);
    }
    const ToolMemory before = memory, beside_before = beside;
    Friction friction(FrictionOptions{0.3, {}});
    friction.slide(drag.model.surface, mesh.springs, mesh.energy_model->contacts(), u, from_m + push_m + Eigen::Vector3d(0.02, 0, 0), where, touched_m, tool, memory, &beside);
    REQUIRE(friction.slipping());
    REQUIRE((touched_m - from_m).norm() > 0.004);
    for (int g = 0; g < tool.group_count(); ++g) {
        // points of the contact move with the disc, and so does their state
        CHECK(memory.known_N(g) == before.known_N(g));
        CHECK(beside.known_N(g) == beside_before.known_N(g));
    }
}

TEST_CASE("negative friction and kinetic friction above the static one or without one are refused", "[friction]") {
    const double never = FrictionOptions().stick;
    CHECK(refusal<MismatchError>([&] { Friction({never, 0.2}); }) == "friction-slip has no effect while friction is inf, where the tool never slips: set friction too");
    CHECK(refusal<MismatchError>([] { Friction({-0.1, {}}); }) == "friction must not be negative, not -0.1");
    CHECK(refusal<MismatchError>([] { Friction({0.1, -1}); }) == "friction-slip must not be negative, not -1");
    CHECK(refusal<MismatchError>([] { Friction({0.1, 0.2}); }) == "kinetic friction 0.2 must not be above the static 0.1");
    CHECK_FALSE(refusal<MismatchError>([] { HapticModel(energy_model_example(), with_friction(std::nan(""))); }).empty());
}
