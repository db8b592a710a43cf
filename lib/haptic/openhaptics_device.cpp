#include "haptic/openhaptics_device.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "haptic/device_error.h"

namespace tissue {
namespace {

// the vendor's interface, as in its manual
using HandleHD = unsigned;
struct ErrorHD {
    unsigned code;
    int internal_code;
    HandleHD handle;
};
constexpr HandleHD no_handle = 0xFFFFFFFF;
constexpr unsigned current_buttons = 0x2000, first_button = 1;
constexpr unsigned current_position = 0x2050, current_force = 0x2700, force_output = 0x4000;
constexpr unsigned go_on = 1;
constexpr unsigned short highest_priority = 0xFFFF;
constexpr auto let_go_ns = static_cast<long long>(0.75e9 * force_held_s);

long long now_ns() noexcept {
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace

const DeviceKind OpenHapticsDevice::kind = {
    "openhaptics",
    {{"library", "FILE", "", "for openhaptics: the vendor's libHD.so, if the system does not find it"},
     {"device-name", "NAME", "", "for openhaptics: name of the device in the vendor's configuration"}},
    [](const DeviceValues& v, const DeviceContext&) -> std::unique_ptr<Device> {
        return std::make_unique<OpenHapticsDevice>(v.at("library"), v.at("device-name"));
    },
    touch_impedance, 0, false};

struct OpenHapticsDevice::Library {
    void* file = nullptr;
    HandleHD (*init_device)(const char*) = nullptr;
    void (*disable_device)(HandleHD) = nullptr;
    void (*enable)(unsigned) = nullptr;
    void (*start_scheduler)() = nullptr;
    void (*stop_scheduler)() = nullptr;
    unsigned long (*schedule_asynchronous)(unsigned (*)(void*), void*, unsigned short) = nullptr;
    void (*unschedule)(unsigned long) = nullptr;
    void (*begin_frame)(HandleHD) = nullptr;
    void (*end_frame)(HandleHD) = nullptr;
    void (*get_doubles)(unsigned, double*) = nullptr;
    void (*get_integers)(unsigned, int*) = nullptr;
    void (*set_doubles)(unsigned, const double*) = nullptr;
    ErrorHD (*get_error)() = nullptr;
    HandleHD device = no_handle;
    unsigned long callback = 0;

    template <class Function>
    void find(const std::string& name, Function& function) {
        function = reinterpret_cast<Function>(dlsym(file, name.c_str()));
        if (!function)
            throw DeviceError(fmt::format("openhaptics: the library has no {}: it is not OpenHaptics 3", name));
    }
};

/// Passes the newest value of one thread to another through three slots: one is written, one is read, one is between.
template <int Size>
struct OpenHapticsDevice::Exchange {
    std::atomic<unsigned> between{2};
    unsigned writing = 0, reading = 1;
    double slot[3][Size] = {};

    void put(const double* values) noexcept {
        for (int k = 0; k < Size; ++k) slot[writing][k] = values[k];
        writing = between.exchange(writing | 4u, std::memory_order_acq_rel) & 3u;
    }
    const double* get() noexcept {
        if (between.load(std::memory_order_relaxed) & 4u)
            reading = between.exchange(reading, std::memory_order_acq_rel) & 3u;
        return slot[reading];
    }
};

OpenHapticsDevice::OpenHapticsDevice(const std::string& library, const std::string& device)
    : library_(new Library), position_(new Exchange<4>), force_(new Exchange<3>) {
    try {
        const std::string file = library.empty() ? "libHD.so" : library;
        library_->file = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
        if (!library_->file)
            throw DeviceError(fmt::format("openhaptics: cannot load {}; install the vendor's OpenHaptics "
                                          "and its device driver, or name the library with --library",
                                          file));
        library_->find("hdInitDevice", library_->init_device);
        library_->find("hdDisableDevice", library_->disable_device);
        library_->find("hdEnable", library_->enable);
        library_->find("hdStartScheduler", library_->start_scheduler);
        library_->find("hdStopScheduler", library_->stop_scheduler);
        library_->find("hdScheduleAsynchronous", library_->schedule_asynchronous);
        library_->find("hdUnschedule", library_->unschedule);
        library_->find("hdBeginFrame", library_->begin_frame);
        library_->find("hdEndFrame", library_->end_frame);
        library_->find("hdGetDoublev", library_->get_doubles);
        library_->find("hdGetIntegerv", library_->get_integers);
        library_->find("hdSetDoublev", library_->set_doubles);
        library_->find("hdGetError", library_->get_error);
        library_->device = library_->init_device(device.empty() ? nullptr : device.c_str());
        const ErrorHD error = library_->get_error();
        if (library_->device == no_handle || error.code != 0)
            throw DeviceError(fmt::format("openhaptics: cannot open the device '{}': vendor error 0x{:04x}",
                                          device.empty() ? "default" : device, error.code));
    } catch (...) {
        if (library_->device != no_handle) library_->disable_device(library_->device);
        if (library_->file) dlclose(library_->file);
        delete library_;
        delete position_;
        delete force_;
        throw;
    }
}

OpenHapticsDevice::~OpenHapticsDevice() {
    stop();
    library_->disable_device(library_->device);
    dlclose(library_->file);
    delete library_;
    delete position_;
    delete force_;
}

void OpenHapticsDevice::start() {
    written_ns_.store(0, std::memory_order_release);  // forces written before start() do not go out
    started_ = true;  // from here on stop() undoes what start() did, also after an exception
    library_->enable(force_output);
    library_->callback = library_->schedule_asynchronous(&OpenHapticsDevice::servo, this, highest_priority);
    library_->start_scheduler();
    const ErrorHD error = library_->get_error();
    if (error.code != 0) throw DeviceError(fmt::format("openhaptics: cannot start the servo loop: vendor error 0x{:04x}", error.code));
}

/// Called in the vendor's thread, once per servo period.
unsigned OpenHapticsDevice::servo(void* self) noexcept {
    OpenHapticsDevice& d = *static_cast<OpenHapticsDevice*>(self);
    Library& hd = *d.library_;
    hd.begin_frame(hd.device);
    double position_mm[3] = {};
    hd.get_doubles(current_position, position_mm);
    int buttons = 0;
    hd.get_integers(current_buttons, &buttons);
    const double nothing[3] = {};
    const bool silent = now_ns() - d.written_ns_.load(std::memory_order_acquire) > let_go_ns;
    if (silent) d.cut_off_.fetch_add(1, std::memory_order_relaxed);
    hd.set_doubles(current_force, silent ? nothing : d.force_->get());
    hd.end_frame(hd.device);

    const ErrorHD error = hd.get_error();
    d.vendor_error_.store(static_cast<int>(error.code), std::memory_order_relaxed);
    const double measured[4] = {position_mm[0] * 1e-3, position_mm[1] * 1e-3, position_mm[2] * 1e-3, (static_cast<unsigned>(buttons) & first_button) != 0 ? 1.0 : 0.0};
    d.position_->put(measured);
    d.servo_ticks_.fetch_add(1, std::memory_order_release);
    return go_on;
}

DeviceSample OpenHapticsDevice::read(double time_s) noexcept {
    const unsigned long servo_ticks = servo_ticks_.load(std::memory_order_acquire);
    if (servo_ticks != seen_by_tick_) {
        seen_by_tick_ = servo_ticks;
        seen_at_s_ = time_s;
    }
    DeviceSample sample;
    const double* position = position_->get();
    sample.position_m = {position[0], position[1], position[2]};
    sample.grasp = position[3] == 1;
    sample.valid = servo_ticks > 0 && vendor_error_.load(std::memory_order_relaxed) == 0;
    sample.age_s = time_s - seen_at_s_ + touch_impedance.delay_s;  // at the time when the force for it goes out
    return sample;
}

void OpenHapticsDevice::write(const Eigen::Vector3d& force_N) noexcept {
    if (!started_) return;
    force_->put(force_N.data());
    written_ns_.store(now_ns(), std::memory_order_release);
}

void OpenHapticsDevice::stop() noexcept {
    if (!started_) return;
    write(Eigen::Vector3d::Zero());
    started_ = false;
    // the zero force must reach the motors: wait for two servo periods, at most 20 ms if the servo has stopped
    const unsigned long until = servo_ticks_.load() + 2;
    for (int k = 0; k < 20 && servo_ticks_.load() < until; ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    library_->stop_scheduler();
    library_->unschedule(library_->callback);
}

std::vector<std::pair<std::string, double>> OpenHapticsDevice::statistics() const {
    return {{"servo_ticks", static_cast<double>(servo_ticks_.load())},
            {"cut_off_ticks", static_cast<double>(cut_off_.load())},
            {"vendor_error", static_cast<double>(vendor_error_.load())}};
}

}  // namespace tissue
