// Where a grasp comes from: pointer, UDP datagram, recording, and a checked indentation that pulls.
#include <arpa/inet.h>
#include <catch2/catch.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "../example.h"
#include "../wait_for.h"
#include "eval/session_indentation.h"
#include "graspable.h"
#include "haptic/pointer_device.h"
#include "haptic/recorder.h"
#include "haptic/remote_device.h"
#include "haptic/replay_device.h"
#include "haptic/virtual_device.h"
#include "haptic_example.h"

using namespace tissue;

namespace {

DeviceSample read_after(RemoteDevice& device, std::uint32_t sequence, double grasp) {
    static const int from = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(device.port()));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const PositionDatagram p{{'T', 'S', 'P', '1'}, sequence, 1e-3 * sequence, {0.001 * sequence, 0, 0}, grasp};
    REQUIRE(::sendto(from, &p, sizeof p, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to) == sizeof p);
    DeviceSample sample;
    wait_for([&] { return (sample = device.read(1e-3 * sequence)).position_m.x() == 0.001 * sequence; });
    return sample;
}

}  // namespace

TEST_CASE("the pointer and the UDP datagram ask for a grasp", "[grasp][device]") {
    PointerDevice pointer(Eigen::Vector2d(0.05, 0.12), {}, 2);
    CHECK(!pointer.read(0).grasp);
    pointer.grasp(true);
    CHECK(pointer.read(0.001).grasp);
    CHECK(pointer.skip_tick(0.002).grasp);
    pointer.grasp(false);
    CHECK(!pointer.read(0.003).grasp);

    RemoteDevice device(0);
    device.start();
    read_after(device, 1, 1);
    CHECK(read_after(device, 2, 1).grasp);
    CHECK(!read_after(device, 3, 0).grasp);
    CHECK(!read_after(device, 4, 0.5).grasp);  // an older client may leave something else in the field
    CHECK(!read_after(device, 5, std::nan("")).grasp);
}

TEST_CASE("a recorded session with a grasp replays to bitwise equal forces", "[grasp][recorder]") {
    const TemporaryFolder folder;
    const TissueModel tissue = graspable_solid();
    HapticOptions options;
    options.heuristic_mesh = false;
    const HapticModel model(tissue, options);
    MotionOptions motion;
    motion.name = "pull";
    motion.depth_m = 0.005;
    motion.rest = &tissue.mesh;
    motion.seconds = 3;
    {
        Simulation simulation(model);
        VirtualDevice hand(make_motion(motion), model.options.map);
        Recorder recorder(folder.file("a.h5"), 3, {"test", 4, {}});
        for (int k = 0; k < 3000; ++k) {
            simulation.tick(hand.read(k * 1e-3));
            TickStatistics statistics;
            statistics.time_s = k * 1e-3;
            recorder.after(simulation, statistics);
        }
        recorder.close(simulation);
        REQUIRE(recorder.dropped() == 0);
    }
    const Hdf5Reader in(folder.file("a.h5"), "recording");
    const std::vector<int> grasp = in.integers("/grasp");
    CHECK(std::count(grasp.begin(), grasp.end(), 2) > 1000);
    CHECK(std::count(grasp.begin(), grasp.end(), 0) > 900);
    Simulation again(model);
    ReplayDevice replay(folder.file("a.h5"));
    const NodeField force = in.field("/device_force");
    const Eigen::VectorXd time = in.vector("/time");
    double off_N = 0;
    for (Eigen::Index k = 0; k < time.size(); ++k) off_N = std::max(off_N, (again.tick(replay.read(time[k])) - force.row(k).transpose()).norm());
    CHECK(off_N == 0);
    CHECK(force.col(2).minCoeff() < -0.05);
}

TEST_CASE("a checked indentation that pulls grasps first and rests at the static force", "[grasp][truth][long]") {
    const TissueModel tissue = graspable_solid();
    const IndentationReference pull{"pull", Eigen::Vector3d(0.043, 0.056, 0.05), Eigen::Vector3d(0.3, 0, 1).normalized(), 0.005, {}};
    const IndentationResult r = indent(HapticModel(tissue, {}), tissue, pull);
    INFO(r.reason);
    REQUIRE(r.rested);
    CHECK(r.reason.empty());
    CHECK(r.static_error < 0.01);
    CHECK(r.force_N[2] > 0.05);
    const TissueModel other = solid_example();
    CHECK(indent(HapticModel(other, {}), other, pull, 2).reason == "the case pulls, and the model cannot grasp");
}
