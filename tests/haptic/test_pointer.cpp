#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "../example.h"
#include "../refusal.h"
#include "../wait_for.h"
#include "error.h"
#include "haptic/target_tissue.h"
#include "haptic/latest.h"
#include "haptic/pointer_device.h"
#include "haptic/realtime_loop.h"
#include "haptic/recorder.h"
#include "haptic/state_channel.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

constexpr double safe = 2;  // SafetyOptions::speed_max_m_s

/// A value in which a torn read is detected.
struct Pair {
    long long a = 0, b[40] = {};
};

}  // namespace

TEST_CASE("the newest value passes between two threads complete and in order", "[pointer]") {
    Latest<Pair> latest;
    CHECK_FALSE(latest.fetch());
    latest.back().a = 7;
    latest.publish();
    CHECK(latest.fetch());
    CHECK(latest.front().a == 7);
    CHECK_FALSE(latest.fetch());
    CHECK(latest.front().a == 7);
    for (int k = 0; k < 5; ++k) {   // the reader's copy does not change
        CHECK(&latest.back() != &latest.front());
        latest.back().a = 8 + k;
        latest.publish();
        CHECK(latest.front().a == 7);
    }
    CHECK(latest.fetch());
    CHECK(latest.front().a == 12);

    constexpr long long last = 300000;
    std::atomic<bool> torn{false}, backwards{false};
    Latest<Pair> shared;
    std::thread reader([&] {
        long long before = 0;
        while (before < last) {
            if (!shared.fetch()) continue;
            const Pair& pair = shared.front();
            for (long long b : pair.b)
                if (b != pair.a) torn = true;
            if (pair.a <= before) backwards = true;
            before = pair.a;
        }
    });
    for (long long k = 1; k <= last; ++k) {
        Pair& pair = shared.back();
        pair.a = k;
        for (long long& b : pair.b) b = k;
        shared.publish();
    }
    reader.join();
    CHECK_FALSE(torn.load());
    CHECK_FALSE(backwards.load());
}

TEST_CASE("a pointer with 60 random targets per second raises no fault and moves smoothly", "[pointer]") {
    DeviceMap map;
    map.fit(2);
    map.scale = 0.5;  // 2 mm of the device per millimetre of tissue: the limit is that of the device
    PointerDevice pointer(Eigen::Vector2d(0.05, 0.12), map, safe);
    Safety safety{SafetyOptions{}};
    Draw draw(3);
    Eigen::Vector3d before = pointer.read(0).position_m, step_before = Eigen::Vector3d::Zero();
    CHECK((map.to_tissue(before) - Eigen::Vector2d(0.05, 0.12)).norm() < 1e-15);
    double fastest = 0, hardest = 0;
    for (int k = 1; k < 20000; ++k) {
        // anywhere: up to half a metre per frame
        if (k % 17 == 0) pointer.aim(Eigen::Vector2d(draw(-0.1, 0.3), draw(-0.1, 0.2)));
        const DeviceSample sample = pointer.read(k * 1e-3);
        REQUIRE(safety.admit(sample, 1e-3));
        const Eigen::Vector3d step = sample.position_m - before;
        fastest = std::max(fastest, step.norm() / 1e-3);
        hardest = std::max(hardest, (step - step_before).norm());
        before = sample.position_m;
        step_before = step;
    }
    CHECK(fastest <= 0.9 * safe * (1 + 1e-9));
    CHECK(fastest > 0.5 * safe);
    CHECK(hardest < 2.2 * fastest * 1e-3);   // no jump: at most the direction reverses
    CHECK(safety.counters().jump == 0);
}

TEST_CASE("a pointer reaches its target without overshoot for any number of missed ticks", "[pointer]") {
    for (int every : {1, 3, 50}) {
        PointerDevice pointer(Eigen::Vector2d(0, 0), {}, safe);
        pointer.aim(Eigen::Vector2d(0.03, 0));
        double x = 0;
        for (int k = 0; k < 1500; k += every) {
            const double now = pointer.read(k * 1e-3).position_m.x();
            CHECK(now >= x - 1e-15);
            CHECK(now <= 0.03 + 1e-12);
            x = now;
        }
        CHECK(x == Approx(0.03).epsilon(1e-3));
    }
}

