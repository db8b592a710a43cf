// A stand-in for the vendor's libdrd.so, with the functions, types and return values of the documentation of
// forcedimension_core 1.0 (functions of dhd and drd): two devices, which a test changes by the functions stand_in_...
// The real library was never at hand. Here, as in the documentation: an error is -1, and its code is that of the calling
// thread; dhdSetWatchdog needs the expert mode; a device disables its forces where its watchdog ends; gravity and the
// times of USB are left out.
#include <time.h>

#include <atomic>
#include <cstdlib>

namespace {

constexpr int none = 0, com = 2, not_available = 6, timed_out = 7, expert_mode_disabled = 9, invalid_index = 15;
constexpr int cause_watchdog = 3;

struct State {
    std::atomic<int> type{35}, opened{0}, regulated{0}, initialized{1}, has_gripper{0}, button{0}, forces{0}, brakes{0}, cause{0}, moved{0};
    std::atomic<int> has_watchdog{1}, watchdog{64};  // 64: 8 ms, the device's own setting
    std::atomic<double> position[3] = {}, force[3] = {}, gripper_deg{30};
    std::atomic<long long> commanded_ns{0};
    std::atomic<long> commands{0};
} devices[2];

std::atomic<int> count{1}, minor_version{17}, expert{0};
std::atomic<int> fails_open{0}, fails_init{0}, fails_enable{0};
std::atomic<int> position_errors{0};  // so many calls of dhdGetPosition fail; -1: all
int from_environment(const char* name) {
    const char* value = std::getenv(name);
    return value ? std::atoi(value) : 0;
}
std::atomic<int> force_errors{from_environment("STAND_IN_FORCE_ERRORS")};  // so that a test may set it for a program
std::atomic<int> timeguard{0}, saturated{0}, disconnected{0};
std::atomic<int> stall_ms{0};         // of the next dhdGetPosition
thread_local int last_error = none;

int error(int code) {
    last_error = code;
    return -1;
}

long long now_ns() {
    timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

State* open_device(char id) {
    if (id < 0 || id >= 2 || devices[int(id)].opened == 0) {
        error(invalid_index);
        return nullptr;
    }
    if (disconnected) {
        error(com);
        return nullptr;
    }
    return &devices[int(id)];
}

bool one_of(std::atomic<int>& left) {
    if (left < 0) return true;
    if (left == 0) return false;
    --left;
    return true;
}

/// Disables forces where no command has come in time.
void watch(State& d) {
    if (d.forces && d.has_watchdog && d.watchdog > 0 && now_ns() - d.commanded_ns > 125000LL * d.watchdog) {
        d.forces = 0;
        d.brakes = 1;
        d.cause = cause_watchdog;
    }
    if (!d.forces)
        for (auto& f : d.force) f = 0;
}

}  // namespace

extern "C" {

void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
    *major = 3;
    *minor = minor_version;
    *release = 1;
    *revision = 4711;
}
int dhdErrorGetLast() { return last_error; }
const char* dhdErrorGetStr(int code) {
    switch (code) {
        case none: return "no error";
        case com: return "communication error with the device";
        case not_available: return "feature not available";
        case timed_out: return "timeout";
        case expert_mode_disabled: return "expert mode disabled";
        case invalid_index: return "invalid index";
        default: return "unspecified error";
    }
}
const char* dhdErrorGetLastStr() { return dhdErrorGetStr(last_error); }

int dhdGetDeviceCount() { return count; }
int drdOpenID(char index) {
    if (index < 0 || index >= count) return error(invalid_index);
    if (fails_open) return error(com);
    devices[int(index)].opened = 1;
    return index;
}
int drdClose(char id) {
    if (id < 0 || id >= 2) return error(invalid_index);
    devices[int(id)].opened = devices[int(id)].forces = 0;
    return 0;
}
bool drdIsInitialized(char id) {
    const State* d = open_device(id);
    return d && d->initialized;
}
int drdAutoInit(char id) {
    State* d = open_device(id);
    if (!d) return -1;
    ++d->moved;
    d->regulated = 1;
    if (fails_init) return error(timed_out);
    d->initialized = 1;
    return 0;
}
int drdStop(bool leave_forces_on, char id) {
    State* d = open_device(id);
    if (!d) return -1;
    d->regulated = 0;
    if (!leave_forces_on) d->forces = 0;
    return 0;
}

int dhdGetSystemType(char id) {
    const State* d = open_device(id);
    return d ? d->type.load() : -1;
}
const char* dhdGetSystemName(char) { return "stand-in"; }
int dhdEnableForce(unsigned char on, char id) {
    State* d = open_device(id);
    if (!d) return -1;
    if (fails_enable) return error(not_available);
    d->commanded_ns = now_ns();
    d->forces = on;
    d->brakes = !on;
    d->cause = 0;
    return 0;
}
int dhdStop(char id) {
    State* d = open_device(id);
    if (!d) return -1;
    d->forces = 0;
    d->brakes = 1;
    watch(*d);
    return 0;
}
int dhdGetStatus(int* status, char id) {
    State* d = open_device(id);
    if (!d) return -1;
    watch(*d);
    for (int k = 0; k < 17; ++k) status[k] = 0;
    status[5] = d->forces;
    status[6] = d->brakes;
    status[14] = d->cause;
    return 0;
}
int dhdGetPosition(double* x, double* y, double* z, char id) {
    if (const int ms = stall_ms.exchange(0)) {
        const timespec t{ms / 1000, ms % 1000 * 1000000L};
        nanosleep(&t, nullptr);
    }
    State* d = open_device(id);
    if (!d) return -1;
    if (one_of(position_errors)) return error(com);
    *x = d->position[0];
    *y = d->position[1];
    *z = d->position[2];
    return timeguard ? 1 : 0;
}
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double, double, double, double, char id) {
    State* d = open_device(id);
    if (!d) return -1;
    if (one_of(force_errors)) return error(timed_out);
    watch(*d);
    d->commanded_ns = now_ns();
    ++d->commands;
    d->force[0] = d->forces ? fx : 0;
    d->force[1] = d->forces ? fy : 0;
    d->force[2] = d->forces ? fz : 0;
    return saturated ? 2 : 0;
}
int dhdGetButton(int button, char id) {
    const State* d = open_device(id);
    if (!d) return -1;
    const int buttons = d->button;
    return buttons < 0 ? error(not_available) : buttons >> button & 1;
}
bool dhdHasGripper(char id) {
    const State* d = open_device(id);
    return d && d->has_gripper;
}
int dhdGetGripperAngleDeg(double* angle, char id) {
    const State* d = open_device(id);
    if (!d) return -1;
    // also of a device without a gripper: what the library does then is not documented
    *angle = d->gripper_deg;
    return timeguard ? 1 : 0;
}
int dhdEnableExpertMode() {
    expert = 1;
    return 0;
}
int dhdDisableExpertMode() {
    expert = 0;
    return 0;
}
int dhdGetWatchdog(unsigned char* units, char id) {
    const State* d = open_device(id);
    if (!d) return -1;
    if (!expert) return error(expert_mode_disabled);
    if (!d->has_watchdog) return error(not_available);
    *units = static_cast<unsigned char>(d->watchdog);
    return 0;
}
int dhdSetWatchdog(unsigned char units, char id) {
    State* d = open_device(id);
    if (!d) return -1;
    if (!expert) return error(expert_mode_disabled);
    if (!d->has_watchdog) return error(not_available);
    d->watchdog = units;
    return 0;
}

