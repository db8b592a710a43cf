#include "haptic/force_dimension_device.h"

#include <fmt/format.h>
#include <glob.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "haptic/device_error.h"
#include "haptic/realtime_thread.h"
#include "haptic/shared_library.h"

namespace tissue {

namespace {

constexpr int most_devices = 32;

}  // namespace

const DeviceKind ForceDimensionDevice::kind = {
    "force-dimension",
    {{"drd-library", "FILE", "", "for force-dimension: the vendor's libdrd.so, if it is not where the SDK puts it"},
     {"device-id", "number", "0", "for force-dimension: index of the device, 0 for the first", false,
      [](const std::string& text) -> std::string {
          char* end = nullptr;
          const long id = std::strtol(text.c_str(), &end, 10);
          return !text.empty() && *end == '\0' && id >= 0 && id < most_devices ? "" : fmt::format("must be a number from 0 to {}, not {}", most_devices - 1, text);
      }},
     {"home", "NAME", "no", "for force-dimension: yes: the device may move by its motors to initialise itself where that is needed, with no hand on it; or no", false,
      [](const std::string& text) -> std::string { return text == "yes" || text == "no" ? "" : "must be yes or no, not " + text; }}},
    [](const DeviceValues& v, const DeviceContext& context) -> std::unique_ptr<Device> {
        return std::make_unique<ForceDimensionDevice>(ForceDimensionOptions{v.at("drd-library"), std::stoi(v.at("device-id")), v.at("home") == "yes", context.realtime});
    },
    force_dimension_impedance};

namespace {

// the vendor's interface, as in the documentation of forcedimension_core 1.0 and the vendor's dhdc.h, drdc.h
constexpr int timeguard = 1, motor_saturated = 2;  // returned, and no errors
constexpr int some_error = 1;                      // code of an error without one
constexpr int status_force = 5, status_cause = 14, cause_watchdog = 3;
constexpr int most_status = 64;  // more than the library has; 17 in version 3.16
constexpr int oldest_major = 3, oldest_minor = 16;
constexpr double watchdog_unit_s = 125e-6;
constexpr auto watchdog_ns = static_cast<long long>(1e9 * force_held_s);

constexpr long long shortest_period_ns = 250'000, slow_period_ns = 1'000'000;
constexpr double gone_s = 2;                      // errors alone for this time: the device has been disconnected
constexpr double closes_deg = 7, opens_deg = 10;  // of a gripper

/// Device types by the vendor's numbers (forcedimension_core 1.0, constants.py; 64, 106 and 107: dhdc.h of 3.7), and
/// their largest force (CHAI3D 3.2, CDeltaDevices.cpp). For sigma and lambda the vendor is said to state 20 N, which was
/// not verified. So sigma has CHAI3D's lower limit, and lambda, which CHAI3D does not have, that of sigma.
struct Type {
    int number;
    const char* name;
    double force_max_N;
};
constexpr Type types[] = {
    {60, "Falcon", 8},
    {33, "omega.3", 12}, {34, "omega.6", 12}, {36, "omega.6 left", 12}, {35, "omega.7", 12}, {37, "omega.7 left", 12},
    {63, "delta.3", 20}, {64, "delta.6", 20},
    {206, "sigma.3", 12}, {106, "sigma.6+", 12}, {107, "sigma.6+ left", 12}, {104, "sigma.7", 12}, {105, "sigma.7 left", 12},
    {203, "lambda.3", 12}, {108, "lambda.7", 12}, {109, "lambda.7 left", 12},
};

/// The newest file of these, by the numbers in its name; "": there is none.
std::string newest(const std::string& pattern) {
    glob_t found{};
    std::string file;
    if (::glob(pattern.c_str(), 0, nullptr, &found) == 0)
        for (std::size_t k = 0; k < found.gl_pathc; ++k)
            if (strverscmp(found.gl_pathv[k], file.c_str()) > 0) file = found.gl_pathv[k];
    ::globfree(&found);
    return file;
}

/// ForceDimensionOptions::library, where it is "".
std::string usual_library() {
    utsname machine{};
    ::uname(&machine);
    if (const char* sdk = std::getenv("FDSDK"); sdk && *sdk) {
        const std::string file = newest(fmt::format("{}/lib/release/lin-{}-gcc/libdrd.so.*", sdk, machine.machine));
        if (!file.empty()) return file;
    }
    std::string folders[] = {"", "/usr/local/lib"};
    if (const char* home = std::getenv("HOME"); home && *home) folders[0] = std::string(home) + "/.local/lib";
    for (const std::string& folder : folders) {
        if (folder.empty()) continue;
        if (::access((folder + "/libdrd.so").c_str(), F_OK) == 0) return folder + "/libdrd.so";
        const std::string file = newest(folder + "/libdrd.so.*");
        if (!file.empty()) return file;
    }
    return "libdrd.so";
}

/// Devices that are open in this process, a bit each: the library opens a device twice without an error.
std::atomic<unsigned> in_use{0};

}  // namespace

/// The vendor's library with its functions, and the device that is open in it.
struct ForceDimensionDevice::Library {
    Library(const std::string& path, int index) : file(path), index_bit(1u << index) {}
    ~Library() {
        if (id >= 0) close(static_cast<char>(id));
        if (claimed) in_use.fetch_and(~index_bit);
    }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;

