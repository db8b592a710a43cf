// Trajectories: CSV, replayed on a tissue.
#include "../haptic/haptic_example.h"
#include "fuzz_file.h"
#include "haptic/replay_device.h"

using namespace tissue;

FUZZ_TARGET(replay)(const std::uint8_t* data, std::size_t size) {
    static const TissueModel tissue = haptic_example({"grid4", "isotropic", 3});
    static const HapticModel model(tissue, {});
    const FuzzFile file(data, size, "trajectory.csv");
    reads([&] {
        ReplayDevice device(file);
        Simulation simulation(model);
        for (int tick = 0; tick < 40 && !device.finished(); ++tick) {
            const Eigen::Vector3d force_N = simulation.tick(device.read(tick < 20 ? 0.001 * tick : 0.1 * tick));
            must(force_N.allFinite() && force_N.norm() <= model.options.safety.force_max_N * (1 + 1e-12), "a force that is not finite or above its maximum");
            device.write(force_N);
        }
        device.statistics();
    });
    return 0;
}
