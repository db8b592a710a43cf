// The tick of an energy model in space: contact, force and safety as in test_simulation.cpp, along three axes.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "../allocations.h"
#include "../example.h"
#include "../mesh/dome.h"
#include "../refusal.h"
#include "../solid_model_example.h"
#include "error.h"
#include "haptic/moving_triangles.h"
#include "haptic/state_channel.h"
#include "haptic/virtual_device.h"
#include "haptic_example.h"
#include "mesh/embedded_lattice.h"
#include "mesh/free_surface.h"
#include "springs/contact_spring.h"
#include "springs/energy_model_kernel.h"
#include "springs/indentation_solver.h"

using namespace tissue;

namespace {

const HapticModel& solid() {
    static const HapticModel model(solid_example(), {});
    return model;
}

/// Moves the hand to a place, and keeps it there.
class Way {
   public:
    Way(Simulation& s, const Eigen::Vector3d& from_m) : s_(s), at_m_(from_m) {}
    void to(const Eigen::Vector3d& place_m, int ticks, int stay = 0) {
        const Eigen::Vector3d from = at_m_;
        for (int k = 1; k <= ticks + stay; ++k) {
            at_m_ = from + (place_m - from) * std::min(1.0, static_cast<double>(k) / ticks);
            s_.tick(sample_at(at_m_));
        }
    }

   private:
    Simulation& s_;
    Eigen::Vector3d at_m_;
};

/// An adversarial hand in space: exactly onto nodes and edges, at full speed, through the tissue, with invalid samples.
class WildHand {
   public:
    explicit WildHand(unsigned long seed) : draw_(seed) {}
    DeviceSample next(const Simulation& s, double elapsed_s) {
        const Eigen::Vector3d low = s.model().low_m, high = s.model().high_m;
        if (--left_ <= 0) {
            mode_ = draw_.below(5);
            left_ = 1 + draw_.below(200);
            for (int axis = 0; axis < 3; ++axis) aim_[axis] = draw_(low[axis] - 0.03, high[axis] + 0.03);
            if (draw_.below(3) == 0) aim_.z() = draw_(0.8 * high.z(), high.z());
            speed_ = draw_.below(2) ? 2e-3 * (1 - 1e-9) : draw_(1e-5, 2e-3);
        }
        Eigen::Vector3d to = aim_;
        const int facet = draw_.below(static_cast<int>(s.model().rest.facets.rows()));
        if (mode_ == 1) to = s.surface(0).at(facet, {1, 0, 0});      // exactly onto a node
        if (mode_ == 2) to = s.surface(0).at(facet, {0.5, 0.5, 0});  // onto an edge
        if (mode_ == 3) to = s.contact().proxy_m + 1e-3 * Eigen::Vector3d(draw_(-1, 1), draw_(-1, 1), draw_(-1, 1));
        if (mode_ == 4) to = x_ + 0.01 * Eigen::Vector3d(draw_(-1, 1), draw_(-1, 1), draw_(-1, 1));
        const Eigen::Vector3d step = to - x_;
        x_ += step * std::min(1.0, step.norm() > 0 ? speed_ * std::max(1.0, 1e3 * elapsed_s) / step.norm() : 0.0);
        DeviceSample sample = sample_at(x_);
        if (draw_.below(2000) == 0) sample.position_m[draw_.below(3)] = draw_.below(2) ? std::nan("") : 1e300;
        if (draw_.below(2000) == 0) sample.age_s = 1;
        if (draw_.below(2000) == 0) sample.valid = false;
        return sample;
    }

   private:
    Draw draw_;
    Eigen::Vector3d x_{-0.02, 0.05, 0.03}, aim_{0.05, 0.05, 0.05};
    int mode_ = 0, left_ = 0;
    double speed_ = 1e-3;
};

/// Highest frequency of the nodes under a tool at contact_m, with the contact's stiffness alone [Hz].
double frequency(const TissueModel& tissue, const Eigen::Vector3d& contact_m) {
    const ContactSpring contact(make_contact_kernel(tissue.mesh, tissue.energy_model->disc_radius_m, tissue.energy_model->disc)->rows_at(contact_m),
                                tissue.energy_model->patch);
    Eigen::MatrixXd K = contact.tangent(Eigen::Vector3d::Zero(), Eigen::VectorXd::Zero(contact.rows.pull.cols()));
    for (Eigen::Index k = 0; k < K.rows(); ++k) {
        const double mass = tissue.node_mass_kg[contact.rows.nodes[static_cast<std::size_t>(k / 3)]];
        K.row(k) /= std::sqrt(mass);
        K.col(k) /= std::sqrt(mass);
    }
    return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues().maxCoeff()) / 6.283185307179586;
}

}  // namespace

