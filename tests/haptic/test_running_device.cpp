#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>

#include "../allocations.h"
#include "error.h"
#include "haptic/device_error.h"
#include "haptic/realtime_loop.h"
#include "haptic/running_device.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

enum class Fails { never, before_it_takes, after_it_took };

/// Motors that are on from some point in start() until stop(), and hold the last force written.
class Motors final : public Device {
   public:
    explicit Motors(Fails fails = Fails::never) : fails_(fails) {}
    std::string name() const override { return "motors"; }
    void start() override {
        if (fails_ == Fails::before_it_takes) throw DeviceError("no device");
        on = true;
        force_N = {1, 0, 0};  // force before the session
        if (fails_ == Fails::after_it_took) throw DeviceError("no servo");
    }
    DeviceSample read(double) noexcept override {
        return sample_at(0.05, 0.104 - 5e-5 * ++reads);  // deeper in each tick
    }
    void write(const Eigen::Vector3d& f) noexcept override {
        force_N = f;
        largest_N = std::max(largest_N, f.norm());
    }
    void stop() noexcept override {
        stopped_at_N = force_N.norm();
        if (beside) beside_N = beside->force_N.norm();
        on = false;
        ++stops;
    }
    bool at_rest() const { return !on && force_N.isZero(0) && stops == 1 && stopped_at_N == 0; }

    const Motors* beside = nullptr;  ///< the device whose force is recorded when this one is stopped
    double beside_N = -1;
    bool on = false;
    int reads = 0, stops = 0;
    double largest_N = 0, stopped_at_N = -1;
    Eigen::Vector3d force_N{0, 0, 0};

   private:
    Fails fails_;
};

/// A hook that throws before or after a given tick. foreign: what it throws is not a std::exception.
class Bomb final : public TickHook {
   public:
    Bomb(int at, bool early, bool foreign = false) : at_(at), early_(early), foreign_(foreign) {}
    bool before(Simulation&) override {
        if (early_ && ++ticks_ == at_) go_off();
        return true;
    }
    void after(const Simulation&, const TickStatistics&) override {
        if (!early_ && ++ticks_ == at_) go_off();
    }

   private:
    void go_off() const {
        if (foreign_) throw 42;
        throw std::runtime_error("a hook has failed");
    }
    int at_, ticks_ = 0;
    bool early_, foreign_;
};

/// clock: whether the ticks wait for their time.
LoopOptions short_loop(bool clock = false) {
    LoopOptions o;
    o.seconds = 0.3;
    o.realtime = false;
    o.clock = clock;
    return o;
}

}  // namespace

TEST_CASE("a device whose start() fails is stopped with zero force", "[device]") {
    for (Fails fails : {Fails::before_it_takes, Fails::after_it_took}) {
        Motors device(fails);
        CHECK_THROWS_AS(RunningDevice(device), DeviceError);
        CHECK(device.at_rest());
    }
    Motors device;
    {
        const RunningDevice running(device);
        CHECK(device.on);
        device.write({2, 0, 0});
    }
    CHECK(device.at_rest());
}

TEST_CASE("a session that is stopped before its first tick does not start the device", "[device][loop]") {
    const HapticModel model(haptic_example(), {});
    Simulation simulation(model);
    Motors device;
    const std::atomic<bool> stop{true};
    LoopOptions o = short_loop();
    o.stop = &stop;
    CHECK(run_loop(simulation, device, o).ticks == 0);
    CHECK((device.reads == 0 && device.stops == 0 && device.force_N.isZero(0)));
}

