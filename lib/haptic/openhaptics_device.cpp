#include "haptic/openhaptics_device.h"

#include <fmt/format.h>

#include "haptic/device_error.h"
#include "haptic/shared_library.h"

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

}  // namespace

const DeviceKind OpenHapticsDevice::kind = {
    "openhaptics",
    {{"library", "FILE", "", "for openhaptics: the vendor's libHD.so, if the system does not find it"},
     {"device-name", "NAME", "", "for openhaptics: name of the device in the vendor's configuration"}},
    [](const DeviceValues& v, const DeviceContext&) -> std::unique_ptr<Device> {
        return std::make_unique<OpenHapticsDevice>(v.at("library"), v.at("device-name"));
    },
    touch_impedance, 0, false};

/// The vendor's library with its functions, and the device that is open in it.
struct OpenHapticsDevice::Library {
    explicit Library(const std::string& path) : file(path) {}
    ~Library() {
        if (device != no_handle) disable_device(device);
    }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;

    SharedLibrary file;
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
    void find(const char* name, Function& function) {
        if (!file.find(name, function))
            throw DeviceError(fmt::format("openhaptics: the library has no {}: it is not OpenHaptics 3", name));
    }
};

OpenHapticsDevice::OpenHapticsDevice(const std::string& library, const std::string& device) {
    const std::string file = library.empty() ? "libHD.so" : library;
    library_ = std::make_unique<Library>(file);
    if (!library_->file.loaded())
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
}

OpenHapticsDevice::~OpenHapticsDevice() {
    stop();
}

void OpenHapticsDevice::start() {
    exchange_.begin();
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
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();
    hd.get_doubles(current_position, position_mm.data());
    int buttons = 0;
    hd.get_integers(current_buttons, &buttons);
    hd.set_doubles(current_force, d.exchange_.force_N().data());
    hd.end_frame(hd.device);

    const ErrorHD error = hd.get_error();
    if (error.code != 0)
        d.exchange_.failed(static_cast<int>(error.code));
    else
        d.exchange_.measured(1e-3 * position_mm, (static_cast<unsigned>(buttons) & first_button) != 0);
    return go_on;
}

DeviceSample OpenHapticsDevice::read(double time_s) noexcept {
    return exchange_.read(time_s, touch_impedance.delay_s);
}

void OpenHapticsDevice::write(const Eigen::Vector3d& force_N) noexcept {
    if (started_) exchange_.write(force_N);
}

void OpenHapticsDevice::stop() noexcept {
    if (!started_) return;
    exchange_.rest();
    started_ = false;
    library_->stop_scheduler();
    library_->unschedule(library_->callback);
}

std::string OpenHapticsDevice::last_error() const {
    return exchange_.last_error() != 0 ? fmt::format("vendor error 0x{:04x}", exchange_.last_error()) : "";
}

}  // namespace tissue