TEST_CASE("a solid indented in motion comes to rest at minimum energy and the mesh beside it gets the same force", "[simulation][solid]") {
    const TissueModel tissue = solid_example();
    const IndentationSolver solver(tissue);
    Simulation s(solid());
    const Eigen::Vector3d contact(0.043, 0.056, 0.05), push(0.001, -0.002, -0.005);
    Way way(s, contact + Eigen::Vector3d(0, 0, 0.005));
    way.to(contact, 100);
    way.to(contact + push, 500, 6000);
    const TickRecord& r = s.record();
    REQUIRE(r.mesh == 0);
    const Point touched = s.model().meshes[0]->springs.rest_place(r.facet, r.weight);
    CHECK((touched - contact).norm() < 1e-3);
    CHECK((r.contact_displacement_m - (contact + push - touched)).norm() < 1e-12);
    const Equilibrium rest = solver.at(touched, r.contact_displacement_m);
    REQUIRE(rest);
    CHECK((r.coupling_N + rest.contact_force).norm() < 1e-3 * rest.contact_force.norm());
    CHECK((s.state(0).displacement - NodeColumns(rest.displacement)).norm() < 1e-3 * rest.displacement.norm());
    CHECK(r.device_N.dot(push) < 0);
    CHECK(r.device_N.z() > 0);

    // The displayed displacement is that of evaluation. On both meshes it differs from that of the nodes.
    NodeColumns seen = s.state(0).displacement, other = s.state(1).displacement;
    s.displayed(0, seen);
    s.displayed(1, other);
    const NodeField wanted = solver.displayed(touched, r.contact_displacement_m, rest.displacement);
    CHECK((seen - NodeColumns(wanted)).norm() < 1e-3 * wanted.norm());
    CHECK((seen - s.state(0).displacement).norm() > 1e-2 * wanted.norm());
    CHECK((other - s.state(1).displacement).norm() > 1e-2 * wanted.norm());
    {
        const Allocations counted;
        s.displayed(0, seen);
        s.displayed(1, other);
    }
    CHECK(Allocations::count() == 0);
    // The page draws the displayed surface, and the tool on it.
    StateChannel channel(s.model(), 1);
    {
        const Allocations counted;
        channel.after(s, {});
    }
    CHECK(Allocations::count() == 0);
    REQUIRE(channel.fetch());
    Eigen::Vector3d on_it = Eigen::Vector3d::Zero(), on_lattice = on_it;
    for (Eigen::Index k = 0; k < 3; ++k) {
        const int node = s.model().rest.facets(r.facet, k);
        on_it += r.weight[static_cast<std::size_t>(k)] * (tissue.mesh.nodes.row(node) + seen.row(node)).transpose();
        on_lattice += r.weight[static_cast<std::size_t>(k)] * (tissue.mesh.nodes.row(node) + s.state(0).displacement.row(node)).transpose();
    }
    CHECK((channel.state().proxy_m - on_it).norm() < 1e-12);
    CHECK((on_it - on_lattice).norm() > 1e-4);
    CHECK((r.proxy_m - on_lattice).norm() < 1e-4);

    // The mesh beside got the same force.
    CHECK(s.displacement_at_contact(1).norm() > 0.5 * r.contact_displacement_m.norm());
    CHECK((s.tool().tool_force_N(s.displacement_at_contact(1), s.state(1).displacement) + r.coupling_N).norm() < 0.02 * r.coupling_N.norm());
    CHECK(s.surface(1).at(0, {1, 0, 0})[0] - s.surface(0).at(0, {1, 0, 0})[0] == Approx(s.model().options.place_m).margin(0.02));

    // Without a contact the nodes' displacement is displayed.
    s.reset();
    s.displayed(0, seen);
    CHECK(seen.isZero(0));
}