    SharedLibrary file;
    void (*get_sdk_version)(int* major, int* minor, int* release, int* revision) = nullptr;
    int (*get_device_count)() = nullptr;
    int (*open_id)(char index) = nullptr;
    int (*close)(char id) = nullptr;
    bool (*is_initialized)(char id) = nullptr;
    int (*auto_init)(char id) = nullptr;
    int (*stop_regulation)(bool leave_forces_on, char id) = nullptr;
    int (*get_system_type)(char id) = nullptr;
    const char* (*get_system_name)(char id) = nullptr;
    int (*enable_force)(unsigned char on, char id) = nullptr;
    int (*stop)(char id) = nullptr;
    int (*get_status)(int* status, char id) = nullptr;
    int (*get_position)(double* x, double* y, double* z, char id) = nullptr;
    int (*set_force)(double fx, double fy, double fz, double tx, double ty, double tz, double gripper, char id) = nullptr;
    int (*get_button)(int button, char id) = nullptr;
    bool (*has_gripper)(char id) = nullptr;
    int (*get_gripper_angle_deg)(double* angle, char id) = nullptr;
    int (*enable_expert_mode)() = nullptr;
    int (*disable_expert_mode)() = nullptr;
    int (*get_watchdog)(unsigned char* units, char id) = nullptr;
    int (*set_watchdog)(unsigned char units, char id) = nullptr;
    int (*last_error)() = nullptr;
    const char* (*last_error_text)() = nullptr;
    const char* (*error_text)(int error) = nullptr;

    unsigned index_bit;
    bool claimed = false;
    int id = -1;

    char device() const { return static_cast<char>(id); }

    template <class Function>
    void find(const char* name, Function& function) {
        if (!file.find(name, function)) throw DeviceError(fmt::format("force-dimension: the library has no {}: it is not the Force Dimension SDK's libdrd.so", name));
    }
    void find_functions() {
        find("dhdGetSDKVersion", get_sdk_version);
        find("dhdGetDeviceCount", get_device_count);
        find("drdOpenID", open_id);
        find("drdClose", close);
        find("drdIsInitialized", is_initialized);
        find("drdAutoInit", auto_init);
        find("drdStop", stop_regulation);
        find("dhdGetSystemType", get_system_type);
        find("dhdGetSystemName", get_system_name);
        find("dhdEnableForce", enable_force);
        find("dhdStop", stop);
        find("dhdGetStatus", get_status);
        find("dhdGetPosition", get_position);
        find("dhdSetForceAndTorqueAndGripperForce", set_force);
        find("dhdGetButton", get_button);
        find("dhdHasGripper", has_gripper);
        find("dhdGetGripperAngleDeg", get_gripper_angle_deg);
        find("dhdEnableExpertMode", enable_expert_mode);
        find("dhdDisableExpertMode", disable_expert_mode);
        find("dhdGetWatchdog", get_watchdog);
        find("dhdSetWatchdog", set_watchdog);
        find("dhdErrorGetLast", last_error);
        find("dhdErrorGetLastStr", last_error_text);
        find("dhdErrorGetStr", error_text);
    }

