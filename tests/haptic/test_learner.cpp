#include "haptic/learner.h"

#include <atomic>
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <thread>

#include "../mesh/embedded_block.h"
#include "../adapt/adapt_example.h"
#include "../allocations.h"
#include "../example.h"
#include "../solid_model_example.h"
#include "../solid_shape_study.h"
#include "error.h"
#include "haptic/target_tissue.h"
#include "haptic/realtime_energy_model.h"
#include "haptic/virtual_device.h"
#include "mesh/embedded_lattice.h"
#include "haptic_example.h"
#include "springs/indentation_solver.h"

using namespace tissue;
using Catch::Matchers::Contains;

namespace {

constexpr double most = 1.5;

AdaptOptions live() {
    AdaptOptions options;
    options.largest = most;
    options.place_error_m = 1e-3;  // both tissues oscillate when they are touched, and are not at the same place
    return options;
}

HapticOptions options_for_learning() {
    HapticOptions options;
    options.heuristic_mesh = false;
    options.stiffest = std::exp(most);
    return options;
}

/// A session whose ticks follow one another without waiting: an energy model adapts to a hand that probes a target
/// tissue.
struct Session {
    TissueModel law;
    HapticModel model;
    Simulation simulation;
    Adaptation adaptation;
    Learner learner;
    TargetTissue device;
    long long tick = 0;

    Session(const TissueModel& base, const TissueModel& target, const std::vector<Waypoint>& motion)
        : law(base), model(law, options_for_learning()), simulation(model), adaptation(law, live()), learner(model, adaptation),
          device(std::make_unique<VirtualDevice>(motion, model.options.map), target, options_for_learning()) {}
    Session(const TissueModel& base, const TissueModel& target, double seconds, unsigned long seed = 3)
        : Session(base, target, make_motion({"probe", seconds, 0.006, seed, &base.mesh})) {}