void stand_in_set(const char* what, int value) {
    struct Name {
        const char* name;
        std::atomic<int>& value;
    } const names[] = {{"count", count}, {"minor", minor_version}, {"fails_open", fails_open}, {"fails_init", fails_init}, {"fails_enable", fails_enable},
                       {"position_errors", position_errors}, {"force_errors", force_errors}, {"timeguard", timeguard}, {"saturated", saturated},
                       {"disconnected", disconnected}, {"stall_ms", stall_ms}, {"type", devices[0].type}, {"initialized", devices[0].initialized},
                       {"has_gripper", devices[0].has_gripper}, {"button", devices[0].button}, {"has_watchdog", devices[0].has_watchdog},
                       {"forces", devices[0].forces}, {"cause", devices[0].cause}};
    for (const Name& n : names) {
        const char *a = n.name, *b = what;
        while (*a && *a == *b) ++a, ++b;
        if (*a == *b) return void(n.value = value);
    }
    __builtin_trap();  // an unknown name
}
void stand_in_set_gripper(double angle_deg) { devices[0].gripper_deg = angle_deg; }
void stand_in_set_position(double x, double y, double z) {
    devices[0].position[0] = x;
    devices[0].position[1] = y;
    devices[0].position[2] = z;
}
void stand_in_get_force(double* force) {
    watch(devices[0]);
    for (int k = 0; k < 3; ++k) force[k] = devices[0].force[k];
}
int stand_in_forces_on() {
    watch(devices[0]);
    return devices[0].forces;
}
int stand_in_brakes_on() { return devices[0].brakes; }
int stand_in_moved() { return devices[0].moved; }
int stand_in_regulated() { return devices[0].regulated; }
int stand_in_opened(int id) { return devices[id].opened; }
int stand_in_watchdog() { return devices[0].watchdog; }
int stand_in_expert() { return expert; }
}
