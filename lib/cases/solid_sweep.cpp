#include "cases/solid_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cases/solid_draws.h"
#include "cases/solid_training.h"
#include "study/solid_push.h"

namespace tissue {
namespace {

/// Size of finite elements at a contact [m]: in proportion to its disc, and no larger than of those far from it.
double near_m(const Study& study, const std::array<double, 2>& sizes_m, const StudyPath& push) {
    return std::min(study.indenter.times(push.radius_m) * sizes_m[0], sizes_m[1]);
}

PlannedPath planned(const Study& study, const StudyPath& push, const std::string& role) {
    const double times = study.indenter.times(push.radius_m), deepest_m = push.second ? std::max(push.depth_m, push.second->depth_m) : push.depth_m;
    const int records = std::max(1, static_cast<int>(std::ceil(deepest_m / (times * study.loads.record_step_m) - 1e-9)));
    return {push, role, push.depth_m, records, study.refine, {near_m(study, study.sizes_m, push), study.sizes_m[1]}};
}

}  // namespace

std::vector<PlannedPath> solid_paths(const Study& study, const std::optional<Shape>& shape) {
    std::vector<PlannedPath> paths, checks;
    const std::vector<StudyPath> trained = solid_training(study, shape);
    std::optional<FreeSurface> surface;
    if (!study.geometry.is_block()) surface.emplace(study_surface(study, shape));
    for (const StudyPath& push : trained) paths.push_back(planned(study, push, "train"));
    for (const Study::Draws& draws : study.draws) {
        SolidDraws drawn(study, draws, trained, surface ? &*surface : nullptr, "draws." + draws.role);
        const bool checked = draws.role == "held_out" && study.check_sizes_m[0] > 0;
        for (int i = 1; i <= draws.count; ++i) {
            StudyPath push = drawn.push();
            push.name = fmt::format("{}-{:04}", draws.role, i);
            std::replace(push.name.begin(), push.name.end(), '_', '-');
            paths.push_back(planned(study, push, draws.role));
            if (!checked || i > std::lround(study.check_fraction * draws.count)) continue;
            PlannedPath check = paths.back();
            check.push.name = fmt::format("check-{:04}", i);
            check.role = "check";
            check.sizes_m = {near_m(study, study.check_sizes_m, push), study.check_sizes_m[1]};
            checks.push_back(check);
        }
    }
    int number = 0;
    if (study.map)
        for (const double y : study.map->y_m)
            for (const double x : study.map->x_m) {
                const StudyPath push{fmt::format("map-{:04}", ++number), Eigen::Vector3d(x, y, study.geometry.height_m), solid_push(0, 0), study.map->depth_m, study.indenter.radius_m};
                paths.push_back(planned(study, push, "map"));
            }
    paths.insert(paths.end(), checks.begin(), checks.end());
    return paths;
}

}  // namespace tissue