TEST_CASE("an embedded solid comes to rest at minimum energy and its ticks allocate nothing", "[simulation][solid][embedded][long]") {
    const TissueModel tissue = solid_model_example(embedded_lattice(dome(8), 0.011));
    const IndentationSolver solver(tissue);
    HapticOptions o;
    o.heuristic_mesh = false;
    const HapticModel model(tissue, o);
    Simulation s(model);
    const Eigen::Vector3d contact = FreeSurface(tissue.mesh).nearest(Eigen::Vector3d(0.012, 0.008, 0.05)).point_m, push(0.001, -0.001, -0.004);
    Way way(s, contact + Eigen::Vector3d(0, 0, 0.005));
    way.to(contact, 100);
    {
        const Allocations counted;
        way.to(contact + push, 500, 4000);
    }
    CHECK(Allocations::count() == 0);
    const TickRecord& r = s.record();
    REQUIRE(r.mesh == 0);
    const Point touched = s.model().meshes[0]->springs.rest_place(r.facet, r.weight);
    const Equilibrium rest = solver.at(touched, r.contact_displacement_m);
    REQUIRE(rest);
    CHECK((r.coupling_N + rest.contact_force).norm() < 1e-3 * rest.contact_force.norm());
    CHECK((s.state(0).displacement - NodeColumns(rest.displacement)).norm() < 1e-3 * rest.displacement.norm());
    CHECK(s.state(0).displacement.topRows(tissue.mesh.embedding.node_count()).norm() > 1e-3);
    // supports give way by little
    for (int node : tissue.mesh.fixed) CHECK(s.state(0).displacement.row(node).norm() < 1e-4);
}

TEST_CASE("a contact whose frequency exceeds the tick rate is excited neither by ticks nor by a loss of contact", "[simulation][solid][long]") {
    const Eigen::Vector3d contact(0.043, 0.056, 0.05), down(0, 0, -8e-6);  // 8 mm/s, to a light touch
    const auto stiffer = [](double by) {
        TissueModel tissue = solid_example();
        tissue.energy_model->patch.log_N_m(2, 0) += by;
        return tissue;
    };
    for (double by : {5.0, 6 - 2 * std::log(1e-3 * frequency(stiffer(6), contact)), 7.0}) {
        const TissueModel tissue = stiffer(by);
        HapticOptions o;
        o.heuristic_mesh = false;
        const HapticModel model(tissue, o);
        Simulation s(model);
        Way way(s, contact - 250 * down);
        double farthest_m = 0, force_max_N = 0;
        for (int k = 0; k < 3000; ++k) {
            way.to(contact + std::min(k - 250, 50) * down, 1);
            farthest_m = std::max(farthest_m, s.state(0).displacement.cwiseAbs().maxCoeff());
            force_max_N = std::max(force_max_N, s.record().coupling_N.norm());
        }
        const TickRecord& r = s.record();
        INFO("by " << by << ": oscillates " << 1e-3 * frequency(tissue, contact) << " times a tick, force " << r.coupling_N.norm() << ", at most " << force_max_N);
        CHECK(farthest_m < 4.5e-4);
        REQUIRE(r.mesh == 0);
        const Equilibrium rest = IndentationSolver(tissue).at(model.meshes[0]->springs.rest_place(r.facet, r.weight), r.contact_displacement_m);
        REQUIRE(rest);
        CHECK((r.coupling_N + rest.contact_force).norm() < 1e-3 * rest.contact_force.norm());
        CHECK(force_max_N < 1.3 * rest.contact_force.norm());
    }
}

TEST_CASE("a tick in space allocates nothing", "[simulation][solid]") {
    HapticOptions o;
    o.friction.stick = 0.4;
    const HapticModel model(solid_example(), o);
    Simulation s(model);
    VirtualDevice hand(make_motion({"poke", 2, 0.01, 3, &model.rest}), model.options.map);
    long pressed = 0, allocations = 0;
    for (int k = 0; k < 2000; ++k) {
        const DeviceSample sample = hand.read(k * 1e-3);
        const Allocations none;
        s.tick(sample);
        allocations += Allocations::count();
        pressed += s.contact().pressing;
    }
    CHECK(allocations == 0);
    CHECK(pressed > 100);
}

