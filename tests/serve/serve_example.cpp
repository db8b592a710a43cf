#include "serve_example.h"

namespace tissue::serve {

TissueModel with_forces() {
    TissueModel tissue = haptic_example();
    tissue.contact_force_N = 2 * tissue.magnitude_m.asDiagonal() * tissue.direction;
    return tissue;
}

Cases cases_of(const TissueModel& tissue) {
    Cases cases;
    cases.study = tissue.study;
    cases.nodes = tissue.mesh.nodes;
    cases.magnitudes_m = {0.010, 0.015};
    for (int c = 0; c < tissue.case_count(); ++c) {
        if (c % 2 == 0) {
            const std::string& name = tissue.case_names[static_cast<std::size_t>(c)];
            LoadPath path;
            path.name = name.substr(0, name.rfind('-'));
            path.contact_m = tissue.contact_m.row(c);
            path.direction = tissue.direction.row(c);
            path.depth_m = 0.015;
            cases.paths.push_back(path);
        }
        PathRecord record = measured_record(tissue.magnitude_m[c], tissue.contact_force_N.row(c), Eigen::Vector2d(0, 0));
        record.displacement = record.force = scattered(tissue.mesh, 0.001 * (c + 1));
        record.support_force_N.setZero();
        record.smallest_J = 1;
        cases.paths.back().records.push_back(record);
    }
    return cases;
}

bool in_tissue(const Scene& scene, const Point& p, double margin) {
    for (const auto& [low, high] : scene.boxes())
        if ((p.array() > low.array() - margin).all() && (p.array() < high.array() + margin).all()) return true;
    return false;
}

}  // namespace tissue::serve
