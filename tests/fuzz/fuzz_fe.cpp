// CSV files of load paths and displacement histories by finite elements, and of trajectories by the user, in the plane
// and in space.
#include "cases/history.h"
#include "cases/load_path.h"
#include "cases/trajectory.h"
#include "fuzz_file.h"

using namespace tissue;

FUZZ_TARGET(fe)(const std::uint8_t* data, std::size_t size) {
    static const NodeField plane = make_lattice("grid4", 1, 1, 0.1, 0.1).nodes;
    static const NodeField space = (NodeField(2, 3) << 0, 0, 0, 0.1, 0, 0.05).finished();
    const FuzzFile file(data, size, "fe.csv");
    for (const Eigen::Index D : {2, 3}) {
        for (const bool second : {false, true})
            reads([&] {
                const LoadPath path = read_path_csv(file, D == 2 ? plane : space, second);
                for (const PathRecord& r : path.records) must(r.displacement.allFinite() && r.force.allFinite() && (!second || r.second_force_N.allFinite()), "not finite");
            });
        reads([&] {
            const History h = read_history_csv(file, D);
            must(h.time_s.allFinite() && h.push_m.allFinite() && h.force_N.allFinite(), "not finite");
        });
        reads([&] {
            const Trajectory trajectory = read_trajectory(file, D);
            must(trajectory.time_s.allFinite() && trajectory.push_m.allFinite(), "not finite");
        });
    }
    return 0;
}