TEST_CASE("an exception of any kind in a session leaves the device stopped with zero force", "[device][loop]") {
    const HapticModel model(haptic_example(), {});
    for (Fails fails : {Fails::before_it_takes, Fails::after_it_took}) {
        Simulation simulation(model);
        Motors device(fails);
        CHECK_THROWS_AS(run_loop(simulation, device, short_loop()), DeviceError);
        CHECK(device.at_rest());
        CHECK(device.reads == 0);
    }
    for (bool early : {true, false})
        for (bool foreign : {true, false})
            for (int at : {1, 200}) {
                Simulation simulation(model);
                Motors device;
                Bomb bomb(at, early, foreign);
                LoopOptions o = short_loop();
                o.seconds = 0;  // until the hook throws
                o.hooks = {&bomb};
                if (foreign) CHECK_THROWS_AS(run_loop(simulation, device, o), int);
                else CHECK_THROWS_WITH(run_loop(simulation, device, o), "a hook has failed");
                CHECK(device.at_rest());
                if (at == 200) CHECK(device.largest_N > 0);
            }
}

TEST_CASE("with two devices no force is left on either after a failed start or an exception or a normal end", "[device][loop][two]") {
    HapticOptions two;
    two.tools = 2;
    two.heuristic_mesh = false;
    const HapticModel model(energy_model_example(), two);
    Simulation simulation(model);
    const auto both = [](Motors& a, Motors& b) { return std::vector<Device*>{&a, &b}; };
    for (const bool first : {false, true})
        for (const Fails fails : {Fails::before_it_takes, Fails::after_it_took}) {
            Motors good, bad(fails);
            CHECK_THROWS_AS(run_loop(simulation, first ? both(bad, good) : both(good, bad), short_loop()), DeviceError);
            CHECK(bad.at_rest());
            if (first) CHECK((!good.on && good.stops == 0 && good.force_N.isZero(0)));
            else CHECK(good.at_rest());
        }
    {
        Motors a, b;
        LoopOptions o = short_loop();
        Bomb hook(20, false);
        o.hooks = {&hook};
        CHECK_THROWS_WITH(run_loop(simulation, both(a, b), o), "a hook has failed");
        CHECK((a.at_rest() && b.at_rest()));
    }
    {
        Motors a, b;
        a.beside = &b, b.beside = &a;
        CHECK(run_loop(simulation, both(a, b), short_loop()).ticks == 300);
        CHECK((a.at_rest() && b.at_rest()));
        CHECK((a.beside_N == 0 && b.beside_N == 0));  // neither had a force when the first was stopped
        CHECK_THROWS_AS(run_loop(simulation, a, short_loop()), MismatchError);
        const HapticModel one(energy_model_example(), {});
        Simulation alone(one);
        CHECK_THROWS_AS(run_loop(alone, both(a, b), short_loop()), MismatchError);
    }
}

TEST_CASE("an allocation failure at any point of the loop's set-up leaves no force", "[device][loop]") {
    if (!Allocations::seen()) return;
    const HapticModel model(haptic_example(), {});
    Simulation simulation(model);
    LoopOptions o = short_loop(true);
    o.seconds = 0.003;
    o.realtime = true;  // which allocates
    int failed = 0;
    for (int nth = 0; nth < 100; ++nth) {
        Motors device;
        bool threw = false;
        {
            const Allocations hook(nth);
            try {
                run_loop(simulation, device, o);
            } catch (const std::bad_alloc&) {
                threw = true;
            }
        }
        REQUIRE(device.at_rest());
        if (!threw) break;
        ++failed;
    }
    CHECK(failed > 0);
}

TEST_CASE("a tick that starts late gets its true period and a hand at 0.5 m/s is no fault", "[loop]") {
    /// Position of a hand by wall-clock time.
    class Hand final : public Device {
       public:
        std::string name() const override { return "hand"; }
        DeviceSample read(double) noexcept override {
            const double t = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
            return sample_at(-0.1 - 0.5 * t, 0.05);
        }
        void write(const Eigen::Vector3d&) noexcept override {}

       private:
        std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    } hand;
    /// Delays the loop by 20 ms before the 50th tick, and beyond the session's end before its last one.
    class Sleeper final : public TickHook {
       public:
        bool before(Simulation&) override {
            if (++ticks_ == 50 || last.time_s > 0.29) std::this_thread::sleep_for(std::chrono::milliseconds(20));
            return true;
        }
        void after(const Simulation&, const TickStatistics& books) override {
            last = books;
            latest_us = std::max(latest_us, books.lateness_us);
        }
        TickStatistics last;
        double latest_us = 0;

       private:
        int ticks_ = 0;
    } sleeper;
    const HapticModel model(haptic_example(), {});
    Simulation simulation(model);
    LoopOptions o = short_loop(true);
    o.hooks = {&sleeper};
    const LoopReport report = run_loop(simulation, hand, o);
    CHECK(report.misses >= 19);
    CHECK(sleeper.latest_us >= 19000);
    // on a busy machine some ticks may use a whole period of processor time
    CHECK(report.misses_program <= report.misses - 19);
    CHECK(report.ticks + report.misses == 300);
    CHECK(sleeper.last.time_s < 0.3);
    CHECK(simulation.safety().counters().jump == 0);
}