TEST_CASE("adversarial ticks in space keep the force within its limits and the proxy outside and the port passive", "[simulation][solid][adversarial]") {
    constexpr double sticks = std::numeric_limits<double>::infinity();
    struct Kind { double force_scale, stick; bool on_time, relaxes; double hold_s = force_held_s; };
    for (const Kind& kind : {Kind{1, sticks, true, false}, Kind{10, sticks, false, false}, Kind{10, 0.3, false, false}, Kind{1, sticks, true, true}, Kind{10, 0.3, false, true}, Kind{10, 0.3, false, false, 0.05},
                             Kind{10, sticks, false, true, std::numeric_limits<double>::infinity()}}) {
        DYNAMIC_SECTION((kind.relaxes ? "relaxing law" : "law") << ", force scale " << kind.force_scale << ", stick " << kind.stick << (kind.on_time ? ", on time" : ", irregular ticks") << ", held for " << kind.hold_s << " s") {
            HapticOptions o;
            o.map.force_scale = kind.force_scale;
            o.friction.stick = kind.stick;
            o.safety.hold_s = kind.hold_s;
            const HapticModel model(kind.relaxes ? relaxing(solid_example()) : solid_example(), o);
            Simulation s(model);
            WildHand hand(42);
            Draw kick(43);
            Pace pace(44);
            Port port(s);
            long long inside = 0, pressed = 0;
            const long long ticks = adversarial_ticks(15000);
            for (long long k = 0; k < ticks; ++k) {
                if (kind.relaxes && kick.below(1000) == 0) s.reset();  // as in the plane
                if (kick.below(500) == 0) {
                    const int node = kick.below(model.rest.node_count());
                    if (!model.meshes[0]->springs.fixed(node)) s.state(0).velocity.row(node) += Eigen::RowVector3d(kick(-2, 2), kick(-2, 2), kick(-2, 2));
                }
                const double elapsed = kind.on_time ? o.dt_s : pace.next(o.dt_s);
                const bool force_may = port.tick(hand.next(s, elapsed), elapsed);
                REQUIRE(s.state(0).displacement.allFinite());
                REQUIRE(s.contact().where.weight.minCoeff() >= 0);
                for (std::size_t m = 0; m < 2 && force_may; ++m) inside += s.surface(m).contains_strictly(s.contact().proxy_m, 1e-9);
                pressed += s.contact().pressing;
            }
            const std::string seen = fmt::format("{} ticks: pressed {}, faults {}, folded {}, unstable {}, worst energy {:.3g} J of {:.3g} J", ticks, pressed, port.faults(), s.counters().folded,
                                                 s.counters().unstable, port.worst_J(), port.bound_J());
            INFO(seen);
            if (ticks != 15000) WARN(seen);
            CHECK(inside == 0);
            CHECK(port.worst_J() <= port.bound_J() * (1 + 1e-9));
            CHECK(pressed > 0);
            CHECK(port.faults() > 0);
        }
    }
}

TEST_CASE("a tool at full speed never passes through the tissue without a contact", "[simulation][solid]") {
    Simulation s(solid());
    Draw draw(7);
    for (int shot = 0; shot < 60; ++shot) {
        s.reset();
        const Eigen::Vector3d through(draw(0.005, 0.095), draw(0.005, 0.095), draw(0.02, 0.045));
        const Eigen::Vector3d way = Eigen::Vector3d(draw(-1, 1), draw(-1, 1), draw(-1, -0.2)).normalized(), from = through - 0.12 * way;
        bool touched = false;
        for (int k = 0; k < 140 && !touched; ++k) {
            s.tick(sample_at(from + 0.0019 * k * way));
            touched = s.contact().contact;
        }
        INFO("shot " << shot);
        CHECK(touched);
    }
}

