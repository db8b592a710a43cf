/* Presses or grasps a tissue over UDP: udp_press press|grasp PORT X Y Z DX DY DZ [SECONDS [HZ]]
 * The device moves from outside to the contact X Y Z [m] and on by the tool displacement DX DY DZ [m], and back. With
 * `grasp` the tool grasps where it is deepest, lifts the tissue out by a quarter of the displacement, and lets go. It
 * sends HZ positions a second (1000) and prints the forces on the hand [N]. UdpPress.cs is the same in C#.
 * Start `tissue-haptic MODEL --device remote --port PORT` first. Build: g++ -std=c++17 udp_press.cpp */
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include "udp_device.h"

int main(int count, char** argument) try {
    const bool grasps = count > 1 && std::strcmp(argument[1], "grasp") == 0;
    double number[9] = {0, 0, 0, 0, 0, 0, 0, 2, 1000};  // port, contact, displacement, seconds, rate
    bool known = count >= 9 && count <= 11 && (grasps || std::strcmp(argument[1], "press") == 0);
    for (int k = 2; known && k < count; ++k) {
        char* end = nullptr;
        number[k - 2] = std::strtod(argument[k], &end);
        known = end != argument[k] && *end == '\0' && std::isfinite(number[k - 2]);
    }
    const double depth = std::hypot(number[4], number[5], number[6]), seconds = number[7], rate = number[8];
    if (!known || number[0] < 1 || number[0] > 65535 || depth == 0 || seconds <= 0 || rate <= 0) {
        std::fprintf(stderr, "usage: udp_press press|grasp PORT X Y Z DX DY DZ [SECONDS [HZ]]\n");
        return 2;
    }

    UdpDevice device(static_cast<int>(number[0]));
    double pushed = 0, pulled = 0, last = 0;
    const double begin = device.now_s();
    for (long tick = 1; device.now_s() - begin < seconds; ++tick) {
        const double turn = (device.now_s() - begin) / seconds, pi = 3.14159265358979;
        // outside by 0.4 of the displacement, in, out
        const double at = -0.4 + 1.4 * std::pow(std::sin(pi * turn), 2);
        device.send({number[1] + at * number[4], number[2] + at * number[5], number[3] + at * number[6]}, grasps && turn > 0.5 && turn < 0.9);
        std::this_thread::sleep_for(std::chrono::duration<double>(begin + static_cast<double>(tick) / rate - device.now_s()));
        const UdpDevice::Vector force = device.force_N();
        last = std::hypot(force[0], force[1], force[2]);
        const double along = (force[0] * number[4] + force[1] * number[5] + force[2] * number[6]) / depth;
        pushed = std::max(pushed, -along);
        pulled = std::max(pulled, along);
    }
    std::printf("the tissue pushed with up to %.4f N, pulled with up to %.4f N, at the end %.4f N\n", pushed, pulled, last);
    std::printf("sent %ld, answers %ld, refused %ld\n", device.sent(), device.answers(), device.refused());
    return device.answers() > 0 ? 0 : 1;
} catch (const std::exception& e) {
    std::fprintf(stderr, "udp_press: %s\n", e.what());
    return 1;
}