TEST_CASE("a loop reports the cost of ticks to its session and the session counts the time lost", "[loop][long]") {
    class Still final : public Device {
       public:
        std::string name() const override { return "still"; }
        DeviceSample read(double) noexcept override { return sample_at(0.05, 0.098); }
        void write(const Eigen::Vector3d&) noexcept override {}
    };
    HapticOptions options;
    options.dt_s = 1e-6;  // every tick costs more
    const HapticModel model(energy_model_example(make_lattice("grid8", 16, 16, 0.1, 0.1)), options);
    Simulation simulation(model);
    /// Ends the session when the loss is counted, since the time for that depends on the machine.
    class Enough final : public TickHook {
       public:
        void after(const Simulation& simulation, const TickStatistics&) override { stop = stop || simulation.counters().lost_s > 0.1; }
        std::atomic<bool> stop{false};
    } enough;
    Still device;
    LoopOptions o = short_loop(true);
    o.seconds = 0;
    o.stop = &enough.stop;
    o.hooks = {&enough};
    run_loop(simulation, device, o);
    CHECK(simulation.counters().lost_s > 0.1);
}

TEST_CASE("without a clock all ticks run one after the other however long they take", "[loop]") {
    class Slow final : public Device {
       public:
        std::string name() const override { return "slow"; }
        DeviceSample read(double time_s) noexcept override {
            if (times.size() % 20 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(3));
            times.push_back(time_s);
            return sample_at(0.05, 0.098);
        }
        void write(const Eigen::Vector3d&) noexcept override {}
        std::vector<double> times;
    };
    const HapticModel model(haptic_example(), {});
    Simulation simulation(model);
    Slow device;
    device.times.reserve(100);
    LoopOptions o = short_loop();
    o.seconds = 0.1;
    const LoopReport report = run_loop(simulation, device, o);
    CHECK_FALSE(report.clock);
    CHECK(report.ticks == 100);
    CHECK(report.misses == 0);
    CHECK(report.lateness_us.max() == 0);
    REQUIRE(device.times.size() == 100);
    for (std::size_t k = 0; k < 100; ++k) CHECK(device.times[k] == Approx(1e-3 * static_cast<double>(k)).margin(1e-12));
    CHECK(simulation.record().time_s == Approx(0.1));
    CHECK(simulation.counters().lost_s == 0);
}

TEST_CASE("a pause is no part of the tissue's time and is neither made up for nor counted as lost", "[loop]") {
    struct Pauses final : TickHook {
        bool before(Simulation&) override {
            const bool wanted = asked < 50 || asked >= 3050;
            ++asked;
            return wanted;
        }
        void after(const Simulation& simulation, const TickStatistics& books) override {
            if (books.left_out) return;
            times.push_back(books.time_s);
            advanced_s = std::max(advanced_s, simulation.advanced_s());
        }
        int asked = 0;
        double advanced_s = 0;
        std::vector<double> times;
    } pauses;
    class Hand final : public Device {  // moves on during the pause
       public:
        std::string name() const override { return "hand"; }
        DeviceSample read(double time_s) noexcept override { return sample_at(0.05, 0.098 + (time_s > 1 ? 0.004 : 0.0)); }
        DeviceSample skip_tick(double time_s) noexcept override {
            ++stood;
            return read(time_s);
        }
        void write(const Eigen::Vector3d&) noexcept override {}
        int stood = 0;
    } hand;
    const HapticModel model(haptic_example(), {});
    Simulation simulation(model);
    LoopOptions o = short_loop();
    o.seconds = 3.1;
    o.hooks = {&pauses};
    const LoopReport report = run_loop(simulation, hand, o);
    CHECK(report.ticks == 100);
    CHECK(hand.stood == 3000);
    REQUIRE(pauses.times.size() == 100);
    for (std::size_t k = 0; k < 100; ++k) CHECK(pauses.times[k] == Approx(1e-3 * static_cast<double>(k)).margin(1e-12));
    CHECK(pauses.advanced_s == Approx(1e-3));
    CHECK(simulation.record().time_s == Approx(0.1));
    CHECK(simulation.counters().lost_s == 0);
    CHECK(simulation.safety().counters().jump == 0);  // 4 mm, but in three seconds
}