TEST_CASE("closed loops of the tool over depth and direction give the hand no net energy", "[simulation][solid]") {
    HapticOptions o;
    o.safety.passivity = false;
    o.heuristic_mesh = false;
    const HapticModel model(solid_example(), o);
    Simulation s(model);
    const Eigen::Vector3d contact(0.05, 0.05, 0.05);
    Way way(s, contact + Eigen::Vector3d(0, 0, 0.005));
    way.to(contact + Eigen::Vector3d(0, 0, -0.004), 400, 1500);
    const double before = s.safety().counters().energy_given_J;
    double least = before, most = before;
    for (int loop = 0; loop < 4; ++loop)
        for (int k = 1; k <= 2000; ++k) {
            const double t = 2 * 3.14159265358979 * k / 2000, turn = loop % 2 ? -t : t;
            s.tick(sample_at(contact + Eigen::Vector3d(0.003 * std::sin(turn), 0.002 * (1 - std::cos(turn)), -0.004 - 0.003 * std::sin(2 * t))));
            least = std::min(least, s.safety().counters().energy_given_J);
            most = std::max(most, s.safety().counters().energy_given_J);
        }
    const double swung = most - least;
    CHECK(swung > 1e-5);
    CHECK(s.safety().counters().energy_given_J - before <= 1e-3 * swung);
}

TEST_CASE("a model in space without an energy model and options of another dimension are refused", "[simulation][solid]") {
    TissueModel none = solid_example();
    none.energy_model.reset();
    CHECK(refusal<MismatchError>([&] { HapticModel(none, {}); }) == "a model in space must be an energy model; this one has spring sets");
    HapticOptions plane;
    plane.map.axes = parse_axes("x,y");
    CHECK(refusal<MismatchError>([&] { HapticModel(solid_example(), plane); }) == "axes: 2 device axes for a tissue of 3 axes");
}

TEST_CASE("force and energy keep their limits until a self-intersection in space is found and then the force is zero", "[simulation][solid]") {
    const TissueModel tissue = solid_example();
    for (double force_scale : {1.0, 300.0}) {
        HapticOptions o;
        o.heuristic_mesh = false;
        o.map.force_scale = force_scale;
        const HapticModel model(tissue, o);
        const int longest = MovingTriangles(tissue.mesh).ticks_to_look();
        Draw draw(5);
        int latest = 0, with_force = 0;
        for (int time = 0; time < 6; ++time) {
            Simulation s(model);
            Port port(s);
            Eigen::Vector3d hand(0.043, 0.056, 0.052);
            for (int k = 0; k < 600; ++k) {
                hand.z() = 0.052 - 0.005 * std::min(1.0, k / 400.0);
                port.tick(sample_at(hand), 1e-3);
            }
            REQUIRE(s.record().device_N.norm() > 0.01);
            // Far from the tool a node of the top is held below the bottom. The enclosed volume stays positive.
            int through = -1;
            for (int n = 0; n < model.rest.node_count(); ++n)
                if ((model.rest.nodes.row(n) - Eigen::RowVector3d(0.075, 0.025, 0.05)).norm() < 1e-6) through = n;
            REQUIRE(through >= 0);
            for (int wait = draw.below(longest); wait > 0; --wait) port.tick(sample_at(hand), 1e-3);
            int found = 0;
            for (int k = 1; k <= longest && found == 0; ++k) {
                s.state(0).displacement.row(through) << 0, 0, -0.06;
                s.state(0).velocity.row(through).setZero();
                hand += 2e-3 * 0.99 * Eigen::Vector3d(draw(-1, 1), draw(-1, 1), draw(-1, 1)) / 2;  // at up to 1.7 m/s
                port.tick(sample_at(hand), 1e-3);
                with_force += s.record().device_N.norm() > 0;
                if (s.counters().folded > 0) found = k;
            }
            INFO("force scale " << force_scale << ", trial " << time << ": found after " << found << " ticks of " << longest << ", given " << port.worst_J() << " J of " << port.bound_J());
            REQUIRE(found > 0);
            CHECK(s.record().device_N.isZero(0));
            CHECK(port.worst_J() <= port.bound_J() * (1 + 1e-9));
            latest = std::max(latest, found);
        }
        CHECK(with_force > 0);  // else nothing was tested
        CHECK(latest > 1);
    }
}
