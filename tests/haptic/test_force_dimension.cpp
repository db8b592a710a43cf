#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <thread>

#include "../refusal.h"
#include "../wait_for.h"
#include "error.h"
#include "haptic/device_error.h"
#include "haptic/force_dimension_device.h"
#include "haptic/realtime_loop.h"
#include "haptic/running_device.h"
#include "haptic_example.h"
#include "stand_in.h"

using namespace tissue;

namespace {

/// The stand-in for the vendor's library. Its state outlives the devices that a test makes.
class Vendor final : public StandIn {
   public:
    Vendor() : StandIn("libdrd") {
        find("stand_in_set", set);
        find("stand_in_set_gripper", set_gripper);
        find("stand_in_set_position", set_position);
        find("stand_in_get_force", get_force);
        find("stand_in_forces_on", forces_on);
        find("stand_in_brakes_on", brakes_on);
        find("stand_in_moved", moved);
        find("stand_in_regulated", regulated);
        find("stand_in_opened", opened);
        find("stand_in_watchdog", watchdog);
        find("stand_in_expert", expert);
    }
    ForceDimensionOptions options(bool home = false) const { return {library, 0, home, false}; }
    Eigen::Vector3d force_N() const {
        Eigen::Vector3d force = Eigen::Vector3d::Zero();
        get_force(force.data());
        return force;
    }
    std::string refused(int id = 0) const {
        return refusal<DeviceError>([&] { ForceDimensionDevice device({library, id, false, false}); });
    }

    void (*set)(const char*, int) = nullptr;
    void (*set_gripper)(double) = nullptr;
    void (*set_position)(double, double, double) = nullptr;
    void (*get_force)(double*) = nullptr;
    int (*forces_on)() = nullptr;
    int (*brakes_on)() = nullptr;
    int (*moved)() = nullptr;
    int (*regulated)() = nullptr;
    int (*opened)(int) = nullptr;
    int (*watchdog)() = nullptr;
    int (*expert)() = nullptr;
};

/// A variable of the environment, for the lifetime of this object.
class Environment {
   public:
    Environment(const char* name, const std::string& value) : name_(name) {
        if (const char* before = std::getenv(name)) before_ = before;
        ::setenv(name, value.c_str(), 1);
    }
    ~Environment() {
        if (before_) ::setenv(name_, before_->c_str(), 1);
        else ::unsetenv(name_);
    }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