TEST_CASE("a pointer continues from its place after a pause and after a restart of the clock", "[pointer]") {
    PointerDevice pointer(Eigen::Vector2d(0, 0), {}, safe);
    pointer.aim(Eigen::Vector2d(1, 0));
    Eigen::Vector3d at = pointer.read(0).position_m;
    for (int k = 1; k < 100; ++k) at = pointer.read(k * 1e-3).position_m;
    const Eigen::Vector3d after = pointer.read(60).position_m;   // a minute later
    CHECK((after - at).norm() < 0.9 * safe * 0.011);
    const Eigen::Vector3d again = pointer.read(0).position_m;    // another loop
    CHECK(again == after);
    CHECK(pointer.read(1e-3).position_m.x() > again.x());
}

TEST_CASE("a pointer ignores and counts targets that are not finite and invalid limits are refused", "[pointer]") {
    PointerDevice pointer(Eigen::Vector2d(0.01, 0.02), {}, safe);
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    pointer.aim(Eigen::Vector2d(nan, 0));
    pointer.aim(Eigen::Vector2d(0, inf));
    for (int k = 0; k < 100; ++k) REQUIRE(pointer.read(k * 1e-3).position_m == Eigen::Vector3d(0.01, 0.02, 0));
    CHECK(pointer.statistics() == std::vector<std::pair<std::string, double>>{{"targets", 0}, {"refused_targets", 2}});
    refusal<MismatchError>([] { PointerDevice(Eigen::Vector2d(0, 0), {}, 0); });
    refusal<MismatchError>([] { PointerDevice(Eigen::Vector2d(0, 0), {}, safe, {1, 0}); });
    refusal<MismatchError>([&] { PointerDevice(Eigen::Vector2d(nan, 0), {}, safe); });
}

TEST_CASE("a very distant target gives a direction of motion and the pointer returns from it", "[pointer]") {
    for (double far : {1e9, 1e300, 1.7e308}) {
        PointerDevice pointer(Eigen::Vector2d(0.01, 0.02), {}, safe);
        pointer.aim(Eigen::Vector2d(far, -far));
        Eigen::Vector3d before = pointer.read(0).position_m;
        for (int k = 1; k < 300; ++k) {
            const Eigen::Vector3d now = pointer.read(k * 1e-3).position_m;
            REQUIRE(now.allFinite());
            REQUIRE((now - before).norm() <= 0.9 * safe * 1e-3 * (1 + 1e-9));
            before = now;
        }
        CHECK(before.x() - 0.01 == Approx(0.02 - before.y()));
        CHECK(before.x() > 0.1);
        pointer.aim(Eigen::Vector2d(0.01, 0.02));
        for (int k = 300; k < 1500; ++k) before = pointer.read(k * 1e-3).position_m;
        CHECK((before - Eigen::Vector3d(0.01, 0.02, 0)).norm() < 1e-6);
    }
}

TEST_CASE("the state channel passes one state every 10 ticks with the values of the simulation", "[pointer]") {
    HapticOptions o;
    o.place_m = 0.2;
    const HapticModel model(haptic_example(), o);
    Simulation s(model);
    StateChannel channel(model, 10, 1000);
    int states = 0;
    for (int k = 0; k < 600; ++k) {
        s.tick(sample_at(0.047, 0.102 - 0.00002 * k));
        TickStatistics books;
        books.ticks = k + 1;
        books.tick_us = k;
        channel.after(s, books);
        if (!channel.fetch()) continue;
        ++states;
        CHECK(channel.state().books.ticks == k + 1);
    }
    CHECK(states == 60);
    const TickState& state = channel.state();
    REQUIRE(state.record.mesh == 0);
    // the simulation has ticked since
    CHECK((state.contact_displacement_m[0] - s.record().contact_displacement_m).norm() < 2e-4);
    CHECK(state.contact_displacement_m[0].norm() > 1e-3);
    CHECK(state.contact_displacement_m[1].norm() > 1e-4);
    REQUIRE(state.nodes_m.size() == 2 * 2 * 121);
    const auto node = [&](int mesh, int n) { return Eigen::Vector2d(state.nodes_m[static_cast<std::size_t>(2 * (121 * mesh + n))],
                                                                    state.nodes_m[static_cast<std::size_t>(2 * (121 * mesh + n) + 1)]); };
    for (int mesh : {0, 1})
        for (int n : {0, 17, 60, 120}) {
            const auto& springs = model.meshes[static_cast<std::size_t>(mesh)]->springs;
            const Eigen::Vector2d expected = Eigen::Vector2d(mesh * 0.2, 0) + (springs.rest().row(n) + s.state(static_cast<std::size_t>(mesh)).displacement.row(n)).transpose();
            CHECK((node(mesh, n) - expected).norm() < 2e-4);
        }
    double us = -1;
    for (int k = 0; k < 600; ++k) REQUIRE((channel.pop_time(us) && us == k));
    CHECK_FALSE(channel.pop_time(us));
}

