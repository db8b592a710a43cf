// A stand-in for the vendor's libHD.so, with the function names of its manual: one device, a servo thread at about 1
// kHz, and functions by which a test sets the hand's position.
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

namespace {

struct ErrorInfo {
    unsigned code;
    int internal_code;
    unsigned handle;
};

std::mutex guard;
double position_mm[3], force_N[3];
std::atomic<unsigned> error{0}, error_once{0};
std::atomic<int> buttons{0};
std::atomic<bool> running{false}, enabled{false};
unsigned (*callback)(void*) = nullptr;
void* callback_data = nullptr;
std::thread servo;

}  // namespace

extern "C" {

unsigned hdInitDevice(const char*) { return 1; }
void hdDisableDevice(unsigned) {}
void hdEnable(unsigned what) { enabled = what == 0x4000; }
unsigned long hdScheduleAsynchronous(unsigned (*function)(void*), void* data, unsigned short) {
    callback = function;
    callback_data = data;
    return 7;
}
void hdUnschedule(unsigned long) { callback = nullptr; }
void hdStartScheduler() {
    running = true;
    servo = std::thread([] {
        while (running && callback && callback(callback_data) == 1) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
}
void hdStopScheduler() {
    running = false;
    if (servo.joinable()) servo.join();
    const std::lock_guard<std::mutex> lock(guard);
    for (double& f : force_N) f = 0;
}
void hdBeginFrame(unsigned) {}
void hdEndFrame(unsigned) {}
void hdGetDoublev(unsigned what, double* values) {
    const std::lock_guard<std::mutex> lock(guard);
    for (int k = 0; k < 3; ++k) values[k] = what == 0x2050 ? position_mm[k] : 0;
}
void hdGetIntegerv(unsigned what, int* values) { *values = what == 0x2000 ? buttons.load() : 0; }
void hdSetDoublev(unsigned what, const double* values) {
    const std::lock_guard<std::mutex> lock(guard);
    for (int k = 0; k < 3 && what == 0x2700 && enabled; ++k) force_N[k] = values[k];
}
ErrorInfo hdGetError() {
    const unsigned once = error_once.exchange(0);
    return {once != 0 ? once : error.load(), 0, 1};
}

void stand_in_set_position(double x, double y, double z) {
    const std::lock_guard<std::mutex> lock(guard);
    position_mm[0] = x;
    position_mm[1] = y;
    position_mm[2] = z;
}
void stand_in_get_force(double* values) {
    const std::lock_guard<std::mutex> lock(guard);
    for (int k = 0; k < 3; ++k) values[k] = force_N[k];
}
int stand_in_running() { return running; }
void stand_in_set_buttons(int down) { buttons = down; }
void stand_in_set_error(unsigned code) { error = code; }
void stand_in_fail_once(unsigned code) {
    error_once = code;
    while (error_once != 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}
}
