#include "eval/solid_force_table.h"

#include <catch2/catch.hpp>

#include "../tolerances.h"

using namespace tissue;

TEST_CASE("a force table in space gives back a stiffness that is the same everywhere, and knows how far it reaches", "[solid]") {
    const Eigen::Matrix3d S = (Eigen::Matrix3d() << 30, 2, 0, 2, 35, 1, 0, 1, 50).finished();
    std::vector<LoadPath> paths(6);
    std::vector<PathRecord> records(paths.size());
    std::vector<LoadCase> loads;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        paths[i].contact_m = Eigen::Vector3d(0.01 * static_cast<double>(i), 0.02, 0.05);
        paths[i].direction = Eigen::Vector3d(i % 2 ? 0.5 : 0, i % 3 ? 0.4 : 0, -1).normalized();
        records[i].magnitude_m = 0.004;
        records[i].contact_force_N = S * (0.004 * Eigen::Vector3d(paths[i].direction));
        loads.push_back({"", &paths[i], &records[i]});
    }
    const SolidForceTable table(loads);
    const Eigen::Vector3d direction = Eigen::Vector3d(0.2, 0.3, -1).normalized();
    const ForceTable::Entry near = table.at(Eigen::Vector3d(0.024, 0.021, 0.05), direction, 0.005);
    CHECK((near.force_N - S * (0.005 * direction)).norm() < 1e-3 * near.force_N.norm());
    CHECK_FALSE(near.extrapolated);
    CHECK(table.at(Eigen::Vector3d(0.024, 0.08, 0.05), direction, 0.005).extrapolated);
}