   private:
    const char* name_;
    std::optional<std::string> before_;
};

double statistics(const Device& device, const std::string& name) {
    for (const auto& [key, value] : device.statistics())
        if (key == name) return value;
    FAIL_CHECK("no entry " << name);
    return 0;
}

/// Waits for the next servo periods. False where they do not come.
bool servo_goes_on(const Device& device) {
    const double before = statistics(device, "servo_ticks");
    return wait_for([&] { return statistics(device, "servo_ticks") > before + 2; });
}

bool contains(const std::string& text, const std::string& part) {
    INFO(text);
    CHECK(text.find(part) != std::string::npos);
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("force-dimension refuses a library that is missing or another one or too old", "[device]") {
    const std::string missing = refusal<DeviceError>([] { ForceDimensionDevice device({"libdrd_that_is_not_there.so"}); });
    contains(missing, "cannot load libdrd_that_is_not_there.so");
    contains(missing, "--drd-library");
    contains(refusal<DeviceError>([] { ForceDimensionDevice device({"libm.so.6"}); }), "the library has no dhdGetSDKVersion");
    const Vendor vendor;
    vendor.set("minor", 15);
    contains(vendor.refused(), vendor.library + " is version 3.15.1: install the Force Dimension SDK 3.16 or newer");
    CHECK(vendor.opened(0) == 0);
    vendor.set("minor", 16);
    CHECK(ForceDimensionDevice(vendor.options()).name() == "force-dimension (omega.7)");
    CHECK(vendor.opened(0) == 0);  // closed by the destructor
}

TEST_CASE("force-dimension finds the newest library of the SDK's folder before those of home", "[device]") {
    const Vendor vendor;
    const auto folder = [](const std::string& path) { return std::filesystem::create_directories(path), path; };
    for (const char* name : {"x86_64", "aarch64", "i686", "armv7l", "riscv64", "ppc64le"}) {
        const std::string lib = folder(vendor.folder.file("sdk") + "/lib/release/lin-" + name + "-gcc");
        std::filesystem::copy_file(vendor.library, lib + "/libdrd.so.3.17.1");
        vendor.folder.file("sdk/lib/release/lin-" + std::string(name) + "-gcc/libdrd.so.3.9.0", "older, and the last one in alphabetical order");
    }
    folder(vendor.folder.file("home") + "/.local/lib");
    const std::string of_home = vendor.folder.file("home/.local/lib/libdrd.so", "not a library");
    const Environment home("HOME", vendor.folder.file("home"));
    {
        const Environment sdk("FDSDK", vendor.folder.file("sdk"));
        CHECK(ForceDimensionDevice().name() == "force-dimension (omega.7)");
    }
    const Environment sdk("FDSDK", vendor.folder.file("empty"));
    contains(refusal<DeviceError>([] { ForceDimensionDevice device; }), "cannot load " + of_home);
}

TEST_CASE("force-dimension refuses a device that is absent or unknown or in use or cannot be opened", "[device]") {
    const Vendor vendor;
    vendor.set("count", 0);
    contains(vendor.refused(), "there is no device 0: none is connected");
    vendor.set("count", 1);
    contains(vendor.refused(1), "there is no device 1: 1, counted from 0, are connected");
    contains(vendor.refused(32), "must be 0 to 31, not 32");
    vendor.set("count", -1);
    contains(vendor.refused(), "cannot count the devices");
    vendor.set("count", 1);
    vendor.set("fails_open", 1);
    contains(vendor.refused(), "cannot open device 0: communication error with the device");
    vendor.set("fails_open", 0);
    for (const int type : {0, 81, 91}) {
        vendor.set("type", type);
        contains(vendor.refused(), "is of type " + std::to_string(type) + " (stand-in), whose largest force is not known");
        CHECK(vendor.opened(0) == 0);
    }
    vendor.set("type", 33);
    vendor.set("count", 2);
    const ForceDimensionDevice first(vendor.options());
    contains(vendor.refused(), "device 0 moves another tool of this session");
    CHECK(vendor.opened(0) == 1);  // the one in use stays open
    CHECK(ForceDimensionDevice({vendor.library, 1, false, false}).name() == "force-dimension (omega.7)");
    CHECK(vendor.opened(1) == 0);
}

TEST_CASE("force-dimension moves a device that is not initialised only with the user's consent", "[device]") {
    const Vendor vendor;
    vendor.set("initialized", 0);
    contains(vendor.refused(), "device 0 (omega.7) is not initialised: initialise it by hand");
    contains(vendor.refused(), "--home yes");
    CHECK(vendor.moved() == 0);
    CHECK(vendor.opened(0) == 0);
    {
        ForceDimensionDevice device(vendor.options(true));
        CHECK(vendor.moved() == 0);  // not before start()
        vendor.set("fails_init", 1);
        contains(refusal<DeviceError>([&] { RunningDevice running(device); }), "could not initialise itself: timeout");
        CHECK(vendor.forces_on() == 0);
        CHECK(vendor.brakes_on() == 1);
        vendor.set("fails_init", 0);
        const RunningDevice running(device);
        CHECK(vendor.moved() == 2);
        CHECK(vendor.regulated() == 0);  // the hand moves it from now on
        CHECK(wait_for([&] { return device.read(0).valid; }));
    }
    {
        ForceDimensionDevice device(vendor.options(true));
        const RunningDevice running(device);
        CHECK(vendor.moved() == 2);  // it is initialised
    }
    ForceDimensionDevice device(vendor.options());
    vendor.set("initialized", 0);  // it lost its power after it was opened
    contains(refusal<DeviceError>([&] { RunningDevice running(device); }), "no longer initialised");
    CHECK(vendor.moved() == 2);
}

TEST_CASE("force-dimension reads metres and sets the force to zero when ticks cease and when the device stops", "[device]") {
    const Vendor vendor;
    vendor.set_position(0.01, -0.02, 0.03);
    {
        ForceDimensionDevice device(vendor.options());
        CHECK_FALSE(device.read(0).valid);
        device.write({1, 1, 1});  // before start(): no force
        device.start();
        CHECK(wait_for([&] { return vendor.forces_on() == 1; }));
        CHECK(vendor.watchdog() == 80);  // 80 x 125 us = force_held_s
        CHECK(vendor.expert() == 0);
        CHECK(wait_for([&] { return device.read(0.01).valid; }));
        CHECK(vendor.force_N().isZero(0));
        CHECK((device.read(0.03).position_m - Eigen::Vector3d(0.01, -0.02, 0.03)).norm() < 1e-15);
        CHECK(wait_for([&] {
            device.write({0.5, 0.25, -1});
            return vendor.force_N() == Eigen::Vector3d(0.5, 0.25, -1);
        }));
        CHECK(wait_for([&] { return vendor.force_N().isZero(0); }));  // without ticks
        CHECK(wait_for([&] { return vendor.forces_on() == 1; }));     // they are on, unless this machine stalls
        CHECK(statistics(device, "cut_off_ticks") > 0);
        // A force lasts for more than half of force_held_s and less than all of it. A busy machine needs several
        // attempts to show it.
        bool let_go_in_time = false;
        for (int k = 0; k < 500 && !let_go_in_time; ++k) {
            const auto from = std::chrono::steady_clock::now();
            device.write({0.5, 0, 0});
            double there_s = 0, gone_s = 0, now_s = 0;
            do {
                const double force_N = vendor.force_N().x();
                now_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
                if (force_N == 0.5) there_s = now_s;
                else if (there_s > 0 && gone_s == 0) gone_s = now_s;
            } while (now_s < 1.5 * force_held_s);
            let_go_in_time = there_s > force_held_s / 2 && gone_s > there_s && gone_s < force_held_s;
        }
        CHECK(let_go_in_time);
        // faster than the ticks; a position is at least as old as the servo's period when its force goes out
        CHECK(wait_for([&] { return statistics(device, "servo_period_us") < 1000; }));
        CHECK(statistics(device, "servo_period_us") >= 250);
        CHECK(wait_for([&] { return device.read(0.04).valid; }));
        CHECK(device.read(0.04).age_s >= 250e-6);
        CHECK(device.last_error().empty());

        device.write({1, 0, 0});
        device.stop();
        CHECK(vendor.force_N().isZero(0));
        CHECK(vendor.forces_on() == 0);
        CHECK(vendor.brakes_on() == 1);
        CHECK(vendor.watchdog() == 64);  // the device's own
        device.write({1, 0, 0});
        CHECK(vendor.force_N().isZero(0));

        // a second session: the position of the first one is none of it
        vendor.set("stall_ms", 500);
        const RunningDevice again(device);
        CHECK_FALSE(device.read(0).valid);
        CHECK(wait_for([&] { return device.read(0).valid; }));
    }
    CHECK(vendor.opened(0) == 0);
}

TEST_CASE("force-dimension limits the force to that of the type it finds", "[device]") {
    const Vendor vendor;
    struct Expected {
        int type;
        double force_N;
        std::string name;
    };
    for (const Expected& e : {Expected{60, 8, "Falcon"}, {33, 12, "omega.3"}, {37, 12, "omega.7 left"}, {63, 20, "delta.3"}, {104, 12, "sigma.7"}, {109, 12, "lambda.7 left"}}) {
        vendor.set("type", e.type);
        ForceDimensionDevice device(vendor.options());
        CHECK(device.name() == "force-dimension (" + e.name + ")");
        CHECK(device.force_max_N() == e.force_N);
        CHECK(ForceDimensionDevice::kind.impedance.force_max_N <= e.force_N);
        const RunningDevice running(device);
        const Eigen::Vector3d direction = Eigen::Vector3d(1, -2, 2) / 3;
        Eigen::Vector3d largest_N = Eigen::Vector3d::Zero();
        CHECK(wait_for([&] {
            device.write(1.5 * e.force_N * direction);
            return (largest_N = vendor.force_N()).norm() > 0;
        }));
        CHECK((largest_N - e.force_N * direction).norm() < 1e-9);
        CHECK(wait_for([&] {
            device.write(0.5 * e.force_N * direction);
            return (vendor.force_N() - 0.5 * e.force_N * direction).norm() < 1e-9;
        }));
        for (int k = 0; k < 5; ++k) {
            device.write(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
            CHECK(servo_goes_on(device));
            CHECK(vendor.force_N().isZero(0));
        }
    }
}

TEST_CASE("the time guard and saturated motors of force-dimension are no errors", "[device]") {
    const Vendor vendor;
    ForceDimensionDevice device(vendor.options());
    const RunningDevice running(device);
    vendor.set("timeguard", 1);
    vendor.set("saturated", 1);
    CHECK(wait_for([&] { return statistics(device, "saturated_ticks") > 5 && statistics(device, "time_guard_ticks") > 5; }));
    CHECK(wait_for([&] { return device.read(0).valid; }));
    CHECK(statistics(device, "vendor_errors") == 0);
    CHECK(device.last_error().empty());
}

TEST_CASE("an error of force-dimension between two reads is not hidden by a success after it", "[device]") {
    const Vendor vendor;
    ForceDimensionDevice device(vendor.options());
    const RunningDevice running(device);
    for (const char* call : {"position_errors", "force_errors"}) {
        CHECK(wait_for([&] { return device.read(0).valid; }));
        const double errors = statistics(device, "vendor_errors");
        vendor.set(call, 1);
        CHECK(wait_for([&] { return statistics(device, "vendor_errors") == errors + 1; }));
        CHECK(servo_goes_on(device));
        CHECK_FALSE(device.read(0.01).valid);
        CHECK(device.read(0.011).valid);
    }
    // errors without an end, after which the library stalls: no error comes between the last two reads
    vendor.set("position_errors", -1);
    CHECK(wait_for([&] { return !device.read(0.02).valid; }));
    vendor.set("stall_ms", 500);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    device.read(0.021);
    CHECK_FALSE(device.read(0.022).valid);
    vendor.set("position_errors", 0);
    CHECK(wait_for([&] { return device.read(0.03).valid; }));
    vendor.set("force_errors", 1);
    CHECK(wait_for([&] { return device.last_error() == "timeout (vendor error 7)"; }));  // of the servo's thread, not of this one
    CHECK(statistics(device, "vendor_error") == 7);
}

TEST_CASE("a force-dimension device that was disconnected gives no position and finishes", "[device]") {
    const Vendor vendor;
    vendor.set_position(0.01, 0, 0);
    ForceDimensionDevice device(vendor.options());
    {
        const RunningDevice running(device);
        CHECK(wait_for([&] { return device.read(0).valid; }));
        CHECK_FALSE(device.finished());
        vendor.set("disconnected", 1);
        CHECK(wait_for([&] { return !device.read(0.01).valid; }));
        CHECK(servo_goes_on(device));
        const DeviceSample sample = device.read(0.5);
        CHECK_FALSE(sample.valid);
        CHECK(sample.position_m.x() == 0.01);
        CHECK(sample.age_s >= 0.49);
        CHECK(wait_for([&] { return device.finished(); }));
        CHECK(device.last_error() == "communication error with the device (vendor error 2)");
    }
    vendor.set("disconnected", 0);
    const RunningDevice again(device);
    CHECK_FALSE(device.finished());
    CHECK(wait_for([&] { return device.read(0).valid; }));
    CHECK(device.last_error().empty());
}

TEST_CASE("after a stall of force-dimension forces return only where the watchdog disabled them", "[device]") {
    const Vendor vendor;
    ForceDimensionDevice device(vendor.options());
    const RunningDevice running(device);
    CHECK(wait_for([&] { return device.read(0).valid; }));
    const auto push = [&] {
        return wait_for([&] {
            device.write({2, 0, 0});
            return vendor.force_N().x() == 2;
        });
    };
    CHECK(push());
    const double before = statistics(device, "forces_enabled_again");  // a busy machine stalls too
    vendor.set("stall_ms", 300);
    CHECK(wait_for([&] { return vendor.forces_on() == 0; }));  // of the device itself
    CHECK(vendor.force_N().isZero(0));
    CHECK(wait_for([&] { return statistics(device, "forces_enabled_again") > before; }));
    CHECK(vendor.force_N().isZero(0));  // no tick since
    CHECK(push());
    CHECK(statistics(device, "slow_periods") > 0);

    vendor.set("forces", 0);  // by the button of the device
    vendor.set("cause", 1);
    const double enabled = statistics(device, "forces_enabled_again"), slow = statistics(device, "slow_periods");
    vendor.set("stall_ms", 50);
    CHECK(wait_for([&] { return statistics(device, "slow_periods") > slow; }));
    CHECK(servo_goes_on(device));
    CHECK(vendor.forces_on() == 0);
    CHECK(statistics(device, "forces_enabled_again") == enabled);
}

TEST_CASE("a force-dimension device without a watchdog plays and reports that it has none", "[device]") {
    const Vendor vendor;
    vendor.set("has_watchdog", 0);
    ForceDimensionDevice device(vendor.options());
    const RunningDevice running(device);
    CHECK(wait_for([&] { return device.read(0).valid; }));
    CHECK(statistics(device, "watchdog") == 0);
    CHECK(vendor.watchdog() == 64);
    CHECK(vendor.expert() == 0);
}

TEST_CASE("the first button or a closed gripper of force-dimension grasps", "[device]") {
    const Vendor vendor;
    const auto grasps = [](Device& device) {
        CHECK(servo_goes_on(device));
        return device.read(0).grasp;
    };
    {
        ForceDimensionDevice device(vendor.options());
        const RunningDevice running(device);
        CHECK_FALSE(grasps(device));
        vendor.set("button", 2);  // the second button alone
        CHECK_FALSE(grasps(device));
        vendor.set("button", 3);
        CHECK(grasps(device));
        vendor.set_gripper(0);  // of a device without a gripper
        vendor.set("button", 0);
        CHECK_FALSE(grasps(device));
        vendor.set("button", -1);  // it has no buttons: an error that says nothing about positions
        CHECK_FALSE(grasps(device));
        CHECK(device.read(0).valid);
    }
    vendor.set("has_gripper", 1);
    for (const double hand : {1.0, -1.0}) {  // the left hand's angles are negative
        ForceDimensionDevice device(vendor.options());
        vendor.set_gripper(hand * 20);
        const RunningDevice running(device);
        CHECK_FALSE(grasps(device));
        vendor.set_gripper(hand * 8);
        CHECK_FALSE(grasps(device));
        vendor.set_gripper(hand * 6);
        CHECK(grasps(device));
        vendor.set_gripper(hand * 8);
        CHECK(grasps(device));
        vendor.set_gripper(hand * 11);
        CHECK_FALSE(grasps(device));
    }
}

TEST_CASE("force-dimension stops what it began where its start fails", "[device]") {
    const Vendor vendor;
    ForceDimensionDevice device(vendor.options());
    vendor.set("fails_enable", 1);
    contains(refusal<DeviceError>([&] { RunningDevice running(device); }), "cannot enable the forces of device 0 (omega.7): feature not available");
    CHECK(vendor.forces_on() == 0);
    CHECK(vendor.watchdog() == 64);
    vendor.set("fails_enable", 0);
    const RunningDevice again(device);
    CHECK(wait_for([&] { return device.read(0).valid; }));
}

TEST_CASE("a whole session on the force-dimension stand-in renders a force and ends with zero force", "[device]") {
    const Vendor vendor;
    vendor.set_position(0.05, 0.105, 0);
    HapticOptions o;
    o.map.force_scale = 100;
    o.device = ForceDimensionDevice::kind.impedance;
    o.device.stiffness_N_m = std::numeric_limits<double>::infinity();  // the scale of force is for a short test
    const HapticModel model(haptic_example(), o);
    Simulation simulation(model);
    ForceDimensionDevice device(vendor.options());
    double largest_N = 0;
    std::atomic<bool> through{false};
    std::thread hand([&] {
        // then the hand is still; on a slow machine the force comes later
        for (int k = 0; k < 300 || (largest_N <= 0.05 && k < 20000); ++k) {
            vendor.set_position(0.05, 0.105 - 0.05e-3 * std::min(k, 299), 0);
            largest_N = std::max(largest_N, vendor.force_N().y());
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        through = true;
    });
    LoopOptions loop;
    loop.seconds = 0;
    loop.stop = &through;
    loop.realtime = false;
    const LoopReport report = run_loop(simulation, device, loop);
    hand.join();
    CHECK(report.ticks > 10);
    CHECK(largest_N > 0.05);
    CHECK(largest_N <= 8);
    CHECK(vendor.force_N().isZero(0));
    CHECK(vendor.forces_on() == 0);
}
