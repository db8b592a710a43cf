#include "cases/solid_draws.h"

#include <algorithm>
#include <cmath>

#include "error.h"
#include "study/solid_push.h"

namespace tissue {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;
// Least difference between a drawn contact and every training contact, in place or in direction.
constexpr double least_distance_m = 0.002, least_angle_deg = 5;
constexpr int most_tries = 10'000;                            // for one contact

/// Whether two paths differ enough, in place or in direction.
bool apart(const StudyPath& a, const StudyPath& b) {
    const double cosine = std::clamp(a.direction.dot(b.direction), -1.0, 1.0);
    return (a.contact_m - b.contact_m).norm() >= least_distance_m || std::acos(cosine) >= least_angle_deg * degree;
}

}  // namespace

SolidDraws::SolidDraws(const Study& study, const Study::Draws& draws, const std::vector<StudyPath>& trained, const FreeSurface* surface,
                       const std::string& key)
    : study_(study), draws_(draws), trained_(trained), surface_(surface), key_(key), rng_(seeded_rng(draws.seed)) {}

StudyPath SolidDraws::push() {
    StudyPath push;
    int tries = most_tries;
    const std::vector<double>& radii_m = draws_.radii_m;
    const double apart_m = draws_.of_pairs() ? uniform(draws_.pair_apart_m[0], draws_.pair_apart_m[1]) : 0;
    push.radius_m = radii_m.empty() ? study_.indenter.radius_m : radii_m[drawn_++ % radii_m.size()];
    do {
        do {
            push.contact_m = surface_ ? place_on_surface(tries) : place(tries);
            push.direction = direction(push.contact_m);
        } while (!is_apart(push));
        push.depth_m = study_.indenter.times(push.radius_m) * uniform(draws_.depth_m[0], draws_.depth_m[1]);
        if (draws_.of_pairs()) push.second = second(push, apart_m);
    } while (draws_.of_pairs() && !push.second);
    return push;
}

/// Draws a side and puts a second disc there, on a block's top; nothing where it does not fit.
std::optional<SecondTool> SolidDraws::second(const StudyPath& first, double apart_m) {
    const double side = uniform(0, 360) * degree;
    StudyPath other;
    other.contact_m = first.contact_m + apart_m * Eigen::Vector3d(std::cos(side), std::sin(side), 0);
    other.direction = direction(other.contact_m);
    other.depth_m = study_.indenter.times(first.radius_m) * uniform(draws_.depth_m[0], draws_.depth_m[1]);
    const Point pushed_m = other.contact_m + other.depth_m * other.direction - first.contact_m - first.depth_m * first.direction;
    if (!may_be(other.contact_m) || !is_apart(other) || pushed_m.norm() < 2 * first.radius_m) return {};
    return SecondTool{other.contact_m, other.direction, other.depth_m};
}

/// Whether the distance of a place of a block's top from the nearest wall is in the range of the draws.
bool SolidDraws::may_be(const Point& top_m) const {
    const Study::Geometry& g = study_.geometry;
    const double wall_m = std::min({top_m[0], g.width_m - top_m[0], top_m[1], g.length_m - top_m[1]});
    return wall_m >= draws_.clearance_m[0] && wall_m <= draws_.clearance_m[1];
}

void SolidDraws::count_down(int& tries) const {
    if (--tries < 0)
        throw MismatchError(key_ + (draws_.of_pairs() ? ": clearance_m leaves no space for two discs apart_m apart, each 2 mm or 5 degrees from all training contacts: widen clearance_m or reduce apart_m"
                                                     : ": clearance_m leaves no space for contacts that are 2 mm or 5 degrees from all training contacts: widen it"));
}

Point SolidDraws::place(int& tries) {
    const Study::Geometry& g = study_.geometry;
    const double low = draws_.clearance_m[0];
    while (true) {
        count_down(tries);
        const double x = uniform(low, g.width_m - low), y = uniform(low, g.length_m - low);
        if (std::min({x, g.width_m - x, y, g.length_m - y}) <= draws_.clearance_m[1]) return Eigen::Vector3d(x, y, g.height_m);
    }
}

/// Uniform by area: draws a facet with a probability proportional to its area, then a point of it.
Point SolidDraws::place_on_surface(int& tries) {
    const Eigen::VectorXd& area = surface_->measure();
    while (true) {
        count_down(tries);
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

Point SolidDraws::direction(const Point& place) {
    const double high = std::cos(draws_.tilt_deg[0] * degree), low = std::cos(draws_.tilt_deg[1] * degree);
    const double tilt_deg = std::acos(uniform(low, high)) / degree, azimuth_deg = uniform(0, 360);
    const double tilt = std::clamp(tilt_deg, draws_.tilt_deg[0], draws_.tilt_deg[1]);
    return surface_ ? surface_push(surface_->nearest(place).inward, tilt, azimuth_deg) : solid_push(tilt, azimuth_deg);
}

bool SolidDraws::is_apart(const StudyPath& push) const {
    return std::all_of(trained_.begin(), trained_.end(), [&](const StudyPath& t) { return apart(push, t); });
}

}  // namespace tissue