    /// One tick, as in run_loop.
    void step() {
        learner.before(simulation);
        const DeviceSample sample = device.read(1e-3 * static_cast<double>(tick));
        device.write(simulation.tick(sample));
        TickStatistics books;
        books.time_s = 1e-3 * static_cast<double>(tick++);
        learner.after(simulation, books);
    }
    /// Waits until the learner has processed so many measurements, up to some 20 s.
    void wait(long long lines) {
        for (int k = 0; k < 20000 && adaptation_lines < lines; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        REQUIRE(adaptation_lines >= lines);
    }
    std::atomic<long long> adaptation_lines{0};
    std::vector<ForceMeasurement> pokes;  ///< of those lines; used by the learner's thread until it stops
    void keep_lines() {
        learner.on_line(
            [](const Learner::Line& line, const Adaptation&, void* with) {
                static_cast<Session*>(with)->pokes.push_back(line.poke);
                ++static_cast<Session*>(with)->adaptation_lines;
            },
            this);
    }
};

}  // namespace

TEST_CASE("an energy model with replaced stiffness has the forces of one made with it and allocates nothing", "[adapt][law]") {
    const SpringMesh shape = embedded_lattice(dome(6), 0.011);
    for (const TissueModel& model : {energy_model_example(), solid_model_example(embedded_block(Lattice{{5, 6, 2}, {0.05, 0.06, 0.02}})), solid_model_example(shape)}) {
        Draw draw(5);
        TissueModel other = model;
        for (double& c : other.energy_model->constants) c *= draw(0.3, 3);
        other.energy_model->contact_log_scale.resize(model.mesh.node_count());
        for (double& s : other.energy_model->contact_log_scale) s = draw(-1, 1);
        other.energy_model->patch.log_N_m(0, 0) += 0.3;
        const RealtimeMesh springs(model.mesh, model.energy_model->curve, model.node_mass_kg);
        RealtimeEnergyModel energy_model(model, springs);
        const RealtimeEnergyModel wanted(other, springs);
        {
            const EnergyModelStiffness& stiffness = wanted.stiffness();
            const Allocations none;
            energy_model.become(stiffness);
            CHECK(Allocations::count() == 0);
        }
        const NodeColumns u = scattered(model.mesh, 1e-3);
        NodeColumns f = u, g = u;
        RealtimeEnergyModel::Scratch scratch = energy_model.scratch();
        energy_model.force(u, f, scratch);
        wanted.force(u, g, scratch);
        CHECK((f - g).norm() < 1e-12 * g.norm());
        ToolSpring a, b;
        energy_model.contacts().at(3, Eigen::Vector3d::Constant(1.0 / 3), {}, a);
        wanted.contacts().at(3, Eigen::Vector3d::Constant(1.0 / 3), {}, b);
        const Point push = Point::Constant(model.mesh.dimension(), 1e-3);
        CHECK((a.tool_force_N(push, u) - b.tool_force_N(push, u)).norm() < 1e-12 * b.tool_force_N(push, u).norm());
    }
}

TEST_CASE("in a session an energy model adapts to the target tissue and the force never jumps by 0.02 N", "[adapt][long]") {
    const TissueModel model = energy_model_example(), target = stiffer(model, 0.5);
    Session s(model, target, 16);
    s.keep_lines();
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    Eigen::Vector3d stood_m = Eigen::Vector3d::Zero();
    double largest_jump = 0, largest_step = 0;
    long long readings = 0;
    int stood = 0;
    for (int k = 0; k < 16000; ++k) {
        const double before = s.simulation.energy_model()->stiffness().constants[0];
        s.step();
        largest_step = std::max(largest_step, std::abs(s.simulation.energy_model()->stiffness().constants[0] / before - 1));
        const TickRecord& tick = s.simulation.record();
        stood = tick.device_m == stood_m ? stood + 1 : 0;
        // the tissue rests under the tool, and only the model changes
        if (stood > 600) largest_jump = std::max(largest_jump, rise_N(last, tick.device_N));
        last = tick.device_N;
        stood_m = tick.device_m;
        CHECK_FALSE(!last.allFinite());
        if (s.learner.readings() > readings) s.wait(++readings);
    }
    s.learner.stop();
    CHECK(readings >= 4);
    CHECK(s.adaptation.state().learned >= 4);
    INFO("largest jump of force " << largest_jump << " N");
    CHECK(largest_jump > 0);
    CHECK(largest_jump < 0.02);
    CHECK(largest_step <= LearnerOptions().step * (1 + 1e-9));
    CHECK(largest_step > 0);
    CHECK(s.learner.arrived());
    // The model in the session is the adapted one, and near the target tissue.
    CHECK((s.simulation.energy_model()->stiffness().constants - s.adaptation.energy_model().constants).norm() == 0);
    const std::vector<ForceMeasurement> held_out = pokes_of(target, 20, 9);
    INFO("evidence " << s.adaptation.state().evidence << ", scale " << s.adaptation.state().scale << ", learned " << s.adaptation.state().learned);
    CHECK(worst_error(model, held_out) > 0.35);
    CHECK(worst_error(s.adaptation.model(), held_out) < 0.2);
}

TEST_CASE("a tick during adaptation allocates nothing", "[adapt]") {
    const TissueModel model = energy_model_example();
    Session s(model, stiffer(model, 0.4), 4);
    s.keep_lines();
    for (int k = 0; k < 2000; ++k) s.step();
    s.wait(s.learner.readings());
    REQUIRE(s.learner.readings() >= 1);
    long allocated = 0;
    {
        const Allocations none;
        for (int k = 0; k < 50; ++k) s.step();  // the model is still moving to the adapted one
        allocated = Allocations::count();
    }
    CHECK(allocated == 0);
}

TEST_CASE("adaptation to tissue that relaxes improves its instantaneous forces and can be repeated from its measurements", "[adapt][memory][long]") {
    const TissueModel model = relaxing(energy_model_example());
    TissueModel target = model;
    target.energy_model->constants *= std::exp(0.4);
    target.energy_model->contact_log_scale = Eigen::VectorXd::Constant(model.mesh.node_count(), 0.4);
    Session s(model, target, 8);
    s.keep_lines();
    long long readings = 0;
    for (int k = 0; k < 8000; ++k) {
        s.step();
        if (s.learner.readings() > readings) s.wait(++readings);
    }
    s.learner.stop();
    REQUIRE(s.adaptation.state().learned >= 2);
    Adaptation again(model, live());  // from the measurements
    for (const ForceMeasurement& poke : s.pokes) again.learn(poke);
    CHECK(again.state().learned == s.adaptation.state().learned);
    CHECK(again.state().x == s.adaptation.state().x);
    TissueModel at_once = s.adaptation.model(), wanted = target;
    at_once.energy_model = instantaneous(*at_once.energy_model);
    wanted.energy_model = instantaneous(*wanted.energy_model);
    const std::vector<ForceMeasurement> held_out = pokes_of(wanted, 12, 9);
    CHECK(worst_error(model, held_out) > 0.3);
    CHECK(worst_error(at_once, held_out) < 0.15);
}

TEST_CASE("a model stiffened during a contact has the force of one that was stiffer from the start", "[adapt][memory]") {
    const TissueModel model = relaxing(energy_model_example()), other = stiffer(model, 0.5);
    HapticModel changes(model, options_for_learning()), was(other, options_for_learning());
    Simulation a(changes), b(was);
    const auto press = [&](int from, int to) {
        for (int k = from; k < to; ++k) {
            const DeviceSample sample = sample_at(0.05, std::max(0.105 - 1e-4 * k, 0.096));
            a.tick(sample);
            b.tick(sample);
        }
    };
    press(0, 1500);
    const double before_N = a.record().coupling_N.norm();
    a.energy_model()->become(RealtimeEnergyModel(other, changes.meshes[0]->springs).stiffness());
    a.energy_model_changed();
    press(1500, 1900);
    const double force_N = a.record().coupling_N.norm(), wanted_N = b.record().coupling_N.norm();
    INFO("before " << before_N << " N, " << force_N << " N, wanted " << wanted_N << " N");
    CHECK(wanted_N > 1.3 * before_N);
    CHECK(force_N == Approx(wanted_N).epsilon(0.01));
}

TEST_CASE("a model stiffened while the mesh beside it is indented moves like one stiffer from the start under more force", "[adapt][memory][long]") {
    const TissueModel model = relaxing(energy_model_example()), other = stiffer(model, std::log(1.5));
    HapticOptions options = options_for_learning();
    options.heuristic_mesh = true;
    const HapticModel changes(model, options), was(other, options);
    const double place_m = changes.meshes[1]->place_m[0];
    const auto tick = [&](Simulation& s, double depth_m) { s.tick(sample_at(place_m + 0.05, 0.1 - depth_m)); };
    const auto press = [&](Simulation& s, double depth_m, double to_m, int ticks) {
        for (int k = 1; k <= ticks; ++k) {
            const double t = std::min(1.0, k / 150.0);
            tick(s, depth_m + t * t * (3 - 2 * t) * (to_m - depth_m));
        }
    };
    constexpr double shallow_m = 0.001;
    Simulation a(changes), probe(was);
    tick(a, -0.004), tick(probe, -0.004);
    press(a, -0.004, shallow_m, 3000);
    REQUIRE(a.record().mesh == 1);
    const double force_N = a.record().coupling_N.norm(), at_first_m = a.displacement_at_contact(0).norm();
    // Depth at which the mesh beside gives 1.5 times the force.
    double low_m = shallow_m, high_m = 3 * shallow_m;
    for (int k = 0; k < 12; ++k) {
        const double middle_m = (low_m + high_m) / 2;
        Simulation s(probe);
        press(s, -0.004, middle_m, 1500);
        (s.record().coupling_N.norm() < 1.5 * force_N ? low_m : high_m) = middle_m;
    }
    Simulation b(was);
    tick(b, -0.004);
    press(b, -0.004, low_m, 3000);
    REQUIRE(b.record().coupling_N.norm() == Approx(1.5 * force_N).epsilon(0.01));
    REQUIRE(b.displacement_at_contact(0).norm() == Approx(at_first_m).epsilon(0.01));

    a.energy_model()->become(RealtimeEnergyModel(other, changes.meshes[0]->springs).stiffness());
    a.energy_model_changed();
    double now_m = 0, wanted_m = 0;  // means during the oscillation
    for (int k = 0; k < 1000; ++k) {
        const double t = std::min(1.0, k / 150.0);
        tick(a, shallow_m);
        tick(b, low_m + t * t * (3 - 2 * t) * (shallow_m - low_m));
        if (k < 200) continue;
        now_m += a.displacement_at_contact(0).norm() / 800;
        wanted_m += b.displacement_at_contact(0).norm() / 800;
    }
    INFO("from " << at_first_m << " m to " << now_m << " m, wanted " << wanted_m << " m");
    CHECK(now_m == Approx(wanted_m).epsilon(0.01));
}

TEST_CASE("measurements of tissue that relaxes are right in a contact during which the model adapts", "[adapt][memory]") {
    const TissueModel model = relaxing(energy_model_example());
    TissueModel target = model;
    target.energy_model->constants *= std::exp(0.9);
    target.energy_model->patch.log_N_m.array() += 0.9;
    // three depths without a release in between
    std::vector<Waypoint> motion;
    const auto to = [&](double time_s, double y_m) { motion.push_back({time_s, (Point(2) << 0.05, y_m).finished()}); };
    to(0, 0.105);
    double at_s = 0.1;
    for (const double depth_m : {0.0035, 0.0045, 0.0035}) {
        to(at_s, 0.1 - depth_m);
        to(at_s + 1.7, 0.1 - depth_m);
        at_s += 1.8;
    }
    Session s(model, target, motion);
    s.keep_lines();
    long long readings = 0;
    for (int k = 0; k < 5500; ++k) {
        s.step();
        if (s.learner.readings() > readings) s.wait(++readings);
    }
    s.learner.stop();
    CHECK(s.pokes.size() == 3);
    TissueModel rested = target;
    rested.energy_model = long_term(*rested.energy_model);
    CHECK(worst_error(rested, s.pokes) < 0.02);
}

TEST_CASE("a measurement of tissue that relaxes is dropped where the model in use has no equilibrium to convert its force by", "[adapt][memory]") {
    const TissueModel tissue = relaxing(energy_model_example());
    HapticOptions options = options_for_learning();
    options.safety.force_max_N = 20;  // else the tool stays behind the hand
    const HapticModel model(tissue, options);
    Adaptation adaptation(tissue, live());
    // 30 mm deep the trained model is unstable; a field that is stiff at the contact is not
    const Point contact_m = Eigen::Vector2d(0.05, 0.1), push_m = Eigen::Vector2d(0, -0.03);
    Adaptation::State state = adaptation.state();
    for (Eigen::Index n = 0; n < state.x.size(); ++n)
        if ((adaptation.unknowns().place_m.row(n).transpose() - contact_m).norm() < 0.03) state.x[n] = 1.4;
    adaptation.restore(state);
    const Expected by_field = adaptation.expect(contact_m, push_m);
    REQUIRE(by_field.status == SolverStatus::converged);
    state.evidence = -1;  // the scale is in use, which is that of the trained model
    adaptation.restore(state);
    REQUIRE(adaptation.single_scale_in_use());
    REQUIRE(adaptation.expect(contact_m, push_m).status != SolverStatus::converged);
    Learner learner(model, adaptation);
    Simulation simulation(model);
    TickStatistics books;
    books.clock = false;
    for (int k = 0; k < 3000; ++k) {
        learner.before(simulation);
        DeviceSample sample = sample_at(0.05, 0.1 - std::min(2e-5 * k - 0.005, 0.03));
        sample.measured_N.head<2>() = by_field.force_N;
        sample.measured_N[2] = 0;
        simulation.tick(sample);
        learner.after(simulation, books);
    }
    learner.stop();
    CHECK(learner.readings() == 1);
    CHECK(learner.dropped() == 1);
    CHECK(adaptation.state().learned == 0);
    CHECK(adaptation.state().x == state.x);
}

TEST_CASE("a hand without a sensor or in motion gives no measurement and one at rest gives one", "[adapt]") {
    const TissueModel tissue = energy_model_example();
    HapticModel model(tissue, options_for_learning());
    Adaptation adaptation(tissue, live());
    Learner learner(model, adaptation);
    Simulation simulation(model);
    const auto run = [&](bool sensor, double wave_m) {
        for (int k = 0; k < 5000; ++k) {  // in, at rest, and out
            learner.before(simulation);
            const double depth = std::clamp(1e-5 * std::min(k, 5000 - k) - 0.005, -0.005, 0.005) + wave_m * std::sin(0.05 * k);
            DeviceSample sample = sample_at(0.05, 0.1 - depth);
            if (sensor) sample.measured_N = Eigen::Vector3d(0, -1, 0);
            simulation.tick(sample);
            learner.after(simulation, {});
        }
    };
    run(false, 0);
    CHECK(learner.readings() == 0);
    run(true, 1e-3);
    CHECK(learner.readings() == 0);
    run(true, 0);
    CHECK(learner.readings() == 1);  // one per hold, however long
    learner.stop();
}

TEST_CASE("a measurement takes the same simulated time for any length of ticks", "[adapt]") {
    const TissueModel tissue = energy_model_example();
    const HapticModel model(tissue, options_for_learning());
    constexpr double outside_s = 0.2, goes_s = 0.2;
    for (const double elapsed_s : {2.5e-4, 1e-3, 4e-3, 0.012}) {  // the last ones as in a loop that misses ticks
        INFO(elapsed_s);
        Adaptation adaptation(tissue, live());
        Learner learner(model, adaptation);
        Simulation simulation(model);
        double held_s = 0;  // time from the end of the hand's motion to the measurement
        for (double time_s = 0; time_s < 3 && learner.readings() == 0; time_s += elapsed_s) {
            learner.before(simulation);
            DeviceSample sample = sample_at(0.05, 0.105 - 0.01 * std::clamp((time_s - outside_s) / goes_s, 0.0, 1.0));
            sample.measured_N = Eigen::Vector3d(0, -1, 0);
            simulation.tick(sample, elapsed_s);
            learner.after(simulation, {});
            held_s = time_s - outside_s - goes_s;
        }
        CHECK(learner.readings() == 1);
        CHECK(held_s == Approx(LearnerOptions().hold_s).margin(0.03));
    }
}

TEST_CASE("without a clock each measurement is adapted to before the next tick however long that takes", "[adapt]") {
    const TissueModel tissue = energy_model_example();
    const HapticModel model(tissue, options_for_learning());
    Adaptation adaptation(tissue, live());
    Learner learner(model, adaptation);
    std::atomic<int> lines{0};
    learner.on_line(
        [](const Learner::Line&, const Adaptation&, void* with) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            ++*static_cast<std::atomic<int>*>(with);
        },
        &lines);
    Simulation simulation(model);
    TickStatistics books;
    books.clock = false;
    for (int k = 0; k < 2000; ++k) {
        learner.before(simulation);
        DeviceSample sample = sample_at(0.05, std::max(0.105 - 5e-5 * k, 0.096));
        sample.measured_N = Eigen::Vector3d(0, -0.5, 0);
        simulation.tick(sample);
        learner.after(simulation, books);
        REQUIRE(lines == learner.readings());
    }
    CHECK(lines == 1);
}

