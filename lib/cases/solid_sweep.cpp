#include "cases/solid_sweep.h"

#include <fmt/format.h>
#include <gsl/gsl_rng.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "cases/solid_training.h"
#include "error.h"
#include "study/solid_push.h"

namespace tissue {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;
constexpr double least_distance_m = 0.002, least_angle_deg = 5;  // what "held out" means, beside the seed

PlannedPath planned(const Study& study, const StudyPath& push, const std::string& role) {
    const int records = std::max(1, static_cast<int>(std::ceil(push.depth_m / study.loads.record_step_m - 1e-9)));
    return {push, role, push.depth_m, records, study.refine, study.sizes_m};
}

/// Whether a push is far enough from another, in place or direction, not to be the same contact.
bool apart(const StudyPath& a, const StudyPath& b) {
    const double cosine = std::clamp(a.direction.dot(b.direction), -1.0, 1.0);
    return (a.contact_m - b.contact_m).norm() >= least_distance_m || std::acos(cosine) >= least_angle_deg * degree;
}

/// Pushes of one role, by its own stream of random numbers.
class SolidDraws {
   public:
    /// surface: of a shape; null for a block.
    SolidDraws(const Study& study, const Study::Draws& draws, const std::vector<StudyPath>& trained, const FreeSurface* surface)
        : study_(study), draws_(draws), trained_(trained), surface_(surface), rng_(gsl_rng_alloc(gsl_rng_mt19937), gsl_rng_free), tries_(1000L * draws.count) {
        gsl_rng_set(rng_.get(), draws.seed);
    }

    /// number: from 1, for its name.
    StudyPath draw(int number) {
        StudyPath push;
        do {
            push.contact_m = surface_ ? place_on_surface() : place();
            push.direction = direction(push.contact_m);
        } while (!apart_from_training(push));
        push.depth_m = uniform(draws_.depth_m);
        push.name = fmt::format("{}-{:04}", draws_.role, number);
        std::replace(push.name.begin(), push.name.end(), '_', '-');
        return push;
    }

   private:
    double uniform(double low, double high) { return low + (high - low) * gsl_rng_uniform(rng_.get()); }
    double uniform(const double (&range)[2]) { return uniform(range[0], range[1]); }

    void count_a_try() {
        if (--tries_ < 0)
            throw MismatchError(fmt::format("draws.{}: clearance_m and the training contacts leave no room for contacts 2 mm or 5 "
                                            "degrees away from all of them", draws_.role));
    }

    Point place() {
        const Study::Geometry& g = study_.geometry;
        const double low = draws_.clearance_m[0];
        while (true) {
            count_a_try();
            const double x = uniform(low, g.width_m - low), y = uniform(low, g.length_m - low);
            if (std::min({x, g.width_m - x, y, g.length_m - y}) <= draws_.clearance_m[1]) return Eigen::Vector3d(x, y, g.height_m);
        }
    }

    /// Uniform by area: a facet by its area, then a point of it.
    Point place_on_surface() {
        const Eigen::VectorXd& area = surface_->measure();
        while (true) {
            count_a_try();
            double left = uniform(0, area.sum());
            Eigen::Index f = 0;
            while (f + 1 < area.size() && left >= area[f]) left -= area[f++];
            double a = uniform(0, 1), b = uniform(0, 1);
            if (a + b > 1) {
                a = 1 - a;
                b = 1 - b;
            }
            const Point place = surface_->at(f, {1 - a - b, a, b});
            const double clearance_m = surface_->clearance_m(place);
            if (clearance_m >= draws_.clearance_m[0] && clearance_m <= draws_.clearance_m[1]) return place;
        }
    }

    Point direction(const Point& place) {
        const double high = std::cos(draws_.tilt_deg[0] * degree), low = std::cos(draws_.tilt_deg[1] * degree);
        const double tilt_deg = std::acos(uniform(low, high)) / degree, azimuth_deg = uniform(0, 360);
        const double tilt = std::clamp(tilt_deg, draws_.tilt_deg[0], draws_.tilt_deg[1]);
        return surface_ ? surface_push(surface_->nearest(place).inward, tilt, azimuth_deg) : solid_push(tilt, azimuth_deg);
    }

    bool apart_from_training(const StudyPath& push) const {
        return std::all_of(trained_.begin(), trained_.end(), [&](const StudyPath& t) { return apart(push, t); });
    }

    const Study& study_;
    const Study::Draws& draws_;
    const std::vector<StudyPath>& trained_;
    const FreeSurface* surface_;
    std::unique_ptr<gsl_rng, void (*)(gsl_rng*)> rng_;
    long tries_;
};

}  // namespace

std::vector<PlannedPath> solid_paths(const Study& study, const std::optional<Shape>& shape) {
    std::vector<PlannedPath> paths, checks;
    const std::vector<StudyPath> trained = solid_training(study, shape);
    std::optional<FreeSurface> surface;
    if (!study.geometry.is_block()) surface.emplace(study_surface(study, shape));
    for (const StudyPath& push : trained) paths.push_back(planned(study, push, "train"));
    for (const Study::Draws& draws : study.draws) {
        SolidDraws drawn(study, draws, trained, surface ? &*surface : nullptr);
        const bool checked = draws.role == "held_out" && study.check_sizes_m[0] > 0;
        for (int i = 1; i <= draws.count; ++i) {
            paths.push_back(planned(study, drawn.draw(i), draws.role));
            if (!checked || i > std::lround(study.check_fraction * draws.count)) continue;
            PlannedPath check = paths.back();
            check.push.name = fmt::format("check-{:04}", i);
            check.role = "check";
            check.sizes_m = study.check_sizes_m;
            checks.push_back(check);
        }
    }
    int number = 0;
    if (study.map)
        for (const double y : study.map->y_m)
            for (const double x : study.map->x_m) {
                const StudyPath push{fmt::format("map-{:04}", ++number), Eigen::Vector3d(x, y, study.geometry.height_m), solid_push(0, 0), study.map->depth_m};
                paths.push_back(planned(study, push, "map"));
            }
    paths.insert(paths.end(), checks.begin(), checks.end());
    return paths;
}

}  // namespace tissue
