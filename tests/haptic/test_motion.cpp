#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "../mesh/embedded_block.h"
#include "../refusal.h"
#include "error.h"
#include "haptic/virtual_device.h"
#include "mesh/spring_mesh.h"

using namespace tissue;

TEST_CASE("a scripted motion of any length is cut at about an hour and repeats without a jump", "[device][long]") {
    for (const SpringMesh& block : {make_lattice("grid8", 10, 10, 0.1, 0.1), embedded_block(Lattice{{4, 4, 3}, {0.1, 0.1, 0.05}})})
        for (const std::string& name : motion_names())
            for (double seconds : {20.0, 1e9, 1e300, std::numeric_limits<double>::infinity()}) {
                INFO(name << ", " << seconds << " s");
                MotionOptions o;
                o.rest = &block;
                o.name = name;
                o.seconds = seconds;
                std::vector<Waypoint> motion = make_motion(o);
                const double end_s = motion.back().time_s;
                CHECK(end_s < 1.1 * longest_motion_s);
                const bool stays = name == "press";
                const Eigen::Vector3d begins = VirtualDevice(motion, {}, true).read(0).position_m;
                VirtualDevice hand(std::move(motion), {}, true);
                Eigen::Vector3d before = hand.read(end_s - 1).position_m;
                double fastest = 0, moved = 0;
                for (int k = 1; k < 3000; ++k) {
                    const Eigen::Vector3d now = hand.read(end_s - 1 + k * 1e-3).position_m;
                    fastest = std::max(fastest, (now - before).norm() / 1e-3);
                    if (k > 1000) moved += (now - before).norm();
                    before = now;
                }
                CHECK(fastest < 1);
                CHECK((moved > 0) == !stays);
                CHECK((hand.read(1000 * end_s).position_m - begins).norm() < (stays ? 0.1 : 1e-4));
                CHECK(hand.read(1e9).position_m.allFinite());
            }
    MotionOptions o;
    const SpringMesh block = make_lattice("grid8", 10, 10, 0.1, 0.1);
    o.rest = &block;
    o.seconds = std::nan("");
    refusal<MismatchError>([&] { make_motion(o); });
}