TEST_CASE("the hand's motion during a pause gives no speed in the next tick", "[device]") {
    const HapticModel model(energy_model_example(), {});
    const auto hand = [](int k) { return sample_at(0.05, 0.102 - 2e-4 * k); };  // 0.2 m/s
    Simulation paused(model), late(model);
    for (int k = 0; k < 40; ++k)
        for (Simulation* s : {&paused, &late}) s->tick(hand(k), 1e-3);
    REQUIRE(paused.safety().force_N().norm() > 0);
    paused.skip_tick(hand(40), 1e-3);
    paused.tick(hand(41), 1e-3);
    late.tick(hand(41), 2e-3);
    CHECK(paused.record().coupling_N.norm() > 0);
    CHECK(paused.record().coupling_N.norm() < 1.02 * late.record().coupling_N.norm());
}

TEST_CASE("the energy of a force held until a pause is counted and none of the pause itself", "[device]") {
    class Pause final : public TickHook {
       public:
        bool before(Simulation& simulation) override {
            const double given_J = simulation.safety().counters().energy_given_J;
            if (++asked == 301) before_J = given_J, held_N = simulation.safety().force_N().y();
            if (asked == 601) after_J = given_J;
            return asked <= 300 || asked > 600;
        }
        void after(const Simulation&, const TickStatistics&) override {}
        int asked = 0;
        double before_J = 0, held_N = 0, after_J = 0;
    } pause;
    // Indents; moves out by 1 mm in the period in which the pause begins, and by 2 mm more during the pause.
    class Hand final : public Device {
       public:
        std::string name() const override { return "hand"; }
        DeviceSample read(double time_s) noexcept override {
            return sample_at(0.05, 0.102 - 0.008 * std::clamp((time_s - 0.01) / 0.1, 0.0, 1.0) + (time_s > 0.2995 ? 1e-3 : 0) + 2e-3 * std::clamp((time_s - 0.35) / 0.1, 0.0, 1.0));
        }
        void write(const Eigen::Vector3d&) noexcept override {}
    } hand;
    const HapticModel model(energy_model_example(), {});
    Simulation simulation(model);
    LoopOptions o = short_loop();
    o.seconds = 0.7;
    o.hooks = {&pause};
    run_loop(simulation, hand, o);
    REQUIRE(pause.held_N > 0.2);
    CHECK(pause.after_J - pause.before_J == Approx(1e-3 * pause.held_N));
    CHECK(simulation.safety().counters().jump == 0);
    CHECK(simulation.contact().pressing);  // the same contact continues
}

TEST_CASE("a session of invalid length does not begin", "[device]") {
    const HapticModel model(haptic_example(), {});
    for (double seconds : {-1.0, std::nan(""), 1.1 * longest_session_s, 1e300, std::numeric_limits<double>::infinity()}) {
        Motors motors;
        Simulation simulation(model);
        LoopOptions loop;
        loop.seconds = seconds;
        loop.realtime = false;
        CHECK_THROWS_AS(run_loop(simulation, motors, loop), MismatchError);
        CHECK(motors.reads == 0);
        CHECK_FALSE(motors.on);
    }
}