    /// An error of the last call in this thread.
    DeviceError error(const std::string& what) const {
        const char* text = last_error_text();
        return DeviceError(fmt::format("force-dimension: {}: {}", what, text && *text ? text : "the vendor's library gives no reason"));
    }
    int error_code() const noexcept {
        const int code = last_error();
        return code != 0 ? code : some_error;
    }
};

ForceDimensionDevice::ForceDimensionDevice(const ForceDimensionOptions& options) : options_(options) {
    const std::string file = options.library.empty() ? usual_library() : options.library;
    if (options.id < 0 || options.id >= most_devices) throw DeviceError(fmt::format("force-dimension: the index of a device must be 0 to {}, not {}", most_devices - 1, options.id));
    library_ = std::make_unique<Library>(file, options.id);
    Library& drd = *library_;
    if (!drd.file.loaded())
        throw DeviceError(fmt::format("force-dimension: cannot load {} ({}); install the Force Dimension SDK 3.16 or newer, set FDSDK to its folder, or name libdrd.so with --drd-library",
                                      file, drd.file.error()));
    drd.find_functions();
    int major = 0, minor = 0, release = 0, revision = 0;
    drd.get_sdk_version(&major, &minor, &release, &revision);
    if (major < oldest_major || (major == oldest_major && minor < oldest_minor))
        throw DeviceError(fmt::format("force-dimension: {} is version {}.{}.{}: install the Force Dimension SDK {}.{} or newer", file, major, minor, release, oldest_major, oldest_minor));

    const int count = drd.get_device_count();
    if (count < 0) throw drd.error("cannot count the devices");
    if (options.id >= count)
        throw DeviceError(fmt::format("force-dimension: there is no device {}: {} connected; check power, cable and the udev rule that permits access",
                                      options.id, count == 0 ? "none is" : fmt::format("{}, counted from 0, are", count)));
    if ((in_use.fetch_or(drd.index_bit) & drd.index_bit) != 0)
        throw DeviceError(fmt::format("force-dimension: device {} moves another tool of this session: give each tool its own --device-id", options.id));
    drd.claimed = true;
    drd.id = drd.open_id(static_cast<char>(options.id));
    if (drd.id < 0) throw drd.error(fmt::format("cannot open device {}", options.id));
    const int number = drd.get_system_type(drd.device());
    const Type* type = std::find_if(std::begin(types), std::end(types), [&](const Type& t) { return t.number == number; });
    if (type == std::end(types)) {
        const char* name = drd.get_system_name(drd.device());
        throw DeviceError(fmt::format("force-dimension: device {} is of type {} ({}), whose largest force is not known here: it is not used", options.id, number, name ? name : "without a name"));
    }
    type_ = type->name;
    force_max_N_ = type->force_max_N;
    gripper_ = drd.has_gripper(drd.device());
    if (!drd.is_initialized(drd.device()) && !options.home)
        throw DeviceError(fmt::format("force-dimension: device {} ({}) is not initialised: initialise it by hand as its manual describes, "
                                      "or take your hands off and let it move by itself with --home yes",
                                      options.id, type_));
}

ForceDimensionDevice::~ForceDimensionDevice() {
    stop();
}

std::string ForceDimensionDevice::name() const {
    return fmt::format("{} ({})", kind.name, type_);
}

void ForceDimensionDevice::start() {
    Library& drd = *library_;
    stop();
    started_ = true;  // from here on stop() undoes what start() did, also after an exception
    if (!drd.is_initialized(drd.device())) {
        // again, since the device may have lost its power after it was opened
        if (!options_.home) throw DeviceError(fmt::format("force-dimension: device {} ({}) is no longer initialised: initialise it by hand, or use --home yes", options_.id, type_));
        if (drd.auto_init(drd.device()) < 0) throw drd.error(fmt::format("device {} ({}) could not initialise itself", options_.id, type_));
        if (!drd.is_initialized(drd.device())) throw DeviceError(fmt::format("force-dimension: device {} ({}) has moved and is still not initialised: initialise it by hand", options_.id, type_));
        // the thread that moves the device must not hold it in its place
        if (drd.stop_regulation(true, drd.device()) < 0) throw drd.error(fmt::format("device {} ({}) still holds its place", options_.id, type_));
    }
    if (drd.enable_expert_mode() >= 0) {
        watchdog_ = drd.get_watchdog(&watchdog_before_, drd.device()) >= 0 && drd.set_watchdog(static_cast<unsigned char>(std::lround(force_held_s / watchdog_unit_s)), drd.device()) >= 0;
        drd.disable_expert_mode();
    }
    period_s_ = 1e-9 * slow_period_ns;
    slow_ = saturated_ = time_guarded_ = enabled_again_ = 0;
    closed_ = false;
    commanded_ns_ = now_ns();
    exchange_.begin();
    if (drd.enable_force(1, drd.device()) < 0) throw drd.error(fmt::format("cannot enable the forces of device {} ({})", options_.id, type_));
    ending_ = false;
    servo_ = std::thread([this] { serve(); });
}

void ForceDimensionDevice::serve() noexcept {
    if (options_.realtime) scheduled_ = request_realtime(servo_priority) == 0;
    constexpr double smoothing = 0.05;
    long long began = now_ns(), before = began;
    while (!ending_.load(std::memory_order_acquire)) {
        servo_period();
        sleep_until(began + shortest_period_ns);
        before = began;
        began = now_ns();
        const long long period_ns = began - before;
        if (period_ns > slow_period_ns) slow_.fetch_add(1, std::memory_order_relaxed);
        const double mean_s = period_s_.load(std::memory_order_relaxed);
        period_s_.store(mean_s + smoothing * (1e-9 * static_cast<double>(period_ns) - mean_s), std::memory_order_relaxed);
    }
}

/// One exchange with the device. The force goes out last, so that it is the newest one.
void ForceDimensionDevice::servo_period() noexcept {
    Library& drd = *library_;
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    const int got = drd.get_position(&position_m.x(), &position_m.y(), &position_m.z(), drd.device());
    int error = got < 0 ? drd.error_code() : 0;  // of this thread's last call, before another one replaces it
    const bool grasp = grasps();
    Eigen::Vector3d force_N = exchange_.force_N();
    const double length_N = force_N.norm();
    if (!std::isfinite(length_N)) force_N.setZero();
    else if (length_N > force_max_N_) force_N *= force_max_N_ / length_N;
    const long long now = now_ns(), since_ns = now - commanded_ns_;
    commanded_ns_ = now;
    // torques and the gripper's force are zero
    const int set = drd.set_force(force_N.x(), force_N.y(), force_N.z(), 0, 0, 0, 0, drd.device());
    if (set < 0 && error == 0) error = drd.error_code();
    if (got == timeguard) time_guarded_.fetch_add(1, std::memory_order_relaxed);
    if (set == motor_saturated) saturated_.fetch_add(1, std::memory_order_relaxed);
    if (error != 0) exchange_.failed(error);
    else exchange_.measured(position_m, grasp);
    // not at the watchdog's own time, which the device measures by its clock from when a command arrives
    if (watchdog_ && since_ns > watchdog_ns / 2) after_stall();
}

/// The device's watchdog may have disabled its forces. They stay disabled where the cause is another one.
void ForceDimensionDevice::after_stall() noexcept {
    Library& drd = *library_;
    int status[most_status] = {};
    if (drd.get_status(status, drd.device()) < 0 || status[status_force] != 0 || status[status_cause] != cause_watchdog) return;
    if (drd.enable_force(1, drd.device()) >= 0) enabled_again_.fetch_add(1, std::memory_order_relaxed);
}

bool ForceDimensionDevice::grasps() noexcept {
    Library& drd = *library_;
    double angle_deg = 0;
    // of the left hand's devices angles are negative
    if (gripper_ && drd.get_gripper_angle_deg(&angle_deg, drd.device()) >= 0)
        closed_ = std::abs(angle_deg) < (closed_ ? opens_deg : closes_deg);
    else
        closed_ = false;
    return closed_ || drd.get_button(0, drd.device()) == 1;
}

DeviceSample ForceDimensionDevice::read(double time_s) noexcept {
    return exchange_.read(time_s, period_s_.load(std::memory_order_relaxed));
}

void ForceDimensionDevice::write(const Eigen::Vector3d& force_N) noexcept {
    if (started_) exchange_.write(force_N);
}

bool ForceDimensionDevice::finished() const noexcept {
    return started_ && exchange_.silent_s() > gone_s;
}

void ForceDimensionDevice::stop() noexcept {
    if (!started_) return;
    if (servo_.joinable()) {
        exchange_.rest();
        ending_.store(true, std::memory_order_release);
        servo_.join();
    }
    started_ = false;
    Library& drd = *library_;
    drd.stop(drd.device());  // forces off, brakes on
    if (watchdog_ && drd.enable_expert_mode() >= 0) {  // the device keeps the setting for other programs
        drd.set_watchdog(watchdog_before_, drd.device());
        drd.disable_expert_mode();
    }
}

std::string ForceDimensionDevice::last_error() const {
    const int code = exchange_.last_error();
    if (code == 0) return "";
    const char* text = library_->error_text(code);
    return fmt::format("{} (vendor error {})", text && *text ? text : "no description", code);
}

std::vector<std::pair<std::string, double>> ForceDimensionDevice::statistics() const {
    auto all = exchange_.statistics();
    all.insert(all.end(), {{"servo_period_us", 1e6 * period_s_.load()},
                           {"slow_periods", static_cast<double>(slow_.load())},
                           {"saturated_ticks", static_cast<double>(saturated_.load())},
                           {"time_guard_ticks", static_cast<double>(time_guarded_.load())},
                           {"watchdog", watchdog_ ? 1.0 : 0.0},
                           {"forces_enabled_again", static_cast<double>(enabled_again_.load())},
                           {"realtime", scheduled_.load() ? 1.0 : 0.0},
                           {"type_force_max_N", force_max_N_}});
    return all;
}

}  // namespace tissue