TEST_CASE("a paused session has no motion and no force and its contact continues afterwards without a fault", "[pointer]") {
    const TemporaryFolder folder;
    const HapticModel model(haptic_example(), {});
    Simulation s(model);
    PointerDevice pointer(Eigen::Vector2d(0.05, 0.11), model.options.map, safe);
    StateChannel channel(model, 5);
    Recorder recorder(folder.file("s.h5"), 2, {"test", 1, {}});
    pointer.aim(Eigen::Vector2d(0.05, 0.092));
    std::atomic<bool> stop{false};
    LoopOptions loop;
    loop.seconds = 0;
    loop.stop = &stop;
    loop.realtime = false;
    loop.hooks = {&channel, &recorder};
    LoopReport report;
    std::thread ticks([&] { report = run_loop(s, pointer, loop); });
    const auto next = [&](const auto& wanted) {
        return wait_for([&] { return channel.fetch() && wanted(channel.state()); });
    };
    CHECK(next([](const TickState& t) { return t.record.mesh == 0 && t.record.device_N.norm() > 1e-4 && t.books.ticks > 300; }));
    channel.pause(true);
    CHECK(next([](const TickState& t) { return t.books.left_out; }));
    const TickState held = channel.state();
    CHECK(held.record.device_N.norm() == 0);
    pointer.aim(Eigen::Vector2d(0.05, 0.2));
    for (int states = 0; states < 10; ++states) CHECK(next([](const TickState& t) { return t.books.left_out; }));
    CHECK(channel.state().books.time_s == held.books.time_s);
    CHECK(channel.state().nodes_m == held.nodes_m);
    CHECK(channel.state().books.ticks == held.books.ticks);
    pointer.aim(Eigen::Vector2d(0.05, 0.092));
    channel.pause(false);
    CHECK(next([&](const TickState& t) { return !t.books.left_out && t.record.mesh == 0 && t.books.ticks > held.books.ticks + 100; }));
    channel.reset();
    CHECK(next([&](const TickState& t) { return t.record.mesh == -1; }));  // inside the tissue, and not armed
    CHECK(channel.state().safety.jump + channel.state().safety.bad_input == 0);
    stop.store(true);
    ticks.join();
    recorder.close(s);
    CHECK(Hdf5Reader(folder.file("s.h5"), "recording").vector("/time").size() == report.ticks);
}

TEST_CASE("a pointer with a new target during a pause continues from its place with and without a target tissue", "[pointer]") {
    const TissueModel tissue = haptic_example();
    const HapticModel model(tissue, {});
    for (const bool hidden : {false, true}) {
        INFO(hidden);
        auto made = std::make_unique<PointerDevice>(Eigen::Vector2d(0.05, 0.11), model.options.map, safe);
        PointerDevice& pointer = *made;
        std::unique_ptr<Device> device = std::move(made);
        if (hidden) device = std::make_unique<TargetTissue>(std::move(device), tissue, HapticOptions{});
        Eigen::Vector3d last_m;
        long k = 0;
        for (; k < 500; ++k) last_m = device->read(1e-3 * static_cast<double>(k)).position_m;
        pointer.aim(Eigen::Vector2d(0.05, 0.05));
        for (; k < 3500; ++k) device->skip_tick(1e-3 * static_cast<double>(k));
        double farthest_m = 0;
        for (; k < 4500; ++k) {
            const Eigen::Vector3d now_m = device->read(1e-3 * static_cast<double>(k)).position_m;
            if (k == 3500) CHECK((now_m - last_m).norm() < 5e-4);  // 6 mm if the pause were one step
            farthest_m = std::max(farthest_m, (now_m - last_m).norm());
            last_m = now_m;
        }
        CHECK(farthest_m <= 1.0001e-3);  // the pointer's own speed
        CHECK((last_m - Eigen::Vector3d(0.05, 0.05, 0)).norm() < 1e-6);
    }
}
