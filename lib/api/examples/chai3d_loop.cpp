/* A tissue in CHAI3D's two loops: chai3d_loop MODEL.h5 SECONDS [NAME VALUE]...
 * The haptic thread reads the device, ticks the tissue and writes the force; nothing in it waits. The graphics loop
 * reads the newest mesh, 60 times a second. Prints what both have seen, in N and mm. CHAI3D's x points to the user, y to
 * the right, z up: of a block of 10 cm the options axes "y,-x,z" offset "0.05 0.05 0.052" put the device's origin 2 mm
 * above the middle of its top. In the plane: axes "y,z" offset "0.05 0.102".
 *
 * Without WITH_CHAI3D the device is a stand-in with the calls of cGenericHapticDevice that are used here; its hand
 * presses 5 mm deep. With it, CHAI3D's own classes are used (BSD; with this library GPL-3.0-or-later as a whole).
 * Build: g++ -std=c++17 chai3d_loop.cpp -pthread $(pkg-config --cflags --libs tissue-c) */
#include <tissue.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#ifdef WITH_CHAI3D
#include <chai3d.h>
using namespace chai3d;
#else
struct cVector3d {
    double at[3];
    double x() const { return at[0]; }
    double y() const { return at[1]; }
    double z() const { return at[2]; }
};
struct cGenericHapticDevice {
    bool open() { return true; }
    bool calibrate() { return true; }
    bool getPosition(cVector3d& position) {  // z is up: from the origin 7 mm down and back, in a second
        const double t = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        position = {{0, 0, -0.007 * std::pow(std::sin(3.14159265358979 * t), 2)}};
        return true;
    }
    bool getUserSwitch(int, bool& pressed) { return pressed = false, true; }
    bool setForce(const cVector3d&) { return true; }
    bool close() { return true; }
    const std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
};
struct cHapticDeviceHandler {
    bool getDevice(std::shared_ptr<cGenericHapticDevice>& device, unsigned) { return device = std::make_shared<cGenericHapticDevice>(), true; }
};
#endif

/// The newest mesh for the graphics: of three, one is written, one is read, and one waits to be exchanged.
struct Meshes {
    std::vector<double> mesh[3];
    std::atomic<int> waits{0};  // its number, plus 4 where it is new
    int written = 1, read = 2;
    void put() { written = waits.exchange(written | 4) & 3; }
    const std::vector<double>& newest() {
        if (waits.load() & 4) read = waits.exchange(read) & 3;
        return mesh[read];
    }
};

struct Haptics {
    tissue_session* tissue = nullptr;
    std::shared_ptr<cGenericHapticDevice> device;
    Meshes meshes;
    std::atomic<bool> runs{true};
    double largest_N = 0;
};

/// CHAI3D's haptic callback (updateHaptics in its examples).
void update_haptics(Haptics& haptics) {
    auto last = std::chrono::steady_clock::now();
    for (long tick = 0; haptics.runs; ++tick) {
        cVector3d p;
        bool pressed = false;
        double force[3] = {0, 0, 0};
        haptics.device->getPosition(p);
        haptics.device->getUserSwitch(0, pressed);
        tissue_grasp(haptics.tissue, pressed);  // a model that cannot grasp refuses it, and is pressed as before
        const double position[3] = {p.x(), p.y(), p.z()};
        const auto now = std::chrono::steady_clock::now();
        const double elapsed = std::chrono::duration<double>(now - last).count();
        last = now;
        tissue_tick(haptics.tissue, position, elapsed > 0 ? elapsed : -1, force);  // zero where it is refused
        haptics.device->setForce(cVector3d{force[0], force[1], force[2]});
        haptics.largest_N = std::max(haptics.largest_N, std::hypot(force[0], force[1], force[2]));
        if (tick % 16 == 0 && tissue_positions(haptics.tissue, haptics.meshes.mesh[haptics.meshes.written].data()) == TISSUE_OK) haptics.meshes.put();
        std::this_thread::sleep_until(now + std::chrono::milliseconds(1));  // where setForce does not wait for the device
    }
    haptics.device->setForce(cVector3d{0, 0, 0});
}

int main(int count, char** argument) {
    const auto fail = [](const char* why) { return std::fprintf(stderr, "chai3d_loop: %s\n", why), EXIT_FAILURE; };
    char* end = nullptr;
    const double seconds = count > 2 ? std::strtod(argument[2], &end) : 0;
    if (!(seconds > 0) || *end != '\0') return std::fprintf(stderr, "usage: chai3d_loop MODEL.h5 SECONDS [NAME VALUE]...\n"), 2;
    Haptics haptics;
    if (tissue_open(argument[1], argument + 3, &haptics.tissue) != TISSUE_OK) return fail(tissue_error());

    const auto D = static_cast<std::size_t>(tissue_dimension(haptics.tissue));
    std::vector<double> rest(D * static_cast<std::size_t>(tissue_node_count(haptics.tissue)));
    std::vector<int> facets(D * static_cast<std::size_t>(tissue_facet_count(haptics.tissue)));
    if (tissue_rest_positions(haptics.tissue, rest.data()) != TISSUE_OK || tissue_facets(haptics.tissue, facets.data()) != TISSUE_OK) return fail(tissue_error());
    for (std::vector<double>& mesh : haptics.meshes.mesh) mesh = rest;

    cHapticDeviceHandler handler;
    if (!handler.getDevice(haptics.device, 0) || !haptics.device->open() || !haptics.device->calibrate()) return fail("no haptic device");
    std::thread thread(update_haptics, std::ref(haptics));  // CHAI3D: cThread::start(.., CTHREAD_PRIORITY_HAPTICS)
    double farthest = 0;
    int frames = 0;
    for (; frames < 60 * seconds; ++frames) {  // CHAI3D's graphics loop: here into the vertices of a cMesh
        const std::vector<double>& mesh = haptics.meshes.newest();
        for (const int node : facets) {  // how far down
            const std::size_t last = D * static_cast<std::size_t>(node) + D - 1;
            farthest = std::max(farthest, rest[last] - mesh[last]);
        }
        std::this_thread::sleep_for(std::chrono::microseconds(16667));
    }
    haptics.runs = false;
    thread.join();
    haptics.device->close();
    long long ticks = 0;
    tissue_count(haptics.tissue, "ticks", &ticks);
    std::printf("%lld ticks, %d frames, largest force %.4f N, largest displacement %.2f mm\n", ticks, frames, haptics.largest_N, 1e3 * farthest);
    tissue_close(&haptics.tissue);
    return EXIT_SUCCESS;
}