TEST_CASE("a tool at the force limit gives no measurement and its recorded displacement is that of the tool", "[adapt][hand]") {
    const TissueModel tissue = energy_model_example();
    for (const double most_N : {3.3, 0.05}) {
        HapticOptions options = options_for_learning();
        options.safety.force_max_N = most_N;
        HapticModel model(tissue, options);
        Adaptation adaptation(tissue, live());
        Learner learner(model, adaptation);
        Simulation simulation(model);
        constexpr double deep_m = 4e-3;
        const std::vector<Waypoint> motion = {{0, (Point(2) << 0.05, 0.105).finished()}, {0.3, (Point(2) << 0.05, 0.1 - deep_m).finished()}, {4, (Point(2) << 0.05, 0.1 - deep_m).finished()}};
        TargetTissue device(std::make_unique<VirtualDevice>(motion, DeviceMap()), tissue, options);
        for (int k = 0; k < 3000; ++k) {
            learner.before(simulation);
            simulation.tick(device.read(1e-3 * k));
            learner.after(simulation, {});
        }
        const bool held_back = most_N < 1;
        CHECK(simulation.held_back() == held_back);
        CHECK(learner.readings() == (held_back ? 0 : 1));
        CHECK(simulation.record().measured_N.norm() > 0.1);  // the target tissue has no force limit
        CHECK(simulation.record().coupling_N.norm() < 1.0001 * most_N);
        const double tool_m = simulation.record().contact_displacement_m.norm();
        CHECK((held_back ? tool_m < 0.5 * deep_m : std::abs(tool_m - deep_m) < 1e-9));
        learner.stop();
    }
}

