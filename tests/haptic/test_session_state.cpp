// Saving, restoring and copying a session, and changes while it runs.
#include <catch2/catch.hpp>

#include <cstring>
#include <thread>

#include "../allocations.h"
#include "../example.h"
#include "../refusal.h"
#include "error.h"
#include "haptic_example.h"

using Catch::Contains;

namespace tissue {
namespace {

struct Kind {
    const char* name;
    TissueModel tissue;
    bool solid = false;
};

std::vector<Kind> kinds() {
    std::vector<Kind> all;
    all.push_back({"linear springs", haptic_example()});
    all.push_back({"springs that turn", haptic_example({"grid8", "geometric"})});
    all.push_back({"law", energy_model_example()});
    all.push_back({"law that relaxes", relaxing(energy_model_example())});
    all.push_back({"law in space", solid_example(), true});
    all.push_back({"law in space that relaxes", relaxing(solid_example()), true});
    return all;
}

HapticOptions sliding() {
    HapticOptions o;
    o.friction.stick = 0.3;
    o.safety.force_max_N = 0.7;  // so that the force limit and the observer act
    return o;
}

/// In and out and along the surface, with an invalid sample now and then.
DeviceSample way(int k, bool solid) {
    const double t = 1e-3 * k, deep = 0.006 * std::sin(3.14 * t);
    DeviceSample sample = solid ? sample_at({0.03 + 0.004 * std::sin(5 * t), 0.03, 0.051 - deep}) : sample_at(0.05 + 0.006 * std::sin(5 * t), 0.101 - deep);
    if (k % 377 == 376) sample.valid = false;
    return sample;
}

double elapsed(int k) { return k % 50 == 7 ? 0.003 : k % 61 == 3 ? 4e-4 : 0; }

/// Forces and other results of these ticks, and the displacements at the end.
std::vector<double> played(Simulation& s, int from, int to, bool solid) {
    std::vector<double> out;
    for (int k = from; k < to; ++k) {
        const Eigen::Vector3d force = s.tick(way(k, solid), elapsed(k));
        out.insert(out.end(), force.data(), force.data() + 3);
        out.push_back(s.record().time_s);
        out.push_back(s.record().facet);
        out.push_back(s.safety().observed_J());
        out.push_back(static_cast<double>(s.record().status));
    }
    for (std::size_t m = 0; m < s.model().meshes.size(); ++m) {
        const NodeColumns& u = s.state(m).displacement;
        out.insert(out.end(), u.data(), u.data() + u.size());
    }
    return out;
}

bool alike(const std::vector<double>& a, const std::vector<double>& b) { return a.size() == b.size() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0; }

HapticOptions alone() {
    HapticOptions o;
    o.heuristic_mesh = false;
    return o;
}

DeviceSample top(double depth_m, double x_m = 0.052) { return sample_at(x_m, 0.1 - depth_m); }

/// Moves the tool to another depth within a fifth of a second and waits until oscillations have decayed.
void press(Simulation& s, double from_m, double to_m, double x_m = 0.052) {
    for (int k = 0; k <= 3000; ++k) s.tick(top(from_m + std::min(1.0, k / 200.0) * (to_m - from_m), x_m));
}

}  // namespace

TEST_CASE("a saved or restored or copied session continues bit for bit", "[state][long]") {
    for (const Kind& kind : kinds()) {
        HapticOptions options = sliding();
        options.stiffest = 2;
        if (kind.tissue.energy_model) options.safety.force_max_N = 0.1;  // the tool has to stay behind the hand
        options.energy_book = std::string(kind.name) == "law that relaxes";
        const HapticModel model(kind.tissue, options);
        Simulation s(model), other(model);
        INFO(kind.name);
        int at = 0;
        for (const int until : {40, 223, 390, 751, 1400}) {
            played(s, at, until, kind.solid);
            at = until;
            const auto learn = [](Simulation& session) {  // during the session
                EnergyModelStiffness stiffer = session.energy_model()->stiffness();
                stiffer.constants *= 1.3;
                stiffer.patch.log_N_m.row(0).array() += 0.1;
                session.energy_model()->become(stiffer);
                session.energy_model_changed();
            };
            if (s.energy_model() && until == 390) learn(s);
            const auto go_on = [&](Simulation& session) {  // where the tool is behind the hand before the model changes
                if (session.energy_model() && until == 223) learn(session);
                return played(session, at, at + 400, kind.solid);
            };
            std::vector<std::byte> state(s.state_size());
            {
                const Allocations none;
                s.save(state.data());
                CHECK(Allocations::count() == 0);
            }
            Simulation copy(s);
            const bool behind = s.held_back();
            if (kind.tissue.energy_model && until == 223) CHECK(behind);
            const std::vector<double> went_on = go_on(s);
            CHECK(alike(went_on, go_on(copy)));
            other.restore(state.data(), state.size());
            CHECK(alike(went_on, go_on(other)));
            CHECK(other.branches().dissipated_J == s.branches().dissipated_J);
            CHECK(other.friction().dissipated_J() == s.friction().dissipated_J());
            s.restore(state.data(), state.size());
            CHECK(alike(went_on, go_on(s)));
            s.restore(state.data(), state.size());
            CHECK(s.state_size() == state.size());
        }
        CHECK(s.friction().dissipated_J() > 0);
        CHECK(s.unarmed() > 0);
    }
}

TEST_CASE("a copy keeps whether a kinetic friction coefficient was given even if it equals the static one", "[state]") {
    for (const bool own : {true, false}) {
        HapticOptions options = alone();
        options.friction.stick = 0.3;
        if (own) options.friction.slip = 0.3;
        const HapticModel model(energy_model_example(), options);
        const Simulation s(model), copy(s);
        CHECK(copy.options().friction.slip == s.options().friction.slip);
        CHECK(copy.friction().options().slip == options.friction.slip);
    }
}

TEST_CASE("bytes that are no state of this session are refused and leave it unchanged", "[state]") {
    const TissueModel tissue = energy_model_example();
    const HapticModel model(tissue, alone());
    HapticOptions finer = alone();
    finer.dt_s = 5e-4;
    const HapticModel other(tissue, finer);
    TissueModel stiffer = tissue;
    stiffer.energy_model->constants *= 1.01;
    const HapticModel third(stiffer, alone());
    TissueModel curved = tissue, curved_otherwise = tissue;  // equal for springs up to 1.5 times their length
    curved.energy_model->curve = SpringCurve::mooney_rivlin(0.1, 2, 0.5, 1.5);
    curved_otherwise.energy_model->curve = SpringCurve::mooney_rivlin(0.1, 2, 0.5, 1.6);
    CHECK(HapticModel(curved, alone()).fingerprint != HapticModel(curved_otherwise, alone()).fingerprint);
    CHECK(HapticModel(curved, alone()).fingerprint == HapticModel(curved, alone()).fingerprint);
    Simulation s(model);
    press(s, -0.002, 0.004);
    std::vector<std::byte> state(s.state_size());
    s.save(state.data());
    Simulation twin(s), of_other(other), of_third(third);
    CHECK_THAT(refusal<MismatchError>([&] { s.restore(state.data(), state.size() - 1); }), Contains("bytes"));
    for (const std::size_t at : {std::size_t(2), std::size_t(40), state.size() - 1}) {
        std::vector<std::byte> damaged = state;
        damaged[at] ^= std::byte{1};
        CHECK_THAT(refusal<MismatchError>([&] { s.restore(damaged.data(), damaged.size()); }), Contains("not the state of a session") || Contains("damaged"));
    }
    CHECK_THAT(refusal<MismatchError>([&] { of_other.restore(state.data(), state.size()); }), Contains("another model"));
    CHECK_THAT(refusal<MismatchError>([&] { of_third.restore(state.data(), state.size()); }), Contains("another model"));
    CHECK(alike(played(s, 0, 200, false), played(twin, 0, 200, false)));
}

TEST_CASE("one model serves sessions in several threads without interaction", "[state]") {
    const HapticModel model(relaxing(energy_model_example()), sliding());
    Simulation lonely(model);
    const std::vector<double> expected = played(lonely, 0, 1200, false);
    std::vector<std::vector<double>> got(4);
    std::vector<std::thread> threads;
    for (std::vector<double>& mine : got)
        threads.emplace_back([&] {
            Simulation s(model);
            mine = played(s, 0, 1200, false);
        });
    for (std::thread& thread : threads) thread.join();
    for (const std::vector<double>& mine : got) CHECK(alike(mine, expected));
    // A model changed in one session is that session's own.
    Simulation learns(model), not_touched(model);
    EnergyModelStiffness stiffer = learns.energy_model()->stiffness();
    stiffer.constants *= 1.3;
    learns.energy_model()->become(stiffer);
    CHECK(alike(played(not_touched, 0, 1200, false), expected));
    CHECK_FALSE(alike(played(learns, 0, 1200, false), expected));
}

TEST_CASE("offset and rotation and force scale and friction change during a session", "[state]") {
    const HapticModel model(energy_model_example(), alone());
    Simulation s(model);
    press(s, -0.002, 0.004);
    const double force_N = s.record().coupling_N.norm();
    REQUIRE(force_N > 0.2);
    HapticOptions o = s.options();

    // A quarter turn of the device that leaves the tool in place: the force on the hand turns, that on the tissue does
    // not.
    const Eigen::Vector3d before_N = s.record().device_N, device_m = s.record().device_m;
    o.map.rotation_rad = Eigen::Vector3d(0, 0, 1.5707963267948966);
    o.map.offset_m = Point(s.record().master_m) - Point(Eigen::Vector2d(-device_m.y(), device_m.x()));
    s.change(o);
    DeviceSample sample;
    sample.position_m = device_m;
    for (int k = 0; k < 300; ++k) s.tick(sample);
    CHECK(s.record().status == TickStatus::done);
    CHECK(s.record().coupling_N.norm() == Approx(force_N).epsilon(1e-3));
    CHECK((s.record().device_N - Eigen::Vector3d(before_N.y(), -before_N.x(), 0)).norm() < 1e-3 * force_N);
    CHECK(s.options().map.to_tissue(s.options().map.to_device(s.record().master_m)).isApprox(s.record().master_m));

    // Twice the force.
    o = s.options();
    o.map.force_scale = 2;
    s.change(o);
    for (int k = 0; k < 100; ++k) s.tick(sample);
    CHECK(s.record().device_N.norm() == Approx(2 * force_N).epsilon(1e-3));

    // Refused changes change nothing.
    for (int which = 0; which < 4; ++which) {
        HapticOptions wrong = s.options();
        if (which == 0) wrong.map.scale = -1;
        if (which == 1) wrong.map.rotation_rad = Eigen::Vector2d(0, 1);
        if (which == 2) wrong.friction.stick = -1;
        if (which == 3) wrong.device.mass_kg = 1e-4;
        CHECK_THROWS_AS(s.change(wrong), MismatchError);
        CHECK(s.options().map.force_scale == 2);
        CHECK(s.options().map.scale == 1);
        CHECK(s.options().device.mass_kg == 0);
    }

    // With friction the tool slips.
    const double x = s.record().master_m.x();
    o = s.options();
    o.friction.stick = 0.2;
    s.change(o);
    const auto at = [&](const Point& tool_m) {
        sample.position_m = s.options().map.to_device(tool_m);
        return sample;
    };
    const double y = s.record().master_m.y();
    for (int k = 0; k < 300; ++k) s.tick(at(Eigen::Vector2d(x + 2e-5 * k, y)));
    CHECK(s.friction().dissipated_J() > 0);

    // After a jump of the tool it is not armed.
    o = s.options();
    o.map.offset_m.y() -= 0.01;
    s.change(o);
    CHECK(s.tick(sample).norm() == 0);
    CHECK(s.record().status == TickStatus::not_armed);
    CHECK(s.safety().counters().jump == 0);
}

TEST_CASE("with the clutch on the hand moves without force and the tool stays", "[state]") {
    for (const Kind& kind : kinds()) {
        if (kind.solid) continue;
        const HapticModel model(kind.tissue, alone());
        Simulation s(model);
        press(s, -0.002, 0.004);
        const double force_N = s.record().coupling_N.norm();
        REQUIRE(force_N > 1e-3);
        s.clutch(true);
        DeviceSample sample = top(0.004);
        for (int k = 0; k < 500; ++k) {
            sample.position_m += Eigen::Vector3d(1e-4, 5e-5, 2e-4);
            const Eigen::Vector3d force = s.tick(sample);
            if (k > 20) REQUIRE(force.norm() == 0);
            REQUIRE(s.record().status == TickStatus::done);
            REQUIRE((s.record().master_m - Eigen::Vector2d(0.052, 0.096)).norm() < 1e-12);
        }
        s.clutch(false);
        double change_N = 0;
        for (int k = 0; k < 200; ++k) {
            const Eigen::Vector3d before = s.record().device_N;
            change_N = std::max(change_N, (s.tick(sample) - before).norm());
        }
        INFO(kind.name);
        CHECK(change_N <= model.options.safety.slew_N_s * 1e-3 * (1 + 1e-9));
        CHECK(s.record().device_N.norm() == Approx(std::string(kind.name) == "law that relaxes" ? s.record().coupling_N.norm() : force_N).epsilon(0.01));
        // The tool continues from its place.
        sample.position_m.y() -= 1e-3;
        s.tick(sample);
        CHECK((s.record().master_m - Eigen::Vector2d(0.052, 0.095)).norm() < 1e-9);
    }
}

TEST_CASE("a session of another model takes over without a jump of force", "[state][long]") {
    TissueModel soft = energy_model_example(), stiff = soft, coarse = energy_model_example(make_lattice("grid8", 8, 8, 0.1, 0.1));
    stiff.energy_model->constants *= 1.5;
    const TissueModel after[] = {stiff, coarse, relaxing(soft), haptic_example()};
    for (const TissueModel& tissue : after) {
        const HapticModel model(soft, alone()), next_model(tissue, alone());
        Simulation s(model), fresh(next_model);
        press(s, -0.002, 0.004);
        Simulation next(next_model);
        next.follow(s);
        next.take_over(s);
        CHECK(next.record().time_s == s.record().time_s);
        CHECK(next.counters().ticks == s.counters().ticks);
        CHECK(next.safety().counters().energy_given_J == s.safety().counters().energy_given_J);
        Eigen::Vector3d last = s.record().device_N;
        double change_N = 0;
        for (int k = 0; k < 3000; ++k) {
            const Eigen::Vector3d force = next.tick(top(0.004));
            REQUIRE(next.record().status == TickStatus::done);
            if (k == 0) CHECK((force - last).norm() < 1e-9);
            change_N = std::max(change_N, (force - last).norm());
            last = force;
        }
        press(fresh, -0.002, 0.004);
        CHECK(change_N < 0.02 * std::max(s.record().device_N.norm(), fresh.record().device_N.norm()));
        // then the time of the contact matters
        const bool relaxes = tissue.energy_model && !tissue.energy_model->relaxation.empty();
        CHECK(last.norm() == Approx(fresh.record().device_N.norm()).epsilon(relaxes ? 0.05 : 0.005));
    }
    // Refused: another number of axes, and tissue too stiff for the device.
    const HapticModel plane(soft, alone()), space(solid_example(), alone());
    Simulation s(plane), in_space(space);
    CHECK_THROWS_AS(in_space.follow(s), MismatchError);
    HapticOptions light = s.options();
    light.device.stiffness_N_m = 1.01 * plane.meshes[0]->static_N_m;
    s.change(light);
    const HapticModel harder(stiff, alone());
    Simulation refuses(harder);
    CHECK_THAT(refusal<MismatchError>([&] { refuses.follow(s); }), Contains("the device can render"));
    // Stopped after follow(): no force until the tool has been outside.
    Simulation stopped(plane), follower(plane);
    press(stopped, -0.002, 0.004);
    follower.follow(stopped);
    DeviceSample stale = top(0.004);
    stale.age_s = 1;
    CHECK(stopped.tick(stale).isZero(0));
    follower.take_over(stopped);
    for (int k = 0; k < 500; ++k) {
        CHECK(follower.tick(top(0.004)).isZero(0));
        CHECK(follower.record().status == TickStatus::not_armed);
    }
    for (int k = 0; k < 20; ++k) follower.tick(top(-0.01));
    CHECK(follower.record().status == TickStatus::done);
    // A force scale that has grown since follow() beyond what the device can show of the other tissue.
    HapticOptions few = s.options(), more = few;
    few.device.stiffness_N_m = more.device.stiffness_N_m = 2.5 * plane.meshes[0]->static_N_m;
    more.map.force_scale = 2;
    Simulation grows(plane), other(harder);
    grows.change(few);
    other.follow(grows);
    other.check_take_over(grows);
    grows.change(more);
    CHECK_THAT(refusal<MismatchError>([&] { other.check_take_over(grows); }), Contains("the device can render"));
    CHECK_THROWS_AS(in_space.check_take_over(grows), MismatchError);
    // The device's limits and impedance are taken over, whatever the other model was opened with, and are part of the
    // state.
    HapticOptions weak = alone();
    weak.safety.force_max_N = 0.1;
    weak.safety.slew_N_s = 50;
    weak.safety.hold_s = 0.05;
    const HapticModel limited(soft, weak);
    Simulation leads(limited), takes(harder);
    press(leads, -0.002, 0.004);
    takes.follow(leads);
    HapticOptions known = leads.options();
    known.device.mass_kg = 10;
    known.map.force_scale = 1.5;  // more than `takes` began with
    leads.change(known);
    {
        const Allocations none;
        takes.check_take_over(leads);
        takes.take_over(leads);
        CHECK(Allocations::count() == 0);
    }
    CHECK(takes.options().device.mass_kg == 10);
    CHECK(takes.options().safety.slew_N_s == 50);
    CHECK(takes.options().safety.hold_s == 0.05);
    CHECK(takes.safety().bound_J() == leads.safety().bound_J());
    const Simulation copied(takes);
    CHECK(copied.options().safety.force_max_N == 0.1);
    CHECK(copied.safety().bound_J() == leads.safety().bound_J());
    double largest_N = 0;
    for (int k = 0; k < 1000; ++k) largest_N = std::max(largest_N, takes.tick(top(0.006), 0.015).norm());
    CHECK(largest_N == Approx(0.1).epsilon(1e-3));
    CHECK(takes.safety().counters().late == 0);  // with the hold that was taken over
    HapticOptions slow = alone();
    slow.safety.hold_s = 1;
    slow.dt_s = 0.02;
    const HapticModel of_slow(stiff, slow);
    Simulation too_slow(of_slow);
    CHECK_THAT(refusal<MismatchError>([&] { too_slow.check_take_over(s); }), Contains("dt is 0.02 s"));
    // A tool outside: only the tissue changes.
    Simulation outside(plane), next(harder);
    for (int k = 0; k < 20; ++k) outside.tick(top(-0.01));
    next.follow(outside);
    next.take_over(outside);
    for (int k = 0; k < 300; ++k) next.tick(top(-0.01 + 5e-5 * k));
    CHECK(next.record().device_N.norm() > 0.1);
}

TEST_CASE("a take-over during slip continues without a jump of force", "[state]") {
    HapticOptions o = alone();
    o.friction.stick = 0.2;
    const HapticModel model(energy_model_example(), o);
    Simulation plays(model);
    press(plays, -0.002, 0.004, 0.04);
    double x_m = 0.04;
    const auto along = [&](Simulation& s) { return s.tick(top(0.004, x_m)); };
    double usual_N = 0;
    Eigen::Vector3d last = plays.record().device_N;
    const auto play = [&](int ticks) {
        for (int k = 0; k < ticks; ++k) {
            x_m += 2e-5;
            const Eigen::Vector3d force = along(plays);
            usual_N = std::max(usual_N, (force - last).norm());
            last = force;
        }
    };
    play(200);
    const Simulation copy(plays);
    Simulation next(model);
    next.follow(copy);
    play(100);
    REQUIRE(plays.record().slipping);
    next.check_take_over(plays);
    next.take_over(plays);
    for (int k = 0; k < 300; ++k) {
        x_m += 2e-5;
        const Eigen::Vector3d force = along(next);
        INFO("tick " << k << " after the take-over");
        CHECK((force - last).norm() < std::max(2 * usual_N, 0.02 * last.norm()));
        last = force;
    }
}

TEST_CASE("after a take-over the force on a moving hand stays within a quarter of the peak of the original session's", "[state]") {
    // deeper, or out; with little friction the contact always slips
    for (const auto& [to_m, mu] : {std::pair{0.008, 1.0}, {-0.002, 1.0}, {0.008, 0.0}, {-0.002, 0.0}, {-0.002, 0.02}}) {
        HapticOptions o = alone();
        o.friction.stick = mu;
        const HapticModel model(energy_model_example(), o);
        Simulation plays(model);
        press(plays, -0.002, 0.004, 0.04);
        Simulation next(model);
        next.follow(plays);
        next.take_over(plays);
        double most_N = 0, off_N = 0;
        for (int k = 1; k <= 250; ++k) {
            const double part = std::min(1.0, k / 200.0), depth_m = 0.004 + (to_m - 0.004) * part * part * part * (10 - 15 * part + 6 * part * part);
            const Eigen::Vector3d usual_N = plays.tick(top(depth_m, 0.04)), force_N = next.tick(top(depth_m, 0.04));
            INFO("tick " << k << " at " << depth_m << " m: " << force_N.transpose() << " N, of the original session " << usual_N.transpose());
            most_N = std::max(most_N, usual_N.norm());
            off_N = std::max(off_N, (force_N - usual_N).norm());
        }
        INFO("to " << to_m << " m, mu " << mu << ": off by " << off_N << " N of " << most_N);
        CHECK(off_N < 0.25 * most_N);
    }
}

TEST_CASE("a take-over is refused when a contact has begun since follow()", "[state]") {
    const HapticModel model(energy_model_example(), alone());
    Simulation plays(model);
    for (int k = 0; k < 20; ++k) plays.tick(top(-0.01));
    Simulation early(model), beside(model), still(model);
    early.follow(Simulation(plays));
    press(plays, -0.002, 0.004);
    CHECK_THAT(refusal<MismatchError>([&] { early.check_take_over(plays); }), Contains("has made a new contact since follow()"));
    beside.follow(Simulation(plays));
    still.follow(Simulation(plays));
    beside.check_take_over(plays);
    for (int k = 0; k <= 400; ++k) plays.tick(top(0.004 - 3e-5 * k));
    still.check_take_over(plays);  // outside: no contact to take over
    press(plays, -0.008, 0.004, 0.03);
    CHECK_THAT(refusal<MismatchError>([&] { beside.check_take_over(plays); }), Contains("has made a new contact since follow()"));
    // After a take-over in between it is the same contact; a restored one is another.
    Simulation first(model), second(model), third(model);
    first.follow(Simulation(plays)), second.follow(Simulation(plays)), third.follow(Simulation(plays));
    first.take_over(plays);
    first.tick(top(0.004, 0.03));
    second.check_take_over(first);
    std::vector<std::byte> state(plays.state_size());
    plays.save(state.data());
    plays.restore(state.data(), state.size());
    CHECK_THROWS_AS(third.check_take_over(plays), MismatchError);
}

TEST_CASE("energies of Maxwell branches are zero unless a session keeps an energy log", "[state]") {
    for (const bool kept : {false, true}) {
        HapticOptions o = alone();
        o.energy_book = kept;
        const HapticModel model(relaxing(energy_model_example()), o);
        Simulation s(model);
        press(s, -0.002, 0.004);
        CHECK((s.branches().stored_J > 0) == kept);
        CHECK((s.branches().dissipated_J > 0) == kept);
    }
}

TEST_CASE("a state restored into a session that has ticked changes no limits and does not unlock them", "[state]") {
    HapticOptions weak = alone();
    weak.safety.force_max_N = 0.5;
    const HapticModel model(energy_model_example(), weak);
    Simulation s(model);
    std::vector<std::byte> unticked(s.state_size());
    s.save(unticked.data());
    CHECK_FALSE(s.has_begun());
    for (int k = 0; k < 20; ++k) s.tick(top(-0.01));
    s.restore(unticked.data(), unticked.size());
    CHECK(s.has_begun());
    HapticOptions strong = s.options();
    strong.safety.force_max_N = 3;
    s.change(strong);
    CHECK(s.options().safety.force_max_N == 0.5);
    CHECK(Simulation(s).has_begun());
    CHECK_THROWS_AS(s.follow(Simulation(model)), MismatchError);
}

TEST_CASE("positions that come every 10 ticks and state their age raise no fault and give nearly the same force", "[state]") {
    const HapticModel model(energy_model_example(), alone());
    const auto led = [](double time_s) {
        const double s = std::clamp(time_s / 0.4, 0.0, 1.0), t = std::clamp((time_s - 0.6) / 0.05, 0.0, 1.0);
        return top(-0.004 + 0.008 * s * s * (3 - 2 * s) - 0.04 * t);  // in smoothly, and out at 0.8 m/s
    };
    struct Heard {
        std::vector<double> force_N;
        long long faults = 0, damped_before = 0;
        double given_before_J = 0;  ///< before the hand moves out
    };
    const auto felt = [&](int each, bool says_age) {
        Simulation s(model);
        Heard heard;
        DeviceSample sample;
        for (int k = 0; k < 700; ++k) {
            if (k % each == 0) sample = led(1e-3 * k), sample.age_s = 0;
            heard.force_N.push_back(s.tick(sample).norm());
            heard.faults += s.record().fault();
            if (k == 590) heard.damped_before = s.safety().counters().damped, heard.given_before_J = s.safety().counters().energy_given_J;
            if (says_age) sample.age_s += 1e-3;
        }
        return heard;
    };
    const Heard usual = felt(1, true), slow = felt(10, true), none = felt(10, false);
    CHECK(usual.faults == 0);
    CHECK(slow.faults == 0);
    CHECK(none.faults > 0);  // a jump of 8 mm in a tick
    double off_N = 0, most_N = 0;
    for (std::size_t k = 0; k < 590; ++k) {
        off_N = std::max(off_N, std::abs(usual.force_N[k] - slow.force_N[k]));
        most_N = std::max(most_N, usual.force_N[k]);
    }
    CHECK(off_N < 0.06 * most_N);  // the hand's position in 10 ms is extrapolated
    CHECK(slow.force_N[590] == Approx(usual.force_N[590]).epsilon(0.005));
    CHECK(slow.damped_before == usual.damped_before);
    CHECK(slow.given_before_J == Approx(usual.given_before_J).epsilon(0.03));
}

}  // namespace tissue