TEST_CASE("a session ends with measurements in the queue and counts those beyond its patience as dropped", "[adapt]") {
    const TissueModel tissue = energy_model_example();
    HapticModel model(tissue, options_for_learning());
    Adaptation adaptation(tissue, live());
    LearnerOptions options;
    options.hold_s = 0.01;
    options.patience_s = 0.05;
    Learner learner(model, adaptation, options);
    Simulation simulation(model);
    std::atomic<bool> ending{false};  // the first measurement takes until then, the others 40 ms each
    learner.on_line(
        [](const Learner::Line&, const Adaptation&, void* with) {
            while (!static_cast<std::atomic<bool>*>(with)->load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            std::this_thread::sleep_for(std::chrono::milliseconds(40));
        },
        &ending);
    for (int k = 0; k < 1200; ++k) {  // in, then alternating by half a millimetre every 40 ms
        learner.before(simulation);
        DeviceSample sample = sample_at(0.05, 0.1 - std::min(1e-5 * k, 2e-3) - (k < 200 ? 0 : 5e-4 * ((k / 40) % 2)));
        sample.measured_N = Eigen::Vector3d(0, -1, 0);
        simulation.tick(sample);
        learner.after(simulation, {});
    }
    const long long readings = learner.readings();
    CHECK(readings >= 10);
    ending = true;
    learner.stop();
    const Adaptation::State& state = adaptation.state();
    CHECK(learner.dropped() > 0);
    CHECK(state.learned + state.gated + state.refused + learner.dropped() == readings);
}

TEST_CASE("a hand on a target tissue that misses ticks keeps its contact", "[adapt]") {
    const TissueModel model = energy_model_example();
    // In at 0.1 m/s from 5 mm outside to a depth of 4 mm, and held there.
    const std::vector<Waypoint> motion = {{0, (Point(2) << 0.05, 0.105).finished()}, {0.09, (Point(2) << 0.05, 0.096).finished()}, {2, (Point(2) << 0.05, 0.096).finished()}};
    TargetTissue device(std::make_unique<VirtualDevice>(motion, DeviceMap()), model, options_for_learning());
    int felt = 0;  // the tissue oscillates, and may leave a hand at rest for a moment
    for (int k = 0; k < 800; ++k)
        // 26 reads are missed, in which the hand moves by 3 mm
        if (k < 60 || k > 85) felt += device.read(1e-3 * k).measured_N.norm() > 1e-3 && k > 85;
    CHECK(felt > 200);
}

TEST_CASE("adaptation of another mesh or beyond the stiffness of the steps or to spring sets is refused", "[adapt]") {
    const TissueModel tissue = energy_model_example();
    HapticModel model(tissue, options_for_learning());
    Adaptation other(energy_model_example(make_lattice("grid8", 6, 6, 0.1, 0.1)), live());
    CHECK_THROWS_WITH(Learner(model, other), Contains("other than the session's"));
    Adaptation bold(tissue);
    CHECK_THROWS_WITH(Learner(model, bold), Contains("the session's time steps are stable up to"));
    HapticModel sets(haptic_example(), {});
    CHECK_THROWS_WITH(Learner(sets, other), Contains("only an energy model"));
}

TEST_CASE("a file adapted beyond a session's bound plays unchanged and its steps allow its stiffness", "[adapt]") {
    const TemporaryFolder folder;
    const TissueModel tissue = energy_model_example(), target = stiffer(tissue, 2.2);
    Adaptation patient(tissue);
    for (const ForceMeasurement& poke : pokes_of(target, 12, 5)) patient.learn(poke);
    REQUIRE(patient.x().maxCoeff() > live_bound + 0.3);
    write_adapted_model(folder.file("patient.h5"), patient, {"test", 1, {}});
    const std::unique_ptr<Adaptation> live = live_adaptation(folder.file("patient.h5"));
    const HapticOptions options = live_options({}, *live);
    CHECK(options.stiffest >= std::exp(patient.x().maxCoeff()));
    HapticModel model(live->base(), options);
    { Learner learner(model, *live); }
    for (const ForceMeasurement& poke : pokes_of(target, 4, 6)) CHECK(live->learn(poke).status == UpdateStatus::learned);
    CHECK((live->x() - patient.x()).lpNorm<Eigen::Infinity>() < 0.2);
    const std::unique_ptr<Adaptation> fresh = [&] {
        write_model(folder.file("law.h5"), tissue, {"test", 1, {}});
        return live_adaptation(folder.file("law.h5"));
    }();
    CHECK(live_options({}, *fresh).stiffest == Approx(std::exp(live_bound)));
}

TEST_CASE("an energy model with its largest adapted stiffness stays stable in its steps", "[adapt]") {
    const TissueModel tissue = energy_model_example();
    HapticModel model(tissue, options_for_learning());
    Simulation simulation(model);
    simulation.energy_model()->become(RealtimeEnergyModel(stiffer(tissue, most), model.meshes[0]->springs).stiffness());
    Port port(simulation);
    Draw draw(2);
    for (int k = 0; k < 3000; ++k) {
        const double depth = std::max(0.0, 0.008 * std::sin(0.004 * k));
        port.tick(sample_at(0.05 + 1e-4 * draw(-1, 1), 0.101 - depth), 1e-3);
    }
    CHECK(simulation.counters().unstable == 0);
    CHECK(simulation.state(0).displacement.allFinite());
    CHECK(simulation.record().device_N.norm() <= model.options.safety.force_max_N);
}

TEST_CASE("a failed adaptation ends the adaptation and not the session", "[adapt][long]") {
    const TissueModel model = energy_model_example();
    struct Told {
        int lines = 0;
        std::atomic<int> failures{0};
        std::string why;
        bool foreign = false;
    };
    for (bool foreign : {false, true}) {
        Session s(model, stiffer(model, 0.5), 16);
        Told told;
        told.foreign = foreign;
        s.learner.on_line(
            [](const Learner::Line&, const Adaptation&, void* with) {
                auto& t = *static_cast<Told*>(with);
                if (++t.lines < 2) return;
                if (t.foreign) throw 7;
                throw std::bad_alloc();
            },
            &told,
            [](const char* why, void* with) {
                static_cast<Told*>(with)->why = why;
                ++static_cast<Told*>(with)->failures;
            });
        double late_N = 0;
        for (int k = 0; k < 16000; ++k) {
            s.step();
            if (s.learner.readings() > 1)
                for (int wait = 0; wait < 5000 && told.failures == 0; ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            if (told.failures > 0) late_N = std::max(late_N, s.simulation.record().device_N.norm());
        }
        s.learner.stop();
        CHECK(told.failures == 1);
        CHECK(told.lines == 2);
        CHECK(std::string(s.learner.failure()) == told.why);
        CHECK_THAT(told.why, foreign ? Contains("unknown exception") : Contains("bad_alloc"));
        CHECK(s.learner.dropped() == s.learner.readings() - 2);
        CHECK(s.learner.dropped() > 0);
        CHECK(late_N > 0.01);  // the session goes on
        // The model in the session is that of the adaptation.
        for (int k = 0; k < 3000; ++k) s.step();
        CHECK(s.learner.arrived());
        CHECK((s.simulation.energy_model()->stiffness().constants - s.adaptation.energy_model().constants).norm() == 0);
    }
}

TEST_CASE("a session's limits of adaptation override those of a file and are not written to files", "[adapt]") {
    const TemporaryFolder folder;
    const TissueModel model = energy_model_example();
    AdaptOptions sure;
    sure.place_error_m = 0;
    Adaptation patient(model, sure);
    for (const ForceMeasurement& poke : pokes_of(stiffer(model, 0.4), 6, 5)) patient.learn(poke);
    const std::string file = folder.file("patient.h5"), after = folder.file("after.h5");
    write_adapted_model(file, patient, {"test", 1, {}});
    const std::unique_ptr<Adaptation> live = live_adaptation(file);
    CHECK(live->place_error_m() == live_place_error_m);
    CHECK(live->largest() == live_bound);
    // The session adapts as with a place error of 1 mm.
    AdaptOptions unsure;
    unsure.place_error_m = live_place_error_m;
    Adaptation same(model, unsure);
    same.restore(patient.state());
    for (const ForceMeasurement& poke : pokes_of(stiffer(model, 0.4), 3, 9)) {
        live->learn(poke);
        same.learn(poke);
    }
    CHECK(live->state().x == same.state().x);
    CHECK(live->state().P == same.state().P);
    write_adapted_model(after, *live, {"test", 1, {}});
    CHECK(adapted_options(after)->largest == AdaptOptions().largest);
    CHECK(adapted_options(after)->place_error_m == 0);
    // Likewise where the file was not adapted before.
    write_model(folder.file("law.h5"), model, {"test", 1, {}});
    write_adapted_model(after, *live_adaptation(folder.file("law.h5")), {"test", 1, {}});
    CHECK(adapted_options(after)->largest == AdaptOptions().largest);
    // A larger value of the file is kept.
    unsure.place_error_m = 0.004;
    write_adapted_model(file, Adaptation(model, unsure), {"test", 1, {}});
    CHECK(live_adaptation(file)->place_error_m() == 0.004);
}
